//! A model and a task as a planner sees them.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use ndarray::Array2;
use rand::RngExt as _;
use sindyna_core::turning::{turns, wrapped};
use sindyna_core::{Bounded, Channel, Diverged, Dynamics, Jacobians, Kind, Rng, Seed, Space, Spec, Task};

/// Rollouts under random controls, from which it is told how far states move.
const ROLLOUTS: u64 = 8;

/// Steps of each of them, at most.
const STEPS: usize = 200;

/// Steps for which such a control is held: one that changed each time would move nothing heavy.
const HELD: usize = 10;

/// Scales beyond the bounds of a position at which a state is there no longer by rounding or for want of iterations.
const OUTSIDE: f64 = 1e-2;

/// What a step came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stepped {
    pub(crate) reward: f64,
    pub(crate) ended: bool,
}

/// x⁺ = F(x, u) with rewards and ends. States stay within their bounds, as sensors show them, but for positions whose rates are states too: there the equations go on as
/// if nothing were in the way, and what is beyond the bounds counts against a plan.
pub(crate) struct Plant {
    dynamics: Bounded<Arc<dyn Dynamics>>,
    pub(crate) task: Arc<dyn Task>,
    /// Controls lie between; numbered ones are taken from this box while planning.
    pub(crate) low: Vec<f64>,
    pub(crate) high: Vec<f64>,
    /// How far each state moves under random controls; 1 where it does not.
    pub(crate) scales: Vec<f64>,
    /// The largest change of a state in a step under random controls, in scales: its mean.
    pub(crate) pace: f64,
    /// The size of what a step pays under random controls: its mean; 1 where nothing is paid.
    pub(crate) paid_mostly: f64,
    /// States that turn: whole turns of them change neither steps nor what these pay.
    pub(crate) turns: Vec<bool>,
    /// Positions whose rates are states, with their bounds.
    walls: Vec<(usize, f64, f64)>,
    /// States that the controls can change.
    pub(crate) moved: Vec<bool>,
    stop: Arc<AtomicBool>,
}

impl Plant {
    pub(crate) fn new(dynamics: Arc<dyn Dynamics>, task: Arc<dyn Task>) -> Self {
        let spec = task.spec();
        let (low, high) = match &spec.action_space {
            Space::Box { low, high } => (low.clone(), high.clone()),
            Space::Discrete { controls } => controls
                .columns()
                .into_iter()
                .map(|c| {
                    (
                        c.iter().copied().fold(f64::INFINITY, f64::min),
                        c.iter().copied().fold(f64::NEG_INFINITY, f64::max),
                    )
                })
                .unzip(),
        };
        let n = spec.state_dim();
        let is_wall = |i: usize| spec.state.iter().any(|channel| channel.kind == Kind::RateOf(i));
        let free = |(i, channel): (usize, &Channel)| {
            let channel = channel.clone();
            if is_wall(i) { channel.within(f64::NEG_INFINITY, f64::INFINITY) } else { channel }
        };
        let shown: Vec<Channel> = spec.state.iter().enumerate().map(free).collect();
        let dynamics = Bounded::new(dynamics, &shown);
        let bounds = |i: usize| (i, spec.state[i].prior.bounds.0, spec.state[i].prior.bounds.1);
        let walls = (0..n).filter(|i| is_wall(*i)).map(bounds).collect();
        let (scales, moved, turns) = (vec![1.0; n], vec![true; n], vec![false; n]);
        let stop = Arc::new(AtomicBool::new(false));
        let mut plant =
            Self { dynamics, task, low, high, scales, pace: 1.0, paid_mostly: 1.0, turns, walls, moved, stop };
        plant.look_around();
        plant
    }

    /// Ends plans soon after `stop` is set.
    pub(crate) fn with_stop(self, stop: Arc<AtomicBool>) -> Self {
        Self { stop, ..self }
    }

    pub(crate) fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    pub(crate) fn spec(&self) -> &Spec {
        self.task.spec()
    }

    /// States and controls.
    pub(crate) fn dims(&self) -> (usize, usize) {
        (self.scales.len(), self.low.len())
    }

    /// Half of the range of control `j`.
    pub(crate) fn half(&self, j: usize) -> f64 {
        0.5 * (self.high[j] - self.low[j])
    }

