//! States that are angles, as equations tell.

use std::f64::consts::TAU;

use rand::RngExt as _;
use sindyna_core::{Dynamics as _, Rng, Seed};
use sindyna_sindy::Model;

/// States and inputs at which a step is compared with one a turn farther.
const PLACES: u64 = 16;

/// Part of a state within which both are the same, and beyond which the state matters.
const SAME: f64 = 1e-9;

/// Whether steps of `model` depend on state `i`, and whole turns of it \[rad\] change nothing.
pub(super) fn turns(model: &Model, i: usize) -> bool {
    let (n, k) = (model.states().len(), model.controls().len());
    if i >= n {
        return false;
    }
    let (mut rng, mut matters, mut compared) = (Seed::new(0).stream("whole turns", 0), false, 0);
    for _ in 0..PLACES {
        let mut draw = |count: usize| (0..count).map(|_| rng.random_range(-1.0..1.0)).collect::<Vec<f64>>();
        let (x, u, part) = (draw(n), draw(k), draw(1)[0]);
        // Another place, and a turn from here.
        let (Some(here), Some(there), Some(turned)) =
            (moved(model, &x, &u, (i, 0.0)), moved(model, &x, &u, (i, part)), moved(model, &x, &u, (i, TAU)))
        else {
            continue;
        };
        let differ = |other: &[f64], by: f64| {
            let far = |(a, b): (&f64, &f64)| (a - b).abs() > by * (1.0 + a.abs() + b.abs());
            here.iter().zip(other).any(far)
        };
        matters |= differ(&there, SAME);
        if differ(&turned, SAME) {
            return false;
        }
        compared += 1;
    }
    matters && compared > 0
}

/// By how much a step moves each state from x with `off` added to one of them; `None` where the model diverges.
fn moved(model: &Model, x: &[f64], u: &[f64], (i, off): (usize, f64)) -> Option<Vec<f64>> {
    let (mut x, mut next, mut rng): (_, _, Rng) = (x.to_vec(), vec![0.0; x.len()], Seed::new(0).numpy());
    x[i] += off;
    model.step(&x, u, &mut rng, &mut next).ok()?;
    Some(next.iter().zip(&x).map(|(next, x)| next - x).collect())
}

#[cfg(test)]
mod tests {
    use sindyna_core::Scheme;
    use sindyna_sindy::{Entry, Form, ModelParts};

    use super::*;

    #[test]
    fn angles_are_what_whole_turns_do_not_change() {
        // A cart x with a pole θ and a spring q: x matters nowhere.
        let model = Model::new(ModelParts {
            form: Form::Continuous(Scheme::Rk4 { substeps: 1 }),
            dt: 0.05,
            terms: ["v", "w", "sin(th)", "u", "q", "cos(th)"].map(String::from).to_vec(),
            equations: vec![
                vec![Entry::new(0, 1.0)],
                vec![Entry::new(1, 1.0)],
                vec![Entry::new(4, -3.0)],
                vec![Entry::new(3, 1.0)],
                vec![Entry::new(2, -9.0), Entry::new(5, 0.5)],
            ],
            n_features: 6,
            states: ["x", "th", "q", "v", "w"].map(String::from).to_vec(),
            controls: vec!["u".into()],
            readings: None,
            offsets: vec![0.0; 5],
            kinematic: vec![true, true, false, false, false],
        })
        .expect("a model");
        assert_eq!((0..6).filter(|i| turns(&model, *i)).collect::<Vec<_>>(), [1]);
    }
}
