//! Gradients against central differences of the loss, written out plainly in double precision.

use sindyna_core::Seed;

use super::{Activation, Ensemble, EnsembleConfig, EnsembleTrainer, rows::Table, step::Step};
use crate::Isa;

const ROWS: usize = 37;
const D: usize = 3;
const Q: usize = 2;

fn wave(n: usize, phase: f64) -> Vec<f32> {
    (0..n).map(|i| (1.7 * i as f64 + phase).sin() as f32).collect()
}

fn batch() -> Table {
    Table { inputs: wave(ROWS * D, 0.3), targets: wave(ROWS * Q, 2.0) }
}

fn ensemble(activation: Activation, isa: Isa) -> Ensemble {
    let config = EnsembleConfig {
        members: 2,
        elites: 1,
        hidden: vec![9, 17],
        activation,
        weight_decay: vec![0.0; 3],
        bound_weight: 0.05,
        ..EnsembleConfig::janner()
    };
    let trainer = EnsembleTrainer::new(config).expect("usable settings").with_isa(isa).expect("filtered");
    let mut ensemble = trainer.begin(D, Q, &mut Seed::new(3).numpy());
    // Bounds near the variances, so that both of their slopes are felt, and biases other than 0.
    ensemble.bounds = vec![0.4, 0.7, -1.0, -0.6];
    for (i, member) in ensemble.members.iter_mut().enumerate() {
        let nudges = wave(member.net.params.len(), i as f64);
        member.net.params.iter_mut().zip(nudges).for_each(|(p, n)| *p += 0.3 * n);
    }
    ensemble
}

/// The loss of all members and the bounds (decay is Adam's, and tested there), as a function of all parameters in their public order.
fn loss(ensemble: &Ensemble, params: &[f64], batch: &Table) -> f64 {
    let config = &ensemble.config;
    let (nets, bounds) = params.split_at(params.len() - 2 * Q);
    let (high, low) = bounds.split_at(Q);
    let mut loss = config.bound_weight * (high.iter().sum::<f64>() - low.iter().sum::<f64>());
    let softplus = |x: f64| x.exp().ln_1p();
    for net in nets.chunks_exact(nets.len() / config.members) {
        let (mut start, mut layers) = (0, Vec::new());
        for w in config.widths(D, Q).windows(2) {
            let weights = &net[start..start + w[0] * w[1]];
            let biases = &net[start + w[0] * w[1]..start + (w[0] + 1) * w[1]];
            layers.push((weights, biases));
            start += (w[0] + 1) * w[1];
        }
        for (x, y) in batch.inputs.chunks_exact(D).zip(batch.targets.chunks_exact(Q)) {
            let mut x: Vec<f64> = x.iter().map(|v| f64::from(*v)).collect();
            for (l, (weights, biases)) in layers.iter().enumerate() {
                let n = biases.len();
                let sum = |o: usize| biases[o] + x.iter().enumerate().map(|(i, v)| v * weights[i * n + o]).sum::<f64>();
                x = (0..n).map(sum).collect();
                if l + 1 < layers.len() {
                    x.iter_mut().for_each(|z| {
                        *z = match config.activation {
                            Activation::Relu => z.max(0.0),
                            Activation::Swish => *z / (1.0 + (-*z).exp()),
                        }
                    });
                }
            }
            for j in 0..Q {
                let log_var = high[j] - softplus(high[j] - x[Q + j]);
                let log_var = low[j] + softplus(log_var - low[j]);
                let error = x[j] - f64::from(y[j]);
                loss += (error * error * (-log_var).exp() + log_var) / (ROWS * Q) as f64;
            }
        }
    }
    loss
}

#[test]
fn gradients_are_the_slopes_of_the_loss() {
    for isa in Isa::ALL.into_iter().filter(|isa| isa.present()) {
        for activation in [Activation::Relu, Activation::Swish] {
            let (ensemble, batch) = (ensemble(activation, isa), batch());
            let mut step = Step::new(&ensemble);
            step.begin(&ensemble);
            let mut ours: Vec<f64> = Vec::new();
            for i in 0..ensemble.members.len() {
                step.gradient(&ensemble, i, &batch);
                ours.extend(step.gradients.iter().map(|g| f64::from(*g)));
            }
            ours.extend(&step.d_bounds);
            let mut params: Vec<f64> = ensemble.parameters().map(f64::from).collect();
            let (h, mut difference, mut norm) = (1e-5, 0.0, 0.0);
            for i in 0..params.len() {
                let p = params[i];
                let [above, below] = [p + h, p - h].map(|moved| {
                    params[i] = moved;
                    loss(&ensemble, &params, &batch)
                });
                params[i] = p;
                let slope: f64 = (above - below) / (2.0 * h);
                assert!((ours[i] - slope).abs() < 2e-5, "{isa} {activation:?}: {i}: {} is not {slope}", ours[i]);
                difference += (ours[i] - slope).powi(2);
                norm += slope * slope;
            }
            let distance = (difference / norm).sqrt();
            assert!(distance < 1e-6, "{isa} {activation:?}: relative distance {distance}");
        }
    }
}
