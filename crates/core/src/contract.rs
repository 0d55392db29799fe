//! What environments, dynamics and agents promise, as checks for one's own.

use ndarray::Array2;
use rand::RngExt as _;

use crate::{
    Agent, Batch, Channel, Dynamics, EnvError, Environment, Kind, Mode, Outcome, Policy, Precision, Prior, Rng, Seed,
};
use crate::{Space, Spec};

/// A promise that is not kept.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{subject}: {what}")]
pub struct ContractError {
    /// Whose promise.
    pub subject: String,
    /// What is wrong.
    pub what: String,
}

/// A subject whose promises are checked.
struct Subject<'a>(&'a str);

impl Subject<'_> {
    fn holds(&self, promise: bool, otherwise: impl FnOnce() -> String) -> Result<(), ContractError> {
        if promise { Ok(()) } else { Err(ContractError { subject: self.0.to_owned(), what: otherwise() }) }
    }
}

/// Checks what `spec` declares: scales, bounds and the time step are usable, roles name states, actions put controls within their bounds on the
/// system.
///
/// # Errors
/// [`ContractError`] with the first thing that is wrong.
pub fn check_spec(spec: &Spec) -> Result<(), ContractError> {
    let subject = Subject(&spec.name);
    for channel in spec.state.iter().chain(&spec.observation).chain(&spec.control) {
        let Channel { name, prior: Prior { scale, bounds: (low, high), resolution, written }, .. } = channel;
        subject.holds(scale.is_finite() && *scale > 0.0, || format!("the scale of `{name}` is {scale}"))?;
        let is_step = resolution.is_finite() && *resolution >= 0.0;
        subject.holds(is_step, || format!("the resolution of `{name}` is {resolution}"))?;
        let is_distance = written.is_finite() && *written >= 0.0;
        subject.holds(is_distance, || format!("the values of `{name}` are written {written} apart"))?;
        subject.holds(low < high, || format!("`{name}` is bounded by {low} and {high}"))?;
        if let Kind::RateOf(i) | Kind::CosOf(i) | Kind::SinOf(i) = channel.kind {
            let n = spec.state_dim();
            subject.holds(i < n, || format!("`{name}` is of state {i}, and there are {n}"))?;
        }
    }
    let (acts, takes) = (spec.action_space.control_dim(), spec.control_dim());
    subject.holds(acts == takes, || format!("actions put {acts} controls on a system that has {takes}"))?;
    match &spec.action_space {
        Space::Box { low, high } => {
            subject.holds(low.len() == high.len(), || format!("{} lower and {} upper ends", low.len(), high.len()))?;
            for ((channel, low), high) in spec.control.iter().zip(low).zip(high) {
                let within = low < high && channel.prior.bounds.0 <= *low && *high <= channel.prior.bounds.1;
                subject.holds(within, || format!("actions of `{}` go from {low} to {high}", channel.name))?;
            }
        }
        Space::Discrete { controls } => {
            subject.holds(controls.nrows() > 0, || "there is no action".into())?;
            for row in controls.rows() {
                for (channel, u) in spec.control.iter().zip(row) {
                    let within = (channel.prior.bounds.0..=channel.prior.bounds.1).contains(u);
                    subject.holds(within, || format!("an action puts {u} on `{}`, beyond its bounds", channel.name))?;
                }
            }
        }
    }
    subject.holds(spec.dt > 0.0 && spec.dt.is_finite(), || format!("the time step is {}", spec.dt))
}

/// A valid action that depends on the step number `t` only, up to half the control range.
fn wave(space: &Space, t: usize) -> Vec<f64> {
    let wave = (0.7 * t as f64).sin() / 2.0;
    match space {
        Space::Box { low, high } => low.iter().zip(high).map(|(lo, hi)| (lo + hi + wave * (hi - lo)) / 2.0).collect(),
        Space::Discrete { controls } => vec![(t % controls.nrows().max(1)) as f64],
    }
}

