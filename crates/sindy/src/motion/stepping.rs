//! How a system goes from one sample to the next.

use serde::{Deserialize, Serialize};
use sindyna_core::Scheme;

use super::Run;
use crate::design::whiten;
use crate::model::Form;

/// How the equations of motion are stepped through one control interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Stepping {
    /// Every state moves by its rate before the step.
    Euler,
    /// Rates first, the states they belong to then move by the new ones.
    SemiImplicit {
        /// Steps per control interval.
        substeps: usize,
    },
    /// In continuous time: Runge–Kutta steps of fourth order.
    Continuous {
        /// Steps per control interval.
        substeps: usize,
    },
    /// Classical Runge–Kutta steps of a simulator, over kinks as over anything.
    Classical {
        /// Steps per control interval.
        substeps: usize,
    },
}

impl Stepping {
    pub(crate) fn is_continuous(self) -> bool {
        matches!(self, Self::Continuous { .. } | Self::Classical { .. })
    }

    pub(crate) fn form(self) -> Form {
        match self {
            Self::Euler => Form::Continuous(Scheme::Euler),
            Self::SemiImplicit { substeps } => Form::SemiImplicit { substeps },
            Self::Continuous { substeps } | Self::Classical { substeps } => Form::Continuous(Scheme::Rk4 { substeps }),
        }
    }
}

/// Most Runge–Kutta steps per control interval that are tried.
pub(super) const FINEST: usize = 8;

/// Most semi-implicit steps per control interval that are tried, and how far from the likeliest number.
pub(crate) const MOST_SEMI_IMPLICIT: usize = 20;
const NEIGHBOURS: usize = 2;

/// Difference of −2 ln L below which two ways of stepping are as good as each other.
pub(super) const CLEAR: f64 = 12.0;

/// States with the states that are their rates.
fn pairs(rates: &[Option<usize>]) -> Vec<(usize, usize)> {
    rates.iter().enumerate().filter_map(|(i, r)| r.map(|v| (i, v))).collect()
}

/// The stepping that the states with known rates show: whether they moved by the rate before the step, after it, or by
/// something between the two. `rates` holds, per state, the state that is its rate. `None` where no state has one.
///
/// What the data cannot tell is taken as continuous.
pub(crate) fn shown(runs: &[Run], rates: &[Option<usize>], dt: f64) -> Option<Stepping> {
    let pairs = pairs(rates);
    if pairs.is_empty() {
        return None;
    }
    let misfit = |old: f64, new: f64| misfit(runs, &pairs, dt, (old, new));
    let continuous = misfit(0.5, 0.5);
    let (euler, semi) = (misfit(1.0, 0.0), misfit(0.0, 1.0));
    Some(if euler.min(semi) + CLEAR > continuous {
        Stepping::Continuous { substeps: 1 }
    } else if euler <= semi {
        Stepping::Euler
    } else {
        Stepping::SemiImplicit { substeps: 1 }
    })
}

/// Ways in which a simulator may have gone from sample to sample, the likeliest first, where the states with known rates do not show one that is
/// discrete: those that they do not contradict.
pub(crate) fn simulators(runs: &[Run], rates: &[Option<usize>], dt: f64) -> Vec<Stepping> {
    match shown(runs, rates, dt) {
        None => vec![Stepping::Euler],
        Some(Stepping::Continuous { .. }) => {
            let shown = substeps_shown(runs, rates, dt).into_iter().map(|substeps| Stepping::SemiImplicit { substeps });
            // Noise may hide a single step of what the whole equations show.
            let pairs = pairs(rates);
            let misfit = |old: f64, new: f64| misfit(runs, &pairs, dt, (old, new));
            let single =
                [(Stepping::SemiImplicit { substeps: 1 }, misfit(0.0, 1.0)), (Stepping::Euler, misfit(1.0, 0.0))];
            let bar = misfit(0.5, 0.5) + CLEAR;
            shown.chain(single.into_iter().filter(|(_, misfit)| *misfit < bar).map(|(stepping, _)| stepping)).collect()
        }
        Some(_) => Vec::new(),
    }
}

/// Numbers of semi-implicit steps per control interval that the states with known rates show, the likeliest first: a simulator that takes several steps from
/// sample to sample, as MuJoCo's do. Empty where continuous time is as likely, or one step.
///
/// With m steps of the same acceleration x⁺ = x + Δt ((m − 1) v + (m + 1) v⁺)/(2 m).
pub(super) fn substeps_shown(runs: &[Run], rates: &[Option<usize>], dt: f64) -> Vec<usize> {
    let pairs = pairs(rates);
    let of = |substeps: usize| {
        let after = (substeps + 1) as f64 / (2 * substeps) as f64;
        misfit(runs, &pairs, dt, (1.0 - after, after))
    };
    let likeliest = (2..=MOST_SEMI_IMPLICIT).min_by(|a, b| of(*a).total_cmp(&of(*b)));
    let Some(m) = likeliest.filter(|m| of(*m) + CLEAR < misfit(runs, &pairs, dt, (0.5, 0.5))) else {
        return Vec::new();
    };
    // Accelerations change within an interval, which hides a step or two of many.
    let mut near: Vec<usize> = (m.saturating_sub(NEIGHBOURS).max(2)..=m + NEIGHBOURS).collect();
    near.sort_by_key(|other| other.abs_diff(m));
    near
}

