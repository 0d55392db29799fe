//! How much of what is done by those who learn while they act.

use serde::Serialize;

use crate::ScheduleError;

/// The hyper-parameters of learning on the system, with a model's help or without.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OnlineSchedule {
    /// Real steps, at most.
    pub real_steps: usize,
    /// Real steps of the explorer, before the agent acts and learns.
    pub first_steps: usize,
    /// Real steps for which every explored action is held: 1 for none, more where a single push does nothing.
    pub held_steps: usize,
    /// Updates after every real step: the update-to-data ratio.
    pub updates_per_step: usize,
    /// Transitions in one update.
    pub batch_size: usize,
    /// Real transitions remembered.
    pub replay_capacity: usize,
    /// What a model is used for; nothing where the learner makes none.
    pub branches: Option<Branches>,
    /// When the policy is looked at.
    pub checks: Checks,
}

impl OnlineSchedule {
    /// Refuses what would hang, panic or give no numbers.
    ///
    /// # Errors
    /// [`ScheduleError`] with the first setting that is out of its range.
    pub fn check(&self) -> Result<(), ScheduleError> {
        let own = [
            ("batch_size", self.batch_size),
            ("replay_capacity", self.replay_capacity),
            ("checks.every", self.checks.every),
            ("checks.episodes", self.checks.episodes),
        ];
        let branches = self.branches.iter().flat_map(|b| {
            let Branches { every, length, rounds_kept, .. } = *b;
            [("branches.every", every), ("branches.length", length), ("branches.rounds_kept", rounds_kept)]
        });
        if let Some((name, _)) = own.into_iter().chain(branches).find(|(_, count)| *count == 0) {
            return Err(ScheduleError { name, value: 0.0, wanted: "at least 1" });
        }
        match self.branches.as_ref().map(|b| b.real_share).filter(|share| !(0.0..=1.0).contains(share)) {
            Some(value) => Err(ScheduleError { name: "branches.real_share", value, wanted: "in 0..=1" }),
            None => Ok(()),
        }
    }
}

/// Short rollouts in a model, branched off from real states (Janner et al. 2019).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Branches {
    /// Real steps after which the model is fitted anew and rollouts branch off.
    pub every: usize,
    /// Rollouts branched off for each real step.
    pub per_step: usize,
    /// Steps of each, at most.
    pub length: usize,
    /// Rounds of branching whose transitions are remembered.
    pub rounds_kept: usize,
    /// Share of real transitions in a batch.
    pub real_share: f64,
}

/// When the deterministic policy is looked at, on systems of its own: these steps are not counted, and nothing is learned
/// from them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Checks {
    /// Real steps between two checks.
    pub every: usize,
    /// Episodes of a check, from start states drawn anew for each.
    pub episodes: usize,
    /// Mean return of a check at which a run ends; without one, a run takes all its steps.
    pub until: Option<f64>,
}
