//! What an identification leaves: `config.toml` and `identify.json`.

use std::path::Path;

use serde::Serialize;
use sindyna_core::{Channel, InterSample, Kind, Precision, Spec};
use sindyna_logs::Note;
use sindyna_record::identification::Account;
use sindyna_training::settings::IdentificationConfig;

use crate::cli::reading::STDIN;

/// `config.toml`: everything to run an identification again.
#[derive(Debug, Serialize)]
pub(super) struct Record {
    version: &'static str,
    commit: &'static str,
    /// The logs, with commas between them.
    log: String,
    #[serde(skip)]
    name: String,
    dt: f64,
    /// Rows by which inputs act later than over the step after theirs, where they do; whatever uses the model must delay them so.
    #[serde(skip_serializing_if = "Option::is_none")]
    input_delay: Option<f64>,
    /// Time constant \[s\] of the first-order lag through which inputs act, where they do; whatever uses the model must filter them so.
    #[serde(skip_serializing_if = "Option::is_none")]
    input_lag: Option<f64>,
    /// Standard errors of these \[s\], where they were estimated and are no whole rows.
    #[serde(skip_serializing_if = "Option::is_none")]
    input_delay_error: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    input_lag_error: Option<f64>,
    /// What inputs do between rows, where they are not held.
    #[serde(skip_serializing_if = "Option::is_none")]
    intersample: Option<InterSample>,
    precision: &'static str,
    states: Vec<Named>,
    inputs: Vec<Named>,
    identification: IdentificationConfig,
}

/// A column as it was understood.
#[derive(Debug, Serialize)]
struct Named {
    name: String,
    unit: String,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    angle: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    rate_of: Option<String>,
    /// Largest magnitude in the log.
    scale: f64,
    /// Lowest and highest value it may have, where such were given.
    #[serde(skip_serializing_if = "Option::is_none")]
    limits: Option<(f64, f64)>,
    /// Standard deviation of its error, as given and as its digits show.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<f64>,
}

impl Record {
    /// What its directory is called if nobody says so.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    pub(super) fn new(paths: &[&Path], (spec, notes): (&Spec, &[Note]), identification: IdentificationConfig) -> Self {
        let error = |name: &str| {
            let mut shown = spec.observation.iter().zip(spec.noise_deviations());
            shown.find(|(o, deviation)| o.name == name && *deviation > 0.0).map(|(_, deviation)| deviation)
        };
        let named = |channel: &Channel| Named {
            name: channel.name.clone(),
            unit: channel.unit.clone(),
            angle: channel.kind == Kind::Angle,
            rate_of: match channel.kind {
                Kind::RateOf(i) => Some(spec.state[i].name.clone()),
                _ => None,
            },
            scale: channel.prior.scale,
            limits: (channel.prior.bounds.0.is_finite() || channel.prior.bounds.1.is_finite())
                .then_some(channel.prior.bounds),
            error: error(&channel.name),
        };
        Self {
            version: env!("CARGO_PKG_VERSION"),
            commit: sindyna_training::COMMIT,
            log: paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", "),
            name: name_of(paths),
            dt: spec.dt,
            input_delay: notes.iter().find_map(|note| match note {
                Note::Delayed { rows, .. } => Some(*rows),
                _ => None,
            }),
            input_lag: notes.iter().find_map(|note| match note {
                Note::Lagged { seconds, .. } => Some(*seconds),
                _ => None,
            }),
            input_delay_error: notes.iter().find_map(|note| match note {
                Note::Delayed { deviation, .. } => *deviation,
                _ => None,
            }),
            input_lag_error: notes.iter().find_map(|note| match note {
                Note::Lagged { deviation, .. } => *deviation,
                _ => None,
            }),
            intersample: notes.iter().find_map(|note| match note {
                Note::InterSample { intersample, .. } => Some(*intersample),
                _ => None,
            }),
            precision: match spec.precision {
                Precision::F32 => "f32",
                Precision::F64 => "f64",
            },
            states: spec.state.iter().map(named).collect(),
            inputs: spec.control.iter().map(named).collect(),
            identification,
        }
    }
}

/// What the directory of a model found in the logs at `paths` is called.
fn name_of(paths: &[&Path]) -> String {
    let stem =
        |path: &&Path| Some(path.file_stem()?.to_string_lossy().into_owned()).filter(|_| *path != Path::new(STDIN));
    let first = paths.first().and_then(stem).unwrap_or_else(|| "log".into());
    if paths.len() > 1 { format!("{first}-and-{}-more", paths.len() - 1) } else { first }
}

/// `identify.json`.
#[derive(Serialize)]
pub(super) struct Document<'a> {
    #[serde(flatten)]
    pub(super) record: &'a Record,
    #[serde(flatten)]
    pub(super) account: &'a Account,
}
