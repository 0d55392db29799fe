//! A way through the rest of an episode: a plan, and a goal that is held from its end on.

use super::goal::Goal;
use super::ilqr::Plan;
use super::objective::{BEYOND, EFFORT, Objective};
use super::plant::{Plant, unused};

/// Distance of a goal at which it is reached, and the part of what it pays more than the start that the last steps may lack.
const ARRIVED: f64 = 1e-2;

/// One in so many steps of an episode is one of the last.
const LATE: usize = 10;

/// Distance of a goal at which steps are all alike, looked at every so many steps.
const STAYS: f64 = 1e-12;
const LOOKED: usize = 10;

/// Part of the return that is not worth a search.
pub(super) const NOTHING: f64 = 1e-3;

/// Steps of differences of the reward, in scales, one after the other: small ones for smooth rewards, and wide enough to see the edge of what is paid in some place only.
/// On the way only the first two.
pub(super) const WIDTHS: [f64; 4] = [1e-3, 0.1, 0.3, 0.1];

/// Iterations by which the best is improved for its reward.
pub(super) const POLISH: usize = 40;

/// Iterations of such an improvement in receding horizon.
const AGAIN: usize = 3;

/// States of a plan from which it is tried to go on where it was missed.
const JOINS: usize = 4;

/// Scales within which a state is the planned one.
const FOLLOWED: f64 = 1e-6;

/// A plan, after which a goal is held; without a goal the last control is.
#[derive(Debug, Clone)]
pub(crate) struct Course {
    pub(crate) plan: Option<Plan>,
    /// Steps of the plan that were made.
    pub(crate) made: usize,
    pub(crate) goal: Option<usize>,
}

/// What a course comes to.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) earned: f64,
    pub(crate) controls: Vec<Vec<f64>>,
    /// The state after the last step; none where the episode ends before.
    pub(crate) last: Option<Vec<f64>>,
    /// What the last steps pay, on average.
    late: f64,
    /// Whether all positions stay within their bounds; what the system does beyond is not known.
    known: bool,
}

impl Run {
    /// Whether it comes to `goal`, or pays about as much as that does if it is more than the start pays; where the episode ends in the goal, whether it ends.
    pub(crate) fn arrives(&self, goal: &Goal) -> bool {
        if !self.known {
            return false;
        }
        let Some(last) = &self.last else { return goal.ends && self.earned.is_finite() };
        let more = goal.pay - goal.first;
        goal.distance(last) < ARRIVED || (more > 0.0 && goal.pay - self.late <= ARRIVED * more)
    }
}

/// What it costs to be a scale beyond the bounds of a position, for a step: as much as many steps pay.
pub(super) fn charge(plant: &Plant, goals: &[Goal]) -> f64 {
    BEYOND * goals.iter().map(|goal| goal.pay.abs()).fold(plant.paid_mostly, f64::max)
}

impl Course {
    /// Only holding a goal: the one for which that earns most from x in the next `steps` steps, and what it earns.
    pub(crate) fn held(plant: &Plant, goals: &[Goal], x: &[f64], steps: usize) -> (Self, f64) {
        let earned = |course: Self| {
            let earned = course.earns(plant, goals, x, steps).0;
            (course, earned)
        };
        let all = (0..goals.len()).map(|goal| earned(Self { plan: None, made: 0, goal: Some(goal) }));
        let best = all.reduce(|best, other| if other.1 > best.1 { other } else { best });
        best.unwrap_or_else(|| earned(Self { plan: None, made: 0, goal: None }))
    }

    /// What to do in x, so many steps from now.
    pub(crate) fn control(&self, plant: &Plant, goals: &[Goal], x: &[f64], later: usize) -> Vec<f64> {
        let planned = self.plan.as_ref().filter(|plan| self.made + later < plan.u.len());
        let mut u = match (planned, self.goal) {
            (Some(plan), _) => {
                let t = self.made + later;
                let off: ndarray::Array1<f64> = x.iter().zip(&plan.x[t]).map(|(x, planned)| x - planned).collect();
                plan.u[t].iter().zip(plan.gains[t].dot(&off)).map(|(u, du)| u + du).collect()
            }
            (None, Some(goal)) => goals[goal].control(plant, x),
            (None, None) => {
                self.plan.as_ref().and_then(|plan| plan.u.last().cloned()).unwrap_or_else(|| plant.middle())
            }
        };
        plant.clamp(&mut u);
        u
    }

    /// Whether it has reached its goal in x and is through with its plan.
    pub(crate) fn holds(&self, goals: &[Goal], x: &[f64]) -> bool {
        let through = self.plan.as_ref().is_none_or(|plan| self.made >= plan.u.len());
        through && self.goal.is_some_and(|goal| goals[goal].distance(x) < ARRIVED)
    }

    /// Whether steps of its plan are left.
    pub(super) fn is_under_way(&self) -> bool {
        self.plan.as_ref().is_some_and(|plan| self.made < plan.u.len())
    }

