//! Angles whose zero is not where sensors say.

use faer::Mat;

use ndarray::Array2;

use super::choice::Choice;
use super::fitting::{Terms, whitened};
use super::found::{Found, Search};
use super::{Run, Stepping, System};
use crate::Triangle;
use crate::expr::{Expr, Function};
use crate::model::ModelError;
use crate::solve::{Selected, least_squares};

/// Largest tilt looked for \[rad\].
const LARGEST: f64 = 0.6;

/// Places between −LARGEST and LARGEST that are tried before the best is refined.
const PLACES: usize = 13;

/// Rounds of golden-section search; what it finds is refined with the coefficients.
const ROUNDS: usize = 20;

/// How a term changes with the zero of an angle: p·sin m(θ + δ) = cos mδ · p·sin mθ + sin mδ · p·cos mθ, and for a
/// cosine with −sin mδ.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turn {
    /// Place of the companion.
    pub(super) companion: usize,
    pub(super) frequency: f64,
    pub(super) sign: f64,
}

impl Search<'_> {
    /// The same search with the zeros of angles where the data want them; `None` if they are right where they are.
    pub(super) fn tilted(&self, upright: &Found) -> Result<Option<Found>, ModelError> {
        let (system, stepping) = (self.system, Stepping::Continuous { substeps: 1 });
        if system.angles.is_empty() {
            return Ok(None);
        }
        let mut offsets = self.upright();
        let core: Vec<usize> = (0..system.core).collect();
        let averages = |run: &Run| system.averages(run, stepping, None, &self.upright(), &core);
        let theta: Vec<Array2<f64>> = self.runs.iter().map(averages).collect();
        let mut triangles = Vec::new();
        for (i, rate) in system.rates.iter().enumerate() {
            let choice = self.choice(Choice::Core, i);
            triangles.push(match rate {
                Some(_) => None,
                None => Some((whitened(system, self.runs, &theta, &choice, i, None)?, choice)),
            });
        }
        for &angle in system.angles {
            if let Some((delta, _)) = tilt(system, &triangles, &upright.fits, angle) {
                offsets[angle] = delta;
            }
        }
        if offsets.iter().all(|v| *v == 0.0) {
            return Ok(None);
        }
        let start = self.fit(stepping, &offsets, None, &Terms::Best(&self.core()))?;
        self.settle(self.refine(start.clone()).unwrap_or(start), &self.core()).map(Some)
    }
}

/// The tilt δ of `angle` \[rad\] with which some subset in the paths of `fits` explains its equation best, and by how much
/// N ln RSS + k ln N falls. `triangles` are [Θ of the first tier | target], one for each equation.
fn tilt(
    system: &System<'_>,
    triangles: &[Option<(Triangle, Vec<usize>)>],
    fits: &[Selected],
    angle: usize,
) -> Option<(f64, f64)> {
    let mut best: Option<(f64, f64)> = None;
    for (fit, triangle) in fits.iter().zip(triangles) {
        let Some((triangle, choice)) = triangle else { continue };
        let turns = turns(system, choice, angle);
        let rows = triangle.n_rows() as f64;
        let place = |j: &usize| choice.iter().position(|c| c == j);
        let supports = fit.path.iter().filter_map(|s| s.support.iter().map(place).collect::<Option<Vec<usize>>>());
        let (mut upright, mut tilted) = (f64::INFINITY, (f64::INFINITY, 0.0));
        for support in supports.filter(|s| !s.is_empty() && s.len() + 2 < triangle.n_rows()) {
            let score = |delta: f64, parameters: usize| {
                rows * rss(triangle, &support, &turns, delta).ln() + parameters as f64 * rows.ln()
            };
            upright = upright.min(score(0.0, support.len()));
            if support.iter().all(|&j| turns[j].is_none()) {
                continue;
            }
            let delta = minimum(|delta| rss(triangle, &support, &turns, delta));
            let candidate = (score(delta, support.len() + 1), delta);
            if candidate.0 < tilted.0 {
                tilted = candidate;
            }
        }
        let gain = upright - tilted.0;
        if gain > 0.0 && best.is_none_or(|(_, most)| gain > most) {
            best = Some((tilted.1, gain));
        }
    }
    best
}

