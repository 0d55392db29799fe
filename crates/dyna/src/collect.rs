//! Real data, every step and reset of it counted.

use sindyna_core::{Dataset, End, EnvError, Environment, Explorer, Mode, Policy, Rng};

/// Something that chooses the next real action.
pub(crate) enum Actor<'a> {
    Explorer(&'a mut dyn Explorer),
    Policy(&'a dyn Policy, Mode),
}

impl Actor<'_> {
    pub(crate) fn act(&mut self, observation: &[f64], so_far: &Dataset, rng: &mut Rng, action: &mut [f64]) {
        match self {
            Self::Explorer(explorer) => explorer.next(so_far, rng, action),
            Self::Policy(policy, mode) => policy.act(observation, *mode, rng, action),
        }
    }
}

/// How much real data is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Amount {
    /// So many steps, over as many episodes as it takes.
    Steps(usize),
    /// One episode, however long.
    Episode,
}

/// Adds real steps to `data`, which counts them: steps as [`Dataset::n_steps`], resets as [`Dataset::n_rollouts`].
/// Where an episode ends before the steps are made, another reset follows. Stops early once `interrupted` says so.
pub(crate) fn collect(
    env: &mut dyn Environment,
    mut actor: Actor<'_>,
    amount: Amount,
    data: &mut Dataset,
    rng: &mut Rng,
    interrupted: &dyn Fn() -> bool,
) -> Result<(), CollectError> {
    let space = env.spec().action_space.clone();
    let mut action = vec![0.0; space.action_dim()];
    let mut control = vec![0.0; space.control_dim()];
    let mut running = false;
    let steps = match amount {
        Amount::Steps(steps) => steps,
        Amount::Episode => env.spec().max_steps,
    };
    for step in 0..steps {
        if interrupted() {
            break;
        }
        if !running {
            if step > 0 && amount == Amount::Episode {
                break;
            }
            env.reset(rng)?;
            data.begin(env.observation())?;
        }
        actor.act(env.observation(), data, rng, &mut action);
        let outcome = env.step(&action, rng)?;
        // The environment accepted the action, so it is one of the space's.
        space.control_into(&action, &mut control);
        data.push(&action, &control, outcome.reward, env.observation())?;
        running = !(outcome.terminated || outcome.truncated);
        if !running {
            data.finish(if outcome.terminated { End::Terminated } else { End::Truncated });
        }
    }
    Ok(())
}

/// Why real data could not be collected.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CollectError {
    /// The environment failed.
    #[error(transparent)]
    Environment(#[from] EnvError),
    /// The environment returned something that is no observation.
    #[error(transparent)]
    Data(#[from] sindyna_core::DatasetError),
}
