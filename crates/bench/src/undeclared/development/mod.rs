//! Systems to develop methods on. What is tuned, is tuned here; no result is ever reported on them.

mod absolute;
mod chaos;
mod circuits;
mod functions;
mod kinks;
mod mechanics;
mod populations;
mod vehicles;

use super::System;

/// All of them.
pub(super) fn systems() -> Vec<System> {
    let all = [
        absolute::systems(),
        chaos::systems(),
        circuits::systems(),
        functions::systems(),
        kinks::systems(),
        mechanics::systems(),
        populations::systems(),
        vehicles::systems(),
    ];
    all.concat()
}
