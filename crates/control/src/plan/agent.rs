//! Planners where an agent is asked for.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use ndarray::{ArrayView2, ArrayViewMut2};
use sindyna_core::{
    Agent, AgentError, Batch, Checkpoint, CheckpointError, Dynamics, Inverse, Mode, Policy, Rng, Task, TrainedPolicy,
};

use super::policy::{Method, Planner};
use crate::ControlError;

/// An agent that has nothing to learn: it plans in whatever model there is, by one method or by each of several.
pub struct Planners {
    methods: Vec<Method>,
    task: Arc<dyn Task>,
    stop: Arc<AtomicBool>,
}

impl Planners {
    /// Planners for `task` by each of `methods`, which end soon after `stop` is set.
    ///
    /// # Errors
    /// [`ControlError::Unseen`] if a state is not observed.
    pub fn new(methods: &[Method], task: Arc<dyn Task>, stop: Arc<AtomicBool>) -> Result<Self, ControlError> {
        Inverse::of(task.spec())?;
        Ok(Self { methods: methods.to_vec(), task, stop })
    }

    /// The planner in `model`, for measurements with errors of the standard deviations `noise` (n; none for exact ones).
    ///
    /// # Errors
    /// [`ControlError::Unseen`] if a state is not observed.
    pub fn planner(&self, method: Method, model: Arc<dyn Dynamics>, noise: &[f64]) -> Result<Planner, ControlError> {
        let planner = Planner::new(method, model, self.task.clone())?;
        Ok(planner.with_noise(noise).with_stop(self.stop.clone()).prepared())
    }
}

impl Policy for Planners {
    /// The first action there is: without a model nothing can be planned.
    fn act_batch(&self, _: ArrayView2<'_, f64>, _: Mode, _: &mut Rng, mut actions: ArrayViewMut2<'_, f64>) {
        actions.fill(0.0);
    }
}

impl Checkpoint for Planners {
    fn save(&self) -> Vec<u8> {
        Vec::new()
    }

    fn restore(&mut self, _saved: &[u8]) -> Result<(), CheckpointError> {
        Ok(())
    }
}

impl Agent for Planners {
    fn name(&self) -> &'static str {
        match self.methods[..] {
            [method] => method.name(),
            _ => "auto",
        }
    }

    fn learn(&mut self, _batch: &Batch, _rng: &mut Rng) -> Result<(), AgentError> {
        Ok(())
    }

    fn plans(&self) -> bool {
        true
    }

    fn plan(&self, model: &Arc<dyn Dynamics>, noise: &[f64]) -> Vec<(&'static str, Arc<dyn TrainedPolicy>)> {
        let mut all: Vec<(&'static str, Arc<dyn TrainedPolicy>)> = Vec::new();
        for &method in &self.methods {
            let Ok(planner) = self.planner(method, model.clone(), noise) else { continue };
            let several = self.methods.len() > 1;
            let enough = several && planner.is_enough();
            // Where the regulator falls short, iLQR holds as it does and finds ways.
            if enough || !several || method != Method::Lqr {
                all.push((method.name(), Arc::new(planner)));
            }
            if enough {
                break;
            }
        }
        all
    }

    fn policy(&self) -> Arc<dyn TrainedPolicy> {
        Arc::new(Still)
    }

    fn read_policy(&self, _bytes: &[u8]) -> Result<Arc<dyn TrainedPolicy>, CheckpointError> {
        Err(CheckpointError::new("a planner is made of its model"))
    }
}

/// The policy of planners without a model.
struct Still;

impl Policy for Still {
    fn act_batch(&self, _: ArrayView2<'_, f64>, _: Mode, _: &mut Rng, mut actions: ArrayViewMut2<'_, f64>) {
        actions.fill(0.0);
    }
}

impl TrainedPolicy for Still {
    fn to_bytes(&self) -> Vec<u8> {
        Vec::new()
    }
}

impl TrainedPolicy for Planner {
    /// The name of the method: the rest is the model's and the task's.
    fn to_bytes(&self) -> Vec<u8> {
        self.method().name().into()
    }
}
