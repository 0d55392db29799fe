//! Systems of one's own.

use std::sync::Arc;

use sindyna_core::{
    Diverged, Dynamics, EnvError, Environment, Held, Observe as _, Outcome, Rng, Scheme, Sensors, Simulated, Spec,
    Task, VectorField,
};

use super::Problem;
use crate::Error;

/// Why a [`Plant`] could not go on.
pub type PlantError = Box<dyn std::error::Error + Send + Sync>;

/// A system that is stepped from outside: hardware, or a simulator of one's own.
pub trait Plant: Send {
    /// Begins an episode as near to the state `start` (n) as it can; the state (n) that it begins in.
    ///
    /// # Errors
    /// Why it cannot.
    fn reset(&mut self, start: &[f64]) -> Result<Vec<f64>, PlantError>;

    /// Applies the control `u` (k) for one control interval; the state (n) afterwards.
    ///
    /// # Errors
    /// Why it cannot.
    fn step(&mut self, u: &[f64]) -> Result<Vec<f64>, PlantError>;
}

/// Makes an environment of a task and its sensors.
type Make = Box<dyn Fn(&Arc<dyn Task>, &Sensors) -> Result<Box<dyn Environment>, Error> + Send + Sync>;

/// A system of one's own with a task on it.
pub struct OwnSystem {
    task: Arc<dyn Task>,
    sensors: Sensors,
    make: Make,
    copies: usize,
}

impl OwnSystem {
    /// The system that moves as `dynamics` do, with `task` on it.
    ///
    /// # Errors
    /// [`Error::System`] if an observation channel names no state.
    pub fn simulated(task: impl Task + 'static, dynamics: impl Dynamics + 'static) -> Result<Self, Error> {
        let dynamics: Arc<dyn Dynamics> = Arc::new(dynamics);
        let make = move |task: &Arc<dyn Task>, sensors: &Sensors| -> Result<Box<dyn Environment>, Error> {
            Ok(Box::new(Simulated::new(dynamics.clone(), task.clone(), sensors.clone())))
        };
        Self::new(task, Box::new(make), usize::MAX)
    }

    /// The system that `connect` opens, with `task` on it; one at a time is open, as hardware has it.
    ///
    /// # Errors
    /// [`Error::System`] if an observation channel names no state.
    pub fn connected<P: Plant + 'static>(
        task: impl Task + 'static,
        connect: impl Fn() -> Result<P, PlantError> + Send + Sync + 'static,
    ) -> Result<Self, Error> {
        let make = move |task: &Arc<dyn Task>, sensors: &Sensors| -> Result<Box<dyn Environment>, Error> {
            let plant = connect().map_err(failed)?;
            Ok(Box::new(Connected::new(plant, task.clone(), sensors.clone())))
        };
        Self::new(task, Box::new(make), 1)
    }

    fn new(task: impl Task + 'static, make: Make, copies: usize) -> Result<Self, Error> {
        let sensors = Sensors::new(task.spec()).ok_or_else(|| Error::System {
            name: task.spec().name.clone(),
            why: "an observation channel names no state".into(),
        })?;
        Ok(Self { task: Arc::new(task), sensors, make, copies })
    }
}

impl Problem for OwnSystem {
    fn spec(&self) -> &Spec {
        self.task.spec()
    }

    fn task(&self) -> Arc<dyn Task> {
        self.task.clone()
    }

    fn sensors(&self) -> Sensors {
        self.sensors.clone()
    }

    fn environment(&self) -> Result<Box<dyn Environment>, Error> {
        (self.make)(&self.task, &self.sensors)
    }

    fn copies(&self) -> usize {
        self.copies
    }
}

/// Dynamics of a function that writes the rates ẋ (n) at state x (n) and control u (k): stepped by eight Runge–Kutta steps of
/// fourth order in `dt` \[s\], the control held.
pub fn ode(dt: f64, rates: impl Fn(&[f64], &[f64], &mut [f64]) + Send + Sync + 'static) -> impl Dynamics {
    Held::new(Rates(rates), Scheme::Rk4 { substeps: 8 }, dt)
}

struct Rates<F>(F);

impl<F: Fn(&[f64], &[f64], &mut [f64]) + Send + Sync> VectorField for Rates<F> {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        (self.0)(x, u, x_dot);
    }
}

/// A [`Plant`] as an environment.
struct Connected<P> {
    plant: P,
    task: Arc<dyn Task>,
    sensors: Sensors,
    state: Vec<f64>,
    control: Vec<f64>,
    observation: Vec<f64>,
    steps: usize,
    running: bool,
}

impl<P: Plant> Connected<P> {
    fn new(plant: P, task: Arc<dyn Task>, sensors: Sensors) -> Self {
        let (n, k, m) = (task.spec().state_dim(), task.spec().control_dim(), task.spec().observation_dim());
        let (state, control, observation) = (vec![0.0; n], vec![0.0; k], vec![0.0; m]);
        Self { plant, task, sensors, state, control, observation, steps: 0, running: false }
    }

    /// The state that the plant tells, if it is one.
    fn checked(&self, state: Vec<f64>) -> Result<Vec<f64>, EnvError> {
        let (expected, got) = (self.state.len(), state.len());
        if got != expected {
            return Err(failed(format!("it tells {got} states where {expected} are declared").into()));
        }
        Diverged::check(&state)?;
        Ok(state)
    }
}

impl<P: Plant> Environment for Connected<P> {
    fn spec(&self) -> &Spec {
        self.task.spec()
    }

    fn observation(&self) -> &[f64] {
        &self.observation
    }

    fn reset(&mut self, rng: &mut Rng) -> Result<(), EnvError> {
        let mut start = vec![0.0; self.state.len()];
        self.task.initial(rng, &mut start);
        let begun = self.plant.reset(&start).map_err(failed)?;
        self.state = self.checked(begun)?;
        (self.steps, self.running) = (0, true);
        self.sensors.observe(&self.state, rng, &mut self.observation);
        Ok(())
    }

    fn step(&mut self, action: &[f64], rng: &mut Rng) -> Result<Outcome, EnvError> {
        if !self.running {
            return Err(EnvError::NeedsReset);
        }
        if !self.task.spec().action_space.control_into(action, &mut self.control) {
            return Err(EnvError::NotAnAction { action: action.to_vec() });
        }
        // Whatever goes wrong, the next call must be a reset.
        self.running = false;
        let told = self.plant.step(&self.control).map_err(failed)?;
        let next = self.checked(told)?;
        let reward = self.task.reward(&self.state, action, &self.control, &next);
        self.state = next;
        self.sensors.observe(&self.state, rng, &mut self.observation);
        self.steps += 1;
        let terminated = self.task.terminated(&self.state);
        let truncated = self.steps >= self.task.spec().max_steps;
        self.running = !(terminated || truncated);
        Ok(Outcome { reward, terminated, truncated })
    }
}

fn failed(error: PlantError) -> EnvError {
    EnvError::System { reason: error.to_string() }
}