    /// Whether x is the state it planned to be in: what is planned from there has been improved already.
    pub(crate) fn is_followed(&self, plant: &Plant, x: &[f64]) -> bool {
        let planned = self.plan.as_ref().and_then(|plan| plan.x.get(self.made));
        let near = |((x, planned), scale): ((&f64, &f64), &f64)| (x - planned).abs() <= FOLLOWED * scale;
        planned.is_some_and(|planned| x.iter().zip(planned).zip(&plant.scales).all(near))
    }

    /// What it earns from x in the next `steps` steps, and the controls of it.
    pub(crate) fn earns(&self, plant: &Plant, goals: &[Goal], x: &[f64], steps: usize) -> (f64, Vec<Vec<f64>>) {
        let run = self.run(plant, goals, x, steps);
        (run.earned, run.controls)
    }

    /// The next `steps` steps from x. What they earn is less what it costs to be beyond the bounds of a position.
    pub(crate) fn run(&self, plant: &Plant, goals: &[Goal], x: &[f64], steps: usize) -> Run {
        let (mut rng, mut x, mut next) = (unused(), x.to_vec(), vec![0.0; x.len()]);
        let mut action = vec![0.0; plant.spec().action_space.action_dim()];
        let mut run = Run { earned: 0.0, controls: Vec::with_capacity(steps), last: None, late: 0.0, known: true };
        let late = steps - steps.div_ceil(LATE);
        let charge = charge(plant, goals);
        for t in 0..steps {
            let mut u = self.control(plant, goals, &x, t);
            plant.settle(&mut u, &mut action);
            let Some(stepped) = plant.step(&x, &u, &mut rng, &mut next) else {
                return Run { earned: f64::NEG_INFINITY, ..run };
            };
            run.known &= !plant.is_outside(&next);
            let paid = stepped.reward - charge * plant.beyond(&next).map(|(_, off)| off * off).sum::<f64>();
            run.earned += paid;
            run.late += if t < late { 0.0 } else { paid };
            run.controls.push(u);
            std::mem::swap(&mut x, &mut next);
            if stepped.ended {
                return run;
            }
            if (t + 1).is_multiple_of(LOOKED) && self.stays(goals, &x, t + 1) {
                run.earned += paid * (steps - t - 1) as f64;
                run.late += paid * (steps - late.max(t + 1)) as f64;
                let u = run.controls[t].clone();
                run.controls.resize(steps, u);
                break;
            }
        }
        run.late /= (steps - late) as f64;
        Run { last: Some(x), ..run }
    }

    /// Steps after which it has reached a goal from x; all of them if it comes to none.
    pub(super) fn reaches(&self, plant: &Plant, goals: &[Goal], x: &[f64], steps: usize) -> usize {
        let (mut rng, mut x, mut next) = (unused(), x.to_vec(), vec![0.0; x.len()]);
        for (t, u) in self.earns(plant, goals, &x, steps).1.iter().enumerate() {
            if goals.iter().any(|goal| goal.distance(&x) < ARRIVED) {
                return t;
            }
            if plant.step(&x, u, &mut rng, &mut next).is_none() {
                break;
            }
            std::mem::swap(&mut x, &mut next);
        }
        steps
    }

    /// Whether x, so many steps from now, is the goal that it holds from then on.
    fn stays(&self, goals: &[Goal], x: &[f64], later: usize) -> bool {
        let through = self.plan.as_ref().is_none_or(|plan| self.made + later >= plan.u.len());
        through && self.goal.is_some_and(|goal| !goals[goal].ends && goals[goal].distance(x) < STAYS)
    }

    /// The same with the rest of its plan improved again for the reward of the next `steps` steps.
    pub(crate) fn again(self, plant: &Plant, goals: &[Goal], x: &[f64], steps: usize, earned: f64) -> (Self, f64) {
        let length = self.length(plant, goals, x, steps);
        self.polished(plant, goals, x, steps, earned, (AGAIN, length, &WIDTHS[..2]))
    }

    /// The same from a near state x, improved; `None` where it earns less than `earned`, what it earns from where it was planned, by more than [`NOTHING`] of that and a step's mean
    /// reward: it may arrive a step later.
    pub(crate) fn adapted(
        &self,
        plant: &Plant,
        goals: &[Goal],
        x: &[f64],
        steps: usize,
        earned: f64,
    ) -> Option<(Self, f64)> {
        let (course, now) = self.led(plant, goals, x, steps);
        let made = course.earns(plant, goals, x, steps).1.len().max(1);
        let less = NOTHING * earned.abs() + earned.abs() / made as f64;
        (now >= earned - less).then_some((course, now))
    }

