//! From weak-form rows to equations that predict pieces.

use super::account::{Disturbed, account};
use super::cut::{Piece, pieces, time_scale};
use super::fit::{Data, Fitted};
use super::grouped::{Choice, Group, chosen};
use super::linearised;
use super::weak::{Balances, Weak, balances};
use crate::BestSubset;
use crate::Watch;
use crate::data::{Segment, measures};
use crate::library::{Joints, Lagrangian};
use crate::mechanics::Equations;
use crate::model::{Form, Model};
use crate::regression::Space;

/// Pieces, at least.
const FEWEST: usize = 4;

/// Pieces by which proposals are compared, about.
const COMPARED: usize = 60;

/// Lengths of the windows of the weak form, in time scales; all arrangements are tried with the first.
const LENGTHS: [f64; 3] = [2.0, 1.0, 4.0];

/// Times that joints are weighed by the momentum they exchange.
const WEIGHINGS: usize = 2;

/// Arrangements and units that are fitted to pieces.
const PROPOSALS: usize = 3;

/// Rounds of their first fit; of fits between choices of terms; of the last one.
const FEW: usize = 6;
const SOME: usize = 10;
const MANY: usize = 40;

/// Times that terms are chosen near the parameters fitted.
const CHOICES: usize = 4;

/// Parts of the speed of a joint (RMS) below which its friction may be larger than above.
const SLOW: [f64; 3] = [1.0 / 64.0, 1.0 / 16.0, 0.25];

/// What is looked for, and in what.
pub(super) struct Problem<'a> {
    pub(super) segments: &'a [Segment],
    pub(super) space: &'a Space,
    pub(super) dt: f64,
    pub(super) solver: &'a BestSubset,
    pub(super) watch: &'a Watch<'a>,
}

/// A Lagrangian with some of its parameters, as the weak form proposes them.
struct Proposal {
    /// Number of the Lagrangian.
    of: usize,
    unit: usize,
    /// Parameters and values beside the unit.
    parameters: Vec<(usize, f64)>,
}

/// Recordings cut into pieces.
pub(crate) struct Cut<'a> {
    segments: &'a [Segment],
    floor: &'a [f64],
    /// Time scale \[s\].
    scale: f64,
    pieces: Vec<Piece>,
    measured: Vec<bool>,
    spread: Vec<f64>,
}

impl<'a> Cut<'a> {
    /// The pieces of `segments`, whose samples have errors of at least `floor` (n), as long as the `speeds` among the states need; `None` where there are too few.
    pub(crate) fn new(segments: &'a [Segment], floor: &'a [f64], speeds: &[usize]) -> Option<Self> {
        let spread: Vec<f64> = (0..floor.len()).map(|i| spread(segments, i)).collect();
        let scale = time_scale(segments, speeds)?;
        let measured = (0..floor.len()).map(|i| measures(segments, i)).collect();
        let pieces = pieces(segments, scale);
        (pieces.len() >= FEWEST).then_some(Self { segments, floor, scale, pieces, measured, spread })
    }

