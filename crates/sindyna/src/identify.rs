//! Identifying equations of motion from arrays or logged data.
//!
//! [`arrays`] takes recordings as they are in memory, [`log`] one that [`Log`] has read. Both give [`Found`]: the
//! model, and how far to believe it. [`Identifier`] has every setting; [`Sindy`] is the plain regression of
//! PySINDy.

mod unmeasured;

use sindyna_core::{Dataset, Rollout, Spec};
pub use sindyna_record::identification::{Account, Equation, HeldOut};
use sindyna_sindy::Watch;
pub use sindyna_sindy::{
    Identified, Identifier, Library, Model, NoiseChoice, Recording, Signals, Sindy, SolverChoice, Stlsq, Target,
    Trajectory, export,
};

use crate::Error;
use crate::logs::{Log, Samples};

pub use unmeasured::Unmeasured;
pub(crate) use unmeasured::with_rates;

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

/// Identifies equations in a log. Rates that were not measured are states where the data speak for it.
///
/// # Errors
/// [`Error::Fit`] if no equations are found.
pub fn log(log: &Log) -> Result<Found, Error> {
    let identifier = Identifier::new(&log.spec);
    let found = match &log.times {
        None => identifier.identify(&log.data)?,
        Some(times) => identifier.identify_recordings(&recordings(&log.data, times))?,
    };
    let kept = Samples { data: log.data.clone(), times: log.times.clone() };
    let choice = (Some(&found), &Unmeasured::Auto);
    let of = |spec: &Spec| Ok::<_, Error>(Identifier::new(spec));
    match with_rates(log, &kept, choice, of, &Watch::default())? {
        Some(with) => Ok(Found::new(with.found.clone(), &with.log(log).spec)),
        None => Ok(Found::new(found, &log.spec)),
    }
}

/// The trajectories of `data`, whose samples were taken at `times` since the start of each \[s\].
#[must_use]
pub fn recordings(data: &Dataset, times: &[Vec<f64>]) -> Vec<Recording> {
    let recording = |(rollout, times): (Rollout<'_>, &Vec<f64>)| Recording {
        times: times.clone(),
        states: rollout.observations.to_owned(),
        controls: rollout.controls.to_owned(),
    };
    data.rollouts().zip(times).map(recording).collect()
}
