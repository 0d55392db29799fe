//! Gradients against central differences of the losses, written out plainly in double precision.

use sindyna_core::Batch;

use super::{STILL, agent, batch, distance};
use crate::{Sac, SacConfig, gaussian::Squashed, mlp::Mlp};

const M: usize = 3;
const K: usize = 2;
const ROWS: usize = 24;
const TEMPERATURE: f64 = 0.4;

/// A network's parameters in double precision, and its layers walked through one number at a time.
pub(super) struct Plain {
    sizes: Vec<usize>,
    params: Vec<f64>,
}

impl Plain {
    pub(super) fn of(net: &Mlp) -> Self {
        Self { sizes: net.sizes().to_vec(), params: net.params.iter().map(|p| f64::from(*p)).collect() }
    }

    pub(super) fn run(&self, x: &[f64]) -> Vec<f64> {
        let (mut x, mut start) = (x.to_vec(), 0);
        for (l, widths) in self.sizes.windows(2).enumerate() {
            let (inputs, outputs) = (widths[0], widths[1]);
            let biases = start + inputs * outputs;
            let sum = |o| (0..inputs).map(|i| x[i] * self.params[start + i * outputs + o]).sum::<f64>();
            let y: Vec<f64> = (0..outputs).map(|o| sum(o) + self.params[biases + o]).collect();
            x = if l + 2 < self.sizes.len() { y.into_iter().map(|v| v.max(0.0)).collect() } else { y };
            start = biases + outputs;
        }
        x
    }

    /// Central differences of `loss` over every parameter.
    pub(super) fn gradient(mut self, loss: impl Fn(&Self) -> f64) -> Vec<f64> {
        let h = 1e-5;
        let mut slopes = Vec::new();
        for i in 0..self.params.len() {
            let p = self.params[i];
            let [above, below] = [p + h, p - h].map(|moved| {
                self.params[i] = moved;
                loss(&self)
            });
            self.params[i] = p;
            slopes.push((above - below) / (2.0 * h));
        }
        slopes
    }
}

/// Action and log-density of one row.
fn draw(head: &[f64], noise: &[f64]) -> (Vec<f64>, f64) {
    let (mut actions, mut log_prob) = (Vec::new(), 0.0);
    for (j, e) in noise.iter().enumerate() {
        let log_std = head[K + j].clamp(-20.0, 2.0);
        let a = (head[j] + log_std.exp() * e).tanh();
        log_prob += -e * e / 2.0 - log_std - std::f64::consts::TAU.sqrt().ln() - (1.0 - a * a + 1e-6).ln();
        actions.push(a);
    }
    (actions, log_prob)
}

fn value(critic: &Plain, o: &[f64], a: &[f64]) -> f64 {
    critic.run(&[o, a].concat())[0]
}

/// An agent whose update has left its gradients behind, the batch, and the noise of ã.
fn updated() -> (Sac, Batch, Vec<f64>) {
    let config = SacConfig {
        hidden: vec![8, 7, 6],
        learning_rate: STILL,
        initial_temperature: TEMPERATURE,
        ..SacConfig::default()
    };
    let (mut sac, batch) = (agent(config, M, K), batch(ROWS, M, K));
    let noise: Vec<f64> = (0..2 * ROWS * K).map(|i| 1.5 * (2.3 * i as f64).sin()).collect();
    sac.update_with_noise(&batch, &noise).expect("finite losses");
    (sac, batch, noise[..ROWS * K].to_vec())
}

pub(super) fn row(table: &ndarray::Array2<f64>, i: usize) -> Vec<f64> {
    table.row(i).to_vec()
}

#[test]
fn critic_gradients_are_those_of_the_squared_error() {
    let (sac, batch, _) = updated();
    for critic in &sac.learner.critics {
        let targets = sac.learner.targets.clone();
        let loss = |net: &Plain| {
            let error = |i| value(net, &row(&batch.observations, i), &row(&batch.actions, i)) - f64::from(targets[i]);
            (0..ROWS).map(|i| 0.5 * error(i) * error(i)).sum::<f64>() / ROWS as f64
        };
        let error = distance(&critic.gradients, &Plain::of(&critic.net).gradient(loss));
        assert!(error < 3e-6, "off by {error:e}");
    }
}

#[test]
fn actor_gradients_go_through_the_squashed_gaussian_and_the_lesser_critic() {
    let (sac, batch, noise) = updated();
    let critics = [Plain::of(&sac.learner.critics[0].net), Plain::of(&sac.learner.critics[1].net)];
    let loss = |net: &Plain| {
        let of_row = |i: usize| {
            let o = row(&batch.observations, i);
            let (a, log_prob) = draw(&net.run(&o), &noise[i * K..(i + 1) * K]);
            TEMPERATURE * log_prob - value(&critics[0], &o, &a).min(value(&critics[1], &o, &a))
        };
        (0..ROWS).map(of_row).sum::<f64>() / ROWS as f64
    };
    let error = distance(&sac.learner.actor_gradients, &Plain::of(&sac.policy.net.net).gradient(loss));
    assert!(error < 3e-6, "off by {error:e}");
}

#[test]
fn the_head_is_differentiated_also_where_it_is_clamped_or_saturated() {
    // (mean, log σ, ε): free, saturated, clamped above and below.
    for (mean, log_std, e) in [(0.3, -0.5, 0.7), (4.0, 0.0, 1.0), (-9.0, 1.0, 0.2), (0.1, 2.5, 0.4), (0.2, -25.0, 1.3)]
    {
        let (d_action, d_log_prob) = (0.8_f64, 0.3);
        let loss = |mean: f64, log_std: f64| {
            let log_std = log_std.clamp(-20.0, 2.0);
            let u: f64 = mean + log_std.exp() * e;
            // 1 - tanh² as 1/cosh², because the difference has no digits left where u is large.
            d_action * u.tanh() - d_log_prob * (log_std + (1.0 / u.cosh().powi(2) + 1e-6).ln())
        };
        let h = 1e-6;
        let slopes = [
            (loss(mean + h, log_std) - loss(mean - h, log_std)) / (2.0 * h),
            (loss(mean, log_std + h) - loss(mean, log_std - h)) / (2.0 * h),
        ];
        let (mut drawn, mut d_head) = (Squashed::default(), Vec::new());
        drawn.draw(&[mean as f32, log_std as f32], &[e], 1);
        drawn.backward(&[d_action as f32], d_log_prob, 1, &mut d_head);
        for (ours, slope) in d_head.iter().zip(slopes) {
            assert!((f64::from(*ours) - slope).abs() < 1e-6 * (1.0 + slope.abs()), "{mean} {log_std}: {ours} {slope}");
        }
    }
}

#[test]
fn densities_and_gradients_are_finite_however_far_the_head_goes() {
    for magnitude in [1e-3, 1.0, 10.0, 20.0, 100.0, 1e3, 1e30] {
        for (mean, log_std) in [(magnitude, 0.0), (-magnitude, 0.0), (0.0, magnitude), (0.0, -magnitude)] {
            for e in [-5.0, 0.0, 5.0] {
                let (mut drawn, mut d_head) = (Squashed::default(), Vec::new());
                drawn.draw(&[mean, log_std], &[e], 1);
                drawn.backward(&[1.0], 1.0, 1, &mut d_head);
                assert!(drawn.log_probs[0].is_finite() && drawn.actions[0].abs() <= 1.0, "{mean} {log_std} {e}");
                assert!(d_head.iter().all(|d| d.is_finite()), "{mean} {log_std} {e}: {d_head:?}");
            }
        }
    }
}