/// Observations and outcomes of `steps` steps, resetting where an episode ends; the first observation comes with no outcome.
type History = Vec<(Vec<f64>, Option<Outcome>)>;

fn play(env: &mut dyn Environment, seed: u64, steps: usize) -> Result<History, EnvError> {
    let mut rng = Seed::new(seed).numpy();
    env.reset(&mut rng)?;
    let mut history = vec![(env.observation().to_vec(), None)];
    for t in 0..steps {
        let action = wave(&env.spec().action_space, t);
        let outcome = env.step(&action, &mut rng)?;
        history.push((env.observation().to_vec(), Some(outcome)));
        if outcome.terminated || outcome.truncated {
            env.reset(&mut rng)?;
        }
    }
    Ok(history)
}

/// Checks the environments that `make` gives: what they declare ([`check_spec`]); that they refuse to step before a reset and after the end, and actions
/// that are none; that one seed gives one history, in the same environment and in another; that observations have the width, bounds and precision
/// declared, rewards are finite, and that an episode is truncated after `max_steps`. `steps` are made in each of a few histories; on hardware that answers otherwise
/// every time, histories differ and the check fails.
///
/// # Errors
/// [`ContractError`] with the first promise that is not kept.
pub fn check_environment<E: Environment>(
    make: impl Fn() -> E,
    max_steps: usize,
    steps: usize,
) -> Result<(), ContractError> {
    let mut env = make();
    let spec = env.spec().clone();
    check_spec(&spec)?;
    let subject = Subject(&spec.name);
    subject.holds(max_steps > 0, || "an episode has no step".into())?;
    let mut rng = Seed::new(0).numpy();

    let early = env.step(&wave(&spec.action_space, 0), &mut rng);
    subject.holds(early == Err(EnvError::NeedsReset), || format!("a step before any reset gives {early:?}"))?;
    let failed = |e: EnvError| ContractError { subject: spec.name.clone(), what: e.to_string() };
    let first = play(&mut env, 5, steps).map_err(failed)?;
    let again = play(&mut env, 5, steps).map_err(failed)?;
    let other = play(&mut make(), 5, steps).map_err(failed)?;
    subject.holds(first == again, || "the same seed gives another history after a reset".into())?;
    subject.holds(first == other, || "the same seed gives another history in another environment".into())?;

    let mut length = 0;
    for (seen, outcome) in &first {
        check_observation(&spec, seen)?;
        let Some(outcome) = outcome else { continue };
        length += 1;
        let (due, cut) = (length == max_steps, outcome.truncated);
        subject.holds(cut == due, || format!("truncated: {cut} after {length} steps of {max_steps}"))?;
        subject.holds(outcome.reward.is_finite(), || format!("a reward is {}", outcome.reward))?;
        if outcome.terminated || outcome.truncated {
            length = 0;
        }
    }

    env.reset(&mut rng).map_err(failed)?;
    for bad in [f64::NAN, f64::INFINITY] {
        let answer = env.step(&vec![bad; spec.action_space.action_dim()], &mut rng);
        let refused = matches!(answer, Err(EnvError::NotAnAction { .. }));
        subject.holds(refused, || format!("the action {bad} is answered by {answer:?}"))?;
    }
    for t in 0..steps {
        let outcome = env.step(&wave(&spec.action_space, t), &mut rng).map_err(failed)?;
        if outcome.terminated || outcome.truncated {
            let late = env.step(&wave(&spec.action_space, 0), &mut rng);
            return subject.holds(late == Err(EnvError::NeedsReset), || format!("a step after the end gives {late:?}"));
        }
    }
    Ok(())
}

