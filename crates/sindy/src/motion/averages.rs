//! The terms of an equation averaged over each step.

use ndarray::Array2;
use sindyna_core::VectorField as _;

use super::{Run, Stepping};
use crate::Model;
use crate::expr::Tape;
use crate::library::Term;

/// A place on the way from one sample to the next, with its weight in the average.
struct Node<'a> {
    weight: f64,
    /// (x; u) there.
    z: &'a [f64],
    /// ẋ there.
    rates: &'a [f64],
}

/// What equations can be made of.
#[derive(Clone, Copy)]
pub(crate) struct System<'a> {
    pub(crate) terms: &'a [Term],
    /// How many of the terms are tried before the others.
    pub(crate) core: usize,
    /// Per state: the state that is its rate.
    pub(crate) rates: &'a [Option<usize>],
    /// States that are angles.
    pub(crate) angles: &'a [usize],
    /// Control interval \[s\].
    pub(crate) dt: f64,
}

impl System<'_> {
    /// The average of every term over each step of `run` (T, F), along the way that `model` takes from sample to sample;
    /// without one, along a cubic through them.
    ///
    /// With the model's own coefficients these averages add up to exactly the step the model takes. `offsets` are added
    /// to the states before the terms are computed. Terms that are not `wanted` are left at zero.
    pub(super) fn averages(
        &self,
        run: &Run,
        stepping: Stepping,
        model: Option<&Model>,
        offsets: &[f64],
        wanted: &[usize],
    ) -> Array2<f64> {
        let mut theta = Array2::zeros((run.len(), self.terms.len()));
        let n_inputs = run.x.ncols() + run.u.ncols();
        let mut wanted = wanted.to_vec();
        wanted.sort_unstable();
        wanted.dedup();
        let tape = Tape::new(n_inputs, wanted.iter().map(|&j| &self.terms[j].expr));
        let mut registers = vec![0.0; tape.n_registers()];
        let mut way = Way::default();
        for t in 0..run.len() {
            let mut add = |node: &Node<'_>| {
                registers[..n_inputs].copy_from_slice(node.z);
                for (register, offset) in registers.iter_mut().zip(offsets) {
                    *register += offset;
                }
                tape.run(&mut registers);
                for (&j, &register) in wanted.iter().zip(tape.outputs()) {
                    let rate = self.terms[j].rate.map_or(1.0, |l| node.rates[l]);
                    theta[[t, j]] += node.weight * registers[register as usize] * rate;
                }
            };
            match (stepping, model) {
                (Stepping::Euler | Stepping::SemiImplicit { substeps: 0 | 1 }, _) => {
                    let z: Vec<f64> = run.x.row(t).iter().chain(run.u.row(t)).copied().collect();
                    add(&Node { weight: 1.0, z: &z, rates: &self.increments(run, t) });
                }
                (Stepping::Continuous { .. } | Stepping::Classical { .. } | Stepping::SemiImplicit { .. }, None) => {
                    self.cubic(run, t, &mut add)
                }
                (Stepping::Continuous { substeps } | Stepping::Classical { substeps }, Some(model)) => {
                    self.stages(run, t, model, substeps, &mut way, &mut add)
                }
                (Stepping::SemiImplicit { substeps }, Some(model)) => {
                    self.steps(run, t, model, substeps, &mut way, &mut add)
                }
            }
        }
        theta
    }

    /// (x⁺ − x)/Δt.
    pub(super) fn increments(&self, run: &Run, t: usize) -> Vec<f64> {
        run.x.row(t + 1).iter().zip(run.x.row(t)).map(|(next, now)| (next - now) / self.dt).collect()
    }

    /// Simpson's rule over both samples and the middle of the cubic through states and rates at both ends. Where there
    /// is no rate to go by, the way is straight.
    fn cubic(&self, run: &Run, t: usize, add: &mut impl FnMut(&Node<'_>)) {
        let (now, next) = (run.x.row(t), run.x.row(t + 1));
        let n = now.len();
        let increments = self.increments(run, t);
        let mut places = [now.to_vec(), (0..n).map(|i| 0.5 * (now[i] + next[i])).collect(), next.to_vec()];
        let mut rates = [increments.clone(), increments.clone(), increments.clone()];
        for (i, v) in self.rates.iter().enumerate().filter_map(|(i, v)| v.map(|v| (i, v))) {
            let (before, after) = (now[v], next[v]);
            // How far the mean rate lies from the mean of the rates: what the cubic bends more than a parabola.
            let bend = increments[i] - 0.5 * (before + after);
            places[1][i] += self.dt / 8.0 * (before - after);
            places[1][v] += 1.5 * bend;
            rates[0][v] += 6.0 * bend / self.dt;
            rates[2][v] -= 6.0 * bend / self.dt;
        }
        for ((weight, x), rates) in [1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0].into_iter().zip(&mut places).zip(&rates) {
            x.extend(run.u.row(t));
            add(&Node { weight, z: x, rates });
        }
    }

    /// The stages of the Runge–Kutta steps of `model`; where its accelerations miss the data's on average, they are moved.
    fn stages(
        &self,
        run: &Run,
        t: usize,
        model: &Model,
        substeps: usize,
        way: &mut Way,
        add: &mut impl FnMut(&Node<'_>),
    ) {
        let (n, k) = (run.x.ncols(), run.u.ncols());
        let weights = [1.0, 2.0, 2.0, 1.0].map(|w| w / (6.0 * substeps as f64));
        let h = self.dt / substeps as f64;
        way.places.resize(4 * substeps * (n + k), 0.0);
        way.slopes.resize(4 * substeps * n, 0.0);
        let mut x: Vec<f64> = run.x.row(t).to_vec();
        for slot in way.places.chunks_exact_mut(n + k) {
            slot[n..].iter_mut().zip(run.u.row(t)).for_each(|(slot, u)| *slot = *u);
        }
        for (places, slopes) in way.places.chunks_exact_mut(4 * (n + k)).zip(way.slopes.chunks_exact_mut(4 * n)) {
            for s in 0..4 {
                let reach = [0.0, 0.5 * h, 0.5 * h, h][s];
                let (before, slope) = slopes.split_at_mut(s * n);
                let (z, u) = places[s * (n + k)..(s + 1) * (n + k)].split_at_mut(n);
                for i in 0..n {
                    z[i] = x[i] + if s > 0 { reach * before[(s - 1) * n + i] } else { 0.0 };
                }
                model.eval(z, u, &mut slope[..n]);
            }
            for (i, x) in x.iter_mut().enumerate() {
                *x += h / 6.0 * (slopes[i] + 2.0 * slopes[n + i] + 2.0 * slopes[2 * n + i] + slopes[3 * n + i]);
            }
        }
        way.add_to(self.increments(run, t), n + k, &weights, add);
    }

    /// The beginnings of the semi-implicit steps of `model`; where its accelerations miss the data's on average, they are moved.
    fn steps(
        &self,
        run: &Run,
        t: usize,
        model: &Model,
        substeps: usize,
        way: &mut Way,
        add: &mut impl FnMut(&Node<'_>),
    ) {
        let (n, k) = (run.x.ncols(), run.u.ncols());
        let h = self.dt / substeps as f64;
        way.places.resize(substeps * (n + k), 0.0);
        way.slopes.resize(substeps * n, 0.0);
        let mut x: Vec<f64> = run.x.row(t).to_vec();
        for (z, slope) in way.places.chunks_exact_mut(n + k).zip(way.slopes.chunks_exact_mut(n)) {
            let (z, u) = z.split_at_mut(n);
            z.copy_from_slice(&x);
            u.iter_mut().zip(run.u.row(t)).for_each(|(slot, u)| *slot = *u);
            model.eval(z, u, slope);
            x.iter_mut().zip(&*slope).for_each(|(x, slope)| *x += h * slope);
            for &i in model.positions() {
                let Some(v) = self.rates[i] else { continue };
                (slope[i], x[i]) = (x[v], z[i] + h * x[v]);
            }
        }
        way.add_to(self.increments(run, t), n + k, &[1.0 / substeps as f64], add);
    }
}

/// Where the stages of one step lie, one after the other: (x; u) and ẋ.
#[derive(Default)]
struct Way {
    places: Vec<f64>,
    slopes: Vec<f64>,
}

impl Way {
    /// Adds all stages, with `weights` in turn and rates moved so that they add up to `increments` (n). A place has `width` values.
    fn add_to(&mut self, increments: Vec<f64>, width: usize, weights: &[f64], add: &mut impl FnMut(&Node<'_>)) {
        let n = increments.len();
        let mut miss = increments;
        for (slope, weight) in self.slopes.chunks_exact(n).zip(weights.iter().cycle()) {
            miss.iter_mut().zip(slope).for_each(|(miss, slope)| *miss -= weight * slope);
        }
        let stages = self.places.chunks_exact(width).zip(self.slopes.chunks_exact_mut(n));
        for ((z, rates), weight) in stages.zip(weights.iter().cycle()) {
            rates.iter_mut().zip(&miss).for_each(|(rate, miss)| *rate += miss);
            add(&Node { weight: *weight, z, rates });
        }
    }
}
