//! What a run tells those who watch it.

use std::io;

use crate::Dataset;

/// A fact about a run, as it happens.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum Event<'a> {
    /// Real data came in; `data` holds all of it so far.
    Collected {
        /// All real data so far.
        data: &'a Dataset,
    },
    /// A model was fitted to `rows` real steps.
    Fitted {
        /// Real steps the model was fitted to.
        rows: usize,
        /// The model in lines a person reads.
        description: &'a [String],
    },
    /// No model could be fitted to `rows` real steps: the one before stays, in doubt.
    NotFitted {
        /// Real steps so far.
        rows: usize,
        /// Why.
        reason: &'a str,
    },
    /// The agent was updated.
    Updated {
        /// Updates so far.
        updates: u64,
        /// Updates after which training stops at the latest.
        max_updates: u64,
        /// Steps imagined so far.
        model_steps: u64,
        /// Imagined rollouts cut because the model diverged.
        diverged: u64,
        /// Imagined rollouts ended because they left the region the model is trusted in.
        left_region: u64,
        /// What the agent tells of the last update, by name.
        metrics: &'a [(&'static str, f64)],
    },
    /// The policy was tried in the model.
    Imagined {
        /// Updates so far.
        updates: u64,
        /// Mean return in the model.
        mean_return: f64,
        /// The best such mean so far, this one included.
        best_return: f64,
    },
    /// A policy that was optimal in the model had an episode on the system.
    Confirmed {
        /// Its return there.
        real: f64,
        /// The return that the model predicts from the same start state.
        predicted: f64,
    },
    /// The policy was evaluated on the system, after everything else.
    Evaluated {
        /// Return of every episode.
        returns: &'a [f64],
    },
}

/// Someone who watches a run: a recorder, a progress bar.
pub trait Observer {
    /// Takes notice of `event`.
    ///
    /// # Errors
    /// What went wrong in writing it down; the run ends with it.
    fn on(&mut self, event: &Event<'_>) -> io::Result<()>;
}
