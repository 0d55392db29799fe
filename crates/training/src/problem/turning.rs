//! States that are angles, as equations tell.

use rand::RngExt as _;
use sindyna_core::{Dynamics as _, Seed, turning};
use sindyna_sindy::Model;

/// States and inputs at which a step is compared with one a turn farther.
const PLACES: usize = 16;

/// Those of the states `open` of which whole turns \[rad\] change no step of `model`.
pub(super) fn angles_among(model: &Model, open: &[usize]) -> Vec<usize> {
    let (n, k) = (model.states().len(), model.controls().len());
    let (mut drawing, unused) = (Seed::new(0).stream("places", 0), Seed::new(0).numpy());
    let mut draw = |count: usize| (0..count).map(|_| drawing.random_range(-1.0..1.0)).collect::<Vec<f64>>();
    let places: Vec<_> = (0..PLACES).map(|_| (draw(n), draw(k))).collect();
    let change = |x: &[f64], u: &[f64]| {
        let mut next = vec![0.0; n];
        model.step(x, u, &mut unused.clone(), &mut next).ok()?;
        Some(next.iter().zip(x).map(|(next, x)| next - x).collect())
    };
    open.iter().copied().filter(|i| *i < n && turning::turns(&places, *i, change)).collect()
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
        assert_eq!(angles_among(&model, &[0, 1, 2, 3, 4, 5]), [1]);
    }
}
