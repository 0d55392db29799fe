//! Inputs that were rounded when they were written, as the states tell what they were.

use nalgebra::DMatrix;
use ndarray::{Array2, ArrayView2};

use super::eliminate::Elimination;
use super::flow::Flow;
use super::passes::Samples;
use super::slack::slack;
use super::state::{ASKED, State, direction};
use super::work::Work;
use crate::Triangle;
use crate::data::Segment;

/// Part of the error of an input by which it may change while it is held.
const HELD: f64 = 1e-3;

/// Standard deviations of an input's error by which it may be corrected: a whole step.
const MOST: f64 = 3.46;

/// Part of the largest value of an input over which differences are taken, at least.
const NUDGE: f64 = 1e-6;

/// What the states tell of inputs.
pub(crate) struct Told {
    /// By how much the inputs of each segment differ from those that were written (T, k).
    pub(crate) by: Vec<Array2<f64>>,
    /// −2 ln of how likely these differences are, with what is known of them before and after, but for what the states then leave.
    pub(crate) price: f64,
    /// The factor of all rows over the coefficients, whitened, whatever the inputs were.
    pub(crate) triangle: Triangle,
    /// By how much the coefficients differ then.
    pub(crate) change: Vec<f64>,
}

/// What `segments` tell of the inputs that were rounded, if `flow` has coefficients near `xi` and states near `x`, which may miss it by `part` of their noise in every step. `None` if a step is not finite, or `go_on` says no.
///
/// Where `along` (p, ·) is given, coefficients move along its columns alone.
///
/// The error of an input is a state that stays the same while the input is held, and begins anew, with the standard deviation that the segment tells, when it changes:
/// one linear least squares over states, errors and coefficients.
pub(crate) fn inputs(
    (flow, along): (&Flow, Option<&DMatrix<f64>>),
    segments: &[Segment],
    (xi, x): (&[f64], &[Array2<f64>]),
    sigma: &[f64],
    part: f64,
    (work, go_on): (&Work, &dyn Fn() -> bool),
) -> Option<Told> {
    let (n, n_xi) = (sigma.len(), flow.n_parameters());
    let p = along.map_or(n_xi, DMatrix::ncols);
    let mut state = State::new(xi.to_vec(), x.to_vec(), sigma.to_vec());
    if !state.miss(flow, segments, work) {
        return None;
    }
    // Once without the inputs, once with them.
    (0..2).for_each(|_| work.elimination(flow, segments));
    let known = state.eliminated(flow, segments, (part, false), go_on, None)?.1;
    // Of inputs that say nothing of the states the prior alone is left.
    let mut volume: f64 = known.iter().map(Elimination::volume).sum();
    let mut triangle = Triangle::new(p + 1);
    let mut eliminations = Vec::with_capacity(segments.len());
    for (at, segment) in segments.iter().enumerate() {
        let rounded: Vec<usize> =
            (0..segment.u.ncols()).filter(|&j| segment.of_inputs.get(j).is_some_and(|s| *s > 0.0)).collect();
        let k = rounded.len();
        let slopes = slopes_of_inputs(flow, segment, (xi, &x[at]), &rounded)?;
        let by = |t: usize, j: usize| segment.corrections.as_ref().map_or(0.0, |by| by[[t, j]]);
        let mut elimination = Elimination::new(n + k, p, true);
        let q = slack(flow, segment, sigma, part);
        let sample = |t: usize| -> (Vec<f64>, Vec<f64>) {
            let seen = (0..n).map(|i| (segment.x[[t, i]] - x[at][[t, i]], sigma[i] * segment.relative(t, i)));
            let of_input = |&j: &usize| if t == 0 { (-by(0, j), segment.of_inputs[j]) } else { (0.0, f64::INFINITY) };
            seen.chain(rounded.iter().map(of_input)).unzip()
        };
        volume -= rounded.iter().map(|&j| segment.of_inputs[j].ln()).sum::<f64>();
        let rough = flow.for_derivatives();
        let width = n + k + p;
        let mut s = vec![0.0; (n + k) * width];
        let samples = Samples { segment, x: &x[at], every: 1 };
        let whole = rough.each_step(samples, xi, true, &mut |made| {
            let t = made.t;
            s.fill(0.0);
            let mut d: Vec<f64> = state.missed[at].row(t).iter().map(|d| -d).collect();
            let mut q = q.clone();
            for i in 0..n {
                let (of_state, row) =
                    (&made.s[i * (n + n_xi)..(i + 1) * (n + n_xi)], &mut s[i * width..(i + 1) * width]);
                row[..n].copy_from_slice(&of_state[..n]);
                (0..k).for_each(|j| row[n + j] = slopes[[t, i * k + j]]);
                match along {
                    Some(along) => row[n + k..].iter_mut().zip(along.column_iter()).for_each(|(slot, column)| {
                        *slot = of_state[n..].iter().zip(&column).map(|(s, by)| s * by).sum();
                    }),
                    None => row[n + k..].copy_from_slice(&of_state[n..]),
                }
            }
            for (place, &j) in rounded.iter().enumerate() {
                let error = segment.of_inputs[j];
                let stays = t + 1 == segment.len() || is_held(segment, t + 1, j);
                s[(n + place) * width + n + place] = f64::from(u8::from(stays));
                d.push(if stays { 0.0 } else { -by(t + 1, j) });
                q.push(if stays { HELD * error } else { error });
                volume -= q[n + place].ln();
            }
            let (y, sigma) = sample(t);
            elimination.step(&y, &sigma, &s, &d, &q);
            made.finite && (!t.is_multiple_of(ASKED) || go_on())
        });
        if !whole {
            return None;
        }
        let (y, sigma) = sample(segment.len());
        elimination.finish(&y, &sigma);
        triangle.push(elimination.rows().view()).ok()?;
        eliminations.push((elimination, rounded));
    }
    let (eliminations, rounded): (Vec<Elimination>, Vec<Vec<usize>>) = eliminations.into_iter().unzip();
    let (change, moved) = direction(&triangle, &eliminations, 0.0)?;
    let mut price = 2.0 * (eliminations.iter().map(Elimination::volume).sum::<f64>() - volume);
    let mut all = Vec::with_capacity(segments.len());
    for ((segment, moved), rounded) in segments.iter().zip(&moved).zip(&rounded) {
        let (by, squares) = differences(segment, moved.view(), n, rounded);
        price += squares;
        all.push(by);
    }
    Some(Told { by: all, price, triangle, change })
}

