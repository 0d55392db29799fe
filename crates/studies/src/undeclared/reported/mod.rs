//! Systems results are reported on. Nothing is ever tuned here.

mod laboratory;
mod machines;
mod mechanics;
mod oscillators;
mod vehicles;

use super::System;

/// All of them.
pub(super) fn systems() -> Vec<System> {
    [oscillators::systems(), mechanics::systems(), vehicles::systems(), machines::systems(), laboratory::systems()]
        .concat()
}
