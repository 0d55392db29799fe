//! A system that can be acted on, one control interval at a time.

use crate::{Checkpoint, Diverged, Rng, Spec};

/// What a step led to besides the new observation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Reward of the step.
    pub reward: f64,
    /// The task ended for good: no value comes after.
    pub terminated: bool,
    /// The time limit was reached: the episode stops, its value does not.
    pub truncated: bool,
}

/// Why a step could not be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EnvError {
    /// The episode is over, or none was begun.
    #[error("the environment must be reset before it can step")]
    NeedsReset,
    /// The action is not one of the action space's.
    #[error("action {action:?} is not in the action space")]
    NotAnAction {
        /// The action that was asked for.
        action: Vec<f64>,
    },
    /// The simulation left the finite numbers.
    #[error("the system diverged: {state} is not finite after the step")]
    Diverged {
        /// Name of the first state that is not finite.
        state: String,
    },
    /// The task pays no finite number for a step.
    #[error("the reward of `{task}` is {reward} at {at}")]
    Reward {
        /// Name of the task.
        task: String,
        /// The reward.
        reward: f64,
        /// Which step it is of.
        at: String,
    },
    /// The system behind the environment failed.
    #[error("the system failed: {reason}")]
    System {
        /// What the system reported.
        reason: String,
    },
}

impl EnvError {
    /// [`EnvError::Diverged`] of the system of `spec`.
    pub fn diverged(spec: &Spec, Diverged { index }: Diverged) -> Self {
        let name = spec.state.get(index).map(|channel| channel.name.clone());
        Self::Diverged { state: name.unwrap_or_else(|| format!("state {index}")) }
    }

    /// `Ok` if the `reward` of the step from `x` (n) with the control `u` (k) to `next` (n) of the system of `spec` is finite.
    ///
    /// # Errors
    /// [`EnvError::Reward`], with what the step was.
    pub fn unless_finite(spec: &Spec, reward: f64, (x, u, next): (&[f64], &[f64], &[f64])) -> Result<(), Self> {
        if reward.is_finite() {
            return Ok(());
        }
        let states = spec.state.iter().zip(x).map(|(state, v)| format!("{} = {v:?}", state.name));
        let controls = spec.control.iter().zip(u).map(|(control, v)| format!("{} = {v:?}", control.name));
        let ends = spec.state.iter().zip(next).map(|(state, v)| format!("next_{} = {v:?}", state.name));
        let at = states.chain(controls).chain(ends).collect::<Vec<_>>().join(", ");
        Err(Self::Reward { task: spec.name.clone(), reward, at })
    }
}

/// A system with a task on it, true or imagined.
///
/// After [`reset`](Self::reset) and after every [`step`](Self::step) that ends neither way, the environment can step.
pub trait Environment: Send {
    /// Names, bounds, time step.
    fn spec(&self) -> &Spec;

    /// What the sensors show now.
    fn observation(&self) -> &[f64];

    /// Begins an episode in a start state drawn from the task.
    ///
    /// # Errors
    /// [`EnvError::System`] if the system behind it fails.
    fn reset(&mut self, rng: &mut Rng) -> Result<(), EnvError>;

    /// Applies `action` for one control interval.
    ///
    /// # Errors
    /// [`EnvError::NeedsReset`] after an episode's end, [`EnvError::NotAnAction`], [`EnvError::Diverged`], [`EnvError::Reward`].
    fn step(&mut self, action: &[f64], rng: &mut Rng) -> Result<Outcome, EnvError>;

    /// Its state, to be written down and put back; `None` for a system that cannot be put back where it was, as one outside of the computer. Such a one goes
    /// on with a reset.
    fn checkpoint(&mut self) -> Option<&mut dyn Checkpoint> {
        None
    }
}

/// An environment behind a pointer is the same environment.
macro_rules! pointed_at {
    ($pointer:ty) => {
        impl<E: Environment + ?Sized> Environment for $pointer {
            fn spec(&self) -> &Spec {
                (**self).spec()
            }
            fn observation(&self) -> &[f64] {
                (**self).observation()
            }
            fn reset(&mut self, rng: &mut Rng) -> Result<(), EnvError> {
                (**self).reset(rng)
            }
            fn step(&mut self, action: &[f64], rng: &mut Rng) -> Result<Outcome, EnvError> {
                (**self).step(action, rng)
            }
            fn checkpoint(&mut self) -> Option<&mut dyn Checkpoint> {
                (**self).checkpoint()
            }
        }
    };
}

pointed_at!(Box<E>);
pointed_at!(&mut E);