/// Whether input `j` is the same in step `t` as in the one before.
pub(crate) fn is_held(segment: &Segment, t: usize, j: usize) -> bool {
    t > 0 && segment.u[[t, j]].to_bits() == segment.u[[t - 1, j]].to_bits()
}

/// By how much the inputs differ from those that were written (T, k), if the errors of those that were `rounded` change by what `moved` says after its first `n` columns:
/// the same while an input is held, and no more than rounding makes. And the sum of their squares in standard deviations.
fn differences(segment: &Segment, moved: ArrayView2<'_, f64>, n: usize, rounded: &[usize]) -> (Array2<f64>, f64) {
    let mut by = segment.corrections.clone().unwrap_or_else(|| Array2::zeros(segment.u.dim()));
    let mut squares = 0.0;
    for (place, &j) in rounded.iter().enumerate() {
        let (error, steps) = (segment.of_inputs[j], segment.len());
        let mut first = 0;
        while first < steps {
            let last = (first + 1..steps).find(|&t| !is_held(segment, t, j)).unwrap_or(steps);
            let mean = (first..last).map(|t| moved[[t, n + place]]).sum::<f64>() / (last - first) as f64;
            // Rounding to q has the deviation q/√12 and moves nothing by more than q/2; coefficients that are not exact yet may ask for more.
            let most = MOST * error;
            let all = (by[[first, j]] + mean).clamp(-most, most);
            (first..last).for_each(|t| by[[t, j]] = all);
            squares += (all / error).powi(2);
            first = last;
        }
    }
    (by, squares)
}

/// ∂x⁺/∂u of every step, for the inputs number `rounded` (T, n k), by differences over their errors. `None` if a step is not finite.
fn slopes_of_inputs(
    flow: &Flow,
    segment: &Segment,
    (xi, x): (&[f64], &Array2<f64>),
    rounded: &[usize],
) -> Option<Array2<f64>> {
    let (n, k) = (x.ncols(), rounded.len());
    let rough = flow.for_derivatives();
    let steps = |segment: &Segment| {
        let mut next = Array2::zeros((segment.len(), n));
        let finite = rough.each_step(Samples { segment, x, every: 1 }, xi, false, &mut |made| {
            next.row_mut(made.t).iter_mut().zip(made.next).for_each(|(slot, v)| *slot = *v);
            made.finite
        });
        finite.then_some(next)
    };
    let mut slopes = Array2::zeros((segment.len(), n * k));
    for (place, &j) in rounded.iter().enumerate() {
        let moved = |by: f64| {
            let mut segment = segment.clone();
            segment.u.column_mut(j).mapv_inplace(|u| u + by);
            steps(&segment)
        };
        let largest = segment.u.column(j).iter().fold(0.0_f64, |m, u| m.max(u.abs()));
        let h = segment.of_inputs[j].max(NUDGE * largest);
        let difference = (moved(h)? - moved(-h)?) / (2.0 * h);
        (0..n).for_each(|i| slopes.column_mut(i * k + place).assign(&difference.column(i)));
    }
    Some(slopes)
}