    fn data<'b>(&'b self, watch: &'b Watch<'b>) -> Data<'b> {
        Data { pieces: &self.pieces, measured: &self.measured, floor: self.floor, spread: &self.spread, watch }
    }

    /// What `model` leaves of most pieces, each from the start that suits it best: a part of the spread of each state, the largest. `None` where it cannot
    /// follow them.
    pub(crate) fn left_by(&self, model: &Model, watch: &Watch<'_>) -> Option<f64> {
        if !matches!(model.form(), Form::Continuous(_)) {
            return None;
        }
        let data = self.data(watch);
        let fitted = data.fitted(&|_| Some(model.clone()), &[1.0], None, FEW)?;
        Some(data.left(&fitted))
    }

    /// How far `model` misses pieces of each of `cuts`, which differ in their inputs alone, with coefficients fitted to that one, from the start of each piece that suits it best: mean
    /// squares of residuals over their size in most pieces of the first, infinite where it diverges. `None` if the first has no such coefficients.
    pub(crate) fn misfits(cuts: &[Self], model: &Model, watch: &Watch<'_>) -> Option<Vec<Vec<f64>>> {
        let first = cuts.first()?;
        let some: Vec<Vec<Piece>> = cuts.iter().map(Self::some).collect();
        let at = |theta: &[f64]| model.with_coefficients(&theta[1..]);
        let begun = [&[1.0], &model.fitted()[..]].concat();
        let fitted = |pieces: &[Piece], from: Option<&Fitted>| {
            let theta = from.map_or(&begun, |from| &from.theta);
            Data { pieces, ..first.data(watch) }.fitted(&at, theta, from, FEW)
        };
        let base = fitted(&some[0], None)?;
        let of = |(at_cut, pieces): (usize, &Vec<Piece>)| {
            let own = if at_cut == 0 { Some(base.clone()) } else { fitted(pieces, Some(&base)) };
            let missed = |own: Fitted| {
                let data = Data { pieces, ..first.data(watch) };
                data.misfits(at(&own.theta).as_ref(), &own.starts, &base.sigma)
            };
            own.map_or_else(|| vec![f64::INFINITY; pieces.len()], missed)
        };
        Some(some.iter().enumerate().map(of).collect())
    }

    /// `model` with coefficients fitted to the pieces. `None` if it follows none.
    pub(crate) fn refitted(&self, model: &Model, watch: &Watch<'_>) -> Option<Model> {
        let begun = [&[1.0], &model.fitted()[..]].concat();
        let at = |theta: &[f64]| model.with_coefficients(&theta[1..]);
        let fitted = Data { pieces: &self.some(), ..self.data(watch) }.fitted(&at, &begun, None, FEW)?;
        at(&fitted.theta)
    }

    /// Pieces by which equations are compared.
    fn some(&self) -> Vec<Piece> {
        self.pieces.iter().step_by(self.pieces.len().div_ceil(COMPARED)).cloned().collect()
    }

    /// Equations of the machine, whose `joints` rub and are disturbed. `None` where nothing follows the data.
    pub(crate) fn disturbed(
        &self,
        joints: &Joints,
        rates: &[Option<usize>],
        (space, dt): (&Space, f64),
        (solver, watch): (&BestSubset, &Watch<'_>),
    ) -> Option<Disturbed> {
        let problem = Problem { segments: self.segments, space, dt, solver, watch };
        let data = self.data(watch);
        let speeds: Vec<f64> = joints.speeds().iter().map(|&v| size(self.segments, v)).collect();
        let lagrangians: Vec<Lagrangian> =
            Lagrangian::all_arrangements(joints).into_iter().map(|l| l.slow_friction(&speeds, &SLOW)).collect();
        let proposals = problem.proposals(&lagrangians, self.scale);
        let some = self.some();
        let of_some = Data { pieces: &some, ..data };
        let first = |proposal: &Proposal| {
            let others = proposal.parameters.iter();
            let chosen: Vec<usize> = std::iter::once(proposal.unit).chain(others.clone().map(|p| p.0)).collect();
            let equations = Equations::new(&lagrangians[proposal.of], &chosen, (space, rates), dt)?;
            let theta: Vec<f64> = std::iter::once(1.0).chain(others.map(|p| p.1)).collect();
            let fitted = of_some.fitted(&|theta| equations.at(theta), &theta, None, FEW)?;
            Some((of_some.left(&fitted), proposal.of, equations, fitted))
        };
        let best = proposals.iter().filter_map(first).min_by(|a, b| a.0.total_cmp(&b.0));
        let (_, of, equations, fitted) = best?;
        let (equations, fitted) = refined(&problem, &data, (&lagrangians[of], rates), equations, &fitted.theta)?;
        account(rates, &data, &equations, &fitted)
    }
}

