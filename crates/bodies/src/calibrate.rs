//! Parameters of a tree of bodies from motions.

use crate::base::Base;
use crate::consistent::consistent;
use crate::output_error::output_error;
use crate::regression::{Regression, regression};
use crate::rows::{Form, Motion, Rows, rows};
use crate::simulate::{simulated_from, start_of};
use crate::{BodiesError, Tree};

/// Share of each motion, its end, by which forms of rows are compared.
const KEPT: f64 = 0.3;

/// Length of windows that are predicted \[s\], in steps at least, and their number at most.
const AHEAD: f64 = 0.5;
const STEPS: usize = 10;
const WINDOWS: usize = 40;

/// Steps at the beginning of a window to which its start is fitted.
const BEGUN: usize = 10;

/// Part of the error of a prediction by least squares that another one's must be below: without noise both are as good.
const BETTER: f64 = 0.98;

/// Longest delay of forces that is tried \[steps\], and the part of the error of a prediction that one with a longer delay must be below.
const LONGEST_DELAY: i32 = 20;
const CLEAR: f64 = 0.7;

/// Steps of a window of the weak form.
const LENGTHS: [usize; 4] = [8, 16, 32, 64];

/// Identified parameters of a tree of bodies.
#[derive(Debug, Clone)]
pub struct Calibration {
    /// What motions can tell.
    pub base: Base,
    /// The values of the base parameters (b), by linear regression.
    pub values: Vec<f64>,
    /// Their standard errors (b), from blocks of the data; infinite where these do not determine a value.
    pub errors: Vec<f64>,
    /// All parameters (13 n): of bodies that there can be, whose base parameters are nearest to these, and else nearest to those of the file.
    pub parameters: Vec<f64>,
    /// Condition number of the regression, its columns scaled to length 1.
    pub condition: f64,
    /// Base parameters that no motion in the data tells apart from others.
    pub undetermined: usize,
    /// The rows of the regression, in words.
    pub form: String,
    /// Steps by which forces act later than they were recorded.
    pub delay: i32,
    /// What parameters from the first part of each motion predict of its end.
    pub prediction: Option<Prediction>,
}

/// Predictions over windows that were not fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// Length of a window \[s\].
    pub seconds: f64,
    /// Number of windows.
    pub windows: usize,
    /// Windows in which the simulation diverges.
    pub diverged: usize,
    /// Median over windows of the RMS error of each position (n).
    pub errors: Vec<f64>,
    /// The same if every joint stayed where it is at the beginning of the window.
    pub still: Vec<f64>,
    /// The same with the parameters of the file; `None` where these cannot be simulated.
    pub before: Option<Vec<f64>>,
}

/// Identifies the parameters of `tree` from `motions`: base parameters by a linear regression, which needs no start values, then parameters of bodies that there can be.
///
/// Rows are measured accelerations where there are any; else momenta over single steps or the weak form over windows, whichever predicts the end of the motions best from what came before.
///
/// `go_on` is asked now and then.
///
/// # Errors
/// [`BodiesError`] if motions do not fit the tree or are too few; [`BodiesError::Interrupted`] if `go_on` said no.
pub fn calibrate(tree: &Tree, motions: &[Motion], go_on: &dyn Fn() -> bool) -> Result<Calibration, BodiesError> {
    if tree.is_empty() {
        return Err(BodiesError::NoJoint);
    }
    motions.iter().try_for_each(|m| m.check(tree.len()))?;
    let base = Base::of(tree);
    let sizes = spreads(tree.len(), motions);
    let measured = !motions.is_empty() && motions.iter().all(|m| m.accelerations.is_some());
    let problem = Problem { tree, base: &base, sizes: &sizes, go_on };
    let choice = if measured {
        problem.regression(motions, Form::Accelerations)?;
        Choice { form: Form::Accelerations, delay: 0, prediction: None }
    } else {
        problem.with_delay(motions)?
    };
    let Choice { form, delay, prediction } = choice;
    let motions: &[Motion] = &motions.iter().map(|m| m.delayed(delay)).collect::<Vec<_>>();
    let (first, last): (Vec<Motion>, Vec<Motion>) = motions.iter().map(split).unzip();
    // Noise draws least squares towards zero where forces are small beside what masses and gravity do; errors of simulated motions do not.
    let polished = |motions: &[Motion], found: &Regression| {
        let near = output_error((tree, &base), &found.values, (motions, length(motions)?), go_on)?;
        Some(Regression { condition: found.condition, ..near })
    };
    let of_first =
        if measured { None } else { Some(problem.regression(&first, form)?).filter(|found| found.undetermined == 0) };
    let near = of_first.and_then(|found| polished(&first, &found));
    let ahead = near.and_then(|found| predicted(tree, &base.as_parameters(&found.values), (&last, &sizes), go_on));
    let is_better = ahead.is_some() && worst(&ahead, &sizes) < BETTER * worst(&prediction, &sizes);
    let found = problem.regression(motions, form)?;
    let near = if is_better { polished(motions, &found) } else { None };
    let (found, form, prediction) = match near {
        Some(near) => (near, format!("output error of simulated motions, begun with the {}", form.name()), ahead),
        None => (found, format!("linear regression, {}", form.name()), prediction),
    };
    let Regression { values, errors, information, condition, undetermined } = found;
    let before =
        predicted(tree, &tree.parameters(), (&last, &sizes), go_on).filter(|p| p.diverged == 0).map(|p| p.errors);
    let parameters = consistent(tree, &base, &values, &information);
    let prediction = prediction.map(|p| Prediction { before, ..p });
    if !go_on() {
        return Err(BodiesError::Interrupted);
    }
    Ok(Calibration { base, values, errors, parameters, condition, undetermined, form, delay, prediction })
}

