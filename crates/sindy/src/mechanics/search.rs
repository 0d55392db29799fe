//! The Lagrangian that explains steps to rounding.

use ndarray::Array2;

use super::balance::{Steps, balance};
use super::elimination::{Size, eliminated};
use super::fit::{Data, Fit};
use super::weighing::weighed;
use crate::library::{Joints, Lagrangian};
use crate::motion::{Run, Stepping, shown, simulators};
use crate::solve::FLOOR_FACTOR;
use crate::{Triangle, Watch};

/// Sets of parameters that are followed step by step, and of how many at most: from others no steps can be fitted.
const ELBOWS: usize = 4;
const TRIED: usize = 32;

/// Part of the momentum that is left unexplained, beyond which a set of parameters is none.
const EXPLAINED: f64 = 0.2;

/// Part of the momentum that is rounding.
const NOTHING: f64 = 1e-13;

/// Most Runge–Kutta steps per control interval.
const FINEST: usize = 8;

/// Rounds of Gauss–Newton, of few parameters and of all.
const FEW: usize = 4;
const ALL: usize = 12;

/// Half the RMS of whitened residuals that rounding explains.
const ROUNDING: f64 = 2.0;

/// A Lagrangian that explains steps.
pub(crate) struct Mechanics {
    pub(crate) lagrangian: Lagrangian,
    /// Parameters with their values.
    pub(crate) parameters: Vec<(usize, f64)>,
    pub(crate) stepping: Stepping,
    /// Parameters that the data tell, beside the unit.
    pub(crate) triangle: Triangle,
}

/// Parameters that nearly explain the momenta, and by how much more is left without the one of them that is missed least.
pub(super) struct Elbow {
    /// Place of the Lagrangian.
    pub(super) of: usize,
    jump: f64,
    pub(super) chosen: Vec<usize>,
    pub(super) values: Vec<f64>,
}

/// What `explains` makes of the Lagrangian of `joints` that leaves least of the steps of `runs`, with the fewest parameters that do: of bodies in a plane, else
/// of others, those of the fewest angles first.
pub(crate) fn mechanics<T>(
    joints: &Joints,
    (runs, rates, dt): (&[Run], &[Option<usize>], f64),
    is_short: bool,
    explains: impl Fn(&Mechanics) -> Option<T>,
    watch: &Watch<'_>,
) -> Option<T> {
    let steppings = match shown(runs, rates, dt) {
        None => return None,
        Some(Stepping::Continuous { .. }) => {
            let several = simulators(runs, rates, dt);
            (1..=FINEST).map(|substeps| Stepping::Continuous { substeps }).chain(several).collect()
        }
        Some(stepping) => vec![stepping],
    };
    let at_once = steppings.len() == 1;
    let planar = std::iter::once_with(|| Lagrangian::arrangements(joints));
    // Many steps are told by the estimator, too.
    let most = if is_short { joints.angles().len() } else { 0 };
    let spatial = (1..=most).map(|count| Lagrangian::of_some_angles(joints, count));
    let found = planar.chain(spatial).filter_map(|all| likeliest(&all, (runs, dt), (&steppings, at_once), watch));
    found.filter_map(|found| explains(&found)).next()
}

