//! Settings of those who learn on the real system, per task.

use sindyna_core::Spec;
use sindyna_dyna::{Branches, Checks, OnlineSchedule};
use sindyna_rl::SacConfig;

/// What one run on the real system is put together from.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Preset {
    pub(crate) schedule: OnlineSchedule,
    pub(crate) sac: SacConfig,
}

/// Episodes of a check, as in the paper.
const EPISODES: usize = 10;

/// Checks in a row that have to reach the mark before a run ends.
const ENOUGH: usize = 3;

/// Soft actor-critic on the real system with so many updates a step.
///
/// Settings are those of Stable-Baselines3 (two layers of 256, batch 256, learning rate 3e-4, γ 0.99, τ 0.005), but for what
/// RL-Baselines3-Zoo found better: pendulum's learning rate of 1e-3. On mountain-car actions are held, since single random pushes
/// never leave the valley (the zoo has state-dependent noise for that), and γ is 0.999. The budgets are the paper's.
pub(crate) fn sac(spec: &Spec, updates_per_step: usize) -> Preset {
    let (real_steps, every) = budget(&spec.name);
    let mut sac = SacConfig { hidden: vec![256, 256], ..SacConfig::default() };
    let mut held_steps = 1;
    match spec.name.as_str() {
        "pendulum" => sac.learning_rate = 1e-3,
        "mountain-car" => {
            held_steps = 20;
            sac.discount = 0.999;
            sac.polyak = 0.01;
            sac.initial_temperature = 0.1;
        }
        _ => {}
    }
    let schedule = OnlineSchedule {
        real_steps,
        first_steps: 100,
        held_steps,
        updates_per_step,
        batch_size: sac.batch_size,
        replay_capacity: 1_000_000,
        branches: None,
        checks: Checks { every, episodes: EPISODES, mark: spec.solved_at, enough: ENOUGH },
    };
    Preset { schedule, sac }
}

/// MBPO: the same agent with ten updates a step, on batches of which a twentieth is real and the rest one step of the model
/// from states the real system was in, newly imagined after every 250 real steps.
///
/// These are Janner's settings for the inverted pendulum, but for a quarter of his 400 rollouts a step and 250 random steps instead
/// of 500, since with 10 updates a step and batches of 256 the rest would hardly be drawn.
pub(crate) fn mbpo(spec: &Spec) -> Preset {
    let Preset { schedule, sac } = sac(spec, 10);
    let branches = Branches { every: 250, per_step: 100, length: 1, rounds_kept: 1, real_share: 0.05 };
    Preset { schedule: OnlineSchedule { first_steps: 250, branches: Some(branches), ..schedule }, sac }
}

/// Real steps at most (Arora et al. 2022), and from check to check.
pub(crate) fn budget(task: &str) -> (usize, usize) {
    match task {
        "cart-pole" | "pendulum" => (5_000, 250),
        "mountain-car" | "inverted-pendulum" => (20_000, 500),
        _ => (20_000, 1_000),
    }
}
