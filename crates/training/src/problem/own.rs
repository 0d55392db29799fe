//! Systems of one's own.

use std::sync::Arc;

use sindyna_core::{
    Diverged, Dynamics, EnvError, Environment, Held, Observe as _, Outcome, Protocol, Rng, Scheme, Sensors, Simulated,
    Spec, Task, VectorField,
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
    solved_at: Option<f64>,
}

impl OwnSystem {
    /// The system that moves as `dynamics` do, with `task` on it.
    ///
    /// # Errors
    /// [`Error::System`] if an observation channel names no state.
    pub fn simulated(task: impl Task + 'static, dynamics: impl Dynamics + 'static) -> Result<Self, Error> {
        let (task, sensors) = Self::seen(task)?;
        Ok(Self::shown_by(task, sensors, Arc::new(dynamics)))
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
        let (task, sensors) = Self::seen(task)?;
        Ok(Self { task, sensors, make: Box::new(make), copies: 1, solved_at: None })
    }

    /// A task with the sensors that its channels declare.
    fn seen(task: impl Task + 'static) -> Result<(Arc<dyn Task>, Sensors), Error> {
        let sensors = Sensors::new(task.spec()).ok_or_else(|| Error::System {
            name: task.spec().name.clone(),
            why: "an observation channel names no state".into(),
        })?;
        Ok((Arc::new(task), sensors))
    }

    /// `task`, whose states `sensors` show, on the system that moves as `dynamics` do.
    pub(super) fn shown_by(task: Arc<dyn Task>, sensors: Sensors, dynamics: Arc<dyn Dynamics>) -> Self {
        let make = move |task: &Arc<dyn Task>, sensors: &Sensors| -> Result<Box<dyn Environment>, Error> {
            Ok(Box::new(Simulated::new(dynamics.clone(), task.clone(), sensors.clone())))
        };
        Self { task, sensors, make: Box::new(make), copies: usize::MAX, solved_at: None }
    }

    /// `task`, whose states `sensors` show, on a plant that `make` makes anew for each environment.
    pub(super) fn driven<P: Plant + 'static>(
        task: Arc<dyn Task>,
        sensors: Sensors,
        make: impl Fn() -> P + Send + Sync + 'static,
    ) -> Self {
        let make = move |task: &Arc<dyn Task>, sensors: &Sensors| -> Result<Box<dyn Environment>, Error> {
            Ok(Box::new(Connected::new(make(), task.clone(), sensors.clone())))
        };
        Self { task, sensors, make: Box::new(make), copies: usize::MAX, solved_at: None }
    }

    /// Solved from this mean return on.
    #[must_use]
    pub fn solved_at(self, mean_return: f64) -> Self {
        Self { solved_at: Some(mean_return), ..self }
    }
}

impl Problem for OwnSystem {
    fn spec(&self) -> &Spec {
        self.task.spec()
    }

    fn protocol(&self) -> Protocol {
        Protocol { max_steps: self.task.max_steps(), solved_at: self.solved_at }
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

/// Dynamics of a function that gives the next state (n) of state x (n) and control u (k), one control interval later.
pub fn stepped(step: impl Fn(&[f64], &[f64]) -> Vec<f64> + Send + Sync + 'static) -> impl Dynamics {
    Stepped(step)
}

struct Stepped<F>(F);

impl<F: Fn(&[f64], &[f64]) -> Vec<f64> + Send + Sync> Dynamics for Stepped<F> {
    fn step(&self, x: &[f64], u: &[f64], _rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
        let found = (self.0)(x, u);
        // States that are not there are no numbers.
        next.fill(f64::NAN);
        next.iter_mut().zip(found).for_each(|(next, found)| *next = found);
        Diverged::check(next)
    }
}

struct Rates<F>(F);

impl<F: Fn(&[f64], &[f64], &mut [f64]) + Send + Sync> VectorField for Rates<F> {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        (self.0)(x, u, x_dot);
    }
}

/// A [`Plant`] as an environment.
pub(super) struct Connected<P> {
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
    pub(super) fn new(plant: P, task: Arc<dyn Task>, sensors: Sensors) -> Self {
        let (n, k, m) = (task.spec().state_dim(), task.spec().control_dim(), task.spec().observation_dim());
        let (state, control, observation) = (vec![0.0; n], vec![0.0; k], vec![0.0; m]);
        Self { plant, task, sensors, state, control, observation, steps: 0, running: false }
    }

