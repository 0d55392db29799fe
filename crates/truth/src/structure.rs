//! Whether equations have the true terms, and what their true coefficients are.

use faer::Mat;
use faer::linalg::solvers::SolveLstsq as _;
use sindyna_sindy::{Expr, Model};

use crate::Truth;

/// Points of the box that are looked at.
const POINTS: usize = 500;

/// Newton's steps; offsets found from data are so near that three do.
const STEPS: usize = 6;

/// RMS of what true terms leave of a rate, as part of its spread: rounding alone.
const EXPLAINED: f64 = 1e-9;

/// RMS of a summand, or of what a term has of its own beside the others, as part of the whole, below which it is not needed.
const SUPERFLUOUS: f64 = 1e-7;

/// Distance of the differences by which slopes along offsets are taken \[unit of the state\].
const NEAR: f64 = 1e-6;

/// What the terms of equations are, compared with the true rates.
#[derive(Debug, Clone, PartialEq)]
pub enum Structure {
    /// The true rates satisfy these equations with exactly one set of coefficients, none of which is zero.
    True {
        /// The true coefficients, in the order of the equations' summands.
        coefficients: Vec<f64>,
    },
    /// The true rates satisfy these equations, but not all terms are needed.
    Wider,
    /// No coefficients make these equations true.
    Other,
}

/// One equation: the state whose rate it is for, and its summands' terms with the rate each is multiplied by.
pub type Terms<'a> = (usize, Vec<(&'a Expr, Option<usize>)>);

/// Compares the terms of all judged equations of `model` with the truth; the offsets of its states are free where they are
/// not zero.
///
/// An equation Σ c φ(x + δ; u) ẋ_l = ẋ_i is linear in c where the true ẋ are put in, so c follows by least squares over the box
/// and needs no list of true terms; δ joins by Newton's method. Implicit equations have many true forms: any counts.
#[must_use]
pub fn structure(truth: &Truth, model: &Model) -> Structure {
    let terms = model.terms();
    let summands = |i: usize| model.coefficients(i).iter().map(|e| (&terms[e.term], e.rate)).collect();
    let equations: Vec<Terms<'_>> = truth.judged().map(|(i, _)| (i, summands(i))).collect();
    compare(truth, &equations, model.offsets())
}

/// [`structure`] of any equations.
#[must_use]
pub fn compare(truth: &Truth, equations: &[Terms<'_>], offsets: &[f64]) -> Structure {
    let free: Vec<usize> = (0..offsets.len()).filter(|&i| offsets[i].abs() > 0.0).collect();
    let spreads: Vec<f64> = truth.judged().filter(|(i, _)| equations.iter().any(|e| e.0 == *i)).map(|e| e.1).collect();
    let count: usize = equations.iter().map(|(_, terms)| terms.len()).sum();
    if equations.iter().any(|(_, terms)| terms.is_empty()) {
        return Structure::Other;
    }
    let mut offsets = offsets.to_vec();
    let mut coefficients = vec![0.0; count];
    // Without offsets one solve is exact.
    let rounds = if free.is_empty() { 1 } else { STEPS };
    let mut rows = Rows::new(truth, equations, &spreads, &offsets);
    for round in 0..rounds {
        let slopes = if round == 0 { &[][..] } else { &free[..] };
        let slopes: Vec<Vec<f64>> = slopes
            .iter()
            .map(|&state| {
                let at = |by: f64| {
                    let mut moved = offsets.clone();
                    moved[state] += by;
                    Rows::new(truth, equations, &spreads, &moved).explained(&coefficients)
                };
                let (ahead, behind) = (at(NEAR), at(-NEAR));
                ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * NEAR)).collect()
            })
            .collect();
        let Some((moves, found)) = rows.solve(&slopes) else { return Structure::Wider };
        for (state, by) in free.iter().zip(moves) {
            offsets[*state] += by;
        }
        coefficients = found;
        rows = Rows::new(truth, equations, &spreads, &offsets);
    }
    if !free.is_empty() {
        // The last move of the offsets is not yet in the coefficients.
        coefficients = rows.solve(&[]).map_or(coefficients, |(_, found)| found);
    }
    if rows.unexplained(&coefficients) > EXPLAINED {
        Structure::Other
    } else if rows.smallest_summand(&coefficients) < SUPERFLUOUS {
        Structure::Wider
    } else {
        Structure::True { coefficients }
    }
}

