//! Goals: states of rest, and the regulators that hold them.

use ndarray::{Array1, Array2};
use rand_distr::{Distribution as _, StandardNormal};
use sindyna_core::Seed;
use sindyna_core::turning::wrapped;

use super::plant::{Plant, unused};
use super::slopes::costs;
use crate::riccati::regulate_coupled;
use crate::{Costs, Linear, Regulator, regulate};

/// Weights on controls of the regulators that may hold a goal, besides 1 and the costs that the reward itself has near it; what another one must earn more, from how many
/// states so many scales away and for how many steps that is simulated.
const WEIGHTS: [f64; 3] = [0.1, 0.01, 0.001];
const BETTER: f64 = 0.01;
const HELD: usize = 16;
const AWAY: f64 = 0.2;
const FOR: usize = 200;

/// Step of differences of the reward at a state of rest, in scales, and the part of the largest cost of a scale that every state and control costs at least.
const NEAR: f64 = 1e-3;
const FLAT: f64 = 1e-6;

/// Costs of the regulator that holds a goal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum By {
    /// Those of the reward near it, or by scales where these earn more.
    Reward,
    /// Those of the scales of states and controls, by which it is reached soon: a plan that leads there is the shorter, and is itself improved for the reward.
    Scales,
}

/// A state of rest x* under u*, with the regulator that holds it.
#[derive(Debug, Clone)]
pub(crate) struct Goal {
    pub(crate) x: Vec<f64>,
    pub(crate) u: Vec<f64>,
    /// Reward of a step that stays there; 0 where the episode has ended.
    pub(crate) pay: f64,
    /// Reward of a step from a start state.
    pub(crate) first: f64,
    /// Whether the episode ends there.
    pub(crate) ends: bool,
    /// K (k, n) of u = u* − K (x − x*).
    gain: Array2<f64>,
    /// P (n, n) of [`Self::distance`].
    pub(crate) value: Array2<f64>,
    turns: Vec<bool>,
}

impl Goal {
    /// x − x* (n), angles less than half a turn away.
    pub(crate) fn error(&self, x: &[f64]) -> Array1<f64> {
        let each = x.iter().zip(&self.x).zip(&self.turns);
        each.map(|((x, goal), turns)| {
            let off = x - goal;
            if *turns { wrapped(off) } else { off }
        })
        .collect()
    }

    /// (x − x*)ᵀP(x − x*): what the regulator pays on its way, a state one scale off costing 1 a step.
    pub(crate) fn distance(&self, x: &[f64]) -> f64 {
        let error = self.error(x);
        error.dot(&self.value.dot(&error))
    }

    /// What the regulator does in `x`.
    pub(crate) fn control(&self, plant: &Plant, x: &[f64]) -> Vec<f64> {
        let mut u: Vec<f64> = self.u.iter().zip(self.gain.dot(&self.error(x))).map(|(u, du)| u - du).collect();
        plant.clamp(&mut u);
        u
    }

    /// What the regulator earns from states near the goal.
    fn holds(&self, plant: &Plant) -> f64 {
        let (mut rng, mut drawn, mut earned) = (unused(), Seed::new(0).stream("near a goal", 0), 0.0);
        for _ in 0..HELD {
            let (mut x, mut next) = (self.x.clone(), vec![0.0; self.x.len()]);
            for i in (0..x.len()).filter(|i| plant.moved[*i]) {
                let normal: f64 = StandardNormal.sample(&mut drawn);
                let (low, high) = plant.spec().state[i].prior.bounds;
                x[i] = (x[i] + AWAY * plant.scales[i] * normal).clamp(low, high);
            }
            for _ in 0..plant.task.max_steps().min(FOR) {
                let Some(stepped) = plant.step(&x, &self.control(plant, &x), &mut rng, &mut next) else { break };
                earned += stepped.reward;
                if stepped.ended {
                    break;
                }
                std::mem::swap(&mut x, &mut next);
            }
        }
        earned
    }

    /// The state of rest x under u, which pays `pay` where a start state pays `at_start`, with its regulator over the states that controls change, of costs `by` the reward or the scales; `None` where none
    /// stabilises it.
    pub(super) fn held((x, u, [pay, at_start]): (Vec<f64>, Vec<f64>, [f64; 2]), plant: &Plant, by: By) -> Option<Self> {
        let (n, k) = plant.dims();
        let moved: Vec<usize> = (0..n).filter(|i| plant.moved[*i]).collect();
        let all = Linear::around(plant.dynamics(), (&x, &u), &mut unused()).ok()?;
        let part = |of: &Array2<f64>, columns: &[usize]| {
            Array2::from_shape_fn((moved.len(), columns.len()), |(i, j)| of[[moved[i], columns[j]]])
        };
        let linear = Linear { a: part(&all.a, &moved), b: part(&all.b, &(0..k).collect::<Vec<_>>()) };
        let regulator = |weight: f64| {
            let costs = Costs {
                state: moved.iter().map(|i| plant.scales[*i].powi(-2)).collect(),
                control: (0..k).map(|j| weight * plant.half(j).powi(-2)).collect(),
            };
            regulate(&linear, &costs).ok()
        };
        let gain = |regulator: &Regulator| {
            let mut gain = Array2::zeros((k, n));
            for (i, &column) in moved.iter().enumerate() {
                (0..k).for_each(|j| gain[[j, column]] = regulator.gain[[j, i]]);
            }
            gain
        };
        let first = regulator(1.0)?;
        let own = own_costs(plant, (&x, &u), &all, &moved).and_then(|costs| regulate_coupled(&linear, &costs).ok());
        let mut value = Array2::zeros((n, n));
        for (i, &column) in moved.iter().enumerate() {
            moved.iter().enumerate().for_each(|(j, &row)| value[[row, column]] = first.value[[j, i]]);
        }
        let ends = plant.task.terminated(&x);
        let turns = plant.turns.clone();
        let mut goal = Goal { x, u, pay, first: at_start, ends, gain: Array2::zeros((k, n)), value, turns };
        let mut most = f64::NEG_INFINITY;
        let by_scales = std::iter::once(first).chain(WEIGHTS.into_iter().filter_map(regulator));
        let own = own.filter(|_| by == By::Reward);
        for other in own.into_iter().chain(by_scales) {
            let other = Goal { gain: gain(&other), ..goal.clone() };
            let earned = other.holds(plant);
            if most == f64::NEG_INFINITY || earned > most + BETTER * most.abs() {
                (goal, most) = (other, earned);
            }
        }
        Some(goal)
    }
}

/// What the reward costs near rest at x under u, to second order over the states `moved` and the controls; a little more, so that every one of them costs something. `None` where the
/// reward is flat.
fn own_costs(plant: &Plant, (x, u): (&[f64], &[f64]), linear: &Linear, moved: &[usize]) -> Option<Array2<f64>> {
    let (_, curvature) = costs(plant, (x, u, x), (&linear.a, &linear.b), NEAR);
    let (n, k) = plant.dims();
    let among: Vec<usize> = moved.iter().copied().chain(n..n + k).collect();
    let size = |i: usize| if i < n { plant.scales[i] } else { plant.half(i - n) };
    let mut costs = Array2::from_shape_fn((among.len(), among.len()), |(i, j)| curvature[[among[i], among[j]]]);
    let most = among.iter().enumerate().map(|(at, i)| costs[[at, at]] * size(*i).powi(2)).fold(0.0, f64::max);
    among.iter().enumerate().for_each(|(at, i)| costs[[at, at]] += FLAT * most / size(*i).powi(2));
    (most.is_finite() && most > 0.0).then_some(costs)
}
