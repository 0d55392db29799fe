//! Guesses of a way: states from a start to a goal that no controls need lead through.

use std::f64::consts::{PI, TAU};

use rand_distr::{Distribution as _, StandardNormal};
use sindyna_core::{Kind, Seed};

use super::goal::Goal;
use super::plant::Plant;

/// Directions in which angles may turn: those of so many are all tried.
const TURNING: usize = 2;

/// Waves that are added to a guess, and their sizes in scales, one guess after the other; less for the quicker waves.
const WAVES: usize = 4;
const HEIGHTS: [f64; 3] = [0.3, 1.0, 3.0];

/// How many guesses there are for each goal without waves: angles turn either way.
pub(crate) fn ways(plant: &Plant) -> usize {
    1 << turning(plant).len()
}

fn turning(plant: &Plant) -> Vec<usize> {
    (0..plant.dims().0).filter(|i| plant.turns[*i] && plant.moved[*i]).take(TURNING).collect()
}

/// States (`steps` + 1, n) from x to `goal`: guess `number`, all after the first [`ways`] with waves.
pub(crate) fn between(plant: &Plant, x: &[f64], goal: &Goal, steps: usize, number: usize) -> Vec<Vec<f64>> {
    let n = x.len();
    let error = goal.error(x);
    let mut way: Vec<f64> = error.iter().map(|error| -error).collect();
    for (bit, i) in turning(plant).into_iter().enumerate() {
        if (number >> bit) & 1 == 1 {
            way[i] -= TAU * way[i].signum();
        }
    }
    let mut rng = Seed::new(0).stream("guesses", number as u64);
    let height = if number < ways(plant) { 0.0 } else { HEIGHTS[number % HEIGHTS.len()] };
    let waves: Vec<Vec<f64>> = (0..n)
        .map(|i| {
            let of = |wave: usize| {
                let normal: f64 = StandardNormal.sample(&mut rng);
                height * plant.scales[i] / wave as f64 * normal
            };
            (1..=WAVES).map(of).collect()
        })
        .collect();
    let span = plant.spec().dt * steps as f64;
    let mut states = vec![x.to_vec(); steps + 1];
    for (t, state) in states.iter_mut().enumerate().skip(1) {
        let part = t as f64 / steps as f64;
        // A position goes from rest to rest.
        let place = |i: usize| {
            let waves: f64 = (1..).zip(&waves[i]).map(|(k, a)| a * (f64::from(k) * PI * part).sin()).sum();
            x[i] + way[i] * part * part * (3.0 - 2.0 * part) + waves
        };
        let rate = |i: usize| {
            let wave = |(k, a): (i32, &f64)| a * f64::from(k) * PI * (f64::from(k) * PI * part).cos();
            (way[i] * 6.0 * part * (1.0 - part) + (1..).zip(&waves[i]).map(wave).sum::<f64>()) / span
        };
        for i in (0..n).filter(|i| plant.moved[*i]) {
            let (low, high) = plant.spec().state[i].prior.bounds;
            let value = match plant.spec().state[i].kind {
                Kind::RateOf(of) => rate(of),
                _ => place(i),
            };
            state[i] = value.clamp(low, high);
        }
    }
    // It ends at the goal, turns aside.
    for i in (0..n).filter(|i| plant.moved[*i]) {
        states[steps][i] = x[i] + way[i];
    }
    states
}

#[cfg(test)]
mod tests {
    use super::super::goal::By;
    use super::super::ilqr::Plan;
    use super::super::objective::Objective;
    use super::super::rest::find;
    use super::*;

    #[test]
    fn gaps_of_a_guess_are_closed_at_its_goal() {
        let system = sindyna_envs::find("cart-pole-swing-up").expect("it is registered");
        let plant = Plant::new(system.dynamics(), system.task());
        let start = [0.0, PI, 0.0, 0.0];
        let goal = find(&plant, &start, By::Scales).swap_remove(0);
        let objective = Objective { effort: 1e-3, end: Some((&goal, 1.0)), ..Objective::default() };
        let closed = |steps: usize| {
            let states = between(&plant, &start, &goal, steps, 0);
            assert!(states[0] == start && goal.distance(&states[steps]) < 1e-9, "{steps}");
            let plan = Plan::through(&plant, &objective, states, vec![plant.middle(); steps]).expect("it stays finite");
            assert!(!plan.is_closed());
            let plan = plan.improved(&plant, &objective, 80);
            plan.is_closed() && plan.x.last().is_some_and(|last| goal.distance(last) < 1e-2)
        };
        assert!([40, 60, 80, 110].into_iter().any(closed));
    }
}