    /// The same from x, or in another system, improved for the reward of the next `steps` steps; and what it earns. Its states are followed first, as a guess
    /// whose gaps are closed: its controls alone, or its gains, may lead far away from them.
    pub(crate) fn led(&self, plant: &Plant, goals: &[Goal], x: &[f64], steps: usize) -> (Self, f64) {
        let length = self.length(plant, goals, x, steps);
        let turned = self.plan.as_ref().map(|plan| plan.turned(plant, self.made, x));
        let closed = turned.as_ref().and_then(|plan| {
            let along = &plan.x[self.made..];
            let mut states = along.to_vec();
            states[0].copy_from_slice(x);
            let objective = Objective { along, ..Objective::way(None) };
            let plan = Plan::through(plant, &objective, states, plan.u[self.made..].to_vec())?;
            Some(plan.improved(plant, &objective, POLISH)).filter(Plan::is_closed)
        });
        let course = match closed {
            Some(plan) => Self { plan: Some(plan), made: 0, goal: self.goal },
            None => Self { plan: turned, ..*self },
        };
        let earned = course.earns(plant, goals, x, steps).0;
        course.polished(plant, goals, x, steps, earned, (POLISH, length, &WIDTHS))
    }

    /// The same from states of its plan on that are nearer to x than those before and after, the nearest first: what was missed may be had some steps later.
    pub(crate) fn joined(&self, plant: &Plant, x: &[f64]) -> Vec<Self> {
        let Some(plan) = &self.plan else { return Vec::new() };
        let away: Vec<f64> = plan.x[..plan.u.len()].iter().map(|planned| plant.apart(planned, x)).collect();
        let beside = |t: usize| [t.wrapping_sub(1), t + 1].into_iter().filter_map(|t| away.get(t));
        let mut nearest: Vec<usize> = (0..away.len()).filter(|t| beside(*t).all(|other| away[*t] < *other)).collect();
        nearest.sort_by(|one, other| away[*one].total_cmp(&away[*other]));
        nearest.truncate(JOINS);
        nearest.into_iter().map(|made| Self { made, ..self.clone() }).collect()
    }

    /// What it earns in the next `steps` steps from where its plan is to be.
    pub(crate) fn planned(&self, plant: &Plant, goals: &[Goal], steps: usize) -> f64 {
        self.plan.as_ref().map_or(f64::NEG_INFINITY, |plan| self.earns(plant, goals, &plan.x[self.made], steps).0)
    }

    /// Steps that are left of its plan; without one those after which it has reached its goal from x.
    pub(super) fn length(&self, plant: &Plant, goals: &[Goal], x: &[f64], steps: usize) -> usize {
        let Some(plan) = &self.plan else {
            let Some(goal) = self.goal.map(|goal| &goals[goal]) else { return 0 };
            let (mut rng, mut x, mut next) = (unused(), x.to_vec(), vec![0.0; x.len()]);
            let mut made = 0;
            while made < steps && goal.distance(&x) >= ARRIVED {
                if plant.step(&x, &goal.control(plant, &x), &mut rng, &mut next).is_none_or(|stepped| stepped.ended) {
                    break;
                }
                std::mem::swap(&mut x, &mut next);
                made += 1;
            }
            return made;
        };
        plan.u.len().saturating_sub(self.made)
    }

    /// The same with its next `length` steps improved for the reward of the next `steps`, if that earns more; and what it earns.
    pub(super) fn polished(
        self,
        plant: &Plant,
        goals: &[Goal],
        x: &[f64],
        steps: usize,
        earned: f64,
        (iterations, length, widths): (usize, usize, &[f64]),
    ) -> (Self, f64) {
        let per_width = |width| self.objective(plant, goals, (steps, earned), (length, width));
        let objectives: Vec<Objective<'_>> = widths.iter().copied().map(per_width).collect();
        let (mut best, mut earned) = (self, earned);
        for objective in objectives {
            let (_, controls) = best.earns(plant, goals, x, steps.min(length));
            let Some(plan) = Plan::of(plant, &objective, x, controls) else { break };
            let plan = plan.improved(plant, &objective, iterations);
            let course = Self { plan: Some(plan), made: 0, goal: best.goal };
            let more = course.earns(plant, goals, x, steps).0;
            if more > earned {
                (best, earned) = (course, more);
            }
        }
        (best, earned)
    }

    /// The reward of its next `length` steps with differences so wide, where the next `steps` earn `earned`.
    fn objective<'a>(
        &self,
        plant: &Plant,
        goals: &'a [Goal],
        (steps, earned): (usize, f64),
        (length, width): (usize, f64),
    ) -> Objective<'a> {
        // What holds the goal is a small part of it, without which small changes of a plan past unstable rest would lead far away.
        let goal = self.goal.map(|goal| &goals[goal]);
        let unit = goal.map_or(0.0, |goal| (goal.pay - earned / steps.max(1) as f64).abs());
        let unit = if unit.is_finite() { unit } else { 0.0 };
        // Nothing is held after the last step.
        let end = goal.map(|goal| (goal, unit)).filter(|_| length < steps);
        Objective {
            reward: 1.0,
            width,
            effort: EFFORT * unit,
            beyond: charge(plant, goals),
            end,
            ..Objective::default()
        }
    }
}