    /// The middle of the box: no push, mostly.
    pub(crate) fn middle(&self) -> Vec<f64> {
        self.low.iter().zip(&self.high).map(|(low, high)| 0.5 * (low + high)).collect()
    }

    pub(crate) fn clamp(&self, u: &mut [f64]) {
        u.iter_mut().zip(&self.low).zip(&self.high).for_each(|((u, low), high)| *u = u.clamp(*low, *high));
    }

    /// One step under any control in the box; `None` where the model diverges or goes where the task pays no finite number.
    pub(crate) fn step(&self, x: &[f64], u: &[f64], rng: &mut Rng, next: &mut [f64]) -> Option<Stepped> {
        self.dynamics.step(x, u, rng, next).ok()?;
        self.paid(x, u, next)
    }

    /// Positions that are beyond their bounds in x, and how far, in scales: below 0 under the lower one.
    pub(crate) fn beyond<'a>(&'a self, x: &'a [f64]) -> impl Iterator<Item = (usize, f64)> + 'a {
        let off = move |&(i, low, high): &(usize, f64, f64)| (i, (x[i] - x[i].clamp(low, high)) / self.scales[i]);
        self.walls.iter().map(off).filter(|(_, off)| *off != 0.0)
    }

    /// The squared distance of two states in scales, whole turns aside.
    pub(crate) fn apart(&self, one: &[f64], other: &[f64]) -> f64 {
        let off = |i: usize| {
            let off = one[i] - other[i];
            let off = if self.turns[i] { wrapped(off) } else { off };
            (off / self.scales[i]).powi(2)
        };
        (0..one.len()).map(off).sum()
    }

    /// Whether a position is beyond its bounds in x: what happens there the equations do not tell.
    pub(crate) fn is_outside(&self, x: &[f64]) -> bool {
        self.beyond(x).any(|(_, off)| off.abs() > OUTSIDE)
    }

    /// What a step from x to `next` comes to; `None` where the task pays no finite number.
    pub(crate) fn paid(&self, x: &[f64], u: &[f64], next: &[f64]) -> Option<Stepped> {
        let (reward, ended) = (self.reward(x, u, next), self.task.terminated(next));
        reward.is_finite().then_some(Stepped { reward, ended })
    }

    pub(crate) fn reward(&self, x: &[f64], u: &[f64], next: &[f64]) -> f64 {
        match &self.spec().action_space {
            Space::Box { .. } => self.task.reward(x, u, u, next),
            Space::Discrete { .. } => {
                let mut action = [0.0];
                self.action(u, &mut action);
                self.task.reward(x, &action, u, next)
            }
        }
    }

    pub(crate) fn dynamics(&self) -> &dyn Dynamics {
        &self.dynamics
    }

    pub(crate) fn linearize(&self, x: &[f64], u: &[f64], rng: &mut Rng) -> Result<Jacobians, Diverged> {
        self.dynamics.linearize(x, u, rng)
    }

    /// The action whose control is nearest to `u`, in half ranges; `u` becomes what the system will receive.
    pub(crate) fn settle(&self, u: &mut [f64], action: &mut [f64]) {
        self.clamp(u);
        self.action(u, action);
        if let Space::Discrete { controls } = &self.spec().action_space {
            u.iter_mut().zip(controls.row(action[0] as usize)).for_each(|(u, c)| *u = *c);
        }
    }

    fn action(&self, u: &[f64], action: &mut [f64]) {
        match &self.spec().action_space {
            Space::Box { .. } => action.copy_from_slice(u),
            Space::Discrete { controls } => {
                let distance = |row: usize| -> f64 {
                    let parts = controls.row(row).into_iter().zip(u).enumerate();
                    parts.map(|(j, (c, u))| ((c - u) / self.half(j).max(f64::MIN_POSITIVE)).powi(2)).sum()
                };
                let nearest = (0..controls.nrows()).min_by(|&i, &j| distance(i).total_cmp(&distance(j)));
                action[0] = nearest.unwrap_or(0) as f64;
            }
        }
    }

    pub(crate) fn random_control(&self, rng: &mut Rng) -> Vec<f64> {
        self.low.iter().zip(&self.high).map(|(&low, &high)| rng.random_range(low..=high)).collect()
    }