/// The equations over the box, each row divided by the spread of its rate: block by block, one block for each equation.
struct Rows {
    /// Column j of the design, with the block it lies in; it is zero elsewhere.
    columns: Vec<(usize, Vec<f64>)>,
    /// The true rates of each block.
    targets: Vec<Vec<f64>>,
}

impl Rows {
    fn new(truth: &Truth, equations: &[Terms<'_>], spreads: &[f64], offsets: &[f64]) -> Self {
        let mut columns = Vec::new();
        let mut targets = Vec::new();
        let shifted: Vec<(Vec<f64>, &[f64])> = truth
            .rows(POINTS)
            .map(|(z, rates)| {
                let moved = z.iter().enumerate().map(|(i, v)| v + offsets.get(i).copied().unwrap_or(0.0));
                (moved.collect(), rates)
            })
            .collect();
        for (block, ((i, terms), spread)) in equations.iter().zip(spreads).enumerate() {
            for (term, rate) in terms {
                let value = |(z, rates): &(Vec<f64>, &[f64])| term.eval(z) * rate.map_or(1.0, |l| rates[l]) / spread;
                columns.push((block, shifted.iter().map(value).collect()));
            }
            targets.push(shifted.iter().map(|(_, rates)| rates[*i] / spread).collect());
        }
        Self { columns, targets }
    }

    /// Σ c φ, the blocks one below the other.
    fn explained(&self, coefficients: &[f64]) -> Vec<f64> {
        let mut sums: Vec<Vec<f64>> = self.targets.iter().map(|t| vec![0.0; t.len()]).collect();
        for ((block, column), c) in self.columns.iter().zip(coefficients) {
            for (sum, value) in sums[*block].iter_mut().zip(column) {
                *sum += c * value;
            }
        }
        sums.concat()
    }

    /// RMS of what is left of the worst block.
    fn unexplained(&self, coefficients: &[f64]) -> f64 {
        let explained = self.explained(coefficients);
        let mut at = 0;
        let blocks = self.targets.iter().map(|target| {
            let part = &explained[at..at + target.len()];
            at += target.len();
            rms(part.iter().zip(target).map(|(a, b)| a - b))
        });
        blocks.fold(0.0, f64::max)
    }

    /// RMS of the smallest c φ.
    fn smallest_summand(&self, coefficients: &[f64]) -> f64 {
        let summands = self.columns.iter().zip(coefficients).map(|((_, column), c)| rms(column.iter().map(|v| c * v)));
        summands.fold(f64::INFINITY, f64::min)
    }

    /// Moves along `slopes` and coefficients that explain the targets best; `None` if the columns depend on each other.
    fn solve(&self, slopes: &[Vec<f64>]) -> Option<(Vec<f64>, Vec<f64>)> {
        let (points, extra) = (self.targets.first()?.len(), slopes.len());
        let rows = points * self.targets.len();
        let mut a = Mat::<f64>::zeros(rows, extra + self.columns.len());
        for (j, slope) in slopes.iter().enumerate() {
            for (i, value) in slope.iter().enumerate() {
                a[(i, j)] = *value;
            }
        }
        for (j, (block, column)) in self.columns.iter().enumerate() {
            for (i, value) in column.iter().enumerate() {
                a[(block * points + i, extra + j)] = *value;
            }
        }
        let norms: Vec<f64> = (0..a.ncols()).map(|j| a.col(j).norm_l2()).collect();
        if norms.iter().any(|n| !(n.is_finite() && *n > 0.0)) {
            return None;
        }
        for (j, norm) in norms.iter().enumerate() {
            for i in 0..rows {
                a[(i, j)] /= norm;
            }
        }
        let targets = self.targets.concat();
        let b = Mat::from_fn(rows, 1, |i, _| targets[i]);
        let qr = a.qr();
        let r = qr.thin_R();
        if (0..r.ncols()).any(|j| r[(j, j)].abs() < SUPERFLUOUS) {
            return None;
        }
        let x = qr.solve_lstsq(b);
        let scaled = |j: usize| x[(j, 0)] / norms[j];
        Some(((0..extra).map(scaled).collect(), (extra..a.ncols()).map(scaled).collect()))
    }
}

fn rms(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    (values.map(|v| v * v).sum::<f64>() / count).sqrt()
}
