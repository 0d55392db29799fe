//! A trained policy on the system itself.

use std::sync::atomic::{AtomicUsize, Ordering};

use sindyna_core::{Bounded, Dataset, EnvError, Environment, Outcome, Policy, Rng, Seed, Simulated, Spec};
use sindyna_dyna::evaluate;
use sindyna_record::identification::PredictionTable;
use sindyna_record::run::{EpisodeTable, Evaluation, Watched, labels_of};
use sindyna_sindy::{Identifier, Model, Recording};

use crate::Error;
use crate::problem::Problem;
use crate::shown::shown_in;

/// The returns of `policy` (its best actions) on the system, from start states fixed by `seed`.
pub fn evaluation(
    problem: &dyn Problem,
    policy: &dyn Policy,
    episodes: usize,
    seed: Seed,
) -> Result<Evaluation, Error> {
    watched_evaluation(problem, policy, (episodes, &|_| {}), seed).map(|(evaluation, _)| evaluation)
}

/// [`evaluation`], and the first of its episodes; `begun` is told how many were begun whenever another is.
pub fn watched_evaluation(
    problem: &dyn Problem,
    policy: &dyn Policy,
    (episodes, begun): (usize, &(dyn Fn(usize) + Sync)),
    seed: Seed,
) -> Result<(Evaluation, Dataset), Error> {
    let systems = episodes.min(problem.copies()).max(1);
    let count = AtomicUsize::new(0);
    let counted = |i: usize| {
        let env = problem.environment()?;
        Ok::<_, Error>(Counted { env: Watched::new(env, i == 0), count: &count, begun })
    };
    let mut envs = (0..systems).map(counted).collect::<Result<Vec<_>, _>>()?;
    let returns = evaluate(&mut envs, policy, episodes, seed, "evaluation")?;
    problem.check()?;
    Ok((Evaluation::of(returns), envs.swap_remove(0).env.into_episode()))
}

/// A system whose resets are counted, with those of others.
struct Counted<'a, E> {
    env: E,
    count: &'a AtomicUsize,
    begun: &'a (dyn Fn(usize) + Sync),
}

impl<E: Environment> Environment for Counted<'_, E> {
    fn spec(&self) -> &Spec {
        self.env.spec()
    }

    fn observation(&self) -> &[f64] {
        self.env.observation()
    }

    fn reset(&mut self, rng: &mut Rng) -> Result<(), EnvError> {
        (self.begun)(1 + self.count.fetch_add(1, Ordering::Relaxed));
        self.env.reset(rng)
    }

    fn step(&mut self, action: &[f64], rng: &mut Rng) -> Result<Outcome, EnvError> {
        self.env.step(action, rng)
    }
}

/// The first episode of an evaluation, `data`, beside what `model` predicts for the same policy; `None` where its states
/// are not those of the system.
pub fn episode(
    problem: &dyn Problem,
    identifier: &Identifier,
    model: &Model,
    policy: &dyn Policy,
    data: &Dataset,
) -> Option<EpisodeTable> {
    let spec = problem.spec();
    let seen = shown_in(data, identifier.spec().observation_dim()).ok()?;
    let states = identifier.recordings(&seen).ok()?.into_iter().next()?.states;
    if model.readings().is_some() || states.ncols() != spec.state_dim() || states.nrows() < 2 {
        return None;
    }
    let states: Vec<Vec<f64>> = states.rows().into_iter().map(|row| row.to_vec()).collect();
    let mut table = EpisodeTable::of(&states, data, spec);
    let task = problem.task();
    let sensors = problem.sensors().without_noise();
    let mut simulated = Simulated::new(Bounded::new(model, &spec.state), &*task, sensors);
    simulated.reset_to(&states[0], &mut Seed::new(0).stream("start of a prediction", 0));
    table.predict(&mut simulated, |simulated| simulated.state().to_vec(), policy);
    Some(table)
}

/// `recordings` at `times` of their own, where there are such.
pub fn timed(mut recordings: Vec<Recording>, times: Option<&[Vec<f64>]>) -> Vec<Recording> {
    for (recording, times) in recordings.iter_mut().zip(times.unwrap_or_default()) {
        recording.times.clone_from(times);
    }
    recordings
}

/// What `model` predicts for `data`, sampled at `times` where it is not evenly spaced; `None` where its states are not those of the data.
pub fn predictions(
    identifier: &Identifier,
    model: &Model,
    (data, times): (&Dataset, Option<&[Vec<f64>]>),
    spec: &Spec,
) -> Option<PredictionTable> {
    let seen = shown_in(data, identifier.spec().observation_dim()).ok()?;
    let recordings = timed(identifier.recordings(&seen).ok()?, times);
    if recordings.iter().any(|r| r.states.ncols() != model.states().len()) {
        return None;
    }
    let states = labels_of(model.states(), &[&spec.state, &spec.observation]);
    Some(PredictionTable::of(model, &recordings, states, labels_of(model.controls(), &[&spec.control])))
}
