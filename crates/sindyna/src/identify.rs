//! Identifying equations of motion from arrays or logged data.
//!
//! [`arrays`] takes recordings in memory, [`log()`] a log that [`Log`] has read. Both return [`Found`]: the model, with
//! standard errors and doubts. [`Identifier`] has every setting; [`Sindy`] is the plain regression of PySINDy.

mod ahead;
mod as_pieces;
mod as_read;
mod asked;
mod between;
mod changed;
mod delay;
mod derivatives;
mod differences;
mod elsewhere;
mod explored;
mod for_task;
mod gradual;
mod hypotheses;
mod lag;
mod lateness;
mod likeliest;
mod looked;
mod named;
mod reading;
mod readings;
mod robot;
mod trial;
mod turnable;
mod turning;
mod unmeasured;

use sindyna_core::Spec;
pub use sindyna_record::identification::{Account, Equation, HeldOut};
use sindyna_sindy::Watch;
pub use sindyna_sindy::{
    Identified, Identifier, Library, Model, NoiseChoice, Recording, Signals, Sindy, SolverChoice, Stlsq, Target,
    Trajectory, export,
};

use crate::Error;
use crate::logs::Log;

pub use as_read::recordings;
pub(crate) use asked::Asked;
pub use asked::{Delay, Lag};
pub(crate) use elsewhere::elsewhere;
pub use for_task::of_log;
pub(crate) use for_task::{ForTask, for_task};
pub(crate) use hypotheses::looked;
pub(crate) use looked::Looked;
pub use robot::{Matched, RobotError, RobotFound, motions, robot};
pub use unmeasured::Unmeasured;

/// Identified equations.
#[derive(Debug, Clone)]
pub struct Found {
    /// The equations, ready to simulate.
    pub model: Model,
    /// Their terms, standard errors, residuals and doubts, as in `identify.json`.
    pub account: Account,
}

impl Found {
    /// From `identified`, of data of the system `spec`.
    #[must_use]
    pub fn new(identified: Identified, spec: &Spec) -> Self {
        Self { account: Account::new(&identified, spec), model: identified.model }
    }

    /// The equations as text, one per state.
    #[must_use]
    pub fn equations(&self) -> Vec<String> {
        self.model.equations()
    }

    /// Whether the residuals of every equation are at the noise floor; `None` if the floor is not known.
    #[must_use]
    pub fn is_explained(&self) -> Option<bool> {
        self.account.explained
    }
}

/// Identifies equations from `recordings` of `signals` with a sampling interval of about `dt` \[s\].
///
/// # Errors
/// [`Error::Signals`] if names are not unique, [`Error::Fit`] if no equations are found.
pub fn arrays(signals: &Signals, dt: f64, recordings: &[Recording]) -> Result<Found, Error> {
    let identifier = Identifier::of_signals(signals, dt)?;
    Ok(Found::new(identifier.identify_recordings(recordings)?, identifier.spec()))
}

/// Identifies equations from a log. If they leave residuals that no term explains, unmeasured rates, delays and lags of inputs and first-order hold are tried, and used if the data
/// support them.
///
/// # Errors
/// [`Error::Fit`] if no equations are found.
pub fn log(log: &Log) -> Result<Found, Error> {
    let kept = |log: &Log| Ok::<_, Error>(log.samples());
    let asked = Asked {
        unmeasured: &Unmeasured::Auto,
        delay: Delay::Auto,
        lag: Lag::Auto,
        intersample: None,
        kept: &kept,
        identifier: &|spec| Ok(Identifier::new(spec)),
        watch: &Watch::default(),
        say: &|_| {},
    };
    let Looked { found, log, .. } = looked(log.clone(), &asked)?;
    Ok(Found::new(found, &log.spec))
}
