//! The last word: the deterministic policy from fixed start states.

use ndarray::Array2;
use sindyna_core::{EnvError, Environment, Mode, Policy, Seed};

/// Returns of `episodes` episodes of `policy` (its best actions) on the systems `envs`, which share the work.
///
/// Episode i starts from, and draws all its randomness from, stream i of `seed`, so the start states depend on the
/// seed alone and not on how many systems there are.
///
/// # Errors
/// [`EnvError`] of the first environment that fails.
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
    let spec = envs.first().expect("there is a system to evaluate on").spec();
    let (m, k) = (spec.observation_dim(), spec.action_space.action_dim());
    let mut returns = vec![0.0; episodes];
    let mut waiting = 0..episodes;
    // Exploit draws nothing; the trait asks for a generator all the same.
    let mut unused = seed.stream(stream, u64::MAX);

    let mut running = Vec::new();
    for env in envs {
        let Some(episode) = waiting.next() else { break };
        let mut rng = seed.stream(stream, episode as u64);
        env.reset(&mut rng)?;
        running.push((env, episode, rng));
    }
    while !running.is_empty() {
        let mut observations = Array2::zeros((running.len(), m));
        for (mut row, (env, ..)) in observations.rows_mut().into_iter().zip(&running) {
            row.assign(&ndarray::ArrayView1::from(env.observation()));
        }
        let mut actions = Array2::zeros((running.len(), k));
        policy.act_batch(observations.view(), Mode::Exploit, &mut unused, actions.view_mut());

        let mut ended = Vec::new();
        for (i, (env, episode, rng)) in running.iter_mut().enumerate() {
            let outcome = env.step(&actions.row(i).to_vec(), rng)?;
            returns[*episode] += outcome.reward;
            if !(outcome.terminated || outcome.truncated) {
                continue;
            }
            match waiting.next() {
                Some(next) => {
                    *episode = next;
                    *rng = seed.stream(stream, next as u64);
                    env.reset(rng)?;
                }
                None => ended.push(i),
            }
        }
        for i in ended.into_iter().rev() {
            running.remove(i);
        }
    }
    Ok(returns)
}
