//! A task on a MuJoCo model.

use std::fmt;
use std::sync::Arc;

use sindyna_core::{Diverged, EnvError, Environment, Observe, Outcome, Rng, Sensors, Spec, Task};

use crate::error::MujocoError;
use crate::ffi::{DataHandle, Raised, take_warnings};
use crate::model::MujocoModel;
use crate::probe::Conventions;

/// An [`Environment`] whose system is a MuJoCo model.
///
/// The state x is (qpos, qvel) in MuJoCo's order, the control u is ctrl. One control interval is `frame_skip` steps of
/// the model. Between a reset and the end of an episode everything happens in one `mjData`, warm start of the
/// constraint solver included, so that states equal those of the same MuJoCo version under Python bit for bit.
///
/// # Deviations
/// From Gymnasium's `MujocoEnv`:
/// 1. Where MuJoCo finds a number that is not finite, or beyond 1e10, it starts over from the rest position and goes
///    on. Here the step is an error, [`EnvError::Diverged`], and the environment must be reset.
/// 2. Actuators with an activation of their own keep it outside the state; a reset sets it to zero.
pub struct MujocoEnvironment<T, H = Sensors> {
    data: DataHandle,
    conventions: Arc<Conventions>,
    positions: usize,
    /// States that the model moves; those after them stay as an episode began.
    moving: usize,
    frame_skip: usize,
    task: T,
    sensors: H,
    state: Vec<f64>,
    next: Vec<f64>,
    control: Vec<f64>,
    observation: Vec<f64>,
    steps: usize,
    running: bool,
    warning: Option<String>,
}

impl<T: Task, H: Observe> MujocoEnvironment<T, H> {
    /// Puts `task` on `model`, seen through `sensors`. The first call must be a reset.
    ///
    /// # Errors
    /// [`MujocoError::Mismatch`] or [`MujocoError::Interval`] if the task declares other states, controls or another
    /// control interval than `frame_skip` steps of the model; [`MujocoError::Raised`] if there is no memory.
    pub fn new(model: &MujocoModel, frame_skip: usize, task: T, sensors: H) -> Result<Self, MujocoError> {
        Self::with_still_states(model, frame_skip, task, sensors, 0)
    }

