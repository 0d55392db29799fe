//! Where a policy goes in its model and what it does there, and where the data never were.

use std::f64::consts::{PI, TAU};
use std::sync::atomic::{AtomicUsize, Ordering};

use ndarray::Array2;
use rayon::prelude::*;
use sindyna_core::{Dataset, Dynamics, Inverse, Kind, Policy, Spec};
use sindyna_record::run::{ChannelRange, Coverage};

use crate::problem::Problem;
use crate::rollout::{Rollout, rollout};

/// Episodes in the model, and those of a policy that plans, which takes its time for every step.
const EPISODES: u64 = 100;
const PLANNED: u64 = 10;

/// States and controls of `policy` in `model` beside those of `data`; `None` if states follow from no observation. `begun` is told how many episodes
/// were begun, of how many, whenever another is.
pub(crate) fn coverage(
    problem: &dyn Problem,
    (model, policy): (&dyn Dynamics, &dyn Policy),
    data: &Dataset,
    begun: &(dyn Fn(usize, usize) + Sync),
) -> Option<Coverage> {
    let spec = problem.spec();
    let shown = ranges(spec.state_dim(), &states(spec, data)?);
    let pushed: Vec<Vec<f64>> =
        data.rollouts().flat_map(|r| r.controls.outer_iter().map(|u| u.to_vec()).collect::<Vec<_>>()).collect();
    let margins: Vec<f64> = (0..spec.control_dim()).map(|j| between(j, &pushed)).collect();
    let pushed = ranges(spec.control_dim(), &pushed);
    let episodes = if policy.begin().is_some() { PLANNED } else { EPISODES };
    let count = AtomicUsize::new(0);
    let acted = |episode| {
        begun(1 + count.fetch_add(1, Ordering::Relaxed), episodes as usize);
        rollout(problem, model, policy, ("coverage", episode))
    };
    let rollouts: Vec<Rollout> = (0..episodes).into_par_iter().map(acted).collect();
    let is_off = |value: f64, (low, high): (f64, f64)| value < low || value > high;
    let outside = |x: &[f64], u: &[f64]| {
        let mut states = x.iter().zip(&shown).zip(&spec.state).filter(|(_, channel)| channel.kind != Kind::Angle);
        states.any(|((value, range), _)| is_off(*value, *range))
            || u.iter().zip(pushed.iter().zip(&margins)).any(|(u, ((low, high), by))| is_off(*u, (low - by, high + by)))
    };
    // Each step with the state it leads to.
    let steps = || rollouts.iter().flat_map(|r| r.states.iter().skip(1).zip(&r.controls));
    // Of an angle that has turned all the way round every value was seen.
    let turned: Vec<bool> =
        spec.state.iter().zip(&shown).map(|(c, (low, high))| c.kind == Kind::Angle && high - low >= TAU).collect();
    let within_a_turn = |i: usize, range: (f64, f64)| if turned[i] { (-PI, PI) } else { range };
    let share = steps().filter(|(x, u)| outside(x, u)).count() as f64 / steps().count().max(1) as f64;
    let gone = ranges(spec.state_dim(), rollouts.iter().flat_map(|r| &r.states));
    let acted = ranges(spec.control_dim(), rollouts.iter().flat_map(|r| &r.controls));
    let each = spec.state.iter().zip(shown).zip(gone).enumerate();
    let states = each.map(|(i, ((channel, data), policy))| ChannelRange {
        channel: channel.name.clone(),
        unit: channel.unit.clone(),
        data: within_a_turn(i, data),
        policy: if policy.0 < -PI || policy.1 > PI { within_a_turn(i, policy) } else { policy },
        margin: 0.0,
    });
    let each = spec.control.iter().zip(pushed.into_iter().zip(margins)).zip(acted);
    let controls = each.map(|((channel, (data, margin)), policy)| ChannelRange {
        channel: channel.name.clone(),
        unit: channel.unit.clone(),
        data,
        policy,
        margin,
    });
    let (states, controls) = (states.collect(), controls.collect());
    let terminated = rollouts.iter().filter(|rollout| rollout.terminated).count();
    Some(Coverage { episodes: episodes as usize, terminated, share_outside: share, states, controls })
}

/// The mean distance of neighbouring values of control `j`: as far as the largest of so many may be from the end of what they are drawn from.
fn between(j: usize, controls: &[Vec<f64>]) -> f64 {
    let mut values: Vec<f64> = controls.iter().map(|u| u[j]).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values.last().zip(values.first()).map_or(0.0, |(high, low)| (high - low) / values.len() as f64)
}

/// All states (n each) of `data`.
fn states(spec: &Spec, data: &Dataset) -> Option<Vec<Vec<f64>>> {
    let inverse = Inverse::of(spec).ok()?;
    let mut found = Vec::new();
    for rollout in data.rollouts() {
        let mut near = vec![0.0; spec.state_dim()];
        let observations: Array2<f64> = rollout.observations.to_owned();
        for o in observations.rows() {
            let mut x = vec![0.0; spec.state_dim()];
            inverse.state(&o.to_vec(), &near, &mut x);
            near.clone_from(&x);
            found.push(x);
        }
    }
    Some(found)
}

/// Lowest and highest of each of `count` values.
fn ranges<'a>(count: usize, all: impl IntoIterator<Item = &'a Vec<f64>>) -> Vec<(f64, f64)> {
    let none = vec![(f64::INFINITY, f64::NEG_INFINITY); count];
    let wider = |ranges: Vec<(f64, f64)>, values: &Vec<f64>| {
        ranges.into_iter().zip(values).map(|((low, high), v)| (low.min(*v), high.max(*v))).collect()
    };
    all.into_iter().fold(none, wider)
}
