//! The stretches of long recordings that tell most: a sample of them in which equations are looked for first.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use ndarray::Array2;

use super::Segment;

/// Steps of each stretch.
const STRETCH: usize = 100;

/// Share of the values of a channel beyond either end of what counts as its range: glitches tell nothing.
const BEYOND: f64 = 0.01;

/// Stretches of `segments` with `steps` steps together, those that tell most; all if there are no more.
pub(crate) fn sample_of(segments: &[Segment], steps: usize) -> Vec<Segment> {
    stretches(segments, steps).into_iter().map(|(at, steps)| segments[at].part(steps.start, steps.end)).collect()
}

/// The same as numbers of segments, and of the steps in these.
///
/// A system may rest most of the time, and move in bursts. One stretch after the other is taken, always the one by which the determinant of Σ f fᵀ
/// grows most, f being states, inputs and the changes of the states in a step, as parts of their ranges.
///
/// # References
/// Fedorov (1972), Theory of Optimal Experiments: D-optimal designs, here chosen greedily.
pub(crate) fn stretches(segments: &[Segment], steps: usize) -> Vec<(usize, Range<usize>)> {
    let total: usize = segments.iter().map(Segment::len).sum();
    if total <= steps {
        return segments.iter().map(Segment::len).enumerate().map(|(at, len)| (at, 0..len)).collect();
    }
    let count = (steps / STRETCH).max(1);
    let length = (steps / count).min(total);
    let n_candidates = (total / length).max(count);
    let first = |candidate: usize| (total - length) * candidate / (n_candidates - 1).max(1);
    let features = features(segments);
    let told: Vec<DMatrix<f64>> = (0..n_candidates)
        .map(|candidate| {
            let rows = features.rows(first(candidate), length);
            rows.transpose() * rows
        })
        .collect();
    // A channel that never changes tells nothing, and hinders nothing.
    let mut known = DMatrix::identity(features.ncols(), features.ncols());
    let mut taken: Vec<usize> = Vec::with_capacity(count);
    for _ in 0..count {
        let gain = |candidate: &usize| (&known + &told[*candidate]).cholesky().map_or(f64::MIN, |c| c.ln_determinant());
        let left = (0..n_candidates).filter(|candidate| !taken.contains(candidate));
        let gains = left.map(|candidate| (candidate, gain(&candidate)));
        // Of equal ones the first.
        let Some((best, _)) = gains.reduce(|best, other| if other.1 > best.1 { other } else { best }) else { break };
        known += &told[best];
        taken.push(best);
    }
    taken.sort_unstable();
    taken.into_iter().flat_map(|candidate| within(segments, first(candidate)..first(candidate) + length)).collect()
}

/// The steps `steps` of all segments, by number of segment.
fn within(segments: &[Segment], steps: Range<usize>) -> Vec<(usize, Range<usize>)> {
    let (mut taken, mut begun) = (Vec::new(), 0);
    for (at, segment) in segments.iter().enumerate() {
        let from = steps.start.max(begun) - begun;
        let to = steps.end.min(begun + segment.len()).saturating_sub(begun);
        if from < to {
            taken.push((at, from..to));
        }
        begun += segment.len();
    }
    taken
}

/// Per step of all segments: 1, states, inputs and changes of states, each between −1 and 1 over its range.
fn features(segments: &[Segment]) -> DMatrix<f64> {
    let changes =
        |s: &Segment| Array2::from_shape_fn((s.len(), s.x.ncols()), |(t, i)| (s.x[[t + 1, i]] - s.x[[t, i]]) / s.dt[t]);
    let changes: Vec<Array2<f64>> = segments.iter().map(changes).collect();
    let n = segments.first().map_or(0, |s| s.x.ncols());
    let k = segments.first().map_or(0, |s| s.u.ncols());
    let column = |c: usize| -> DVector<f64> {
        let of = |(s, changes): (&Segment, &Array2<f64>)| -> Vec<f64> {
            let value = |t: usize| match c {
                c if c < n => s.x[[t, c]],
                c if c < n + k => s.u[[t, c - n]],
                c => changes[[t, c - n - k]],
            };
            (0..s.len()).map(value).collect()
        };
        in_range(segments.iter().zip(&changes).flat_map(of).collect())
    };
    let total: usize = segments.iter().map(Segment::len).sum();
    let columns: Vec<DVector<f64>> =
        std::iter::once(DVector::repeat(total, 1.0)).chain((0..2 * n + k).map(column)).collect();
    DMatrix::from_columns(&columns)
}

/// `values` as parts of their range, from −1 to 1.
fn in_range(values: Vec<f64>) -> DVector<f64> {
    let mut sorted = values.clone();
    sorted.sort_by(f64::total_cmp);
    let beyond = (BEYOND * values.len() as f64) as usize;
    let (low, high) = (sorted[beyond], sorted[values.len() - 1 - beyond]);
    let (middle, half) = (low.midpoint(high), 0.5 * (high - low));
    let part = |v: f64| if half > 0.0 { ((v - middle) / half).clamp(-1.0, 1.0) } else { 0.0 };
    DVector::from_vec(values.into_iter().map(part).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2,000 samples that rest, but for 100 from the 1,230th on.
    fn bursting() -> Segment {
        let value =
            |t: usize| if (1230..1330).contains(&t) { (0.7 * t as f64).sin() } else { 1e-3 * (0.3 * t as f64).sin() };
        Segment {
            x: Array2::from_shape_fn((2000, 1), |(t, _)| value(t)),
            u: Array2::zeros((1999, 0)),
            dt: vec![0.1; 1999],
            ramp: None,
            relative: None,
            of_inputs: Vec::new(),
            corrections: None,
        }
    }

    #[test]
    fn what_moves_is_in_the_sample() {
        let segments = [bursting()];
        let taken = stretches(&segments, 300);
        assert_eq!(taken.iter().map(|(_, steps)| steps.len()).sum::<usize>(), 300);
        let moving = taken.iter().flat_map(|(_, steps)| steps.clone()).filter(|t| (1230..1330).contains(t)).count();
        assert!(moving >= 90, "{moving}: {taken:?}");
    }

    #[test]
    fn glitches_draw_no_stretch() {
        let mut calm = bursting();
        calm.x[[400, 0]] = 1e6;
        let moving = stretches(&[calm], 100);
        assert!(moving.iter().any(|(_, steps)| (1200..1330).contains(&steps.start)), "{moving:?}");
    }

    #[test]
    fn short_data_are_taken_whole() {
        let segments = [bursting().part(0, 50), bursting().part(50, 90)];
        assert_eq!(stretches(&segments, 300), [(0, 0..50), (1, 0..40)]);
    }
}
