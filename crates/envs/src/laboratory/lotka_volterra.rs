//! Prey and predators.

use sindyna_core::{Channel, Kind, VectorField};

use super::set_up::SetUp;
use crate::system::System;

/// Growth of the prey \[1/day\].
const GROWTH: f64 = 0.5;
/// Prey lost to each predator, as a share \[1/day\].
const PREDATION: f64 = 0.025;
/// Death of the predators \[1/day\].
const DEATH: f64 = 0.5;
/// Predators gained for each prey, as a share \[1/day\].
const GAIN: f64 = 0.005;
/// Most predators released or caught in a day.
const MAX_INPUT: f64 = 2.0;

pub(super) fn system() -> System {
    let set_up = SetUp {
        name: "lotka-volterra",
        summary: "prey x and predators y, of which some are released or caught",
        true_equations: &["ẋ = 0.5 x − 0.025 x y", "ẏ = −0.5 y + 0.005 x y + u"],
        state: vec![Channel::new("x", "", Kind::Plain, 100.0), Channel::new("y", "", Kind::Plain, 20.0)],
        control: vec![Channel::new("u", "1/day", Kind::Plain, MAX_INPUT).within(-MAX_INPUT, MAX_INPUT)],
        start: vec![(50.0, 150.0), (15.0, 35.0)],
        dt: 0.1,
        substeps: 10,
    };
    set_up.system(LotkaVolterra)
}

/// ẋ = a x − b x y, ẏ = −c y + d x y + u; the unit of time is the day.
///
/// # References
/// Lotka (1925), *Elements of Physical Biology*; Volterra (1926), Nature 118. Kaiser, Kutz, Brunton (2018), Proceedings of
/// the Royal Society A 474, doi:10.1098/rspa.2018.0335 (rates, and the input on the predators).
#[derive(Clone, Copy)]
struct LotkaVolterra;

impl VectorField for LotkaVolterra {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        let (prey, predators) = (x[0], x[1]);
        x_dot[0] = GROWTH * prey - PREDATION * prey * predators;
        x_dot[1] = -DEATH * predators + GAIN * prey * predators + u[0];
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_support::rates;
    use super::*;
    use sindyna_core::{Dynamics as _, Seed};

    #[test]
    fn left_alone_prey_and_predators_keep_what_they_keep() {
        let system = system();
        let kept = |x: [f64; 2]| 0.005 * x[0] - 0.5 * x[0].ln() + 0.025 * x[1] - 0.5 * x[1].ln();
        let (mut x, mut next, mut rng) = ([60.0, 50.0], [0.0; 2], Seed::new(0).numpy());
        let start = kept(x);
        for _ in 0..1000 {
            system.dynamics().step(&x, &[0.0], &mut rng, &mut next).expect("populations stay finite");
            x = next;
            assert!((kept(x) - start).abs() < 1e-10, "{x:?}");
        }
    }

    #[test]
    fn a_hundred_prey_feed_twenty_predators_for_ever() {
        assert!(rates(LotkaVolterra, [100.0, 20.0], &[0.0]).iter().all(|v| v.abs() < 1e-13));
    }
}
