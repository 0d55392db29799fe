//! Data from the true systems.

use anyhow::Context as _;
use sindyna_core::{Dataset, End, Environment as _, Explorer as _, Seed};
use sindyna_dyna::Swings;
use sindyna_envs::System;

/// The system called `name`, with a task or of the laboratory.
///
/// # Errors
/// If there is none.
pub fn system(name: &str) -> anyhow::Result<System> {
    sindyna_envs::find(name)
        .or_else(|| sindyna_envs::find_field(name))
        .with_context(|| format!("there is no system named `{name}`"))
}

/// `steps` real steps under the default warm-up, drawn from the stream that `sindyna train` draws from. An episode that ends
/// is followed by another; the rollouts count the resets.
///
/// # Errors
/// If the system fails.
pub fn warm_up(system: &System, steps: usize, seed: Seed) -> anyhow::Result<Dataset> {
    let spec = system.spec();
    let space = &spec.action_space;
    let mut env = system.environment();
    let mut explorer = Swings::new(spec);
    let mut rng = seed.stream("real system", 0);
    let mut data = Dataset::new(spec.observation_dim(), spec.control_dim(), space.action_dim(), spec.dt);
    let (mut action, mut control) = (vec![0.0; space.action_dim()], vec![0.0; space.control_dim()]);
    let mut running = false;
    for _ in 0..steps {
        if !running {
            env.reset(&mut rng)?;
            data.begin(env.observation())?;
        }
        explorer.next(&data, &mut rng, &mut action);
        let outcome = env.step(&action, &mut rng)?;
        space.control_into(&action, &mut control);
        data.push(&action, &control, outcome.reward, env.observation())?;
        running = !(outcome.terminated || outcome.truncated);
        if !running {
            data.finish(if outcome.terminated { End::Terminated } else { End::Truncated });
        }
    }
    Ok(data)
}
