//! States that noise hides.

use ndarray::{Array2, Axis};

use super::hypothesis::Hypothesis;
use super::problem::Problem;
use super::white::is_white;
use crate::data::Segment;

/// States that do not move by more than their noise shows.
pub(crate) struct Still {
    /// Those that stay where they are in each trajectory.
    pub(crate) in_each: Vec<usize>,
    /// Those of them that are the same in all.
    pub(crate) in_all: Vec<usize>,
}

/// Positions in `segments` that are noise around one value in each, with `rates` that are noise around zero. Of the rate alone that tells nothing: what is driven at random may look like noise, but
/// what it moves does not.
pub(crate) fn still(segments: &[Segment], rates: &[Option<usize>]) -> Still {
    let means: Vec<Vec<f64>> =
        segments.iter().map(|s| s.x.mean_axis(Axis(0)).map_or_else(Vec::new, |m| m.to_vec())).collect();
    let around = |i: usize, values: &dyn Fn(usize) -> f64| -> Vec<Array2<f64>> {
        segments.iter().enumerate().map(|(of, s)| s.x.column(i).mapv(|x| x - values(of)).insert_axis(Axis(1))).collect()
    };
    // Values at the trajectories, and the standard error of each.
    let told = |i: usize, left: &[Array2<f64>]| -> Vec<(f64, f64)> {
        let count = left.iter().map(Array2::len).sum::<usize>().max(1) as f64;
        let sigma = (left.iter().flatten().map(|v| v * v).sum::<f64>() / count).sqrt();
        means.iter().zip(segments).map(|(mean, s)| (mean[i], sigma / (s.x.nrows() as f64).sqrt())).collect()
    };
    let (mut in_each, mut in_all) = (Vec::new(), Vec::new());
    for (q, v) in rates.iter().enumerate().filter_map(|(q, v)| Some((q, (*v)?))) {
        let (place, speed) = (around(q, &|of| means[of][q]), around(v, &|_| 0.0));
        let rests = segments.iter().all(|s| s.measures(q) && s.measures(v))
            && is_white(&place, 0)
            && is_white(&speed, 0)
            && told(v, &speed).iter().all(|(mean, error)| mean.abs() <= APART * error);
        if rests {
            in_each.extend([q, v]);
            in_all.push(v);
            if !differ(told(q, &place)) {
                in_all.push(q);
            }
        }
    }
    Still { in_each, in_all }
}

/// Whether values, each with its standard error, are not all the same.
fn differ(mut values: Vec<(f64, f64)>) -> bool {
    values.sort_by(|one, other| one.0.total_cmp(&other.0));
    values.windows(2).any(|pair| pair[1].0 - pair[0].0 > APART * pair[0].1.hypot(pair[1].1))
}

impl Problem<'_> {
    /// Whether equation `i` has a term of a state whose own equation has none, and which is the same in all segments as far as its noise lets see. A factor that is not
    /// known is no more than a constant, and one that has any value with the coefficient to match it.
    pub(super) fn has_still_state(&self, best: &Hypothesis, i: usize) -> bool {
        let is_still = |k: &usize| {
            let own = best.supports[*k].is_empty()
                && self.rates[*k].is_none()
                && self.given().get(*k).is_none_or(Vec::is_empty);
            own && best.fit.sigma[*k] > self.floor[*k] && !self.differs(best, *k)
        };
        (0..self.rates.len()).filter(is_still).any(|k| best.supports[i].iter().any(|&j| self.terms[j].expr.has(k)))
    }

    /// Whether no equation has a term, though states vary: by their noise, or by what no candidate term describes.
    pub(super) fn finds_no_motion(&self, best: &Hypothesis) -> bool {
        let varies = |k: usize| best.fit.sigma[k] > self.floor[k];
        best.supports.iter().all(Vec::is_empty)
            && self.rates.iter().all(Option::is_none)
            && self.given().iter().all(Vec::is_empty)
            && (0..self.rates.len()).any(varies)
    }

    /// Whether the state `k`, constant in each segment, has values whose differences its noise does not explain.
    fn differs(&self, best: &Hypothesis, k: usize) -> bool {
        differ(best.fit.x.iter().map(|x| (x[[0, k]], best.fit.sigma[k] / (x.nrows() as f64).sqrt())).collect())
    }
}

/// Standard errors by which two values differ.
const APART: f64 = 5.0;