    /// Random rollouts tell how far states move, and which of them the controls reach.
    fn look_around(&mut self) {
        let (n, k) = self.dims();
        let (mut sums, mut squares, mut paid, mut count) = (vec![0.0; n], vec![0.0; n], 0.0, 0.0);
        let mut changes: Vec<Vec<f64>> = Vec::new();
        let mut touched = Array2::from_elem((n, n + k), false);
        let mut places = Vec::new();
        for rollout in 0..ROLLOUTS {
            let mut rng = Seed::new(0).stream("looking around", rollout);
            let (mut x, mut next, mut u) = (vec![0.0; n], vec![0.0; n], Vec::new());
            self.task.initial(&mut rng, &mut x);
            for t in 0..self.task.max_steps().min(STEPS) {
                if t % HELD == 0 {
                    u = self.random_control(&mut rng);
                    places.push((x.clone(), u.clone()));
                    if let Ok((a, b)) = self.linearize(&x, &u, &mut rng) {
                        for (i, (a, b)) in a.rows().into_iter().zip(b.rows()).enumerate() {
                            for (j, slope) in a.iter().chain(b).enumerate() {
                                let own = f64::from(u8::from(i == j));
                                touched[[i, j]] |= (slope - own).abs() > 1e-9;
                            }
                        }
                    }
                }
                let Some(Stepped { reward, ended }) = self.step(&x, &u, &mut rng, &mut next) else { break };
                self.walls.iter().for_each(|&(i, low, high)| next[i] = next[i].clamp(low, high));
                changes.push(x.iter().zip(&next).map(|(x, next)| (next - x).abs()).collect());
                std::mem::swap(&mut x, &mut next);
                for (i, x) in x.iter().enumerate() {
                    sums[i] += x;
                    squares[i] += x * x;
                }
                paid += reward.abs();
                count += 1.0;
                if ended {
                    break;
                }
            }
        }
        self.turns = (0..n).map(|i| self.turns(i, &places)).collect();
        for i in 0..n {
            let mean = sums[i] / f64::max(count, 1.0);
            let deviation = (squares[i] / f64::max(count, 1.0) - mean * mean).max(0.0).sqrt();
            // A turn is as far as an angle goes.
            let most = if self.turns[i] { 1.0 } else { f64::INFINITY };
            self.scales[i] = if deviation > 1e-9 * (1.0 + mean.abs()) { deviation.min(most) } else { 1.0 };
        }
        let paid = paid / f64::max(count, 1.0);
        self.paid_mostly = if paid > 0.0 { paid } else { 1.0 };
        let pace = |change: &Vec<f64>| change.iter().zip(&self.scales).map(|(c, s)| c / s).fold(0.0, f64::max);
        self.pace = (changes.iter().map(pace).sum::<f64>() / changes.len().max(1) as f64).max(f64::MIN_POSITIVE);
        let mut moved: Vec<bool> = (0..n).map(|i| (n..n + k).any(|j| touched[[i, j]])).collect();
        for _ in 0..n {
            moved = (0..n).map(|i| moved[i] || (0..n).any(|j| moved[j] && j != i && touched[[i, j]])).collect();
        }
        self.moved = moved;
    }

    /// Whether whole turns of state `i` change neither steps from these states under these controls nor what they pay.
    fn turns(&self, i: usize, places: &[(Vec<f64>, Vec<f64>)]) -> bool {
        let channel = &self.spec().state[i];
        let may = !channel.is_bounded() && !matches!(channel.kind, Kind::RateOf(_));
        may && turns(places, i, |x, u| self.effect(x, u))
    }

    /// By how much a step moves each state, what it pays, and whether it ends the episode.
    fn effect(&self, x: &[f64], u: &[f64]) -> Option<Vec<f64>> {
        let mut next = vec![0.0; x.len()];
        let stepped = self.step(x, u, &mut unused(), &mut next)?;
        next.iter_mut().zip(x).for_each(|(next, x)| *next -= x);
        next.extend([stepped.reward, f64::from(u8::from(stepped.ended))]);
        Some(next)
    }
}

/// A generator for steps that draw nothing.
pub(crate) fn unused() -> Rng {
    Seed::new(0).numpy()
}
