//! What there is to train on.

use crate::system::System;
use crate::{cart_pole, cart_pole_swing_up, inverted_pendulum, mountain_car, pendulum};

/// Every system there is a task for.
#[must_use]
pub fn systems() -> Vec<System> {
    vec![
        cart_pole::system(),
        mountain_car::system(),
        pendulum::system(),
        inverted_pendulum::system(),
        cart_pole_swing_up::system(),
    ]
}

/// The system called `name`, in our words or by its Gymnasium id.
#[must_use]
pub fn find(name: &str) -> Option<System> {
    systems().into_iter().find(|s| s.name() == name || s.gymnasium_id() == Some(name))
}
