//! Angles: values whole turns apart are the same.

use std::f64::consts::{PI, TAU};

use rand::RngExt as _;

use crate::Seed;

/// Part of a value within which two effects differ by rounding only.
const ROUNDING: f64 = 1e-9;

/// `angle` \[rad\] in [−π, π).
#[must_use]
pub fn wrapped(angle: f64) -> f64 {
    (angle + PI).rem_euclid(TAU) - PI
}

/// `angle` plus whole turns, as near to `to` as possible \[rad\].
#[must_use]
pub fn unwrapped(angle: f64, to: f64) -> f64 {
    angle + TAU * ((to - angle) / TAU).round()
}

/// Whether state `i` is an angle: whole turns of it change no `effect(x, u)`, and one radian does.
///
/// `effect` is what is compared, for example by how much a step changes each state; `None` where it fails, which is an effect as well.
/// At each of `places`, pairs of x (n) and u (k), state `i` takes a random value between −π and π. No place, no angle.
pub fn turns(places: &[(Vec<f64>, Vec<f64>)], i: usize, effect: impl Fn(&[f64], &[f64]) -> Option<Vec<f64>>) -> bool {
    let (mut rng, mut matters) = (Seed::new(0).stream("whole turns", i as u64), false);
    for (x, u) in places {
        let (at, mut x) = (rng.random_range(-PI..PI), x.clone());
        let [here, there, turned] = [0.0, 1.0, TAU].map(|off| {
            x[i] = at + off;
            effect(&x, u)
        });
        matters |= !is_same(here.as_deref(), there.as_deref());
        if !is_same(here.as_deref(), turned.as_deref()) {
            return false;
        }
    }
    matters
}

/// Whether two effects are the same but for rounding.
fn is_same(one: Option<&[f64]>, other: Option<&[f64]>) -> bool {
    let near = |(a, b): (&f64, &f64)| (a - b).abs() <= ROUNDING * (1.0 + a.abs() + b.abs());
    match (one, other) {
        (Some(one), Some(other)) => one.iter().zip(other).all(near),
        _ => one.is_none() && other.is_none(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_angle_is_taken_by_whole_turns() {
        for (angle, expected) in [(0.5, 0.5), (3.5, 3.5 - TAU), (-3.5, TAU - 3.5), (PI, -PI), (0.5 - 3.0 * TAU, 0.5)] {
            assert!((wrapped(angle) - expected).abs() < 1e-14, "{angle}");
        }
        assert!((unwrapped(0.5, 12.0) - (0.5 + 2.0 * TAU)).abs() < 1e-14);
        assert!((unwrapped(7.0, -0.1) - (7.0 - TAU)).abs() < 1e-14);
    }

    #[test]
    fn whole_turns_change_nothing_of_an_angle() {
        // x₀ an angle, x₁ no angle, x₂ of no effect, x₃ an angle but for a spring that winds up.
        let effect = |x: &[f64], u: &[f64]| Some(vec![x[0].sin() * u[0] - x[1], x[3].cos() + 0.1 * x[3]]);
        let places: Vec<_> = (0..4).map(|k| (vec![0.1 * f64::from(k); 4], vec![1.0])).collect();
        assert_eq!((0..4).filter(|i| turns(&places, *i, effect)).collect::<Vec<_>>(), [0]);
        assert!(!turns(&[], 0, effect));
        // Failing on one side of a wall is an effect.
        assert!(!turns(&places, 0, |x, u| (x[0] < PI).then(|| effect(x, u)).flatten()));
    }
}