/// What parameters are looked for in.
struct Problem<'a> {
    tree: &'a Tree,
    base: &'a Base,
    /// Spread of positions and rates (2 n).
    sizes: &'a [f64],
    go_on: &'a dyn Fn() -> bool,
}

/// How motions are read, and what that predicts.
#[derive(Debug, Clone)]
struct Choice {
    form: Form,
    delay: i32,
    prediction: Option<Prediction>,
}

impl Problem<'_> {
    fn regression(&self, motions: &[Motion], form: Form) -> Result<Regression, BodiesError> {
        let all: Vec<Rows> = motions.iter().flat_map(|m| rows(self.tree, m, form, self.go_on)).collect();
        regression(self.base, &all)
    }

    /// The one of `forms` whose parameters, found in the first part of each motion, predict its end best.
    fn with_form(&self, motions: &[Motion], delay: i32, forms: &[Form]) -> Result<Choice, BodiesError> {
        let (first, last): (Vec<Motion>, Vec<Motion>) = motions.iter().map(|m| split(&m.delayed(delay))).unzip();
        let (mut best, mut failure): (Option<Choice>, Option<BodiesError>) = (None, None);
        for &form in forms {
            let found = self.regression(&first, form);
            if !(self.go_on)() {
                return Err(BodiesError::Interrupted);
            }
            let parameters = found.map(|found| self.base.as_parameters(&found.values));
            match parameters.map(|p| predicted(self.tree, &p, (&last, self.sizes), self.go_on)) {
                Ok(prediction @ Some(_)) => {
                    let before = best.as_ref().map_or(f64::MAX, |b| worst(&b.prediction, self.sizes));
                    if best.is_none() || worst(&prediction, self.sizes) < before {
                        best = Some(Choice { form, delay, prediction });
                    }
                }
                Ok(None) => {
                    let got = last.iter().map(Motion::steps).max().unwrap_or(0);
                    failure.get_or_insert(BodiesError::Short { got, needed: STEPS });
                }
                Err(error) => {
                    failure.get_or_insert(error);
                }
            }
        }
        best.ok_or_else(|| failure.unwrap_or(BodiesError::TooFew { got: 0, needed: self.base.len() }))
    }

    /// The same with the delay of the forces that predicts clearly better than a shorter one.
    fn with_delay(&self, motions: &[Motion]) -> Result<Choice, BodiesError> {
        let forms: Vec<Form> = std::iter::once(Form::Steps).chain(LENGTHS.map(Form::Windows)).collect();
        let given = self.with_form(motions, 0, &forms)?;
        let mut best = given.clone();
        for sign in [1, -1] {
            for steps in 1..=LONGEST_DELAY {
                let Ok(next) = self.with_form(motions, sign * steps, &[given.form]) else { break };
                if worst(&next.prediction, self.sizes) >= CLEAR * worst(&best.prediction, self.sizes) {
                    break;
                }
                best = next;
            }
        }
        if best.delay == 0 { Ok(given) } else { self.with_form(motions, best.delay, &forms) }
    }
}

