//! Systems results are reported on. Nothing is ever tuned here.

mod absolute;
mod functions;
mod laboratory;
mod machines;
mod mechanics;
mod oscillators;
mod vehicles;

use super::System;

/// Those with parameters inside their terms.
pub(super) fn functions() -> Vec<System> {
    functions::systems()
}

/// Those whose states are far from zero.
pub(super) fn absolute() -> Vec<System> {
    absolute::systems()
}

/// All of the others.
pub(super) fn systems() -> Vec<System> {
    [oscillators::systems(), mechanics::systems(), vehicles::systems(), machines::systems(), laboratory::systems()]
        .concat()
}
