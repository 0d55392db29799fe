//! Where it pays to stay: states of rest.

use std::f64::consts::PI;

use faer::linalg::solvers::Solve as _;
use faer::{Mat, Side};
use rand::RngExt as _;
use rand_distr::{Distribution as _, StandardNormal};
use sindyna_core::{Kind, Rng, Seed};

use super::goal::{By, Goal};
use super::plant::{Plant, unused};

/// States from which rest is looked for.
const SAMPLES: usize = 400;

/// States of rest that are looked at more closely, and the rounds of it.
const KEPT: usize = 8;
const ROUNDS: usize = 40;

/// Goals at most, and what they may pay less than the best, as a part of what rest pays anywhere.
const GOALS: usize = 3;
const ALIKE: f64 = 0.2;

/// Neighbours over which the reward is averaged, and how far they are, in scales: a reward that is paid in a small place only has no slope to follow.
const NEIGHBOURS: usize = 48;
const NEAREST: f64 = 0.01;
const FARTHEST: f64 = 0.5;

/// Scales by which two goals differ.
const APART: f64 = 0.1;

/// Iterations in which rest is found from nearby, and what is left of the motion then, in scales.
const ITERATIONS: usize = 25;
const AT_REST: f64 = 1e-9;

/// States of rest that pay most to stay in, the best first, held by regulators of such costs. States that no control changes are those of `start`.
pub(super) fn find(plant: &Plant, start: &[f64], by: By) -> Vec<Goal> {
    let mut rng = Seed::new(0).stream("goals", 0);
    let mut found: Vec<Rest> = Vec::new();
    for sample in 0..SAMPLES {
        if plant.stopped() {
            return Vec::new();
        }
        let (x, u) = draw(plant, start, sample, &mut rng);
        found.extend(Rest::near(plant, start, x, u));
    }
    found.sort_by(Rest::order);
    let Some((first, last)) = found.first().zip(found.last()) else { return Vec::new() };
    let least = first.around - ALIKE * (first.around - last.around);
    found.retain(|rest| rest.around >= least);
    found.truncate(KEPT);
    for rest in &mut found {
        for round in 0..ROUNDS {
            let width = 0.5 * 0.8_f64.powi(round as i32);
            let (mut x, mut u) = (rest.x.clone(), rest.u.clone());
            shift(plant, &mut x, width, &mut rng);
            if round.is_multiple_of(2) {
                u.iter_mut().for_each(|u| *u = 0.0);
            }
            plant.clamp(&mut u);
            if let Some(other) = Rest::near(plant, start, x, u).filter(|other| Rest::order(other, rest).is_lt()) {
                *rest = other;
            }
        }
    }
    found.sort_by(Rest::order);
    let at_start = pays_at(plant, start);
    let mut goals: Vec<Goal> = Vec::new();
    for rest in found {
        if goals.len() == GOALS {
            break;
        }
        let far = |goal: &Goal| {
            let error = goal.error(&rest.x);
            error.iter().zip(&plant.scales).any(|(e, scale)| e.abs() > APART * scale)
        };
        if goals.iter().all(far) {
            goals.extend(Goal::held((rest.x, rest.u, [rest.pay, at_start]), plant, by));
        }
    }
    goals
}

/// What a step from x pays, under no push; infinity where the model diverges.
fn pays_at(plant: &Plant, x: &[f64]) -> f64 {
    let stepped = plant.step(x, &plant.middle(), &mut unused(), &mut vec![0.0; x.len()]);
    stepped.map_or(f64::INFINITY, |stepped| stepped.reward)
}

/// A state that stays as it is.
struct Rest {
    x: Vec<f64>,
    u: Vec<f64>,
    pay: f64,
    /// `pay` of the states around it, on average.
    around: f64,
    effort: f64,
}

impl Rest {
    /// The better one first: that pays more around it; of those that pay alike, the one that is held with less and nearer to the start.
    fn order(one: &Self, other: &Self) -> std::cmp::Ordering {
        let worth = |rest: &Self| rest.around - 1e-6 * (1.0 + rest.around.abs()) * rest.effort;
        worth(other).total_cmp(&worth(one))
    }

