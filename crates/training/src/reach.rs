//! Where a policy goes in its model, and where the data never were.

use std::f64::consts::{PI, TAU};

use ndarray::Array2;
use rayon::prelude::*;
use sindyna_core::{Dataset, Dynamics, Inverse, Kind, Policy, Spec};
use sindyna_record::run::{Coverage, StateRange};

use crate::problem::Problem;
use crate::rollout::rollout;

/// Episodes in the model.
const EPISODES: u64 = 100;

/// States of `policy` in `model` beside those of `data`; `None` if states follow from no observation.
pub(crate) fn coverage(
    problem: &dyn Problem,
    model: &dyn Dynamics,
    policy: &dyn Policy,
    data: &Dataset,
) -> Option<Coverage> {
    let spec = problem.spec();
    let shown = ranges(spec, states(spec, data)?.into_iter());
    let visited: Vec<Vec<f64>> = (0..EPISODES)
        .into_par_iter()
        .flat_map_iter(|episode| rollout(problem, model, policy, ("coverage", episode)).states)
        .collect();
    let outside = |x: &Vec<f64>| {
        let mut beyond = x.iter().zip(&shown).zip(&spec.state).filter(|((_, _), channel)| channel.kind != Kind::Angle);
        beyond.any(|((value, (low, high)), _)| value < low || value > high)
    };
    // Of an angle that has turned all the way round every value was seen.
    let turned: Vec<bool> =
        spec.state.iter().zip(&shown).map(|(c, (low, high))| c.kind == Kind::Angle && high - low >= TAU).collect();
    let within_a_turn = |i: usize, range: (f64, f64)| if turned[i] { (-PI, PI) } else { range };
    let share = visited.iter().filter(|x| outside(x)).count() as f64 / visited.len().max(1) as f64;
    let gone = ranges(spec, visited.into_iter());
    let each = spec.state.iter().zip(shown).zip(gone).enumerate();
    let states = each.map(|(i, ((channel, data), policy))| StateRange {
        state: channel.name.clone(),
        unit: channel.unit.clone(),
        data: within_a_turn(i, data),
        policy: if policy.0 < -PI || policy.1 > PI { within_a_turn(i, policy) } else { policy },
    });
    Some(Coverage { episodes: EPISODES as usize, share_outside: share, states: states.collect() })
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

/// Lowest and highest value of each state.
fn ranges(spec: &Spec, states: impl Iterator<Item = Vec<f64>>) -> Vec<(f64, f64)> {
    let none = vec![(f64::INFINITY, f64::NEG_INFINITY); spec.state_dim()];
    states.fold(none, |ranges, x| ranges.into_iter().zip(x).map(|((low, high), v)| (low.min(v), high.max(v))).collect())
}