/// ‖Θ_S(δ) ξ − y‖² at the best ξ.
fn rss(triangle: &Triangle, support: &[usize], turns: &[Option<Turn>], delta: f64) -> f64 {
    let target = triangle.column(triangle.n_columns() - 1);
    let rows = target.len();
    let at = |j: usize, i: usize| triangle.column(j).get(i).copied().unwrap_or(0.0);
    let a = Mat::from_fn(rows, support.len(), |i, k| {
        let j = support[k];
        match turns[j] {
            None => at(j, i),
            Some(turn) => {
                let (sin, cos) = (turn.frequency * delta).sin_cos();
                cos * at(j, i) + turn.sign * sin * at(turn.companion, i)
            }
        }
    });
    let b = Mat::from_fn(rows, 1, |i, _| target[i]);
    let xi = least_squares(a.as_ref(), b.as_ref());
    let residual = |i: usize| target[i] - xi.iter().enumerate().map(|(k, c)| c * a[(i, k)]).sum::<f64>();
    (0..rows).map(|i| residual(i).powi(2)).sum::<f64>().max(f64::MIN_POSITIVE)
}

/// Where `f` is smallest in ±[`LARGEST`]: the best of evenly spread places, refined by golden sections.
fn minimum(f: impl Fn(f64) -> f64) -> f64 {
    let step = 2.0 * LARGEST / (PLACES - 1) as f64;
    let place = |i: usize| i as f64 * step - LARGEST;
    let best = (0..PLACES).map(place).min_by(|a, b| f(*a).total_cmp(&f(*b))).unwrap_or(0.0);
    let golden = 0.5 * (5_f64.sqrt() - 1.0);
    let (mut low, mut high) = (best - step, best + step);
    for _ in 0..ROUNDS {
        let (a, b) = (high - golden * (high - low), low + golden * (high - low));
        if f(a) < f(b) { high = b } else { low = a }
    }
    0.5 * (low + high)
}

/// Per term of `choice`: how it turns with `angle`; `None` for terms that do not, or whose companion is not there.
pub(super) fn turns(system: &System<'_>, choice: &[usize], angle: usize) -> Vec<Option<Turn>> {
    let turn = |&j: &usize| {
        let term = &system.terms[j];
        let (wave, frequency, sign) = turned(&term.expr, angle)?;
        let same = |&l: &usize| system.terms[l].rate == term.rate && system.terms[l].expr == wave;
        Some(Turn { companion: choice.iter().position(same)?, frequency, sign })
    };
    choice.iter().map(turn).collect()
}

/// The expression with its wave of `angle` exchanged for the other one, the wave's frequency and the sign of the exchange.
fn turned(expr: &Expr, angle: usize) -> Option<(Expr, f64, f64)> {
    match expr {
        Expr::Call(function @ (Function::Sin | Function::Cos), argument) => {
            let frequency = frequency(argument, angle)?;
            let (other, sign) = if *function == Function::Sin { (Function::Cos, 1.0) } else { (Function::Sin, -1.0) };
            Some((Expr::Call(other, argument.clone()), frequency, sign))
        }
        Expr::Mul(a, b) => match (turned(a, angle), turned(b, angle)) {
            (Some((a, m, s)), None) => Some((Expr::Mul(Box::new(a), b.clone()), m, s)),
            (None, Some((b, m, s))) => Some((Expr::Mul(a.clone(), Box::new(b)), m, s)),
            _ => None,
        },
        _ => None,
    }
}

/// The factor of `angle` in the argument of a wave.
fn frequency(argument: &Expr, angle: usize) -> Option<f64> {
    match argument {
        Expr::Variable(i) => (*i == angle).then_some(1.0),
        Expr::Mul(k, a) => match (&**k, &**a) {
            (Expr::Constant(k), Expr::Variable(i)) if *i == angle => Some(*k),
            _ => None,
        },
        Expr::Add(a, b) => frequency(a, angle).or_else(|| frequency(b, angle)),
        Expr::Sub(a, b) => frequency(a, angle).or_else(|| frequency(b, angle).map(|m| -m)),
        _ => None,
    }
}