/// An observation is as wide, as large and as fine as `spec` declares. Noise may take it beyond its bounds.
fn check_observation(spec: &Spec, seen: &[f64]) -> Result<(), ContractError> {
    let (subject, m) = (Subject(&spec.name), spec.observation_dim());
    subject.holds(seen.len() == m, || format!("an observation has {} values of {m}", seen.len()))?;
    for (value, channel) in seen.iter().zip(&spec.observation) {
        let (name, (low, high)) = (&channel.name, channel.prior.bounds);
        subject.holds(value.is_finite(), || format!("`{name}` is {value}"))?;
        let within = spec.noise > 0.0 || (low..=high).contains(value);
        subject.holds(within, || format!("`{name}` is {value}, beyond {low} to {high}"))?;
        let fine = spec.precision == Precision::F64 || f64::from(*value as f32).to_bits() == value.to_bits();
        subject.holds(fine, || format!("`{name}` is {value}, which is no float32"))?;
    }
    Ok(())
}

/// Steps tried in a check of dynamics.
const POINTS: usize = 20;

/// Checks `dynamics` over the states and controls of `spec`, near states `starts` (each n): that a step writes every state, is the same for the same random
/// numbers, and that its Jacobians are those of differences.
///
/// # Errors
/// [`ContractError`] with the first promise that is not kept; a step that diverges keeps them.
pub fn check_dynamics(dynamics: &dyn Dynamics, spec: &Spec, starts: &[Vec<f64>]) -> Result<(), ContractError> {
    /// Dynamics of which only the steps are known.
    struct Steps<'a>(&'a dyn Dynamics);
    impl Dynamics for Steps<'_> {
        fn step(&self, x: &[f64], u: &[f64], rng: &mut Rng, next: &mut [f64]) -> Result<(), crate::Diverged> {
            self.0.step(x, u, rng, next)
        }
    }

    let subject = Subject(&spec.name);
    let n = spec.state_dim();
    for (point, x) in starts.iter().cycle().take(POINTS.max(starts.len())).enumerate() {
        subject.holds(x.len() == n, || format!("a start has {} states of {n}", x.len()))?;
        let mut u = vec![0.0; spec.control_dim()];
        spec.action_space.control_into(&wave(&spec.action_space, point), &mut u);
        let step = |next: &mut [f64]| dynamics.step(x, &u, &mut Seed::new(point as u64).numpy(), next);
        let (mut next, mut again) = (vec![f64::NAN; n], vec![f64::NAN; n]);
        let (made, repeated) = (step(&mut next), step(&mut again));
        subject.holds(made == repeated, || format!("a step from {x:?} goes once {made:?}, once {repeated:?}"))?;
        if made.is_err() {
            continue;
        }
        subject.holds(next.iter().all(|v| v.is_finite()), || format!("a step from {x:?} leaves {next:?}"))?;
        subject.holds(next == again, || format!("a step from {x:?} leads to {next:?} and to {again:?}"))?;
        let seeded = || Seed::new(point as u64).numpy();
        if let (Ok(told), Ok(seen)) =
            (dynamics.linearize(x, &u, &mut seeded()), Steps(dynamics).linearize(x, &u, &mut seeded()))
        {
            let pairs = told.0.iter().chain(&told.1).zip(seen.0.iter().chain(&seen.1));
            let alike = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-4 * (1.0 + b.abs());
            subject.holds(pairs.clone().all(alike), || format!("at {x:?} the Jacobians are {seen:?}, not {told:?}"))?;
        }
    }
    Ok(())
}

/// Transitions in the batch that an agent is updated with in its check.
const BATCH: usize = 64;

