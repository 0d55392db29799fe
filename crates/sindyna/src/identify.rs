//! Identifying equations of motion from arrays or logged data.
//!
//! [`arrays`] takes recordings as they are in memory, [`log`] one that [`Log`] has read. Both give [`Found`]: the
//! model, and how far to believe it. [`Identifier`] has every setting; [`Sindy`] is the plain regression of
//! PySINDy.

mod as_read;
mod asked;
mod delay;
mod elsewhere;
mod for_task;
mod hypotheses;
mod unmeasured;

use sindyna_core::Spec;
pub use sindyna_record::identification::{Account, Equation, HeldOut};
use sindyna_sindy::Watch;
pub use sindyna_sindy::{
    Identified, Identifier, Library, Model, NoiseChoice, Recording, Signals, Sindy, SolverChoice, Stlsq, Target,
    Trajectory, export,
};

use crate::Error;
use crate::logs::{Log, Samples};

pub use as_read::recordings;
pub(crate) use asked::Asked;
pub use asked::Delay;
pub(crate) use elsewhere::elsewhere;
pub use for_task::of_log;
pub(crate) use for_task::{ForTask, for_task};
pub(crate) use hypotheses::{Looked, looked};
pub use unmeasured::Unmeasured;

/// Equations that were identified.
#[derive(Debug, Clone)]
pub struct Found {
    /// The equations, ready to simulate.
    pub model: Model,
    /// How far to believe them: terms, standard errors, residuals, as `identify.json` has it.
    pub account: Account,
}

impl Found {
    /// What `identified` says, found in data of the system `spec`.
    #[must_use]
    pub fn new(identified: Identified, spec: &Spec) -> Self {
        Self { account: Account::new(&identified, spec), model: identified.model }
    }

    /// The equations as text, one per state.
    #[must_use]
    pub fn equations(&self) -> Vec<String> {
        self.model.equations()
    }

    /// Whether the residuals of every equation are at the noise floor; `None` where that is not known.
    #[must_use]
    pub fn is_explained(&self) -> Option<bool> {
        self.account.explained
    }
}

/// Identifies equations in `recordings` of `signals`, sampled every `dt` \[s\] or about so often.
///
/// # Errors
/// [`Error::Signals`] if names are not unique, [`Error::Fit`] if no equations are found.
pub fn arrays(signals: &Signals, dt: f64, recordings: &[Recording]) -> Result<Found, Error> {
    let identifier = Identifier::of_signals(signals, dt)?;
    Ok(Found::new(identifier.identify_recordings(recordings)?, identifier.spec()))
}

/// Identifies equations in a log. Where these leave what no term explains, rates that were not measured are states, and inputs act earlier or later, if the data
/// speak for it.
///
/// # Errors
/// [`Error::Fit`] if no equations are found.
pub fn log(log: &Log) -> Result<Found, Error> {
    let kept = |log: &Log| Ok::<_, Error>(Samples { data: log.data.clone(), times: log.times.clone() });
    let asked = Asked {
        unmeasured: &Unmeasured::Auto,
        delay: Delay::Auto,
        kept: &kept,
        identifier: &|spec| Ok(Identifier::new(spec)),
        watch: &Watch::default(),
        say: &|_| {},
    };
    let Looked { found, log, .. } = looked(log.clone(), &asked)?;
    Ok(Found::new(found, &log.spec))
}