/// Terms chosen near the parameters fitted, and fitted again, until they stay.
fn refined(
    problem: &Problem<'_>,
    data: &Data<'_>,
    (lagrangian, rates): (&Lagrangian, &[Option<usize>]),
    mut equations: Equations,
    theta: &[f64],
) -> Option<(Equations, Fitted)> {
    let unit = equations.chosen[0];
    let all: Vec<usize> = std::iter::once(unit).chain(lagrangian.others(unit)).collect();
    let positive: Vec<bool> = all[1..].iter().map(|&p| lagrangian.dissipates(p)).collect();
    let everything = Equations::new(lagrangian, &all, (problem.space, rates), problem.dt)?;
    let mut fitted = data.fitted(&|theta| equations.at(theta), theta, None, SOME)?;
    for _ in 0..CHOICES {
        let value = |p: &usize| equations.chosen.iter().position(|q| q == p).map_or(0.0, |at| fitted.theta[at]);
        let theta: Vec<f64> = all.iter().map(value).collect();
        let (groups, weights): (Vec<Group>, Vec<f64>) = linearised::groups(data, &everything, (&theta, 0.0), &fitted)
            .into_iter()
            .zip(&fitted.weights)
            .filter_map(|(group, weight)| Some((group?, *weight)))
            .unzip();
        let Some(choice) = chosen(&groups, Some(&weights), &positive, (problem.solver, problem.watch.asks())) else {
            break;
        };
        let own: Vec<usize> = std::iter::once(unit).chain(choice.support.iter().map(|c| all[1 + c])).collect();
        let same = own.len() == equations.chosen.len() && own.iter().all(|p| equations.chosen.contains(p));
        let xi: Vec<f64> = std::iter::once(1.0).chain(choice.xi.iter().copied()).collect();
        if same {
            break;
        }
        let Some(next) = Equations::new(lagrangian, &own, (problem.space, rates), problem.dt) else { break };
        let Some(better) = data.fitted(&|theta| next.at(theta), &xi, Some(&fitted), SOME) else { break };
        (equations, fitted) = (next, better);
    }
    let fitted = data.fitted(&|theta| equations.at(theta), &fitted.theta, Some(&fitted), MANY)?;
    Some((equations, fitted))
}

impl Problem<'_> {
    /// What the weak form proposes: the smallest losses over windows of middle length, and over others with the same arrangement and unit.
    fn proposals(&self, lagrangians: &[Lagrangian], scale: f64) -> Vec<Proposal> {
        let balances: Vec<Balances> = lagrangians.iter().map(|l| balances(l, self.segments)).collect();
        let weak = |of: usize, length: f64| Weak::new(&balances[of], self.segments, length * scale);
        let of_all = |(of, lagrangian): (usize, &Lagrangian)| {
            let weak = weak(of, LENGTHS[0]);
            lagrangian
                .units()
                .into_iter()
                .filter_map(|unit| self.proposed(lagrangian, &weak, (of, unit)))
                .collect::<Vec<_>>()
        };
        let mut first: Vec<(f64, Proposal)> = lagrangians.iter().enumerate().flat_map(of_all).collect();
        first.sort_by(|a, b| a.0.total_cmp(&b.0));
        first.truncate(PROPOSALS);
        let others: Vec<(f64, Proposal)> = first
            .iter()
            .flat_map(|(_, p)| LENGTHS[1..].iter().map(move |length| ((p.of, p.unit), *length)))
            .filter_map(|((of, unit), length)| self.proposed(&lagrangians[of], &weak(of, length), (of, unit)))
            .collect();
        first.into_iter().chain(others).map(|(_, proposal)| proposal).collect()
    }

    /// What the windows `weak` propose, and what they lose by it.
    fn proposed(&self, lagrangian: &Lagrangian, weak: &Weak, (of, unit): (usize, usize)) -> Option<(f64, Proposal)> {
        let choice = lagrangian.others(unit);
        let positive: Vec<bool> = choice.iter().map(|&p| lagrangian.dissipates(p)).collect();
        if weak.len() * lagrangian.joints.len() <= choice.len() {
            return None;
        }
        let mut sizes = vec![1.0; lagrangian.joints.len()];
        let mut found: Option<Choice> = None;
        let parameters = |found: &Choice| -> Vec<(usize, f64)> {
            found.support.iter().map(|c| choice[*c]).zip(found.xi.iter().copied()).collect()
        };
        for _ in 0..WEIGHINGS {
            let groups = weak.groups((unit, &choice), &sizes);
            let begun = found.as_ref().map(|f| &f.weights[..]);
            let next = chosen(&groups, begun, &positive, (self.solver, self.watch.asks()))?;
            sizes = weak.exchanged(lagrangian, &parameters(&next));
            found = Some(next);
        }
        found.map(|found| (found.loss, Proposal { of, unit, parameters: parameters(&found) }))
    }
}

/// Standard deviation of the samples of state `i`.
fn spread(segments: &[Segment], i: usize) -> f64 {
    let all: Vec<f64> = segments.iter().flat_map(|s| s.x.column(i).to_vec()).collect();
    let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
    (all.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / all.len().max(1) as f64).sqrt()
}

/// RMS of the samples of state `i`.
fn size(segments: &[Segment], i: usize) -> f64 {
    let (sum, count) =
        segments.iter().flat_map(|s| s.x.column(i).to_vec()).fold((0.0, 0.0), |(s, c), v| (s + v * v, c + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}
