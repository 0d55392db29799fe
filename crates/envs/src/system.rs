//! A true system with the task on it.

use std::sync::Arc;

use sindyna_core::{Dynamics, Protocol, Redeclared, Sensors, Simulated, Spec, Task, VectorField};

/// A true system with the task on it.
#[derive(Clone)]
pub struct System {
    name: &'static str,
    gymnasium_id: Option<&'static str>,
    solved_at: Option<f64>,
    summary: &'static str,
    true_equations: &'static [&'static str],
    task: Arc<dyn Task>,
    dynamics: Arc<dyn Dynamics>,
    rates: Arc<dyn VectorField>,
    sensors: Sensors,
}

/// What is said about a system besides its two parts.
pub(crate) struct Card {
    pub(crate) name: &'static str,
    pub(crate) gymnasium_id: Option<&'static str>,
    pub(crate) solved_at: Option<f64>,
    pub(crate) summary: &'static str,
    pub(crate) true_equations: &'static [&'static str],
}

impl System {
    /// `rates` is what [`System::rates`] tells of `dynamics`.
    pub(crate) fn new(
        card: Card,
        task: impl Task + 'static,
        dynamics: impl Dynamics + 'static,
        rates: impl VectorField + 'static,
    ) -> Self {
        let sensors = Sensors::new(task.spec()).expect("every observation of our specs names a state");
        Self {
            name: card.name,
            gymnasium_id: card.gymnasium_id,
            solved_at: card.solved_at,
            summary: card.summary,
            true_equations: card.true_equations,
            task: Arc::new(task),
            dynamics: Arc::new(dynamics),
            rates: Arc::new(rates),
            sensors,
        }
    }

    /// Name of the task, such as `pendulum`.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Gymnasium's name for it, such as `Pendulum-v1`; none for what Gymnasium does not have.
    #[must_use]
    pub fn gymnasium_id(&self) -> Option<&'static str> {
        self.gymnasium_id
    }

    /// What is to be done, in one line.
    #[must_use]
    pub fn summary(&self) -> &'static str {
        self.summary
    }

    /// The equations of motion, in the channel names of [`Self::spec`]; between walls and limits.
    #[must_use]
    pub fn true_equations(&self) -> &'static [&'static str] {
        self.true_equations
    }

    /// What is declared about the system.
    #[must_use]
    pub fn spec(&self) -> &Spec {
        self.task.spec()
    }

    /// How policies are evaluated on it.
    #[must_use]
    pub fn protocol(&self) -> Protocol {
        Protocol { max_steps: self.task.max_steps(), solved_at: self.solved_at }
    }

    /// The task: all the agent may know.
    #[must_use]
    pub fn task(&self) -> Arc<dyn Task> {
        Arc::clone(&self.task)
    }

    /// The true dynamics: what is to be learned.
    #[must_use]
    pub fn dynamics(&self) -> Arc<dyn Dynamics> {
        Arc::clone(&self.dynamics)
    }

    /// The true right-hand side ẋ = f(x, u), states and controls in the order of [`Self::spec`]: what an identified
    /// model's accelerations are to be compared with. It holds between walls, stops and limits and knows nothing of
    /// them, nor of the scheme by which [`Self::dynamics`] is stepped. For a map without seconds it is the increment of
    /// one step, x⁺ − x.
    #[must_use]
    pub fn rates(&self) -> Arc<dyn VectorField> {
        Arc::clone(&self.rates)
    }

    /// The sensors the spec declares.
    #[must_use]
    pub fn sensors(&self) -> Sensors {
        self.sensors.clone()
    }

    /// The same system with noise on its sensors: the declared one is `fraction` (≥ 0) of every observation channel's
    /// scale. Reward and termination remain those of the state itself.
    #[must_use]
    pub fn with_noise(mut self, fraction: f64) -> Self {
        self.task = Arc::new(Redeclared::new(self.task, |spec| spec.noise = fraction));
        self.sensors = Sensors::new(self.task.spec()).expect("noise changes no channel");
        self
    }

    /// The system: task and true dynamics together. The first call must be a reset.
    #[must_use]
    pub fn environment(&self) -> Simulated<Arc<dyn Dynamics>, Arc<dyn Task>, Sensors> {
        Simulated::new(self.dynamics(), self.task(), self.sensors())
    }
}
