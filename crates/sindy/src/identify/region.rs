//! Where the equations will be used.

use std::f64::consts::PI;

use ndarray::Array2;
use sindyna_core::{Channel, Space, Spec};

use crate::library::{Input, Role};

/// Points drawn from the region.
const POINTS: usize = 256;

/// Points z = (x; u) (points, n + k) spread evenly over the region where equations for `spec` will be used: within the
/// declared range of each channel its typical magnitude or what the data `z` reached, a whole turn of angles that go
/// round, and the controls an agent may choose.
pub(super) fn points(spec: &Spec, channels: &[Channel], inputs: &[Input], z: &Array2<f64>) -> Array2<f64> {
    let n = channels.len();
    let range = |(i, (channel, input)): (usize, (&Channel, &Input))| {
        let reach = z.column(i).iter().fold(channel.prior.scale, |largest: f64, v| largest.max(v.abs()));
        if input.role == Role::Turning {
            (-PI, PI)
        } else {
            (channel.prior.bounds.0.max(-reach), channel.prior.bounds.1.min(reach))
        }
    };
    let all = channels.iter().chain(&spec.control).zip(inputs);
    let ranges: Vec<(f64, f64)> = all.enumerate().map(range).collect();
    let mut points = Array2::from_shape_fn((POINTS, ranges.len()), |(i, j)| {
        let (low, high) = ranges[j];
        low + (high - low) * spread(i, j)
    });
    if let Space::Discrete { controls } = &spec.action_space {
        for (i, mut point) in points.rows_mut().into_iter().enumerate() {
            let row = controls.row(i % controls.nrows().max(1));
            for (slot, u) in point.iter_mut().skip(n).zip(row) {
                *slot = *u;
            }
        }
    }
    points
}

/// The number of point `i` in dimension `j` of an evenly spread sequence on the unit cube.
///
/// # References
/// Richtmyer (1951): multiples of the square roots of primes, modulo 1. It needs no random number.
fn spread(i: usize, j: usize) -> f64 {
    const PRIMES: [f64; 16] =
        [2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0, 29.0, 31.0, 37.0, 41.0, 43.0, 47.0, 53.0];
    let step = (PRIMES[j % PRIMES.len()] + (j / PRIMES.len()) as f64 * 58.0).sqrt();
    (0.5 + (i + 1) as f64 * step).fract()
}
