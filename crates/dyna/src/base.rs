//! What both loops are made of: real data, the model fitted to them, and an agent that learns.

use serde::{Deserialize, Serialize};
use sindyna_core::{
    Agent, AgentError, Batch, CheckpointError, Dataset, DynamicsLearner, FitError, Knowledge, Replay, Rng, Seed, Spec,
    decode, encode,
};

use crate::DynaError;
use crate::collect::Collector;

/// What imagination has done so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Counts {
    pub(crate) steps: u64,
    pub(crate) rollouts: u64,
    pub(crate) diverged: u64,
    pub(crate) left_region: u64,
}

/// What a fit was made of besides the model before: it can be made again.
#[derive(Serialize, Deserialize)]
struct Fit {
    /// Steps that it was made to.
    steps: usize,
    rng: Rng,
}

/// What can be written down as it is.
#[derive(Serialize, Deserialize)]
pub(crate) struct Progress {
    pub(crate) real: Collector,
    pub(crate) replay: Replay,
    /// Real steps that replay was given.
    remembered: usize,
    pub(crate) updates: u64,
    pub(crate) counts: Counts,
    /// Number of the model fitted last, from 1 on.
    pub(crate) model: u32,
    /// The fits that knowledge comes from.
    fits: Vec<Fit>,
    fit_rng: Rng,
    rng: Rng,
}

/// What came of a fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fitted {
    /// A model.
    Model,
    /// None: what was known before stays.
    Nothing,
    /// It was told to stop.
    Stopped,
}

/// An agent on its way, with what it learns from.
pub(crate) struct Base<'a, L: DynamicsLearner + ?Sized> {
    learner: &'a L,
    pub(crate) agent: Box<dyn Agent>,
    pub(crate) knowledge: Option<Knowledge<L::Model>>,
    pub(crate) progress: Progress,
    batch: Batch,
    /// Why the last update was none.
    pub(crate) failure: Option<AgentError>,
    /// Whether a fit was told to stop.
    pub(crate) stopped: bool,
}

impl<'a, L: DynamicsLearner + ?Sized> Base<'a, L> {
    /// Before the first real step; updates are of `batch_size` transitions, drawn from as many as there is room for.
    pub(crate) fn new(
        learner: &'a L,
        agent: Box<dyn Agent>,
        (spec, seed): (&Spec, Seed),
        (batch_size, replay_capacity): (usize, usize),
    ) -> Self {
        let (m, k) = (spec.observation_dim(), spec.action_space.action_dim());
        let progress = Progress {
            real: Collector::new(spec, seed.stream("real system", 0)),
            replay: Replay::new(replay_capacity, m, k),
            remembered: 0,
            updates: 0,
            counts: Counts::default(),
            model: 0,
            fits: Vec::new(),
            fit_rng: seed.stream("identification", 0),
            rng: seed.stream("updates", 0),
        };
        let batch = Batch::zeros(batch_size, m, k);
        Self { learner, agent, knowledge: None, progress, batch, failure: None, stopped: false }
    }

    /// All real data.
    pub(crate) fn data(&self) -> &Dataset {
        &self.progress.real.data
    }

    /// The model fitted last.
    pub(crate) fn model(&self) -> Option<&L::Model> {
        self.knowledge.as_ref().map(|knowledge| &*knowledge.model)
    }

    /// Puts the real steps since the last call into replay.
    pub(crate) fn remember(&mut self) {
        let Progress { real, replay, remembered, .. } = &mut self.progress;
        real.data.transitions(*remembered).for_each(|transition| replay.push(transition));
        *remembered = real.data.n_steps();
    }

    /// Forgets what models before the last one imagined.
    pub(crate) fn forget_older_models(&mut self) {
        self.forget_before(self.progress.model);
    }

    /// Forgets all that was imagined.
    pub(crate) fn forget_imagined(&mut self) {
        self.forget_before(self.progress.model + 1);
    }

    fn forget_before(&mut self, model: u32) {
        let Progress { real, replay, remembered, .. } = &mut self.progress;
        let made_room = *remembered - replay.n_real().min(*remembered);
        replay.forget_before(model, real.data.transitions(0).take(made_room));
    }

    /// Fits a model to all real data.
    pub(crate) fn fit(&mut self) -> Result<Fitted, FitError> {
        let Progress { real, model, fits, fit_rng, .. } = &mut self.progress;
        let fit = Fit { steps: real.data.n_steps(), rng: fit_rng.clone() };
        let previous = self.knowledge.as_ref().map(|knowledge| &*knowledge.model);
        match self.learner.fit(&real.data, previous, fit_rng) {
            Ok(Some(fitted)) => {
                self.knowledge = Some(fitted);
                *model += 1;
                if !self.learner.goes_on() {
                    fits.clear();
                }
                fits.push(fit);
                Ok(Fitted::Model)
            }
            Ok(None) => Ok(Fitted::Nothing),
            Err(FitError::Interrupted) => {
                self.stopped = true;
                Ok(Fitted::Stopped)
            }
            Err(error) => Err(error),
        }
    }

    /// One update; with a second memory, a batch is of replay to a share and else of that. Whether it could be made.
    pub(crate) fn update(&mut self, second: Option<(&Replay, f64)>) -> bool {
        let Progress { replay, rng, updates, .. } = &mut self.progress;
        let n = self.batch.len();
        let second = second.filter(|(second, _)| !second.is_empty());
        let first = second.map_or(n, |(_, share)| n.min((share * n as f64).round() as usize));
        replay.sample_rows_into(&mut self.batch, 0..first, rng);
        if let Some((second, _)) = second {
            second.sample_rows_into(&mut self.batch, first..n, rng);
        }
        match self.agent.learn(&self.batch, rng) {
            Ok(()) => *updates += 1,
            Err(error) => self.failure = Some(error),
        }
        self.failure.is_none()
    }

    /// All of it that does not follow from the rest. Models do where the learner does not write them down: they are fitted again.
    pub(crate) fn save(&self) -> Vec<u8> {
        let knowledge = self.knowledge.as_ref().and_then(|knowledge| self.learner.save(knowledge));
        encode(&(self.agent.save(), knowledge, &self.progress))
    }

    /// Makes one that has just begun the one that was saved.
    pub(crate) fn restore(&mut self, saved: &[u8]) -> Result<(), DynaError> {
        let (agent, knowledge, progress): (Vec<u8>, Option<Vec<u8>>, Progress) = decode(saved)?;
        progress.replay.check(&self.progress.replay)?;
        progress.real.check(&self.progress.real)?;
        self.agent.restore(&agent)?;
        self.knowledge = knowledge.map(|saved| self.learner.read(&saved)).transpose()?;
        let missing = if self.knowledge.is_some() { &[][..] } else { &progress.fits };
        for Fit { steps, rng } in missing {
            let (data, previous) = (progress.real.data.first(*steps), self.model());
            self.knowledge = self.learner.fit(&data, previous, &mut rng.clone())?;
            if self.knowledge.is_none() {
                return Err(CheckpointError::new("its data give no model").into());
            }
        }
        self.progress = progress;
        Ok(())
    }
}
