//! The last word: the deterministic policy from fixed start states.

use rayon::prelude::*;
use sindyna_core::{EnvError, Environment, Memory, Mode, Policy, Rng, Seed};

use crate::lockstep::{Lane, Lockstep};

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
    // Who keeps something in mind acts for one system at a time: there is nothing to share.
    let together = if policy.begin().is_some() { 1 } else { GROUP };
    let groups = envs.par_chunks_mut(together).enumerate().map(|(group, envs)| {
        let first = group * together;
        let lanes = envs.iter_mut().enumerate().map(|(i, env)| Episode::begin(env, policy, first + i, (seed, stream)));
        let lanes = lanes.take(episodes.saturating_sub(first)).collect::<Result<_, EnvError>>()?;
        run(lanes, policy, (systems, episodes), (seed, stream))
    });
    let mut returns = vec![0.0; episodes];
    for (episode, earned) in groups.collect::<Result<Vec<_>, EnvError>>()?.into_iter().flatten() {
        returns[episode] = earned;
    }
    Ok(returns)
}

/// A system in the middle of an episode.
struct Episode<'a, E> {
    env: &'a mut E,
    rng: Rng,
    memory: Option<Box<dyn Memory + 'a>>,
    number: usize,
    earned: f64,
}

impl<'a, E: Environment> Episode<'a, E> {
    /// Begins episode `number` of a random stream.
    fn begin(
        env: &'a mut E,
        policy: &'a dyn Policy,
        number: usize,
        (seed, stream): (Seed, &str),
    ) -> Result<Self, EnvError> {
        let mut rng = seed.stream(stream, number as u64);
        env.reset(&mut rng)?;
        Ok(Self { env, rng, memory: policy.begin(), number, earned: 0.0 })
    }
}

impl<E: Environment> Lane for Episode<'_, E> {
    type System = E;

    fn system(&self) -> &E {
        self.env
    }

    fn with_rng<'a>(&'a mut self, _common: &'a mut Rng) -> (&'a mut E, &'a mut Rng) {
        (self.env, &mut self.rng)
    }

    fn memory(&mut self) -> Option<&mut dyn Memory> {
        match &mut self.memory {
            Some(memory) => Some(&mut **memory),
            None => None,
        }
    }
}

/// Runs all lanes to the end of their last episode; a lane's next episode is `stride` after the one it ended.
fn run<'a, E: Environment>(
    lanes: Vec<Episode<'a, E>>,
    policy: &'a dyn Policy,
    (stride, episodes): (usize, usize),
    (seed, stream): (Seed, &str),
) -> Result<Vec<(usize, f64)>, EnvError> {
    let mut returns = Vec::new();
    let Some(spec) = lanes.first().map(|lane| lane.env.spec().clone()) else { return Ok(returns) };
    let mut lockstep = Lockstep::new(&spec, lanes);
    // Exploit draws nothing; the trait asks for a generator all the same.
    let mut unused = seed.stream(stream, u64::MAX);
    while !lockstep.lanes.is_empty() {
        lockstep.step((policy, Mode::Exploit), &mut unused, |lane, step| {
            let outcome = step.outcome?;
            lane.earned += outcome.reward;
            if !(outcome.terminated || outcome.truncated) {
                return Ok(true);
            }
            returns.push((lane.number, lane.earned));
            (lane.number, lane.earned) = (lane.number + stride, 0.0);
            if lane.number < episodes {
                (lane.rng, lane.memory) = (seed.stream(stream, lane.number as u64), policy.begin());
                lane.env.reset(&mut lane.rng)?;
            }
            Ok::<_, EnvError>(lane.number < episodes)
        })?;
    }
    Ok(returns)
}
