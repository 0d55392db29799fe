//! Samples that a sensor got wrong: single values away from what those before and after them say.

use super::{Segment, measures};

/// Distance of a glitch from the cubic through its neighbours, as a multiple of the typical one of all samples.
const FAR: f64 = 8.0;

/// Standard deviation of normal numbers, as a multiple of the median of their absolute values.
const OF_MEDIAN: f64 = 1.4826;

/// Part of that distance by which the samples beside a glitch seem to be away from theirs, on the other side. Of one alone it is two thirds; of a signal
/// with a kink a half, of one that jumps a third on one side.
const BESIDE: f64 = 0.52;

/// Samples on either side that tell what is usual near one.
const AROUND: usize = 12;

/// Largest share of samples that are glitches.
const MOST: f64 = 0.2;

/// `segments` cut where a sensor was wrong for a sample, and how many steps they have lost; `None` if it was so nowhere, or too often to be called that. `floor` (n) is the
/// smallest error of each state that is believed.
///
/// What is left out is no claim about the equations: they are told by the other samples.
///
/// # References
/// Tukey (1977), Exploratory Data Analysis: residuals from running fits, judged by their median.
pub(crate) fn without_glitches(segments: &[Segment], floor: &[f64]) -> Option<(Vec<Segment>, usize)> {
    let measured: Vec<usize> = (0..floor.len()).filter(|&i| measures(segments, i)).collect();
    let away: Vec<Vec<Vec<f64>>> =
        measured.iter().map(|&i| segments.iter().map(|s| distances(s, i)).collect()).collect();
    let typical: Vec<f64> = away.iter().zip(&measured).map(|(of_state, &i)| typical(of_state).max(floor[i])).collect();
    let is_glitch = |at: usize, t: usize| {
        away.iter().zip(&typical).any(|(of_state, typical)| {
            let d = &of_state[at];
            // Noise may grow with the value: what is usual thereabouts counts too.
            let typical = typical.max(thereabouts(d, t));
            let beside = |k: usize| -d[k] * d[t].signum() > BESIDE * d[t].abs();
            d[t].abs() > FAR * typical && beside(t - 1) && beside(t + 1)
        })
    };
    let (mut kept, mut glitches) = (Vec::new(), 0);
    for (at, segment) in segments.iter().enumerate() {
        let mut first = 0;
        for t in 0..=segment.len() {
            // Of the samples at either end nothing is on the other side.
            if (3..segment.len().saturating_sub(2)).contains(&t) && is_glitch(at, t) {
                glitches += 1;
                if t - 1 > first {
                    kept.push(segment.part(first, t - 1));
                }
                first = t + 1;
            }
        }
        if segment.len() > first {
            kept.push(segment.part(first, segment.len()));
        }
    }
    let steps = |segments: &[Segment]| segments.iter().map(Segment::len).sum::<usize>();
    let all = steps(segments);
    (glitches > 0 && glitches as f64 <= MOST * all as f64).then(|| {
        let lost = all - steps(&kept);
        (kept, lost)
    })
}

/// Standard deviation of most of the distances around that of sample `t`, but for those that have a part in it.
fn thereabouts(distances: &[f64], t: usize) -> f64 {
    let (first, last) = (t.saturating_sub(AROUND), (t + AROUND + 1).min(distances.len()));
    let mut near: Vec<f64> = (first..last).filter(|k| k.abs_diff(t) > 2).map(|k| distances[k].abs()).collect();
    if near.is_empty() {
        return 0.0;
    }
    let middle = near.len() / 2;
    OF_MEDIAN * *near.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// How far each sample of state `i` is from the cubic through two samples before and two after it; 0 at either end.
fn distances(segment: &Segment, i: usize) -> Vec<f64> {
    let mut times = vec![0.0];
    segment.dt.iter().for_each(|dt| times.push(times.last().copied().unwrap_or(0.0) + dt));
    let mut distances = vec![0.0; times.len()];
    for t in 2..times.len().saturating_sub(2) {
        let others = [t - 2, t - 1, t + 1, t + 2];
        let weight = |k: usize| -> f64 {
            let ratio = |l: usize| (times[t] - times[l]) / (times[k] - times[l]);
            others.iter().filter(|l| **l != k).map(|l| ratio(*l)).product()
        };
        distances[t] = segment.x[[t, i]] - others.iter().map(|&k| weight(k) * segment.x[[k, i]]).sum::<f64>();
    }
    distances
}

/// Standard deviation of most of the distances.
fn typical(distances: &[Vec<f64>]) -> f64 {
    let mut all: Vec<f64> = distances.iter().flatten().map(|d| d.abs()).collect();
    if all.is_empty() {
        return f64::INFINITY;
    }
    let middle = all.len() / 2;
    let median = *all.select_nth_unstable_by(middle, f64::total_cmp).1;
    // Most samples of what rarely changes are where their neighbours are, and nothing can be told.
    if median > 0.0 { OF_MEDIAN * median } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;

    use super::*;

    fn segment(value: impl Fn(usize) -> f64) -> Segment {
        Segment {
            x: Array2::from_shape_fn((400, 1), |(t, _)| value(t)),
            u: Array2::zeros((399, 0)),
            dt: vec![0.1; 399],
            ramp: None,
            relative: None,
            of_inputs: Vec::new(),
            corrections: None,
        }
    }

    /// Something like noise.
    fn rough(t: usize) -> f64 {
        1e-3 * (12.9898 * t as f64).sin() * (78.233 * (t * t) as f64).cos()
    }

    #[test]
    fn glitches_are_cut_out() {
        let glitches = [50, 51 + 40, 200, 333];
        let noisy = segment(|t| (0.1 * t as f64).sin() + rough(t) + if glitches.contains(&t) { -0.4 } else { 0.0 });
        let (kept, lost) = without_glitches(&[noisy], &[1e-12]).expect("glitches");
        assert_eq!((kept.len(), lost), (5, 8));
        assert_eq!(kept.iter().map(|s| s.x.nrows()).sum::<usize>(), 396);
    }

    #[test]
    fn noise_that_grows_with_the_value_is_none() {
        let growing = segment(|t| {
            let value = 0.01 + (-(t as f64 - 200.0).powi(2) / 800.0).exp();
            value * (1.0 + 50.0 * rough(t))
        });
        assert!(without_glitches(&[growing], &[1e-12]).is_none());
    }

    #[test]
    fn jumps_bursts_and_kinks_are_none() {
        let jump = segment(|t| (0.1 * t as f64).sin() + rough(t) + if t > 150 { 1.0 } else { 0.0 });
        let burst = segment(|t| rough(t) + (-(t as f64 - 100.0).powi(2) / 8.0).exp());
        let kink = segment(|t| rough(t) + (t as f64 - 77.0).abs());
        let coarse = segment(|t| (0.2 * (0.02 * t as f64).sin() / 0.05).round() * 0.05);
        for (at, none) in [jump, burst, kink, coarse].into_iter().enumerate() {
            assert!(without_glitches(&[none], &[1e-12]).is_none(), "{at}");
        }
    }
}