/// Checks an `agent` for the observations and actions of `spec`: that its actions are of the space in both modes, that its best action draws no random
/// number and is the same for an observation alone and among others, that the policy it hands over does as much and is the same from its bytes, that an
/// update on random transitions keeps all that, and that an agent restored learns and acts as it did.
///
/// # Errors
/// [`ContractError`] with the first promise that is not kept.
pub fn check_agent(agent: &mut dyn Agent, spec: &Spec) -> Result<(), ContractError> {
    let subject = Subject(&spec.name);
    let (m, k) = (spec.observation_dim(), spec.action_space.action_dim());
    let mut rng = Seed::new(0).numpy();
    let mut batch = Batch::zeros(BATCH, m, k);
    for b in 0..BATCH {
        for j in 0..m {
            batch.observations[[b, j]] = rng.random_range(-1.0..1.0);
            batch.next_observations[[b, j]] = rng.random_range(-1.0..1.0);
        }
        for (slot, value) in batch.actions.row_mut(b).iter_mut().zip(wave(&spec.action_space, b)) {
            *slot = value;
        }
        batch.rewards[b] = rng.random_range(-1.0..1.0);
    }
    for updated in [false, true] {
        if updated {
            let done = agent.learn(&batch, &mut rng);
            subject.holds(done.is_ok(), || format!("an update on random transitions fails: {done:?}"))?;
        }
        check_policy(&subject, agent as &dyn Policy, spec, &batch.observations)?;
        let policy = agent.policy();
        check_policy(&subject, &*policy, spec, &batch.observations)?;
        let read = agent.read_policy(&policy.to_bytes());
        let read = read.map_err(|e| ContractError { subject: spec.name.clone(), what: format!("its policy: {e}") })?;
        let alike = best(&*read, spec, &batch.observations) == best(&*policy, spec, &batch.observations);
        subject.holds(alike, || "the policy from its bytes acts otherwise".into())?;
    }
    let saved = agent.save();
    let mut learned = || -> Result<_, ContractError> {
        let fails = |what: String| ContractError { subject: spec.name.clone(), what };
        agent.restore(&saved).map_err(|e| fails(format!("it does not take on its own state: {e}")))?;
        let mut rng = rng.clone();
        agent
            .learn(&batch, &mut rng)
            .map_err(|e| fails(format!("an update after its state was restored fails: {e}")))?;
        Ok((best(agent as &dyn Policy, spec, &batch.observations), agent.policy().to_bytes()))
    };
    let (first, second) = (learned()?, learned()?);
    subject.holds(first == second && agent.save() != saved, || "restored, it does not learn as it did".into())
}

/// The best actions of `policy` for `observations`.
fn best(policy: &dyn Policy, spec: &Spec, observations: &Array2<f64>) -> Array2<f64> {
    let mut actions = Array2::zeros((observations.nrows(), spec.action_space.action_dim()));
    policy.act_batch(observations.view(), Mode::Exploit, &mut Seed::new(2).numpy(), actions.view_mut());
    actions
}

fn check_policy(
    subject: &Subject<'_>,
    policy: &dyn Policy,
    spec: &Spec,
    observations: &Array2<f64>,
) -> Result<(), ContractError> {
    let space = &spec.action_space;
    let (mut actions, mut rng) = (Array2::zeros((observations.nrows(), space.action_dim())), Seed::new(1).numpy());
    for mode in [Mode::Exploit, Mode::Explore] {
        let before = rng.clone();
        policy.act_batch(observations.view(), mode, &mut rng, actions.view_mut());
        subject.holds(mode == Mode::Explore || rng == before, || "the best action draws a random number".into())?;
        for action in actions.rows() {
            let action = action.to_vec();
            let within = match space {
                Space::Box { low, high } => {
                    action.iter().zip(low).zip(high).all(|((a, low), high)| (*low..=*high).contains(a))
                }
                Space::Discrete { .. } => space.control_into(&action, &mut vec![0.0; space.control_dim()]),
            };
            subject.holds(within, || format!("{action:?} is no action of the space"))?;
        }
    }
    policy.act_batch(observations.view(), Mode::Exploit, &mut rng, actions.view_mut());
    let mut alone = vec![0.0; space.action_dim()];
    policy.act(&observations.row(0).to_vec(), Mode::Exploit, &mut rng, &mut alone);
    let among = actions.row(0).to_vec();
    subject
        .holds(alone == among, || format!("an observation alone is answered by {alone:?}, among others by {among:?}"))
}