    /// The same where the last `still` states of the task are none of the model: they stay as an episode began, as a target does.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_still_states(
        model: &MujocoModel,
        frame_skip: usize,
        task: T,
        sensors: H,
        still: usize,
    ) -> Result<Self, MujocoError> {
        let spec = task.spec();
        for (what, expected, got) in [
            ("states (positions and velocities)", spec.state_dim(), model.state_dim() + still),
            ("controls", spec.control_dim(), model.control_dim()),
        ] {
            if expected != got {
                return Err(MujocoError::Mismatch { task: spec.name.clone(), what, expected, got });
            }
        }
        let interval = model.timestep() * frame_skip as f64;
        if frame_skip == 0 || (interval - spec.dt).abs() > 1e-9 * spec.dt {
            let timestep = model.timestep();
            return Err(MujocoError::Interval { task: spec.name.clone(), frame_skip, timestep, dt: spec.dt });
        }
        let (n, k, m) = (spec.state_dim(), spec.control_dim(), spec.observation_dim());
        let data = DataHandle::new(model.handle()).map_err(|Raised(message)| MujocoError::Raised { message })?;
        Ok(Self {
            data,
            conventions: Arc::clone(model.conventions()),
            positions: model.position_dim(),
            moving: model.state_dim(),
            frame_skip,
            task,
            sensors,
            state: vec![0.0; n],
            next: vec![0.0; n],
            control: vec![0.0; k],
            observation: vec![0.0; m],
            steps: 0,
            running: false,
            warning: None,
        })
    }

    /// The state x (n): positions, then velocities, then what stays as it began.
    pub fn state(&self) -> &[f64] {
        &self.state
    }

    /// The control u (k) the last step applied.
    pub fn control(&self) -> &[f64] {
        &self.control
    }

    /// The task on this system.
    pub fn task(&self) -> &T {
        &self.task
    }

    /// The last thing MuJoCo warned of, such as a full list of contacts.
    pub fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    /// Begins an episode in state `x` (n).
    ///
    /// # Errors
    /// [`EnvError::System`] if `x` has another length or holds a number that is not finite, or if MuJoCo fails.
    pub fn reset_to(&mut self, x: &[f64], rng: &mut Rng) -> Result<(), EnvError> {
        self.check_state(x)?;
        self.running = false;
        self.data.reset().map_err(system)?;
        self.move_to(x, rng)?;
        self.control.fill(0.0);
        self.steps = 0;
        self.running = true;
        Ok(())
    }

    /// Moves the system to state `x` (n) in the middle of an episode: time, control and the solver's warm start remain.
    ///
    /// # Errors
    /// As [`Self::reset_to`].
    pub fn set_state(&mut self, x: &[f64], rng: &mut Rng) -> Result<(), EnvError> {
        self.check_state(x)?;
        let running = std::mem::replace(&mut self.running, false);
        self.move_to(x, rng)?;
        self.running = running;
        Ok(())
    }

    fn check_state(&self, x: &[f64]) -> Result<(), EnvError> {
        if x.len() != self.state.len() {
            let reason = format!("a state has {} values, got {}", self.state.len(), x.len());
            return Err(EnvError::System { reason });
        }
        match x.iter().position(|v| !v.is_finite()) {
            None => Ok(()),
            Some(i) => Err(EnvError::System { reason: format!("a state must be finite, got {} at index {i}", x[i]) }),
        }
    }

    fn move_to(&mut self, x: &[f64], rng: &mut Rng) -> Result<(), EnvError> {
        let moved = self.data.set(self.conventions.state(), &x[..self.moving]).and_then(|()| self.data.forward());
        self.keep_warning();
        moved.map_err(system)?;
        self.state.copy_from_slice(x);
        self.sensors.observe(&self.state, rng, &mut self.observation);
        Ok(())
    }

    /// Keeps the last warning. `Some(i)` if MuJoCo found state i, or the acceleration of velocity i, to be no finite number or
    /// a huge one; it then began anew from the rest position.
    fn keep_warning(&mut self) -> Option<usize> {
        let mut warnings = take_warnings();
        let index = warnings.iter().find_map(|text| self.conventions.diverged(text, self.positions));
        self.warning = warnings.pop().or(self.warning.take());
        index.map(|i| i.min(self.state.len().saturating_sub(1)))
    }

    /// One control interval, into `next`.
    fn advance(&mut self) -> Result<(), EnvError> {
        // Of what failed on this thread before, for example a model that was refused.
        take_warnings();
        self.data.set(self.conventions.controls, &self.control).map_err(system)?;
        for _ in 0..self.frame_skip {
            self.data.step().map_err(system)?;
            if let Some(index) = self.keep_warning() {
                return Err(EnvError::diverged(self.task.spec(), Diverged { index }));
            }
        }
        self.data.post_constraint().map_err(system)?;
        let (moving, still) = self.next.split_at_mut(self.moving);
        self.data.get(self.conventions.state(), moving).map_err(system)?;
        still.copy_from_slice(&self.state[self.moving..]);
        Diverged::check(&self.next).map_err(|diverged| EnvError::diverged(self.task.spec(), diverged))
    }
}

fn system(Raised(reason): Raised) -> EnvError {
    EnvError::System { reason }
}

impl<T: Task, H: Observe> Environment for MujocoEnvironment<T, H> {
    fn spec(&self) -> &Spec {
        self.task.spec()
    }

    fn observation(&self) -> &[f64] {
        &self.observation
    }

    fn reset(&mut self, rng: &mut Rng) -> Result<(), EnvError> {
        let mut start = std::mem::take(&mut self.next);
        self.task.initial(rng, &mut start);
        let begun = self.reset_to(&start, rng);
        self.next = start;
        begun
    }

    fn step(&mut self, action: &[f64], rng: &mut Rng) -> Result<Outcome, EnvError> {
        if !self.running {
            return Err(EnvError::NeedsReset);
        }
        if !self.task.spec().action_space.control_into(action, &mut self.control) {
            return Err(EnvError::NotAnAction { action: action.to_vec() });
        }
        let advanced = self.advance();
        self.keep_warning();
        if let Err(failed) = advanced {
            self.running = false;
            return Err(failed);
        }
        let reward = self.task.reward(&self.state, action, &self.control, &self.next);
        std::mem::swap(&mut self.state, &mut self.next);
        self.sensors.observe(&self.state, rng, &mut self.observation);
        self.steps += 1;
        let (spec, (before, after)) = (self.task.spec(), (&self.next, &self.state));
        if let Err(unpaid) = EnvError::unless_finite(spec, reward, (before, &self.control, after)) {
            self.running = false;
            return Err(unpaid);
        }
        let terminated = self.task.terminated(&self.state);
        let truncated = self.steps >= self.task.max_steps();
        self.running = !(terminated || truncated);
        Ok(Outcome { reward, terminated, truncated })
    }
}

impl<T: Task, H> fmt::Debug for MujocoEnvironment<T, H> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("MujocoEnvironment")
            .field("task", &self.task.spec().name)
            .field("state", &self.state)
            .field("steps", &self.steps)
            .field("running", &self.running)
            .finish_non_exhaustive()
    }
}
