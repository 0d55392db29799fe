//! The trait of systems with a task.

use std::sync::Arc;

use sindyna_core::{Dataset, Dynamics, Environment, Protocol, Sensors, Spec, Task};
use sindyna_sindy::{Identified, Model};

use crate::Error;

/// A system with a task.
pub trait Problem: Send + Sync {
    /// Names, units and bounds of the channels, control interval.
    fn spec(&self) -> &Spec;

    /// How policies are evaluated on it; unknown to learners.
    fn protocol(&self) -> Protocol;

    /// Start states, reward and termination: all the agent may know.
    fn task(&self) -> Arc<dyn Task>;

    /// The sensors that [`Self::spec`] declares.
    fn sensors(&self) -> Sensors;

    /// One such system; the first call must be a reset.
    ///
    /// # Errors
    /// [`Error`] if the system is not available.
    fn environment(&self) -> Result<Box<dyn Environment>, Error>;

    /// How many copies may exist at a time: 1 for hardware.
    fn copies(&self) -> usize {
        usize::MAX
    }

    /// The true dynamics, if known: those of a ground-truth simulator.
    fn dynamics(&self) -> Option<Arc<dyn Dynamics>> {
        None
    }

    /// The equations of motion, if known.
    fn true_equations(&self) -> Vec<String> {
        Vec::new()
    }

    /// All data, if the system itself is not available: observations, with the rewards of the task.
    fn log(&self) -> Option<&Dataset> {
        None
    }

    /// Sampling interval \[s\] of what [`Self::log`] is made of, which may be shorter than the control interval.
    fn sampling_interval(&self) -> Option<f64> {
        self.log().map(Dataset::dt)
    }

    /// Time \[s\] after which controls begin to act.
    fn delay(&self) -> f64 {
        0.0
    }

    /// The same task on the system that moves as `model`, whose controls act late; `None` where they act at once.
    fn late(&self, model: &Model) -> Option<Arc<dyn Problem>> {
        let _ = model;
        None
    }

    /// Time constant \[s\] of the lag through which controls act; 0 for none. What actuators deliver are the last states, one for each control, which follow from the controls: no sensor shows them.
    fn lag(&self) -> f64 {
        0.0
    }

    /// What was identified from [`Self::log`] before.
    fn identified(&self) -> Option<&Identified> {
        None
    }

    /// Fails if the task itself failed, as user-defined functions may.
    ///
    /// # Errors
    /// [`Error::System`].
    fn check(&self) -> Result<(), Error> {
        Ok(())
    }

    /// Files that a record needs to repeat the run: names and contents.
    ///
    /// # Errors
    /// [`Error`] if they cannot be made.
    fn files(&self) -> Result<Vec<(&'static str, Vec<u8>)>, Error> {
        Ok(Vec::new())
    }
}
