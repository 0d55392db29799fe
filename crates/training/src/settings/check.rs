//! What settings a run can have.

use super::TrainConfig;
use crate::Error;

/// Real steps a warm-up may take: all of them, times all terms, are held in memory at once.
const MOST_REAL_STEPS: usize = 100_000;

/// Episodes of one evaluation: as many systems stand side by side.
const MOST_EPISODES: usize = 10_000;

/// Imagined systems side by side.
const MOST_SYSTEMS: usize = 10_000;

/// Transitions in the replay: gigabytes for any larger number.
const MOST_TRANSITIONS: usize = 10_000_000;

/// Steps or updates of one turn of the training.
const MOST_PER_TURN: usize = 1_000_000;

/// Transitions of one update.
const MOST_IN_BATCH: usize = 65_536;

/// Hidden layers of a network, and units of one of them.
const MOST_LAYERS: usize = 8;
const MOST_UNITS: usize = 4_096;

/// Weights between all hidden layers of a network: an update works on five networks, with three numbers for each weight.
const MOST_WEIGHTS: usize = 20_000_000;

/// Values of all hidden layers for one batch.
const MOST_VALUES: usize = 100_000_000;

impl TrainConfig {
    /// Refuses settings no run can have; the parts check their own when they are built.
    pub fn check(&self) -> Result<(), Error> {
        at_least_one("warmup.rollouts", self.warmup.rollouts)?;
        at_least_one("warmup.rollout_len", self.warmup.rollout_len)?;
        let real_steps = self.warmup.rollouts.saturating_mul(self.warmup.rollout_len);
        if real_steps > MOST_REAL_STEPS {
            let wanted = format!("at most {MOST_REAL_STEPS} over all rollouts");
            return Err(Error::setting("warmup.rollout_len", wanted, real_steps));
        }
        if let Some(most) = self.imagination.max_real_steps.filter(|most| *most < real_steps) {
            let wanted = format!("at least the {real_steps} real steps of the warm-up");
            return Err(Error::setting("imagination.max_real_steps", wanted, most));
        }
        within("sac.batch_size", self.sac.batch_size, MOST_IN_BATCH)?;
        within("number of sac.hidden layers", self.sac.hidden.len().max(1), MOST_LAYERS)?;
        self.sac.hidden.iter().try_for_each(|width| within("width of a sac.hidden layer", *width, MOST_UNITS))?;
        self.check_networks()?;
        let discount = self.sac.discount;
        if !(0.0..1.0).contains(&discount) {
            return Err(Error::setting("sac.discount", "at least 0 and below 1", discount));
        }
        within("imagination.replay_capacity", self.imagination.replay_capacity, MOST_TRANSITIONS)?;
        within("imagination.systems", self.imagination.systems, MOST_SYSTEMS)?;
        within("imagination.rollout_len", self.imagination.rollout_len, MOST_PER_TURN)?;
        within("imagination.updates_per_turn", self.imagination.updates_per_turn, MOST_PER_TURN)?;
        at_least_one("optimality.trial_every", self.optimality.trial_every as usize)?;
        within("optimality.trial_episodes", self.optimality.trial_episodes, MOST_EPISODES)?;
        at_least_one("optimality.max_updates", self.optimality.max_updates as usize)?;
        let tolerance = self.optimality.tolerance;
        if !(tolerance.is_finite() && tolerance >= 0.0) {
            return Err(Error::setting("optimality.tolerance", "finite and at least 0", tolerance));
        }
        check_episodes(self.evaluation_episodes)?;
        if !(0.0..=1.0).contains(&self.imagination.scattered_starts) {
            let got = self.imagination.scattered_starts;
            return Err(Error::setting("imagination.scattered_starts", "between 0 and 1", got));
        }
        if !(0.0..=1.0).contains(&self.noise) {
            return Err(Error::setting("noise", "between 0 and 1", self.noise));
        }
        Ok(())
    }

    /// Refuses networks that are small enough layer by layer, and too large together.
    fn check_networks(&self) -> Result<(), Error> {
        let (hidden, batch) = (&self.sac.hidden, self.sac.batch_size);
        let weights: usize = hidden.windows(2).map(|pair| pair[0] * pair[1]).sum();
        if weights > MOST_WEIGHTS {
            let wanted = format!("at most {MOST_WEIGHTS} weights between its layers");
            return Err(Error::setting("sac.hidden", wanted, format!("{weights} weights")));
        }
        let values = batch * hidden.iter().sum::<usize>();
        if values > MOST_VALUES {
            let wanted = format!("so small that all sac.hidden layers have at most {MOST_VALUES} values");
            let got = format!("a batch of {batch} with {values} values");
            return Err(Error::setting("sac.batch_size", wanted, got));
        }
        Ok(())
    }
}

/// Refuses a number of evaluation episodes there cannot be.
pub fn check_episodes(episodes: usize) -> Result<(), Error> {
    within("evaluation_episodes", episodes, MOST_EPISODES)
}

fn within(name: &'static str, value: usize, most: usize) -> Result<(), Error> {
    at_least_one(name, value)?;
    if value > most {
        return Err(Error::setting(name, format!("at most {most}"), value));
    }
    Ok(())
}

fn at_least_one(name: &'static str, value: usize) -> Result<(), Error> {
    match value {
        0 => Err(Error::setting(name, "at least 1", 0)),
        _ => Ok(()),
    }
}
