//! The last word: the deterministic policy from fixed start states.

use ndarray::{Array2, ArrayView1};
use rayon::prelude::*;
use sindyna_core::{EnvError, Environment, Mode, Policy, Rng, Seed};

/// Systems stepped in lock-step by one thread: enough to make a network's batch worth while. A fixed number, so that
/// results do not depend on how many threads there are.
const GROUP: usize = 25;

/// Returns of `episodes` episodes of `policy` (its best actions) on the systems `envs`, which share the work.
///
/// Episode i starts from, and draws all its randomness from, number i of the random `stream` of `seed`, so the start
/// states depend on the seed alone and not on how many systems there are.
///
/// # Errors
/// [`EnvError`] of an environment that fails.
///
/// # Panics
/// If `envs` is empty.
pub fn evaluate<E: Environment>(
    envs: &mut [E],
    policy: &dyn Policy,
    episodes: usize,
    seed: Seed,
    stream: &str,
) -> Result<Vec<f64>, EnvError> {
    assert!(!envs.is_empty(), "there must be a system to evaluate on");
    let systems = envs.len();
    let groups = envs.par_chunks_mut(GROUP).enumerate().map(|(group, envs)| {
        let first = group * GROUP;
        let lanes = envs.iter_mut().enumerate().map(|(i, env)| {
            let mut rng = seed.stream(stream, (first + i) as u64);
            env.reset(&mut rng)?;
            Ok(Lane { env, episode: first + i, rng, earned: 0.0 })
        });
        let lanes = lanes.take(episodes.saturating_sub(first)).collect::<Result<_, EnvError>>()?;
        run(lanes, policy, systems, episodes, seed, stream)
    });
    let mut returns = vec![0.0; episodes];
    for (episode, earned) in groups.collect::<Result<Vec<_>, EnvError>>()?.into_iter().flatten() {
        returns[episode] = earned;
    }
    Ok(returns)
}

/// A system in the middle of an episode.
struct Lane<'a, E> {
    env: &'a mut E,
    episode: usize,
    rng: Rng,
    earned: f64,
}

/// Runs all lanes to the end of their last episode; a lane's next episode is `stride` after the one it ended.
fn run<E: Environment>(
    mut lanes: Vec<Lane<'_, E>>,
    policy: &dyn Policy,
    stride: usize,
    episodes: usize,
    seed: Seed,
    stream: &str,
) -> Result<Vec<(usize, f64)>, EnvError> {
    let mut returns = Vec::new();
    // Exploit draws nothing; the trait asks for a generator all the same.
    let mut unused = seed.stream(stream, u64::MAX);
    while let Some(lane) = lanes.first() {
        let spec = lane.env.spec();
        let mut actions = Array2::zeros((lanes.len(), spec.action_space.action_dim()));
        let mut observations = Array2::zeros((lanes.len(), spec.observation_dim()));
        for (mut row, lane) in observations.rows_mut().into_iter().zip(&lanes) {
            row.assign(&ArrayView1::from(lane.env.observation()));
        }
        policy.act_batch(observations.view(), Mode::Exploit, &mut unused, actions.view_mut());

        let mut running = Vec::with_capacity(lanes.len());
        for (mut lane, action) in lanes.into_iter().zip(actions.rows()) {
            let action = action.to_slice().expect("rows are contiguous");
            let outcome = lane.env.step(action, &mut lane.rng)?;
            lane.earned += outcome.reward;
            if outcome.terminated || outcome.truncated {
                returns.push((lane.episode, lane.earned));
                lane.episode += stride;
                if lane.episode >= episodes {
                    continue;
                }
                lane.earned = 0.0;
                lane.rng = seed.stream(stream, lane.episode as u64);
                lane.env.reset(&mut lane.rng)?;
            }
            running.push(lane);
        }
        lanes = running;
    }
    Ok(returns)
}
