//! Noisy logs of the true systems.

use anyhow::Context as _;
use ndarray::{Array2, Axis};
use rand_distr::{Distribution as _, StandardNormal};
use sindyna_core::{Dynamics as _, Held, Rng, Scheme, Seed};

use super::inputs::{signal, uniform};
use super::system::System;
use crate::log::{Log, Trajectory};

/// Starts drawn before a recording is given up.
const TRIES: usize = 100;

/// Magnitude beyond which a recording has run away.
const AWAY: f64 = 1e6;

/// A log of `samples` samples, in recordings of about the system's length, from random starts under random inputs.
///
/// Every state channel carries Gaussian noise of `noise` times its standard deviation over the log. Motion and noise come from
/// streams of their own, so that logs of one seed differ in their noise alone.
///
/// # Errors
/// If the system runs away from every start.
pub fn generate(system: &System, samples: usize, noise: f64, seed: Seed) -> anyhow::Result<Log> {
    let count = (samples as f64 / system.length as f64).round().max(1.0) as usize;
    let rows = |i: usize| samples / count + usize::from(i < samples % count);
    let recording = |i: usize| recording(system, rows(i), &mut seed.stream(system.name, i as u64));
    let mut trajectories = (0..count).map(recording).collect::<anyhow::Result<Vec<_>>>()?;
    disturb(&mut trajectories, noise, &mut seed.stream(&format!("{} noise", system.name), 0));
    let roles = system.states.iter().map(|s| s.role).collect();
    Ok(Log { states: system.states(), roles, controls: system.controls(), dt: system.dt, trajectories })
}

/// One recording without noise.
fn recording(system: &System, rows: usize, rng: &mut Rng) -> anyhow::Result<Trajectory> {
    let dynamics = Held::new(&*system.field, Scheme::Rk4 { substeps: system.substeps }, system.dt);
    let try_once = |rng: &mut Rng| {
        let steps = rows.saturating_sub(1);
        let signals: Vec<Vec<f64>> = system.inputs.iter().map(|u| signal(u.range, steps, rng)).collect();
        let controls = Array2::from_shape_fn((steps, signals.len()), |(t, k)| signals[k][t]);
        let mut states = Array2::zeros((rows, system.states.len()));
        let mut x: Vec<f64> = system.states.iter().map(|s| uniform(s.start.0, s.start.1, rng)).collect();
        let mut next = x.clone();
        for t in 0..rows {
            states.row_mut(t).assign(&ndarray::aview1(&x));
            if t < steps {
                dynamics.step(&x, &controls.row(t).to_vec(), rng, &mut next).ok()?;
                std::mem::swap(&mut x, &mut next);
            }
        }
        let stays = states.iter().all(|v: &f64| v.abs() < AWAY);
        stays.then_some(Trajectory { states, controls, times: None })
    };
    (0..TRIES).find_map(|_| try_once(rng)).with_context(|| format!("{} runs away from every start", system.name))
}

/// Adds noise of `level` times each channel's standard deviation over all recordings.
fn disturb(trajectories: &mut [Trajectory], level: f64, rng: &mut Rng) {
    if level <= 0.0 {
        return;
    }
    let n = trajectories.first().map_or(0, |t| t.states.ncols());
    let channel = |i: usize| trajectories.iter().flat_map(move |t| t.states.index_axis(Axis(1), i).to_vec());
    let sigmas: Vec<f64> = (0..n).map(|i| level * deviation(&channel(i).collect::<Vec<_>>())).collect();
    for trajectory in trajectories {
        for mut row in trajectory.states.rows_mut() {
            for (value, sigma) in row.iter_mut().zip(&sigmas) {
                let normal: f64 = StandardNormal.sample(rng);
                *value += sigma * normal;
            }
        }
    }
}

/// Standard deviation of `values`.
pub(super) fn deviation(values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt()
}
