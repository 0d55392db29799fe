//! Van der Pol's oscillator with an input.

use sindyna_core::{Channel, Kind, VectorField};

use super::set_up::SetUp;
use crate::system::System;

/// μ: how much the oscillator pumps itself.
const PUMPING: f64 = 1.0;
/// Largest input either way.
const MAX_INPUT: f64 = 1.0;

pub(super) fn system() -> System {
    let set_up = SetUp {
        name: "van-der-pol",
        summary: "an oscillator that pumps itself, pushed about",
        true_equations: &["ẋ = v", "v̇ = v − x² v − x + u"],
        state: vec![Channel::new("x", "", Kind::Plain, 2.0), Channel::new("v", "1/s", Kind::RateOf(0), 2.5)],
        control: vec![Channel::new("u", "1/s²", Kind::Plain, MAX_INPUT).within(-MAX_INPUT, MAX_INPUT)],
        start: vec![(-2.0, 2.0), (-2.0, 2.0)],
        dt: 0.05,
        substeps: 20,
    };
    set_up.system(VanDerPol)
}

/// v̇ = μ (1 − x²) v − x + u with μ = 1.
///
/// # References
/// van der Pol (1926), Philosophical Magazine 2(11), "On relaxation-oscillations".
#[derive(Clone, Copy)]
struct VanDerPol;

impl VectorField for VanDerPol {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        x_dot[0] = x[1];
        x_dot[1] = PUMPING * (1.0 - x[0] * x[0]) * x[1] - x[0] + u[0];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sindyna_core::{Dynamics as _, Held, Scheme, Seed};

    #[test]
    fn the_limit_cycle_has_its_known_amplitude_and_period() {
        // Known for μ = 1; that the orbit closes on itself to 1e-11 says that neither is off.
        let (amplitude, period) = (2.008_619_860_874_843, 6.663_286_859_323_13);
        let held = Held::new(VanDerPol, Scheme::Rk4 { substeps: 10_000 }, period);
        let mut next = [0.0; 2];
        held.step(&[amplitude, 0.0], &[0.0], &mut Seed::new(0).numpy(), &mut next).expect("a cycle stays finite");
        assert!((next[0] - amplitude).abs() < 1e-11 && next[1].abs() < 1e-11, "{next:?}");
    }
}
