//! Names to objects.

use sindyna_core::{Explorer, Spec};
use sindyna_dyna::{Alternating, Swings, Uniform};
use sindyna_envs::System;

use crate::failure::{Failure, closest};

/// Share of random actions among alternating ones ("occasional random actions", Arora et al. 2022, §4).
const RANDOM_SHARE: f64 = 0.2;

/// Names an explorer can have.
pub(crate) const EXPLORERS: [&str; 3] = ["swings", "alternating", "random"];

/// The system called `name`.
pub(crate) fn system(name: &str) -> Result<System, Failure> {
    sindyna_envs::find(name).ok_or_else(|| {
        let systems = sindyna_envs::systems();
        let known: Vec<&str> = systems.iter().map(System::name).collect();
        unknown("task", name, &known)
    })
}

/// The explorer called `name` for the action space of `spec`.
pub(crate) fn explorer(name: &str, spec: &Spec) -> Result<Box<dyn Explorer>, Failure> {
    match name {
        "swings" => Ok(Box::new(Swings::new(spec))),
        "alternating" => Ok(Box::new(Alternating::new(spec, RANDOM_SHARE))),
        "random" => Ok(Box::new(Uniform::new(spec))),
        _ => Err(unknown("explorer", name, &EXPLORERS)),
    }
}

/// A name nobody knows, answered with those there are.
pub(crate) fn unknown(what: &str, name: &str, known: &[&str]) -> Failure {
    let list = known.iter().map(|k| format!("`{k}`")).collect::<Vec<_>>().join(", ");
    let failure = Failure::new(format!("no {what} named `{name}`; known: {list}"));
    match closest(name, known) {
        Some(near) => failure.hint(format!("did you mean `{near}`?")),
        None => failure,
    }
}
