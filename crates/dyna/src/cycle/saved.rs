//! A loop as bytes.

use serde::{Deserialize, Serialize};
use sindyna_core::{CheckpointError, Dataset, Explorer, Replay, Rng, decode, encode};

use super::{Best, Loop, Phase};
use crate::DynaError;
use crate::imagine::{Counts, Imagination};
use crate::optimality::Trials;
use crate::real::Confirmation;

/// What a fit was made of besides the model before: it can be made again.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Fit {
    /// Rollouts that it was made to.
    pub(super) rollouts: usize,
    pub(super) rng: Rng,
}

/// A policy and its mean return in the model.
#[derive(Serialize, Deserialize)]
struct Kept {
    policy: Vec<u8>,
    model_return: f64,
}

/// All of a loop that does not follow from the rest. Models do where the learner does not write them down: they are fitted again.
#[derive(Serialize, Deserialize)]
struct State {
    phase: Phase,
    agent: Vec<u8>,
    explorer: Vec<u8>,
    data: Dataset,
    knowledge: Option<Vec<u8>>,
    fits: Vec<Fit>,
    believed: usize,
    imagination: Option<Vec<u8>>,
    replay: Replay,
    trials: Trials,
    best: Option<Kept>,
    tried: Option<(Kept, Confirmation)>,
    optimal: bool,
    updates: u64,
    counts: Counts,
    fitted: usize,
    is_tested: bool,
    is_beginner: bool,
    turns: u64,
    real_rng: Rng,
    fit_rng: Rng,
    rng: Rng,
}

impl Kept {
    fn of(best: &Best) -> Self {
        Self { policy: best.policy.to_bytes(), model_return: best.model_return }
    }
}

impl<L: sindyna_core::DynamicsLearner + ?Sized> Loop<'_, L> {
    /// The loop and its `explorer` as bytes, to go on from by [`Dyna::resume`](crate::Dyna::resume). Only between two steps that were not interrupted: what
    /// [`Loop::advance`] did not do to the end is not in it. `None` once there is nothing more to go on with but the result.
    pub fn save(&self, explorer: &dyn Explorer) -> Option<Vec<u8>> {
        if self.failure.is_some() || self.phase == Phase::Done {
            return None;
        }
        Some(encode(&State {
            phase: self.phase,
            agent: self.agent.save(),
            explorer: explorer.save(),
            data: self.data.clone(),
            knowledge: self.knowledge.as_ref().and_then(|knowledge| self.parts.learner.save(knowledge)),
            fits: self.fits.clone(),
            believed: self.believed,
            imagination: self.imagination.as_ref().map(Imagination::save),
            replay: self.replay.clone(),
            trials: self.trials.clone(),
            best: self.best.as_ref().map(Kept::of),
            tried: self.tried.as_ref().map(|(best, confirmation)| (Kept::of(best), confirmation.clone())),
            optimal: self.optimal,
            updates: self.updates,
            counts: self.counts,
            fitted: self.fitted,
            is_tested: self.is_tested,
            is_beginner: self.is_beginner,
            turns: self.turns,
            real_rng: self.real_rng.clone(),
            fit_rng: self.fit_rng.clone(),
            rng: self.rng.clone(),
        }))
    }

    /// Makes a loop that has just begun the one that was saved.
    pub(crate) fn restore(&mut self, explorer: &mut dyn Explorer, saved: &[u8]) -> Result<(), DynaError> {
        let state: State = decode(saved)?;
        state.replay.check(&self.replay)?;
        state.data.check(&self.data)?;
        self.agent.restore(&state.agent)?;
        explorer.restore(&state.explorer)?;
        let best = |kept: Kept| -> Result<Best, CheckpointError> {
            Ok(Best { policy: self.agent.read_policy(&kept.policy)?, model_return: kept.model_return })
        };
        self.best = state.best.map(best).transpose()?;
        self.tried =
            state.tried.map(|(kept, confirmation)| Ok::<_, DynaError>((best(kept)?, confirmation))).transpose()?;
        self.knowledge = state.knowledge.map(|saved| self.parts.learner.read(&saved)).transpose()?;
        let missing = if self.knowledge.is_some() { &[][..] } else { &state.fits };
        for fit in missing {
            let data = state.data.first(fit.rollouts);
            let previous = self.knowledge.as_ref().map(|k| &*k.model);
            self.knowledge = self.parts.learner.fit(&data, previous, &mut fit.rng.clone())?;
            if self.knowledge.is_none() {
                return Err(CheckpointError::new("its data give no model").into());
            }
        }
        (self.data, self.believed, self.turns) = (state.data, state.believed, state.turns);
        if let Some(imagination) = &state.imagination {
            let turn = state.turns.saturating_sub(1);
            let belief = self.belief(turn).ok_or_else(|| CheckpointError::new("imagination without a model"))?;
            let mut begun = Imagination::new(belief, self.parts.schedule, self.parts.seed, turn);
            begun.restore(imagination)?;
            self.imagination = Some(begun);
        }
        (self.phase, self.fits, self.fitted) = (state.phase, state.fits, state.fitted);
        (self.replay, self.trials, self.optimal) = (state.replay, state.trials, state.optimal);
        (self.updates, self.counts) = (state.updates, state.counts);
        (self.is_tested, self.is_beginner) = (state.is_tested, state.is_beginner);
        (self.real_rng, self.fit_rng, self.rng) = (state.real_rng, state.fit_rng, state.rng);
        Ok(())
    }
}
