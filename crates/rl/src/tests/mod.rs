//! Tests that look inside an update: against golden files, and against losses written out plainly.

mod discrete;
mod finite_differences;
mod golden;
mod update;

use ndarray::{Array1, Array2};
use sindyna_core::{Batch, Seed};

use crate::{Sac, SacConfig, SacDiscrete, Scaling};

/// An agent for `m` observed and `k` action values in -1..1.
fn agent(config: SacConfig, m: usize, k: usize) -> Sac {
    let mut rng = Seed::new(5).stream("test agent", 0);
    Sac::new(config, Scaling::identity(m), &vec![-1.0; k], &vec![1.0; k], &mut rng).expect("usable settings")
}

/// An agent for `m` observed values and `n` numbered actions.
fn discrete_agent(config: SacConfig, m: usize, n: usize) -> SacDiscrete {
    let mut rng = Seed::new(6).stream("test agent", 0);
    SacDiscrete::new(config, Scaling::identity(m), n, &mut rng).expect("usable settings")
}

/// Steps so short that no f32 parameter moves: an update then leaves only its gradients behind.
const STILL: f64 = 1e-300;

/// A batch of `rows` made-up transitions, every fifth of them terminated.
fn batch(rows: usize, m: usize, k: usize) -> Batch {
    let wave = |i: usize, phase: f64| (1.7 * i as f64 + phase).sin();
    let table = |width: usize, phase: f64| {
        Array2::from_shape_fn((rows, width), |(i, j)| wave(i * width + j, phase) * if i % 7 == 0 { 4.0 } else { 1.0 })
    };
    Batch {
        observations: table(m, 0.0),
        actions: table(k, 1.0).mapv(|a| a.clamp(-1.0, 1.0)),
        rewards: Array1::from_shape_fn(rows, |i| wave(i, 2.0)),
        next_observations: table(m, 3.0),
        terminated: Array1::from_shape_fn(rows, |i| if i % 5 == 0 { 1.0 } else { 0.0 }),
    }
}

/// [`batch`] with the numbers of `n` actions.
fn discrete_batch(rows: usize, m: usize, n: usize) -> Batch {
    Batch { actions: Array2::from_shape_fn((rows, 1), |(i, _)| (i * i % n) as f64), ..batch(rows, m, 1) }
}

/// ‖a - b‖ / ‖b‖.
fn distance(a: &[f32], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len(), "lengths");
    let difference: f64 = a.iter().zip(b).map(|(a, b)| (f64::from(*a) - b).powi(2)).sum();
    let norm: f64 = b.iter().map(|b| b * b).sum();
    (difference / norm).sqrt()
}
