//! Learning while acting as a value that is advanced step by step.

use serde::{Deserialize, Serialize};
use sindyna_core::{
    Agent, CheckpointError, DynamicsLearner, Environment, Explorer, Inverse, Mode, Replay, decode, encode,
};

use super::algorithm::{Check, Online, Practised};
use super::branch::Stage;
use crate::DynaError;
use crate::base::{Base, Fitted};
use crate::collect::{Actor, CollectError};
use crate::evaluate::evaluate;

/// What an [`OnlineLoop`] does next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum OnlinePhase {
    /// Make a real step.
    Act,
    /// Fit a model to all real data.
    Fit,
    /// Branch rollouts off in the model.
    Branch,
    /// Make the updates that follow a real step.
    Learn,
    /// Look at the policy.
    Check,
    /// Nothing: it is done.
    Done,
}

/// What changes besides the [`Base`], and can be written down as it is.
#[derive(Serialize, Deserialize)]
struct Course {
    phase: OnlinePhase,
    imagined: Replay,
    checks: Vec<Check>,
    /// Whether a check reached what the run was to go on until.
    reached: bool,
}

/// Learning while acting on its way, between two of its steps.
pub struct OnlineLoop<'a, L: DynamicsLearner + ?Sized> {
    parts: &'a Online<'a, L>,
    base: Base<'a, L>,
    /// In which state rollouts branch off, where they do.
    inverse: Option<Inverse>,
    course: Course,
}

impl<'a, L: DynamicsLearner + ?Sized> OnlineLoop<'a, L> {
    pub(super) fn new(parts: &'a Online<'a, L>, agent: Box<dyn Agent>) -> Result<Self, DynaError> {
        let (spec, schedule) = (parts.task.spec(), parts.schedule);
        let inverse = schedule.branches.as_ref().map(|_| Inverse::of(spec)).transpose()?;
        let room = schedule.branches.as_ref().map_or(1, |b| b.every * b.per_step * b.length * b.rounds_kept);
        let imagined = Replay::new(room, spec.observation_dim(), spec.action_space.action_dim());
        let sizes = (schedule.batch_size, schedule.replay_capacity);
        let mut begun = Self {
            parts,
            base: Base::new(parts.learner, agent, (spec, parts.seed), sizes),
            inverse,
            course: Course { phase: OnlinePhase::Done, imagined, checks: Vec::new(), reached: false },
        };
        begun.course.phase = begun.act_again();
        Ok(begun)
    }

    /// What comes next.
    pub fn phase(&self) -> OnlinePhase {
        self.course.phase
    }

    /// Whether there is nothing more to do, or a fit was told to stop.
    pub fn has_ended(&self) -> bool {
        self.course.phase == OnlinePhase::Done || self.base.stopped
    }

    /// Real steps so far.
    fn steps(&self) -> usize {
        self.base.data().n_steps()
    }

    /// Does what comes next, on the system `env`; checks are on `judges`, systems of the same kind.
    ///
    /// # Errors
    /// [`DynaError`] if a system fails or a model cannot be fitted.
    pub fn advance<E: Environment>(
        &mut self,
        env: &mut dyn Environment,
        judges: &mut [E],
        explorer: &mut dyn Explorer,
    ) -> Result<OnlinePhase, DynaError> {
        self.course.phase = match self.course.phase {
            OnlinePhase::Act => self.act(env, explorer)?,
            OnlinePhase::Fit => match self.base.fit()? {
                Fitted::Stopped => OnlinePhase::Fit,
                Fitted::Model | Fitted::Nothing => OnlinePhase::Branch,
            },
            OnlinePhase::Branch => self.branch(),
            OnlinePhase::Learn => self.learn(),
            OnlinePhase::Check => self.check(judges)?,
            OnlinePhase::Done => OnlinePhase::Done,
        };
        Ok(self.course.phase)
    }

    fn act(&mut self, env: &mut dyn Environment, explorer: &mut dyn Explorer) -> Result<OnlinePhase, DynaError> {
        let schedule = self.parts.schedule;
        let learned_for = self.steps().checked_sub(schedule.first_steps);
        let mut actor = match learned_for {
            Some(_) => Actor::policy(&*self.base.agent, Mode::Explore),
            None => Actor::Explorer(explorer),
        };
        self.base.progress.real.step(env, &mut actor, schedule.held_steps)?;
        drop(actor);
        self.base.remember();
        Ok(match (learned_for, &schedule.branches) {
            (Some(steps), Some(branches)) if steps.is_multiple_of(branches.every) => OnlinePhase::Fit,
            (Some(_), _) => OnlinePhase::Learn,
            (None, _) => self.look_or_act(),
        })
    }

