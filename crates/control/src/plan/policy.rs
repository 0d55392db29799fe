//! A planner as a policy.

use std::fmt;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, OnceLock};

use ndarray::{ArrayView2, ArrayViewMut2};
use sindyna_core::{Dynamics, Inverse, Memory, Mode, Policy, Rng, Seed, Task};

use super::course::Course;
use super::expected::Expected;
use super::filter::Filter;
use super::goal::{By, Goal};
use super::mppi::Sampled;
use super::plant::{Plant, unused};
use super::rest::find;
use super::search::{is_enough, search};
use crate::ControlError;

/// Steps that are looked ahead when an episode is longer.
const HORIZON: usize = 1_000;

/// Steps of a plan that is sampled.
const SAMPLED: usize = 100;

/// Part of what a plan earns that is no reason to keep it where holding a goal earns the rest.
const SAME: f64 = 1e-5;

/// Steps after which a plan that was improved is improved again.
const EVERY: usize = 10;

/// Steps after which another way is looked for, if none leads to a goal.
const LOST: usize = 100;

/// Ways that are made the best of, where many episodes begin with the best of them.
const CANDIDATES: usize = 8;

/// Start states from which it is tried whether holding a goal is enough, and whether ways to one are.
const HELD_FROM: u64 = 200;
const LED_FROM: u64 = 16;

/// How a [`Planner`] plans.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Hold the state of rest that pays most by its linear-quadratic regulator: no plan at all.
    Lqr,
    /// Differential dynamic programming over the rest of the episode, in receding horizon, with regulators near the goal.
    Ilqr,
    /// Model predictive path integral control: random changes of the plan, weighed by what they earn.
    Mppi,
}

impl Method {
    /// All of them, the quickest first.
    pub const ALL: [Self; 3] = [Self::Lqr, Self::Ilqr, Self::Mppi];

