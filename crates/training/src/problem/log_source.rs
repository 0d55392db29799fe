//! A log with what was identified in it: where it is, and how it is read for a task.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Deserialize;
use sindyna_core::{Kind, Precision, Spec};
use sindyna_logs::{Clock, Log, LogOptions, Note};
use sindyna_record::run::log_csv;
use sindyna_sindy::Identified;

use super::turning::angles_among;
use crate::Error;
use crate::known::{identified_bytes, identified_of};
use crate::settings::{DataConfig, PrecisionName, RECORDED_LOG, RECORDED_MODELS};

/// A log as an identification understood it, and what it found.
#[derive(Debug, Clone)]
pub struct LogSource {
    log: Kept,
    models: Kept,
    /// Sampling interval \[s\]; of samples that are not evenly spaced the median.
    dt: f64,
    /// Time after which inputs begin to act \[s\].
    delay: f64,
    /// Time constant of the lag through which they act \[s\]; 0 for none.
    lag: f64,
    /// How finely the states were recorded.
    precision: Precision,
}

/// Where the contents of a file are.
#[derive(Debug, Clone)]
enum Kept {
    File(PathBuf),
    Here(PathBuf, Arc<[u8]>),
}

/// What a [`LogSource`] holds.
pub(super) struct Contents {
    /// The log with even steps: what is played.
    pub(super) log: Log,
    pub(super) identified: Identified,
    /// The files of a record: the log, what was identified.
    pub(super) files: [(&'static str, Vec<u8>); 2],
}

/// What is known of an identification besides its files.
#[derive(Deserialize)]
struct Known {
    dt: f64,
    precision: PrecisionName,
    /// Rows by which inputs act late.
    #[serde(default)]
    input_delay: f64,
    /// Time constant \[s\] of the lag through which they act.
    #[serde(default)]
    input_lag: f64,
}

impl LogSource {
    /// What `sindyna identify` left in `directory`.
    ///
    /// # Errors
    /// [`Error::NotIdentified`] if it left nothing there.
    pub fn of_model(directory: &Path) -> Result<Self, Error> {
        let refused = |why: String| Error::NotIdentified { path: directory.to_owned(), why };
        let path = directory.join("config.toml");
        let text =
            std::fs::read_to_string(&path).map_err(|e| refused(format!("cannot read {}: {e}", path.display())))?;
        let known: Known = toml::from_str(&text)
            .map_err(|e| refused(format!("{} is not that of an identification: {e}", path.display())))?;
        let (log, models) = (directory.join(RECORDED_LOG), directory.join(RECORDED_MODELS));
        if let Some(missing) = [&log, &models].into_iter().find(|path| !path.is_file()) {
            return Err(refused(format!("{}: no such file or directory", missing.display())));
        }
        let (log, models) = (Kept::File(log), Kept::File(models));
        let delay = (known.input_delay * known.dt).max(0.0);
        Ok(Self { log, models, dt: known.dt, delay, lag: known.input_lag, precision: known.precision.into() })
    }

    /// The `log` called `name` as it was read in the end, and what was found in it.
    ///
    /// # Errors
    /// [`Error`] if the log cannot be written down.
    pub fn found(name: &str, log: &Log, identified: &Identified) -> Result<Self, Error> {
        let (mut delay, mut lag) = (0.0, 0.0);
        for note in &log.notes {
            match note {
                // Inputs that were logged late act at once.
                Note::Delayed { seconds, .. } => delay = seconds.max(0.0),
                Note::Lagged { seconds, .. } => lag = *seconds,
                _ => {}
            }
        }
        let text = log_csv(&log.spec, &log.data, log.times.as_deref())?;
        Ok(Self {
            log: Kept::Here(name.into(), text.into()),
            models: Kept::Here(name.into(), identified_bytes(identified).into()),
            dt: log.spec.dt,
            delay,
            lag,
            precision: log.spec.precision,
        })
    }

    /// That of a record in `directory`.
    pub(super) fn of_record(data: &DataConfig, directory: &Path) -> Self {
        let file = |name: &String| Kept::File(directory.join(name));
        let (log, models) = (file(&data.log), file(&data.models));
        Self { log, models, dt: data.dt, delay: data.delay, lag: data.lag, precision: data.precision.into() }
    }

    /// Whether this build can read what was identified in the log: that of another build it cannot.
    #[must_use]
    pub fn is_identified(&self) -> bool {
        self.models.bytes().is_ok_and(|models| identified_of(&models).is_ok())
    }

    /// Where the log is.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.log.path()
    }

    /// Sampling interval \[s\]; of samples that are not evenly spaced the median.
    pub(crate) fn dt(&self) -> f64 {
        self.dt
    }

    /// Time after which inputs begin to act \[s\].
    pub(super) fn delay(&self) -> f64 {
        self.delay
    }

    /// Time constant of the lag through which they act \[s\]; 0 for none.
    pub(super) fn lag(&self) -> f64 {
        self.lag
    }

    /// How finely the states were recorded.
    pub(crate) fn precision(&self) -> Precision {
        self.precision
    }

    /// Those of the states `open` that are angles: by whole turns of which the equations are not changed.
    pub(super) fn angles_among(&self, open: &[usize]) -> Result<Vec<usize>, Error> {
        if open.is_empty() {
            return Ok(Vec::new());
        }
        let refused = |why: String| Error::NotIdentified { path: self.models.path().to_owned(), why };
        let identified = identified_of(&self.models.bytes()?).map_err(refused)?;
        Ok(angles_among(&identified.model, open))
    }

    /// Reads it for the system `spec`, whose states and inputs its columns are called as. Samples that are not evenly spaced are interpolated every `dt` \[s\]:
    /// equations are not found again, and a policy acts at even times.
    pub(super) fn read(&self, spec: &Spec, dt: f64) -> Result<Contents, Error> {
        let (log, models) = (self.log.bytes()?, self.models.bytes()?);
        let refused = |why: String| Error::NotIdentified { path: self.models.path().to_owned(), why };
        let identified = identified_of(&models).map_err(refused)?;
        let options = LogOptions {
            precision: Some(self.precision),
            missing: Some(Vec::new()),
            // It was written in seconds, however its source was.
            units: vec![("t".into(), "s".into())],
            ..columns(spec, LogOptions::default())
        };
        let read = |clock| {
            let options = LogOptions { clock, ..options.clone() };
            Log::read_from(self.log.path(), &log[..], &options)
        };
        let uneven = read(Clock::Stamps)?.times.is_some();
        let told = read(if uneven { Clock::Resampled(dt) } else { Clock::Given(self.dt) })?;
        same_signals(&identified, spec)?;
        Ok(Contents { log: told, identified, files: [(RECORDED_LOG, log), (RECORDED_MODELS, models)] })
    }
}

impl Kept {
    fn path(&self) -> &Path {
        match self {
            Self::File(path) | Self::Here(path, _) => path,
        }
    }

