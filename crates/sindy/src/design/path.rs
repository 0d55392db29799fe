//! Terms averaged over each step along a path.

use ndarray::Array2;

use crate::Expr;
use crate::data::{Segment, Signals};
use crate::expr::Tape;
use crate::library::Term;
use crate::shooting::{Flow, Inputs, Scratch, Stage};

/// What the states do between samples.
pub(crate) enum Path<'a> {
    /// As measured and smoothed: the cubic through values and derivatives at both ends of a step.
    Measured(&'a Signals),
    /// As equations say, from the states `x` (T + 1, n) of each segment.
    Model { flow: &'a Flow, xi: &'a [f64], x: &'a [Array2<f64>] },
    /// As at the sample before the step: for maps, and rates that hold for a whole step.
    Held { x: &'a [Array2<f64>] },
}

/// Abscissae and weights of Gauss–Lobatto quadrature with four points on \[0, 1\].
pub(crate) const LOBATTO: [(f64, f64); 4] =
    [(0.0, 1.0 / 12.0), (0.276_393_202_250_021, 5.0 / 12.0), (0.723_606_797_749_979, 5.0 / 12.0), (1.0, 1.0 / 12.0)];

/// The average of every term over each step of segment number `at` (T, F).
///
/// Where the path of a model does not end at the next state, the derivatives on it are moved by what is missing.
pub(crate) fn averages(terms: &[Term], segment: &Segment, at: usize, path: &Path<'_>) -> Array2<f64> {
    let (n, k) = (segment.x.ncols(), segment.u.ncols());
    let mut theta = Array2::zeros((segment.len(), terms.len()));
    // On the way of a model signs are what they are there, also between −1 and 1.
    let smooth: Vec<Expr> = match path {
        Path::Model { flow, .. } => terms.iter().map(|t| flow.switches().smooth(&t.expr)).collect(),
        _ => terms.iter().map(|t| t.expr.clone()).collect(),
    };
    let n_modes = if let Path::Model { flow, .. } = path { flow.switches().len() } else { 0 };
    let tape = Tape::new(n + k + n_modes, &smooth);
    let mut registers = vec![0.0; tape.n_registers()];
    let mut way = Way::default();
    for t in 0..segment.len() {
        let mut add = |stage: &Stage<'_>| {
            registers[..n + k].copy_from_slice(stage.z.as_flattened());
            registers[n + k..n + k + n_modes].copy_from_slice(stage.modes.as_flattened());
            tape.run(&mut registers);
            for (j, (term, &register)) in terms.iter().zip(tape.outputs()).enumerate() {
                let rate = term.rate.map_or(1.0, |l| stage.x_dot[l][0]);
                theta[[t, j]] += stage.weight * registers[register as usize] * rate;
            }
        };
        match path {
            Path::Measured(signals) => hermite(segment, t, &signals.x[at], &signals.x_dot[at], &mut add),
            Path::Held { x } => {
                let z: Vec<f64> = x[at].row(t).iter().chain(segment.u.row(t)).copied().collect();
                let rate = |i: usize| (x[at][[t + 1, i]] - x[at][[t, i]]) / segment.dt[t];
                let x_dot: Vec<f64> = (0..n).map(rate).collect();
                add(&Stage { weight: 1.0, z: z.as_chunks().0, x_dot: x_dot.as_chunks().0, modes: &[] });
            }
            Path::Model { flow, xi, x } => way.follow(flow, xi, segment, t, &x[at], &mut add),
        }
    }
    theta
}

/// Visits the points of the quadrature along the cubic through values `x` and derivatives `x_dot` at both ends.
fn hermite(segment: &Segment, t: usize, x: &Array2<f64>, x_dot: &Array2<f64>, add: &mut dyn FnMut(&Stage<'_>)) {
    let (n, h) = (x.ncols(), segment.dt[t]);
    let mut z = vec![0.0; n + segment.u.ncols()];
    let mut slopes = vec![0.0; n];
    let (u, ramp) = segment.input(t);
    z[n..].copy_from_slice(&u);
    for (s, weight) in LOBATTO {
        let part = segment.ramp.as_ref().map_or(s, |ramp| ramp.after(s, segment.dt[t]));
        z[n..].iter_mut().zip(u.iter().zip(&ramp)).for_each(|(slot, (u, ramp))| *slot = u + part * ramp);
        for i in 0..n {
            let (a, b) = (x[[t, i]], x[[t + 1, i]]);
            let (p, q) = (h * x_dot[[t, i]], h * x_dot[[t + 1, i]]);
            let (c, d) = (3.0 * (b - a) - 2.0 * p - q, 2.0 * (a - b) + p + q);
            z[i] = a + s * (p + s * (c + s * d));
            slopes[i] = (p + s * (2.0 * c + 3.0 * s * d)) / h;
        }
        add(&Stage { weight, z: z.as_chunks().0, x_dot: slopes.as_chunks().0, modes: &[] });
    }
}

/// The stages of one step.
#[derive(Default)]
struct Way {
    scratch: Option<Scratch>,
    next: Vec<f64>,
    weights: Vec<f64>,
    /// (x; u), one stage after the other.
    z: Vec<f64>,
    /// ẋ likewise.
    x_dot: Vec<f64>,
    /// Signs of the switches likewise.
    modes: Vec<f64>,
}

impl Way {
    /// Visits the stages of the step of `flow` from row t of `x`.
    fn follow(
        &mut self,
        flow: &Flow,
        xi: &[f64],
        segment: &Segment,
        t: usize,
        x: &Array2<f64>,
        add: &mut dyn FnMut(&Stage<'_>),
    ) {
        let n = x.ncols();
        let Self { scratch, next, weights, z, x_dot, modes } = self;
        let scratch = scratch.get_or_insert_with(|| flow.scratch());
        next.resize(n, 0.0);
        weights.clear();
        z.clear();
        x_dot.clear();
        modes.clear();
        let (now, (u, ramp)) = (x.row(t).to_vec(), segment.input(t));
        let inputs = Inputs::of((&u, &ramp), segment.intersample());
        flow.step((&now, inputs, segment.dt[t]), xi, next, None, scratch, &mut |stage| {
            weights.push(stage.weight);
            z.extend_from_slice(stage.z.as_flattened());
            x_dot.extend_from_slice(stage.x_dot.as_flattened());
            modes.extend_from_slice(stage.modes.as_flattened());
        });
        for (s, &weight) in weights.iter().enumerate() {
            let x_dot = &mut x_dot[s * n..(s + 1) * n];
            for i in 0..n {
                x_dot[i] += (x[[t + 1, i]] - next[i]) / segment.dt[t];
            }
            let (width, m) = (n + u.len(), flow.switches().len());
            let (z, modes) = (&z[s * width..(s + 1) * width], &modes[s * m..(s + 1) * m]);
            add(&Stage { weight, z: z.as_chunks().0, x_dot: x_dot.as_chunks().0, modes: modes.as_chunks().0 });
        }
    }
}