    /// `lqr`, `ilqr` or `mppi`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Lqr => "lqr",
            Self::Ilqr => "ilqr",
            Self::Mppi => "mppi",
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A policy that plans in a model, true or learned, for a task. What it needs to know follows from these: where it pays to stay (states of rest and
/// their rewards), how far states move, which of them controls change.
///
/// It acts alike in both modes and draws no number of the generator it is given.
pub struct Planner {
    plant: Plant,
    inverse: Inverse,
    method: Method,
    /// Standard deviations of the errors of the states as measured (n); none for exact ones.
    noise: Vec<f64>,
    /// Goals that are the same in every episode.
    goals: OnceLock<Vec<Goal>>,
    /// The course from one start state, and what it earns: others may be near it.
    first: Option<(Course, f64)>,
}

impl Planner {
    /// A planner in `dynamics` over the states of `task`.
    ///
    /// # Errors
    /// [`ControlError::Unseen`] if a state is not observed.
    pub fn new(method: Method, dynamics: Arc<dyn Dynamics>, task: Arc<dyn Task>) -> Result<Self, ControlError> {
        let inverse = Inverse::of(task.spec())?;
        let plant = Plant::new(dynamics, task);
        Ok(Self { plant, inverse, method, noise: Vec::new(), goals: OnceLock::new(), first: None })
    }

    /// The same for sensors that show the states with errors of the standard deviations `noise` (n; none for exact sensors): an extended Kalman filter
    /// estimates the states that it plans from.
    #[must_use]
    pub fn with_noise(self, noise: &[f64]) -> Self {
        Self { noise: noise.to_vec(), ..self }
    }

    /// The same that ends its plans soon after `stop` is set: its actions are of no use then.
    #[must_use]
    pub fn with_stop(self, stop: Arc<AtomicBool>) -> Self {
        Self { plant: self.plant.with_stop(stop), ..self }
    }

    /// The same with a course planned ahead, which episodes from near start states begin with.
    #[must_use]
    pub fn prepared(self) -> Self {
        if self.method != Method::Ilqr || !self.has_shared_goals() {
            return self;
        }
        let x = self.start();
        let (plant, goals) = (&self.plant, self.goals(&x));
        let first = search(plant, &goals, &x, plant.task.max_steps().min(HORIZON), CANDIDATES);
        Self { first: Some(first).filter(|_| !plant.stopped()), ..self }
    }

    /// The same with the course that `other`, for the same system and other rewards, has planned ahead, improved for its own rewards. What
    /// [`Self::prepared`] searches for, this follows: a course may pay that no search would begin.
    #[must_use]
    pub fn following(self, other: &Self) -> Self {
        let Some((course, _)) = &other.first else { return self };
        let x = self.start();
        let (goals, steps) = (self.goals(&x), self.plant.task.max_steps().min(HORIZON));
        let place = course.goal.and_then(|goal| other.goals(&x).into_iter().nth(goal));
        let nearest = place.and_then(|place| {
            let away = |goal: &usize| goals[*goal].distance(&place.x);
            (0..goals.len()).min_by(|one, other| away(one).total_cmp(&away(other)))
        });
        let first = Course { goal: nearest, ..course.clone() }.led(&self.plant, &goals, &x, steps);
        Self { first: Some(first).filter(|_| !self.plant.stopped()), ..self }
    }

    /// A start state.
    fn start(&self) -> Vec<f64> {
        let mut start = vec![0.0; self.plant.dims().0];
        self.plant.task.initial(&mut Seed::new(0).stream("a start", 0), &mut start);
        start
    }

    /// Whether goals are the same in every episode: the controls move every state.
    fn has_shared_goals(&self) -> bool {
        self.plant.moved.iter().all(|moved| *moved)
    }

    /// What goals are held with: a plan ends with a regulator, and a regulator alone is all there is.
    fn held_by(&self) -> By {
        if self.method == Method::Lqr { By::Reward } else { By::Scales }
    }

    /// Where it pays to stay in an episode from `x`.
    fn goals(&self, x: &[f64]) -> Vec<Goal> {
        if !self.has_shared_goals() {
            return find(&self.plant, x, self.held_by());
        }
        self.goals.get_or_init(|| find(&self.plant, &self.start(), self.held_by())).clone()
    }

    /// Whether it earns about all there is in the model, from every start state that is tried; never known of random changes.
    pub(super) fn is_enough(&self) -> bool {
        let (plant, steps) = (&self.plant, self.plant.task.max_steps().min(HORIZON));
        let starts = match self.method {
            Method::Lqr => HELD_FROM,
            Method::Ilqr => LED_FROM,
            Method::Mppi => return false,
        };
        (0..starts).all(|start| {
            let mut x = vec![0.0; plant.dims().0];
            plant.task.initial(&mut Seed::new(0).stream("starts", start), &mut x);
            let goals = self.goals(&x);
            let earned = match self.method {
                Method::Ilqr => search(plant, &goals, &x, steps, 1).1,
                _ => Course::held(plant, &goals, &x, steps).1,
            };
            is_enough(&goals, earned, steps)
        })
    }

    /// How it plans.
    #[must_use]
    pub fn method(&self) -> Method {
        self.method
    }
}

impl Policy for Planner {
    fn act_batch(
        &self,
        observations: ArrayView2<'_, f64>,
        mode: Mode,
        rng: &mut Rng,
        mut actions: ArrayViewMut2<'_, f64>,
    ) {
        for (o, mut action) in observations.rows().into_iter().zip(actions.rows_mut()) {
            let mut first = vec![0.0; action.len()];
            Episode::new(self).act(&o.to_vec(), mode, rng, &mut first);
            action.iter_mut().zip(first).for_each(|(a, first)| *a = first);
        }
    }

    fn begin(&self) -> Option<Box<dyn Memory + '_>> {
        Some(Box::new(Episode::new(self)))
    }
}

/// A planner in the middle of an episode.
struct Episode<'a> {
    planner: &'a Planner,
    /// The state as of the last step; with a filter, as it was expected after that.
    x: Vec<f64>,
    filter: Option<Filter>,
    steps: usize,
    goals: Vec<Goal>,
    course: Option<Course>,
    /// The courses that were searched for, whole.
    ways: Vec<Course>,
    sampled: Option<Sampled>,
    expected: Expected,
    /// Whether improving the course again has brought nothing.
    settled: bool,
}

impl<'a> Episode<'a> {
    fn new(planner: &'a Planner) -> Self {
        let x = vec![0.0; planner.plant.dims().0];
        Self {
            planner,
            x,
            filter: Filter::new(&planner.plant, &planner.noise),
            steps: 0,
            goals: Vec::new(),
            course: None,
            ways: Vec::new(),
            sampled: None,
            expected: Expected::none(),
            settled: false,
        }
    }

