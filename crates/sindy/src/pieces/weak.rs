//! Rows of the weak form: momenta balanced over windows.

use ndarray::Array2;

use super::grouped::{Group, block};
use crate::data::Segment;
use crate::library::Lagrangian;
use crate::mechanics::{Steps, balance};

/// Windows begin every so manieth part of their length.
const OVERLAP: f64 = 4.0;

/// Steps of a window, at least.
const FEWEST: usize = 8;

/// What every parameter of a Lagrangian changes of the momenta over windows.
pub(super) struct Weak {
    /// Per window, a row for each joint (joints, parameters).
    windows: Vec<Array2<f64>>,
}

/// Per segment and joint, the balance of each step.
pub(super) type Balances = Vec<Vec<Array2<f64>>>;

/// The balance of each step of `segments`.
pub(super) fn balances(lagrangian: &Lagrangian, segments: &[Segment]) -> Balances {
    let of = |s: &Segment| balance(lagrangian, Steps { x: s.x.view(), u: s.mean_inputs().view(), dt: &s.dt }, false);
    segments.iter().map(of).collect()
}

impl Weak {
    /// Windows of `seconds`: −∫ φ̇ p dt = ∫ φ (∂L/∂q + f) dt with φ = (1 − s²)⁴ over s from −1 to 1, which needs no derivative of what was measured.
    ///
    /// # References
    /// Messenger, Bortz (2021), Weak SINDy, Multiscale Model. Simul. 19(3), eq. 2.5.
    pub(super) fn new(balances: &Balances, segments: &[Segment], seconds: f64) -> Self {
        let mut windows = Vec::new();
        for (joints, segment) in balances.iter().zip(segments) {
            let mut middles = Vec::with_capacity(segment.len());
            let mut time = 0.0;
            for dt in &segment.dt {
                middles.push(time + 0.5 * dt);
                time += dt;
            }
            let mut from = 0.0;
            while from + seconds <= time {
                let steps = middles.partition_point(|t| *t < from)..middles.partition_point(|t| *t < from + seconds);
                if steps.len() >= FEWEST {
                    let mut window = Array2::zeros((joints.len(), joints.first().map_or(0, Array2::ncols)));
                    for t in steps {
                        let s = 2.0 * (middles[t] - from) / seconds - 1.0;
                        let weight = (1.0 - s * s).max(0.0).powi(4);
                        for (mut row, own) in window.rows_mut().into_iter().zip(joints) {
                            row.scaled_add(weight, &own.row(t));
                        }
                    }
                    windows.push(window);
                }
                from += seconds / OVERLAP;
            }
        }
        Self { windows }
    }

    /// The rows of the parameters `choice` for what `unit` explains, those of each joint divided by its `sizes`.
    pub(super) fn groups(&self, (unit, choice): (usize, &[usize]), sizes: &[f64]) -> Vec<Group> {
        let count = self.windows.len();
        let group = |(at, window): (usize, &Array2<f64>)| {
            let value = |(row, c): (usize, usize)| {
                choice.get(c).map_or_else(|| -window[[row, unit]], |p| window[[row, *p]]) / sizes[row]
            };
            Group { rows: Array2::from_shape_fn((window.nrows(), choice.len() + 1), value), block: block(at, count) }
        };
        self.windows.iter().enumerate().map(group).collect()
    }

    /// RMS of the momentum that each joint exchanges in a window, by the inertias among the `parameters`; 1 for none.
    pub(super) fn exchanged(&self, lagrangian: &Lagrangian, parameters: &[(usize, f64)]) -> Vec<f64> {
        let inertias: Vec<(usize, f64)> =
            parameters.iter().copied().filter(|(p, _)| !lagrangian.momenta(*p).is_empty()).collect();
        let of = |row: usize| {
            let square =
                |window: &Array2<f64>| inertias.iter().map(|(p, c)| c * window[[row, *p]]).sum::<f64>().powi(2);
            let mean = self.windows.iter().map(square).sum::<f64>() / self.windows.len().max(1) as f64;
            Some(mean.sqrt()).filter(|size| *size > 0.0 && size.is_finite()).unwrap_or(1.0)
        };
        (0..lagrangian.joints.len()).map(of).collect()
    }

    /// How many windows there are.
    pub(super) fn len(&self) -> usize {
        self.windows.len()
    }
}
