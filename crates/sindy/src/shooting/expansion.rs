//! What the likelihood of coefficients owes to the states: those of a system that runs away are known the better the faster it does.

use std::ops::Range;

use ndarray::{Array2, s};

use super::eliminate::Elimination;
use super::fit::Fit;
use super::flow::Flow;
use super::slack::PARTS;
use super::state::State;
use super::work::Work;
use crate::data::Segment;

/// Newton steps towards the most likely coefficients.
const STEPS: usize = 2;

/// Steps of a piece of long data, at most, and steps by which the information about all states is judged: it grows by as much along every piece.
const PIECE: usize = 500;
const ENOUGH: usize = 2000;

/// Coefficients ξ (p) and states (T + 1, n) of each segment.
type At<'a> = (&'a [f64], &'a [Array2<f64>]);

impl Fit {
    /// Moves the coefficients and states of `self`, fitted to `segments` with the number `part` of the [`PARTS`], from the least squares over both to the coefficients
    /// that are most likely whatever the states: by −(RᵀR)⁻¹ ∇ ln √det I(ξ), with I the information about all states. Of a system that is kept at an unstable state of rest
    /// least squares finds coefficients with which it would run away faster.
    ///
    /// # References
    /// MacKay (1992), Neural Computation 4(3), for the determinant; Neyman and Scott (1948), Econometrica 16(1), for the bias without it.
    pub(crate) fn integrate_over_states(
        &mut self,
        flow: &Flow,
        segments: &[Segment],
        part: usize,
        (work, go_on): (&Work, &dyn Fn() -> bool),
    ) {
        for _ in 0..STEPS {
            let at = (&self.xi[..], &self.x[..]);
            let Some(slopes) = self.slopes(flow, segments, at, part, (work, go_on)) else { return };
            work.elimination(flow, segments);
            let mut state = State::new(self.xi.clone(), self.x.clone(), self.sigma.clone());
            if !state.miss(flow, segments, work) {
                return;
            }
            let Some((factor, eliminations)) = state.eliminated(flow, segments, (PARTS[part], true), go_on, None)
            else {
                return;
            };
            let Some(shift) = factor.shift(&slopes) else { return };
            let nearest = factor.solve_unit(&(0..slopes.len()).collect::<Vec<_>>(), slopes.len());
            let delta: Vec<f64> = nearest.iter().zip(&shift).map(|(to, shift)| to - shift).collect();
            let Some(moved) = eliminations.iter().map(|e| e.states(&delta)).collect::<Option<Vec<_>>>() else { return };
            let finite = delta.iter().chain(moved.iter().flatten()).all(|d| d.is_finite());
            if !finite {
                return;
            }
            self.xi.iter_mut().zip(&delta).for_each(|(c, d)| *c += d);
            self.x.iter_mut().zip(&moved).for_each(|(x, d)| *x += d);
        }
    }

    /// ∇ ln √det I(ξ) at the coefficients and states `at`, along `segments`, by central differences over the standard errors of the coefficients; of long data by some
    /// pieces of them. `None` if a step is not finite or `go_on` says no; 0 for coefficients without a standard error.
    pub(crate) fn slopes(
        &self,
        flow: &Flow,
        segments: &[Segment],
        (xi, x): At<'_>,
        part: usize,
        (work, go_on): (&Work, &dyn Fn() -> bool),
    ) -> Option<Vec<f64>> {
        let (pieces, x, times) = some_pieces(segments, x);
        let volume = |j: usize, by: f64| {
            let mut moved = xi.to_vec();
            moved[j] += by;
            work.elimination(flow, &pieces);
            let mut state = State::new(moved, x.clone(), self.sigma.clone());
            let finite = state.miss(flow, &pieces, work);
            let found = finite.then(|| state.eliminated(flow, &pieces, (PARTS[part], false), go_on, None))??;
            Some(found.1.iter().map(Elimination::volume).sum::<f64>())
        };
        let slope = |(j, &error): (usize, &f64)| {
            if !error.is_finite() || error <= 0.0 {
                return Some(0.0);
            }
            Some(times * (volume(j, error)? - volume(j, -error)?) / (2.0 * error))
        };
        self.errors.iter().enumerate().map(slope).collect()
    }
}

/// Pieces of `segments` with the states `x` there, spread evenly over them and about [`ENOUGH`] steps together, and how many times as many steps all of them have; all,
/// where these are no more.
fn some_pieces(segments: &[Segment], x: &[Array2<f64>]) -> (Vec<Segment>, Vec<Array2<f64>>, f64) {
    let all: usize = segments.iter().map(Segment::len).sum();
    if all <= ENOUGH {
        return (segments.to_vec(), x.to_vec(), 1.0);
    }
    let of_segment = |at: usize| {
        let count = segments[at].len().div_ceil(PIECE).max(1);
        let end = move |piece: usize| piece * segments[at].len() / count;
        (0..count).map(move |piece| (at, end(piece)..end(piece + 1)))
    };
    let pieces = (0..segments.len()).flat_map(of_segment).step_by(all.div_ceil(ENOUGH));
    let taken: Vec<(usize, Range<usize>)> = pieces.filter(|(_, steps)| !steps.is_empty()).collect();
    let steps: usize = taken.iter().map(|(_, steps)| steps.len()).sum();
    let parts = taken.iter().map(|(at, steps)| segments[*at].part(steps.start, steps.end)).collect();
    let paths = taken.iter().map(|(at, steps)| x[*at].slice(s![steps.start..=steps.end, ..]).to_owned()).collect();
    (parts, paths, all as f64 / steps.max(1) as f64)
}
