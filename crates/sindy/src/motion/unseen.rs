//! Errors of a step besides those of the states at its ends.

use ndarray::Array2;
use sindyna_core::{Dynamics as _, Seed, VectorField as _};

use super::stepping::FINEST;
use super::{Run, Stepping};
use crate::Model;

/// Errors that enter through the terms are believed up to this many times those of the samples.
const MOST: f64 = 30.0;

/// Standard deviations of the errors that enter the rates of `run` (T, n) besides those of Δx/Δt: the errors of the states
/// and controls the terms are computed from, and with `numerical` what is wrong with the finest Runge–Kutta steps there are.
pub(super) fn unseen(model: &Model, stepping: Stepping, run: &Run, dt: f64, numerical: bool) -> Array2<f64> {
    let n = run.x.ncols();
    let of = |substeps: usize| model.with_form(Stepping::Continuous { substeps }.form());
    let finest = match stepping {
        Stepping::Continuous { .. } if numerical => Some((of(FINEST), of(2 * FINEST))),
        _ => None,
    };
    let mut rng = Seed::new(0).stream("no randomness", 0);
    let mut errors = Array2::zeros((run.len(), n));
    let (mut up, mut down) = (vec![0.0; n], vec![0.0; n]);
    for t in 0..run.len() {
        let (x, u) = (run.x.row(t).to_vec(), run.u.row(t).to_vec());
        let mut squares = vec![0.0; n];
        let z: Vec<f64> = x.iter().chain(&u).copied().collect();
        let sigmas = run.sigma.row(t).into_iter().chain(&run.of_inputs);
        for (j, &sigma) in sigmas.enumerate().filter(|(_, sigma)| **sigma > 0.0) {
            let nudge = 1e-6 * z[j].abs().max(1e-3);
            let mut moved = z.clone();
            moved[j] = z[j] + nudge;
            model.eval(&moved[..n], &moved[n..], &mut up);
            moved[j] = z[j] - nudge;
            model.eval(&moved[..n], &moved[n..], &mut down);
            for i in 0..n {
                squares[i] += ((up[i] - down[i]) / (2.0 * nudge) * sigma).powi(2);
            }
        }
        for i in 0..n {
            let seen = run.sigma[[t, i]].hypot(run.sigma[[t + 1, i]]) / dt;
            let through = squares[i].sqrt();
            errors[[t, i]] = if through.is_finite() { through.min(MOST * seen) } else { MOST * seen };
        }
        if let Some((fine, finer)) = &finest {
            let steps = fine.step(&x, &u, &mut rng, &mut up).and_then(|()| finer.step(&x, &u, &mut rng, &mut down));
            for i in (0..n).filter(|_| steps.is_ok()) {
                errors[[t, i]] = f64::hypot(errors[[t, i]], (up[i] - down[i]) / dt);
            }
        }
    }
    errors
}