    /// The state of rest next to x under u, by Gauss–Newton over positions and controls.
    fn near(plant: &Plant, start: &[f64], mut x: Vec<f64>, mut u: Vec<f64>) -> Option<Self> {
        let ((n, k), mut rng) = (plant.dims(), unused());
        let free: Vec<usize> = (0..n).filter(|i| plant.moved[*i] && !is_rate(plant, *i)).collect();
        let (mut next, size) = (vec![0.0; n], free.len() + k);
        for _ in 0..ITERATIONS {
            plant.step(&x, &u, &mut rng, &mut next)?;
            let off = |i: usize| (next[i] - x[i]) / plant.scales[i];
            if (0..n).filter(|i| plant.moved[*i]).all(|i| off(i).abs() <= AT_REST) {
                return Some(Self::at(plant, start, x, u)).filter(|rest| !plant.is_outside(&rest.x));
            }
            let (a, b) = plant.linearize(&x, &u, &mut rng).ok()?;
            // In scales, so that the damping is alike for all.
            let slope = |i: usize, v: usize| {
                if v < free.len() {
                    let j = free[v];
                    (a[[i, j]] - f64::from(u8::from(i == j))) * plant.scales[j] / plant.scales[i]
                } else {
                    b[[i, v - free.len()]] * plant.half(v - free.len()) / plant.scales[i]
                }
            };
            let j = Mat::from_fn(n, size, slope);
            let right = j.transpose() * Mat::from_fn(n, 1, |i, _| -off(i));
            let mut square = j.transpose() * &j;
            let most = (0..size).map(|i| square[(i, i)]).fold(f64::MIN_POSITIVE, f64::max);
            (0..size).for_each(|i| square[(i, i)] += 1e-9 * most);
            let step = square.llt(Side::Lower).ok()?.solve(right);
            for (v, &i) in free.iter().enumerate() {
                x[i] += plant.scales[i] * step[(v, 0)].clamp(-1.0, 1.0);
            }
            (0..k).for_each(|v| u[v] += plant.half(v) * step[(free.len() + v, 0)]);
            plant.clamp(&mut u);
        }
        None
    }

    fn at(plant: &Plant, start: &[f64], x: Vec<f64>, u: Vec<f64>) -> Self {
        let pay = |x: &[f64]| if plant.task.terminated(x) { 0.0 } else { plant.reward(x, &u, x) };
        let mut rng = Seed::new(0).stream("neighbours", 0);
        let neighbour = |i: usize| {
            let mut other = x.clone();
            let far = i as f64 / (NEIGHBOURS - 1) as f64;
            shift(plant, &mut other, NEAREST * (FARTHEST / NEAREST).powf(far), &mut rng);
            // In pairs, so that no side is looked at more.
            let mirrored: Vec<f64> = x.iter().zip(&other).map(|(x, other)| 2.0 * x - other).collect();
            0.5 * (pay(&other) + pay(&mirrored))
        };
        let around = (0..NEIGHBOURS).map(neighbour).sum::<f64>() / NEIGHBOURS as f64;
        let pushes = u.iter().enumerate().map(|(j, u)| (u / plant.half(j)).powi(2)).sum::<f64>();
        let away = |i: usize| if plant.turns[i] { 0.0 } else { ((x[i] - start[i]) / plant.scales[i]).powi(2) };
        let effort = pushes + (0..x.len()).map(away).sum::<f64>();
        Self { pay: pay(&x), around, effort, x, u }
    }
}

fn is_rate(plant: &Plant, i: usize) -> bool {
    matches!(plant.spec().state[i].kind, Kind::RateOf(_))
}

/// A state from which rest may be found: a start state with its angles anywhere, at rest.
fn draw(plant: &Plant, start: &[f64], sample: usize, rng: &mut Rng) -> (Vec<f64>, Vec<f64>) {
    let k = plant.dims().1;
    let mut x = start.to_vec();
    for (i, x) in x.iter_mut().enumerate() {
        let channel = &plant.spec().state[i];
        let (low, high) = channel.prior.bounds;
        *x = match () {
            () if !plant.moved[i] => *x,
            () if is_rate(plant, i) => 0.0,
            () if sample % 4 == 1 && !plant.turns[i] => *x,
            () if plant.turns[i] => rng.random_range(-PI..PI),
            () if channel.is_bounded() => rng.random_range(low..=high),
            () if channel.kind == Kind::Angle => rng.random_range(low.max(-PI)..high.min(PI)),
            () => {
                let normal: f64 = StandardNormal.sample(rng);
                (*x + plant.scales[i] * normal).clamp(low, high)
            }
        };
    }
    let u = if sample.is_multiple_of(2) { vec![0.0; k] } else { plant.random_control(rng) };
    (x, u)
}

/// Moves positions that controls change, by a normal deviate so many scales wide.
fn shift(plant: &Plant, x: &mut [f64], width: f64, rng: &mut Rng) {
    for i in (0..x.len()).filter(|i| plant.moved[*i] && !is_rate(plant, *i)) {
        let normal: f64 = StandardNormal.sample(rng);
        let (low, high) = plant.spec().state[i].prior.bounds;
        x[i] = (x[i] + width * plant.scales[i] * normal).clamp(low, high);
    }
}
