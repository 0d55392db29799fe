//! Improving an agent inside a model, until it is optimal there.

use std::io;

use sindyna_core::{Agent, AgentError, Batch, Dynamics, EnvError, Event, Losses, Observer, Replay, Rng, Seed};

use crate::evaluate::evaluate;
use crate::imagine::{Counts, Dreamer, Imagination, Imagined, Trial};
use crate::optimality::Trials;
use crate::{Rollouts, Schedule};

/// The best policy so far and what it scored in the model.
#[derive(Debug, Clone)]
pub(crate) struct Best<P> {
    pub(crate) policy: P,
    pub(crate) model_return: f64,
}

/// Why improving stopped.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Stop {
    /// The policy is optimal in the model, or the updates are used up.
    Done { optimal: bool },
    /// N rollouts were imagined: a real one is due.
    RealDue,
    /// Somebody asked to stop.
    Interrupted,
    /// The agent can learn no further.
    Failed(AgentError),
}

/// Why improving failed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ImproveError {
    #[error(transparent)]
    Trial(#[from] EnvError),
    #[error(transparent)]
    Observer(#[from] io::Error),
}

/// What outlives one call of [`Improvement::run`].
pub(crate) struct Improvement<'a, A: Agent> {
    pub(crate) agent: A,
    pub(crate) replay: Replay,
    pub(crate) trials: Trials<'a>,
    pub(crate) best: Option<Best<A::Frozen>>,
    pub(crate) updates: u64,
    pub(crate) counts: Counts,
    pub(crate) rng: Rng,
    pub(crate) batch: Batch,
}

impl<A: Agent> Improvement<'_, A> {
    /// Imagines and updates until a rule stops it.
    pub(crate) fn run<M: Dynamics>(
        &mut self,
        model: &Imagined<'_, M>,
        schedule: &Schedule,
        seed: Seed,
        turn: u64,
        observer: &mut dyn Observer,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Stop, ImproveError> {
        let rule = &schedule.optimality;
        let mut imagination = Imagination::new(model, schedule, seed, turn);
        let counts_before = self.counts;
        while self.replay.len() < schedule.random_steps.clamp(1, self.replay.capacity()) {
            imagination.turn(&Dreamer::Random, &mut self.replay);
            self.counts = counts_before.plus(imagination.counts);
            if interrupted() {
                return Ok(Stop::Interrupted);
            }
            if imagination.counts.diverged > schedule.random_steps as u64 {
                // Nothing can be learned in a model that blows up from nearly every state.
                return Ok(Stop::Done { optimal: false });
            }
        }
        loop {
            imagination.turn(&Dreamer::Policy(&self.agent), &mut self.replay);
            self.counts = counts_before.plus(imagination.counts);
            let left = rule.max_updates.saturating_sub(self.updates);
            for _ in 0..left.min(schedule.updates_per_turn as u64) {
                self.replay.sample_into(&mut self.batch, &mut self.rng);
                let losses = match self.agent.update(&self.batch, &mut self.rng) {
                    Ok(losses) => losses,
                    Err(error) => return Ok(Stop::Failed(error)),
                };
                self.updates += 1;
                if self.updates.is_multiple_of(rule.trial_every) {
                    self.trial(model, schedule, seed, losses, observer)?;
                }
                // A turn may be as many updates as one likes.
                if interrupted() {
                    return Ok(Stop::Interrupted);
                }
            }
            if interrupted() {
                return Ok(Stop::Interrupted);
            }
            let optimal = self.trials.optimal();
            if optimal || self.updates >= rule.max_updates {
                return Ok(Stop::Done { optimal });
            }
            if let Rollouts::Count(n) = schedule.imagined_rollouts
                && imagination.counts.rollouts >= n
            {
                return Ok(Stop::RealDue);
            }
        }
    }

    /// Forgets what earlier trials scored: they were in another model. The best policy of then has to prove itself anew.
    pub(crate) fn start_over(&mut self) {
        self.trials = Trials::new(self.trials.rule());
    }

    /// Hands over `policy` instead of the one that was best in the model.
    pub(crate) fn keep(&mut self, policy: A::Frozen) {
        if let Some(best) = &mut self.best {
            best.policy = policy;
        }
    }

    /// Runs the deterministic policy in the model and keeps it if it is the best so far.
    fn trial<M: Dynamics>(
        &mut self,
        model: &Imagined<'_, M>,
        schedule: &Schedule,
        seed: Seed,
        losses: Losses,
        observer: &mut dyn Observer,
    ) -> Result<(), ImproveError> {
        let rule = &schedule.optimality;
        observer.on(&Event::Updated {
            updates: self.updates,
            max_updates: rule.max_updates,
            model_steps: self.counts.steps,
            diverged: self.counts.diverged,
            left_region: self.counts.left_region,
            losses,
        })?;
        let policy = self.agent.frozen();
        let mut worlds: Vec<_> = (0..rule.trial_episodes).map(|_| Trial::like(model)).collect();
        let returns = evaluate(&mut worlds, &policy, rule.trial_episodes, seed, "trial in the model")?;
        let mean_return = returns.iter().sum::<f64>() / returns.len() as f64;
        if self.trials.note(&returns) {
            self.best = Some(Best { policy, model_return: mean_return });
        }
        let best_return = self.trials.best().unwrap_or(mean_return);
        observer.on(&Event::Imagined { updates: self.updates, mean_return, best_return })?;
        Ok(())
    }
}