/// The one of `lagrangians` that leaves least of the steps.
fn likeliest(
    lagrangians: &[Lagrangian],
    (runs, dt): (&[Run], f64),
    (steppings, at_once): (&[Stepping], bool),
    watch: &Watch<'_>,
) -> Option<Mechanics> {
    let mut elbows: Vec<Elbow> = Vec::new();
    for (of, lagrangian) in lagrangians.iter().enumerate() {
        if !watch.go_on() {
            return None;
        }
        let balanced = |run: &Run| {
            let steps = Steps { x: run.x.view(), u: run.u.view(), dt: &vec![dt; run.len()] };
            balance(lagrangian, steps, at_once)
        };
        let rows: Vec<Vec<Array2<f64>>> = runs.iter().map(balanced).collect();
        for unit in lagrangian.units() {
            let choice = lagrangian.others(unit);
            if let Some(triangle) = weighed(lagrangian, &rows, (unit, &choice)) {
                elbows.extend(jumps(&triangle, (of, unit, &choice), EXPLAINED));
            }
        }
    }
    elbows.sort_by(|a, b| b.jump.total_cmp(&a.jump));
    elbows.truncate(TRIED);
    let data = |elbow: &Elbow| Data { lagrangian: &lagrangians[elbow.of], runs, dt };
    // The steps of a simulator, and what is left of them, show where nothing else is missing.
    let finest = *steppings.get(FINEST - 1).or(steppings.last())?;
    let all = elbows.iter().filter_map(|elbow| Some((elbow, data(elbow).with_all(elbow, finest)?)));
    let (elbow, _) = all.take(ELBOWS).min_by(|(_, a), (_, b)| a.rms.total_cmp(&b.rms))?;
    let data = data(elbow);
    let all = steppings.iter().filter_map(|&stepping| data.with_all(elbow, stepping));
    let found = data.with_fewest(&all.min_by(|a, b| a.rms.total_cmp(&b.rms))?)?;
    let (triangle, _) = data.linearised(&data.mechanism(&found.chosen), &found.values, found.stepping)?;
    let parameters = found.chosen.into_iter().zip(found.values).collect();
    Some(Mechanics { lagrangian: data.lagrangian.clone(), parameters, stepping: found.stepping, triangle })
}

impl Data<'_> {
    /// All parameters fitted, from those of `elbow`.
    fn with_all(&self, elbow: &Elbow, stepping: Stepping) -> Option<Fit> {
        let rough = self.fitted(&elbow.chosen, elbow.values.clone(), stepping, FEW)?;
        let unit = elbow.chosen[0];
        let value = |p: &usize| rough.chosen.iter().position(|q| q == p).map_or(0.0, |at| rough.values[at]);
        let others = self.lagrangian.others(unit);
        let values = std::iter::once(1.0).chain(others.iter().map(value)).collect();
        let chosen: Vec<usize> = std::iter::once(unit).chain(others).collect();
        self.fitted(&chosen, values, stepping, ALL)
    }

    /// The fewest of the parameters `all` that leave no more than rounding, or than all do; `None` if they are too many for the steps to tell.
    fn with_fewest(&self, all: &Fit) -> Option<Fit> {
        let (triangle, _) = self.linearised(&self.mechanism(&all.chosen), &all.values, all.stepping)?;
        let limit = FLOOR_FACTOR * ROUNDING.max(all.rms);
        let count = (2 * self.rows()) as f64;
        let path = eliminated(&triangle, &all.values[1..]);
        let Size { columns, values, .. } = path.into_iter().rev().find(|size| size.left / count.sqrt() <= limit)?;
        let chosen: Vec<usize> =
            std::iter::once(all.chosen[0]).chain(columns.iter().map(|j| all.chosen[1 + j])).collect();
        let values = std::iter::once(1.0).chain(values).collect();
        let found = self.fitted(&chosen, values, all.stepping, ALL)?;
        (3 * found.chosen.len() <= 2 * self.rows()).then_some(found)
    }
}

/// Sets of parameters at which the residual, for each row that is not needed to fit them, falls most, to less than the part `explained` of the momentum.
pub(super) fn jumps(triangle: &Triangle, (of, unit, choice): (usize, usize, &[usize]), explained: f64) -> Vec<Elbow> {
    let target = choice.len();
    let whole = triangle.norm(target);
    let n_rows = triangle.n_rows();
    let path = eliminated(triangle, &vec![0.0; target]);
    let left = |at: usize| {
        let free = n_rows.saturating_sub(path[at].columns.len());
        (free > 0).then(|| path[at].left / whole * (n_rows as f64 / free as f64).sqrt() + NOTHING)
    };
    let elbow = |at: usize| {
        let (here, fewer) = (left(at)?, if at + 1 < path.len() { left(at + 1)? } else { 1.0 });
        let Size { columns, values, .. } = &path[at];
        let chosen = std::iter::once(unit).chain(columns.iter().map(|&c| choice[c])).collect();
        let values = std::iter::once(1.0).chain(values.iter().copied()).collect();
        (here < explained).then_some(Elbow { of, jump: fewer / here, chosen, values })
    };
    let mut elbows: Vec<Elbow> = (0..path.len()).filter_map(elbow).collect();
    elbows.sort_by(|a, b| b.jump.total_cmp(&a.jump));
    elbows.truncate(2);
    elbows
}