    fn bytes(&self) -> Result<Vec<u8>, Error> {
        match self {
            Self::Here(_, bytes) => Ok(bytes.to_vec()),
            Self::File(path) => std::fs::read(path)
                .map_err(|e| Error::NotIdentified { path: path.clone(), why: format!("cannot read it: {e}") }),
        }
    }
}

/// `options` with the columns that `spec` declares: states with their kinds and bounds, inputs.
pub(super) fn columns(spec: &Spec, options: LogOptions) -> LogOptions {
    let names = |is: &dyn Fn(Kind) -> bool| {
        spec.state.iter().filter(|c| is(c.kind)).map(|c| c.name.clone()).collect::<Vec<_>>()
    };
    let rates = spec.state.iter().filter_map(|c| match c.kind {
        Kind::RateOf(of) => Some((c.name.clone(), spec.state[of].name.clone())),
        _ => None,
    });
    let bounds = spec.state.iter().map(|c| (c.name.clone(), c.prior.bounds.0, c.prior.bounds.1));
    LogOptions {
        states: names(&|_| true),
        inputs: spec.control.iter().map(|c| c.name.clone()).collect(),
        angles: Some(names(&|kind| kind == Kind::Angle)),
        rates: Some(rates.collect()),
        circles: Some(Vec::new()),
        limits: bounds.filter(|(_, low, high)| low.is_finite() || high.is_finite()).collect(),
        ..options
    }
}

/// Refuses models of other states or inputs than the task declares.
fn same_signals(identified: &Identified, spec: &Spec) -> Result<(), Error> {
    let names = |channels: &[sindyna_core::Channel]| channels.iter().map(|c| c.name.clone()).collect::<Vec<_>>();
    for (what, theirs, ours) in [
        ("states", identified.model.states(), names(&spec.state)),
        ("inputs", identified.model.controls(), names(&spec.control)),
    ] {
        if theirs != ours {
            let mut why = format!("its {what} are {}, those of the model {}", ours.join(", "), theirs.join(", "));
            let more: Vec<&String> = theirs.iter().filter(|name| !ours.contains(name)).collect();
            if what == "states" && !more.is_empty() {
                let more = more.into_iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
                why += &format!(
                    "; the log supports {more} as an unmeasured rate: declare it as the last [[state]], with `rate_of`"
                );
            }
            return Err(Error::System { name: spec.name.clone(), why });
        }
    }
    Ok(())
}