/// Share of the steps, those with the largest errors, that tell nothing of how a system is stepped: impacts and glitches.
const UNLIKE: f64 = 0.05;

/// −2 ln L of x⁺ = x + Δt (a v + b v⁺) for the states x with the rates v in `pairs`. Errors may be larger than they are said to be, so their size is
/// estimated; smaller than rounding they are not.
fn misfit(runs: &[Run], pairs: &[(usize, usize)], dt: f64, (a, b): (f64, f64)) -> f64 {
    let of = |&(i, v): &(usize, usize)| {
        let all: Vec<Vec<f64>> = runs.iter().map(|run| errors(run, i, v, dt, (a, b))).collect();
        let mut sizes: Vec<f64> = all.iter().flatten().map(|e| e.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let like = sizes.len() - (UNLIKE * sizes.len() as f64) as usize;
        let largest = sizes.get(like.saturating_sub(1)).copied().unwrap_or(0.0);
        let squares: Vec<f64> =
            runs.iter().zip(&all).flat_map(|(run, e)| squared(run, (i, v), dt, e, largest)).collect();
        let steps = squares.len().max(1) as f64;
        steps * (squares.iter().sum::<f64>() / steps).max(1.0).ln()
    };
    pairs.iter().map(of).sum()
}

/// The errors of x⁺ = x + Δt (a v + b v⁺), over Δt.
fn errors(run: &Run, i: usize, v: usize, dt: f64, (a, b): (f64, f64)) -> Vec<f64> {
    let error = |t: usize| (run.x[[t + 1, i]] - run.x[[t, i]]) / dt - a * run.x[[t, v]] - b * run.x[[t + 1, v]];
    (0..run.len()).map(error).collect()
}

/// The squared, whitened errors of the steps of `run` whose error is no larger than `largest`. What is left out borders the others: one impact would
/// be in the whitened errors of all steps after it.
fn squared(run: &Run, (i, v): (usize, usize), dt: f64, errors: &[f64], largest: f64) -> Vec<f64> {
    // The error of the rate enters too.
    let sigma = |t: usize| run.sigma[[t, i]].hypot(dt * run.sigma[[t, v]]);
    let mut squares = Vec::with_capacity(errors.len());
    let mut first = 0;
    for part in errors.split(|e| e.abs() > largest) {
        let mut rows = ndarray::Array2::from_shape_fn((part.len(), 1), |(t, _)| part[t]);
        let sigma: Vec<f64> = (first..=first + part.len()).map(sigma).collect();
        whiten(rows.view_mut(), &sigma, &vec![0.0; part.len()], &vec![dt; part.len()]);
        squares.extend(rows.iter().map(|w| w * w));
        first += part.len() + 1;
    }
    squares
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;

    use super::*;

    /// A ball in the steps of a simulator that bounces: where it does, no rule of these steps holds.
    fn bouncing(after: f64) -> Run {
        let (steps, dt) = (400, 0.02);
        let mut x = Array2::zeros((steps + 1, 2));
        x[[0, 0]] = 1.0;
        for t in 0..steps {
            let v = x[[t, 1]] - 9.81 * dt;
            let y = x[[t, 0]] + dt * ((1.0 - after) * x[[t, 1]] + after * v);
            let hits = y < 0.0;
            x[[t + 1, 0]] = if hits { -0.95 * y } else { y };
            x[[t + 1, 1]] = if hits { -0.95 * v } else { v };
        }
        Run {
            x,
            u: Array2::zeros((steps, 0)),
            sigma: Array2::from_elem((steps + 1, 2), 1e-6),
            of_inputs: Vec::new(),
            written: Vec::new(),
        }
    }

    #[test]
    fn a_few_impacts_hide_no_steps_of_a_simulator() {
        let rates = [Some(1), None];
        let shown = |after: f64| shown(&[bouncing(after)], &rates, 0.02);
        assert_eq!(shown(1.0), Some(Stepping::SemiImplicit { substeps: 1 }));
        assert_eq!(shown(0.0), Some(Stepping::Euler));
        assert_eq!(shown(0.5), Some(Stepping::Continuous { substeps: 1 }));
    }
}
