//! The RealAI score of simulated runs, version 2.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::plant::{DT, LENGTHS, STEPS};

/// Height of the tip, as a part of the largest, above which the pendulum is up.
const UP: f64 = 0.9;

/// What a run is judged by.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct Score {
    /// After which it stays up \[s\]; the length of the run if it does not.
    pub(crate) time: f64,
    /// Σ |Δq τ| \[J\].
    pub(crate) energy: f64,
    /// Σ τ² Δt \[N² m² s\].
    pub(crate) torque: f64,
    /// Standard deviation of the changes of the torques from step to step \[N m\].
    pub(crate) smoothness: f64,
    /// Σ q̇² Δt \[rad²/s\].
    pub(crate) velocity: f64,
    /// success · (1 − mean of tanh(π c/n)).
    pub(crate) score: f64,
}

/// What the criteria are divided by: time, energy, torque, smoothness, velocity.
pub(crate) const NORMS: [f64; 5] = [20.0, 60.0, 20.0, 0.1, 400.0];

/// Height of the tip \[m\].
pub(crate) fn height(q1: f64, q2: f64) -> f64 {
    -LENGTHS[0] * q1.cos() - LENGTHS[1] * (q1 + q2).cos()
}

/// Whether the pendulum is up.
pub(crate) fn is_up(q1: f64, q2: f64) -> bool {
    height(q1, q2) > UP * (LENGTHS[0] + LENGTHS[1])
}

impl Score {
    /// Its criteria, in the order of [`NORMS`].
    pub(crate) fn criteria(&self) -> [f64; 5] {
        [self.time, self.energy, self.torque, self.smoothness, self.velocity]
    }

    /// The score of states (T) and the torques applied from each to the next (T); the last is not counted.
    pub(crate) fn of(x: &[[f64; 4]], torque: &[[f64; 2]]) -> Self {
        let last = x.len().min(torque.len()).saturating_sub(1);
        let down = (1..last).rev().find(|t| !is_up(x[*t][0], x[*t][1]));
        let first = down.map_or(1, |down| down + 1).min(last);
        let time = first as f64 * DT;
        let (mut energy, mut cost, mut velocity) = (0.0, 0.0, 0.0);
        for t in 0..last {
            for j in 0..2 {
                energy += ((x[t + 1][j] - x[t][j]) * torque[t][j]).abs();
                cost += torque[t][j].powi(2) * DT;
                velocity += x[t][2 + j].powi(2) * DT;
            }
        }
        let smoothness = (0..2).map(|j| spread(torque[..=last].windows(2).map(|pair| pair[1][j] - pair[0][j]))).sum();
        let criteria = [time, energy, cost, smoothness, velocity];
        let lost: f64 = criteria.iter().zip(NORMS).map(|(c, n)| (PI * c / n).tanh()).sum();
        let success = first < last && last + 1 >= STEPS;
        let score = if success { 1.0 - lost / NORMS.len() as f64 } else { 0.0 };
        Self { time, energy, torque: cost, smoothness, velocity, score }
    }
}

/// Standard deviation, of the whole population.
fn spread(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / count;
    (values.map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt()
}