    /// The state that the plant tells, if it is one.
    fn checked(&self, state: Vec<f64>) -> Result<Vec<f64>, EnvError> {
        let (expected, got) = (self.state.len(), state.len());
        if got != expected {
            return Err(failed(format!("it gives {got} states where {expected} are declared").into()));
        }
        Diverged::check(&state).map_err(|diverged| EnvError::diverged(self.task.spec(), diverged))?;
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
        let truncated = self.steps >= self.task.max_steps();
        self.running = !(terminated || truncated);
        Ok(Outcome { reward, terminated, truncated })
    }
}

fn failed(error: PlantError) -> EnvError {
    EnvError::System { reason: error.to_string() }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use sindyna_core::Seed;

    use super::*;
    use crate::evaluation::evaluation;
    use crate::problem::TaskBuilder;

    /// A point that moves by its input; how many of it are open is counted.
    struct Point(Arc<AtomicUsize>, f64);

    impl Plant for Point {
        fn reset(&mut self, start: &[f64]) -> Result<Vec<f64>, PlantError> {
            self.1 = start[0];
            Ok(vec![self.1])
        }
        fn step(&mut self, u: &[f64]) -> Result<Vec<f64>, PlantError> {
            self.1 += u[0];
            if self.1 > 10.0 { Err("the end of the rail".into()) } else { Ok(vec![self.1]) }
        }
    }

    impl Drop for Point {
        fn drop(&mut self) {
            self.0.fetch_sub(1, Ordering::SeqCst);
        }
    }

    fn task() -> crate::problem::OwnTask {
        let builder = TaskBuilder::new("point", 1.0).state("x", "m", (1.0, 1.0)).input("u", "m", -1.0, 1.0);
        builder.reward(|x, _, _| x[0]).max_steps(3).build().unwrap()
    }

    /// Always the input 1.
    struct Ahead;

    impl sindyna_core::Policy for Ahead {
        fn act_batch(
            &self,
            _: ndarray::ArrayView2<'_, f64>,
            _: sindyna_core::Mode,
            _: &mut Rng,
            mut actions: ndarray::ArrayViewMut2<'_, f64>,
        ) {
            actions.fill(1.0);
        }
    }

    #[test]
    fn a_plant_is_opened_once_and_earns_what_the_task_says() {
        let open = Arc::new(AtomicUsize::new(0));
        let count = open.clone();
        let connect = move || {
            assert_eq!(count.fetch_add(1, Ordering::SeqCst), 0, "there is only one");
            Ok(Point(count.clone(), 0.0))
        };
        let system = OwnSystem::connected(task(), connect).unwrap();
        let evaluation = evaluation(&system, &Ahead, 4, Seed::new(0)).unwrap();
        assert_eq!((evaluation.returns, open.load(Ordering::SeqCst)), (vec![6.0; 4], 0));
    }

    #[test]
    fn what_a_plant_refuses_is_told() {
        let system = OwnSystem::connected(task(), || Ok(Point(Arc::new(AtomicUsize::new(1)), 0.0))).unwrap();
        let (mut env, mut rng) = (system.environment().unwrap(), Seed::new(0).numpy());
        assert_eq!(env.step(&[0.0], &mut rng), Err(EnvError::NeedsReset));
        env.reset(&mut rng).unwrap();
        assert!(env.step(&[1.0, 2.0], &mut rng).is_err());
        let broken = OwnSystem::connected(task(), || Err::<Point, _>("no cable".into())).unwrap();
        assert!(broken.environment().err().unwrap().to_string().contains("no cable"));
    }

    #[test]
    fn a_step_with_too_few_states_diverges() {
        let mut next = [0.0; 2];
        let step = |dynamics: &dyn Dynamics, next: &mut [f64]| {
            dynamics.step(&[1.0, 2.0], &[3.0], &mut Seed::new(0).numpy(), next)
        };
        assert_eq!(step(&stepped(|x, u| vec![x[0] + u[0], x[1]]), &mut next), Ok(()));
        assert_eq!(next, [4.0, 2.0]);
        assert_eq!(step(&stepped(|_, _| vec![0.0]), &mut next), Err(Diverged { index: 1 }));
        assert_eq!(step(&ode(0.5, |x, u, rate| rate.copy_from_slice(&[u[0], 0.0 * x[0]])), &mut next), Ok(()));
        assert!((next[0] - 2.5).abs() < 1e-12);
    }
}
