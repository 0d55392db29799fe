//! What everything that can be trained on has in common.

use std::sync::Arc;

use sindyna_core::{Dataset, Dynamics, Environment, Protocol, Sensors, Spec, Task};
use sindyna_sindy::Identified;

use crate::Error;

/// A system with a task on it.
pub trait Problem: Send + Sync {
    /// Names, units and bounds of the channels, control interval.
    fn spec(&self) -> &Spec;

    /// How policies are evaluated on it; no learner sees it.
    fn protocol(&self) -> Protocol;

    /// Start states, reward and termination: all the agent may know.
    fn task(&self) -> Arc<dyn Task>;

    /// The sensors that [`Self::spec`] declares.
    fn sensors(&self) -> Sensors;

    /// One such system; the first call must be a reset.
    ///
    /// # Errors
    /// [`Error`] if the system cannot be had.
    fn environment(&self) -> Result<Box<dyn Environment>, Error>;

    /// How many of it there can be at a time: 1 for hardware.
    fn copies(&self) -> usize {
        usize::MAX
    }

    /// The dynamics behind it, where they are known: those of a ground-truth simulator.
    fn dynamics(&self) -> Option<Arc<dyn Dynamics>> {
        None
    }

    /// The equations of motion, where they are known.
    fn true_equations(&self) -> Vec<String> {
        Vec::new()
    }

    /// All data that there will ever be, where the system itself is not at hand: as its sensors showed them, with the rewards of the task.
    fn log(&self) -> Option<&Dataset> {
        None
    }

    /// What was identified in [`Self::log`] before.
    fn identified(&self) -> Option<&Identified> {
        None
    }

    /// Refuses to go on where the task itself failed: one that is made of someone else's functions may.
    ///
    /// # Errors
    /// [`Error::System`].
    fn check(&self) -> Result<(), Error> {
        Ok(())
    }

    /// Files that a record of a run needs to run it again: name and contents.
    ///
    /// # Errors
    /// [`Error`] if they cannot be made.
    fn files(&self) -> Result<Vec<(&'static str, Vec<u8>)>, Error> {
        Ok(Vec::new())
    }
}
