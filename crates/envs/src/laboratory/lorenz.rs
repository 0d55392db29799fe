//! Lorenz's convection with an input.

use sindyna_core::{Channel, Kind, VectorField};

use super::set_up::SetUp;
use crate::system::System;

/// σ, the Prandtl number.
const PRANDTL: f64 = 10.0;
/// ρ, the Rayleigh number over its critical value.
const RAYLEIGH: f64 = 28.0;
/// β, the shape of the rolls.
const SHAPE: f64 = 8.0 / 3.0;
/// Largest input either way.
const MAX_INPUT: f64 = 50.0;

pub(super) fn system() -> System {
    let set_up = SetUp {
        name: "lorenz",
        summary: "the chaos of Lorenz, with an input on x",
        true_equations: &["ẋ = −10 x + 10 y + u", "ẏ = 28 x − y − x z", "ż = −2.66667 z + x y"],
        state: vec![
            Channel::new("x", "", Kind::Plain, 10.0),
            Channel::new("y", "", Kind::Plain, 10.0),
            Channel::new("z", "", Kind::Plain, 25.0),
        ],
        control: vec![Channel::new("u", "1/s", Kind::Plain, MAX_INPUT).within(-MAX_INPUT, MAX_INPUT)],
        start: vec![(-15.0, 15.0), (-15.0, 15.0), (10.0, 40.0)],
        dt: 0.01,
        substeps: 30,
    };
    set_up.system(Lorenz)
}

/// ẋ = σ (y − x) + u, ẏ = x (ρ − z) − y, ż = x y − β z.
///
/// # References
/// Lorenz (1963), Journal of the Atmospheric Sciences 20, equations 25 to 27. Kaiser, Kutz, Brunton (2018), Proceedings of
/// the Royal Society A 474, doi:10.1098/rspa.2018.0335 (the input and its size).
#[derive(Clone, Copy)]
struct Lorenz;

impl VectorField for Lorenz {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        x_dot[0] = PRANDTL * (x[1] - x[0]) + u[0];
        x_dot[1] = x[0] * (RAYLEIGH - x[2]) - x[1];
        x_dot[2] = x[0] * x[1] - SHAPE * x[2];
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_support::rates;
    use super::*;
    use sindyna_core::{Dynamics as _, Held, Scheme, Seed};

    #[test]
    fn the_shortest_periodic_orbit_closes() {
        // Viswanath (2004), Physica D 190, "The fractal property of the Lorenz attractor": orbit AB.
        let (start, period) = ([-13.763_610_682_134, -19.578_751_942_452, 27.0], 1.558_652_210_716_175);
        let held = Held::new(Lorenz, Scheme::Rk4 { substeps: 20_000 }, period);
        let mut next = [0.0; 3];
        held.step(&start, &[0.0], &mut Seed::new(0).numpy(), &mut next).expect("an orbit stays finite");
        for (end, begin) in next.iter().zip(start) {
            // 12 digits are published, and small deviations grow fivefold on the way round.
            assert!((end - begin).abs() < 1e-10, "{next:?}");
        }
    }

    #[test]
    fn convection_rolls_either_way_at_the_known_fixed_points() {
        let rolls = (8.0_f64 / 3.0 * 27.0).sqrt();
        for side in [rolls, -rolls] {
            let still = rates(Lorenz, [side, side, 27.0], &[0.0]);
            assert!(still.iter().all(|v| v.abs() < 1e-13), "{still:?}");
        }
    }
}