    /// The control of differential dynamic programming, in receding horizon: the course so far, moved on, improved now and then, and left where another
    /// earns more.
    fn planned(&mut self, left: usize) -> Vec<f64> {
        let (plant, ahead) = (&self.planner.plant, left.clamp(1, HORIZON));
        let goals = &self.goals;
        let mut course = self.course.take();
        if let Some(course) = &mut course {
            course.made += 1;
        }
        let arrived = course.as_ref().is_some_and(|course| course.holds(goals, &self.x));
        let followed = self.settled && course.as_ref().is_some_and(|course| course.is_followed(plant, &self.x));
        let due = self.steps.is_multiple_of(EVERY) && !arrived && !followed;
        // From another state a way may be found.
        let lost = self.steps.is_multiple_of(LOST)
            && !arrived
            && !is_enough(goals, self.expected.earned, ahead)
            && !goals.is_empty()
            && course.as_ref().is_some_and(|course| {
                let run = course.run(plant, goals, &self.x, ahead);
                run.last.is_some() && !goals.iter().any(|goal| run.arrives(goal))
            });
        if lost {
            course = None;
        }
        let course = match course {
            None => {
                let near = self.planner.first.as_ref().filter(|_| self.steps == 0);
                let near = near.and_then(|first| first.0.adapted(plant, goals, &self.x, ahead, first.1));
                let (course, earned) = near.unwrap_or_else(|| {
                    let found = search(plant, goals, &self.x, ahead, 1);
                    self.ways.push(found.0.clone());
                    found
                });
                self.expected.set(earned);
                course
            }
            Some(course) if !due => course,
            Some(course) => {
                self.settled = false;
                let mut earned = course.earns(plant, goals, &self.x, ahead).0;
                let mut best = course;
                let (held, of_held) = Course::held(plant, goals, &self.x, ahead);
                if of_held >= earned - SAME * earned.abs() {
                    (best, earned) = (held, of_held);
                }
                let is_under_way = best.is_under_way();
                if self.expected.is_missed(earned) {
                    let ways = (self.planner.first.as_ref().map(|first| &first.0), &mut self.ways);
                    (best, earned) = self.expected.regained((best, earned), ways, (plant, goals, &self.x), ahead);
                    self.expected.set(earned);
                } else if is_under_way {
                    let before = earned;
                    (best, earned) = best.again(plant, goals, &self.x, ahead, earned);
                    self.settled = earned - before <= SAME * before.abs();
                    self.expected.set(earned.max(self.expected.earned));
                }
                best
            }
        };
        let u = course.control(plant, goals, &self.x, 0);
        self.course = Some(course);
        u
    }
}

impl Memory for Episode<'_> {
    fn act(&mut self, observation: &[f64], _mode: Mode, _rng: &mut Rng, action: &mut [f64]) {
        let Planner { plant, inverse, method, .. } = self.planner;
        if plant.stopped() {
            plant.settle(&mut plant.middle(), action);
            return;
        }
        let before = self.x.clone();
        inverse.state(observation, &before, &mut self.x);
        if let Some(filter) = &mut self.filter {
            let measured = std::mem::replace(&mut self.x, before);
            filter.update(&measured, &mut self.x);
        }
        if self.steps == 0 {
            self.goals = self.planner.goals(&self.x);
        }
        let left = plant.task.max_steps().saturating_sub(self.steps).max(1);
        let mut u = match method {
            Method::Lqr => {
                let course = self.course.get_or_insert_with(|| Course::held(plant, &self.goals, &self.x, left).0);
                course.control(plant, &self.goals, &self.x, 0)
            }
            Method::Ilqr => self.planned(left),
            Method::Mppi => {
                let horizon = SAMPLED.min(plant.task.max_steps());
                let sampled = self.sampled.get_or_insert_with(|| Sampled::new(plant, horizon));
                sampled.act(plant, &self.goals, &self.x, left)
            }
        };
        plant.settle(&mut u, action);
        // What is yet expected is without the step that is made now.
        if self.course.is_some() {
            let mut next = vec![0.0; self.x.len()];
            let stepped = plant.step(&self.x, &u, &mut unused(), &mut next);
            self.expected.earned -= stepped.map_or(0.0, |stepped| stepped.reward);
        }
        if let Some(filter) = &mut self.filter {
            filter.predict(plant, &mut self.x, &u);
        }
        self.steps += 1;
    }
}