/// A motion but for its end, and that.
fn split(motion: &Motion) -> (Motion, Motion) {
    let cut = motion.steps() - (KEPT * motion.steps() as f64) as usize;
    (motion.part(0, cut), motion.part(cut, motion.steps()))
}

/// Steps of a window; `None` without any.
fn length(motions: &[Motion]) -> Option<usize> {
    let dt = motions.iter().find(|m| m.steps() > 0).map(|m| (m.times[m.steps()] - m.times[0]) / m.steps() as f64)?;
    let longest = motions.iter().map(Motion::steps).max().filter(|steps| *steps >= STEPS)?;
    Some(((AHEAD / dt).round() as usize).max(STEPS).min(longest))
}

/// What `parameters` (13 n) of `tree` predict of `motions`: positions over windows of half a second, begun at the state nearest to their first samples. `None` if no window fits into them.
#[must_use]
pub fn predict(tree: &Tree, parameters: &[f64], motions: &[Motion], go_on: &dyn Fn() -> bool) -> Option<Prediction> {
    motions.iter().try_for_each(|m| m.check(tree.len())).ok()?;
    predicted(tree, parameters, (motions, &spreads(tree.len(), motions)), go_on)
}

/// The same for channels of the spread `sizes` (2 n).
fn predicted(
    tree: &Tree,
    parameters: &[f64],
    (motions, sizes): (&[Motion], &[f64]),
    go_on: &dyn Fn() -> bool,
) -> Option<Prediction> {
    let n = tree.len();
    let length = length(motions)?;
    let seconds = motions.iter().find(|m| m.steps() >= length).map(|m| m.times[length] - m.times[0])?;
    let starts = |m: &Motion| {
        (0..=m.steps().saturating_sub(length))
            .step_by(length)
            .filter(|from| from + length <= m.steps())
            .collect::<Vec<_>>()
    };
    let all: Vec<(&Motion, usize)> =
        motions.iter().flat_map(|m| starts(m).into_iter().map(move |from| (m, from))).collect();
    let hop = all.len().div_ceil(WINDOWS).max(1);
    let (mut errors, mut still, mut diverged) = (vec![Vec::new(); n], vec![Vec::new(); n], 0);
    for (motion, from) in all.iter().step_by(hop).take_while(|_| go_on()) {
        let window = motion.part(*from, from + length);
        let start = start_of(tree, parameters, &window.part(0, BEGUN.min(length)), sizes);
        let simulated = start.and_then(|start| simulated_from(tree, parameters, &window, &start));
        diverged += usize::from(simulated.is_none());
        for (i, still) in still.iter_mut().enumerate() {
            let column = window.positions.column(i);
            still.push((column.add_scalar(-column[0]).norm_squared() / length as f64).sqrt());
        }
        for (i, errors) in errors.iter_mut().enumerate() {
            errors.push(simulated.as_ref().map_or(f64::INFINITY, |x| {
                let difference = x.column(i) - window.positions.column(i);
                (difference.norm_squared() / length as f64).sqrt()
            }));
        }
    }
    let windows = errors.first().map_or(0, Vec::len);
    let median = |mut of: Vec<f64>| {
        of.sort_by(f64::total_cmp);
        of.get(of.len() / 2).copied()
    };
    let errors = errors.into_iter().map(median).collect::<Option<Vec<f64>>>()?;
    let still = still.into_iter().map(median).collect::<Option<Vec<f64>>>()?;
    Some(Prediction { seconds, windows, diverged, errors, still, before: None })
}

/// The error of a prediction, as part of the spread of each position; without one it is larger than any.
fn worst(prediction: &Option<Prediction>, sizes: &[f64]) -> f64 {
    let of =
        |p: &Prediction| p.errors.iter().zip(sizes).map(|(error, size)| (error / size).powi(2)).sum::<f64>().sqrt();
    prediction.as_ref().map_or(f64::MAX, of)
}

/// Standard deviations of positions and rates (2 n).
fn spreads(n: usize, motions: &[Motion]) -> Vec<f64> {
    let spread = |i: usize| {
        let column =
            |m: &Motion| if i < n { m.positions.column(i).into_owned() } else { m.rates.column(i - n).into_owned() };
        let values: Vec<f64> = motions.iter().flat_map(|m| column(m).iter().copied().collect::<Vec<_>>()).collect();
        let count = values.len().max(1) as f64;
        let mean = values.iter().sum::<f64>() / count;
        let spread = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt();
        if spread > 0.0 { spread } else { 1.0 }
    };
    (0..2 * n).map(spread).collect()
}