    fn branch(&mut self) -> OnlinePhase {
        let Online { task, sensors, schedule, seed, .. } = *self.parts;
        let round = (seed, self.steps() as u64 - 1);
        let Base { agent, knowledge, progress, .. } = &mut self.base;
        if let (Some(branches), Some(inverse), Some(knowledge)) = (&schedule.branches, &self.inverse, knowledge) {
            let stage = Stage { model: &*knowledge.model, task, sensors, inverse };
            stage.branch(branches, &**agent, progress, &mut self.course.imagined, round);
        }
        OnlinePhase::Learn
    }

    fn learn(&mut self) -> OnlinePhase {
        let schedule = self.parts.schedule;
        let second = schedule.branches.as_ref().map(|branches| (&self.course.imagined, branches.real_share));
        for _ in 0..schedule.updates_per_step {
            if !self.base.update(second) {
                return OnlinePhase::Done;
            }
        }
        self.look_or_act()
    }

    fn check<E: Environment>(&mut self, judges: &mut [E]) -> Result<OnlinePhase, DynaError> {
        let checks = &self.parts.schedule.checks;
        let stream = format!("check {}", self.course.checks.len());
        let policy = self.base.agent.policy();
        let returns =
            evaluate(judges, &*policy, checks.episodes, self.parts.seed, &stream).map_err(CollectError::from)?;
        let check = Check { real_steps: self.steps(), updates: self.base.progress.updates, returns };
        self.course.reached = checks.until.is_some_and(|wanted| check.mean() >= wanted);
        self.course.checks.push(check);
        Ok(if self.course.reached { OnlinePhase::Done } else { self.act_again() })
    }

    /// What comes after all that follows from a real step.
    fn look_or_act(&self) -> OnlinePhase {
        let due = self.steps().is_multiple_of(self.parts.schedule.checks.every);
        if due { OnlinePhase::Check } else { self.act_again() }
    }

    fn act_again(&self) -> OnlinePhase {
        if self.steps() < self.parts.schedule.real_steps { OnlinePhase::Act } else { OnlinePhase::Done }
    }

    /// The loop, its system and its `explorer` as bytes, to go on from by [`Online::resume`]. `None` once there is nothing more to go on with but the result,
    /// and in the middle of an episode of a system that cannot be put back where it was.
    pub fn save(&self, env: &mut dyn Environment, explorer: &dyn Explorer) -> Option<Vec<u8>> {
        if self.course.phase == OnlinePhase::Done {
            return None;
        }
        let env = match self.base.progress.real.running {
            true => Some(env.checkpoint()?.save()),
            false => None,
        };
        Some(encode(&(self.base.save(), &self.course, env, explorer.save())))
    }

    /// Makes a loop that has just begun the one that was saved.
    pub(super) fn restore(
        &mut self,
        env: &mut dyn Environment,
        explorer: &mut dyn Explorer,
        saved: &[u8],
    ) -> Result<(), DynaError> {
        let (base, course, system, explored): (Vec<u8>, Course, Option<Vec<u8>>, Vec<u8>) = decode(saved)?;
        course.imagined.check(&self.course.imagined)?;
        self.base.restore(&base)?;
        explorer.restore(&explored)?;
        if self.base.progress.real.running {
            let system = system.ok_or_else(|| CheckpointError::new("an episode without its system"))?;
            let env = env.checkpoint().ok_or_else(|| CheckpointError::new("this system cannot be put back"))?;
            env.restore(&system)?;
        }
        if self.steps() == 0 && course.phase != OnlinePhase::Act {
            return Err(CheckpointError::new("learning before the first step").into());
        }
        self.course = course;
        Ok(())
    }

    /// What was learned so far.
    pub fn finish(self) -> Practised<L::Model> {
        let Base { agent, knowledge, progress, failure, .. } = self.base;
        Practised {
            policy: agent.policy(),
            model: knowledge.map(|k| k.model),
            real_steps: progress.real.data.n_steps(),
            real_episodes: progress.real.data.n_rollouts(),
            updates: progress.updates,
            model_steps: progress.counts.steps,
            diverged: progress.counts.diverged,
            checks: self.course.checks,
            reached: self.course.reached,
            failure,
            interrupted: self.course.phase != OnlinePhase::Done,
        }
    }
}
