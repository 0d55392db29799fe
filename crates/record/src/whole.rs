//! Whole records: what a directory holds of one identification or one run.

use std::path::Path;

use sindyna_sindy::Model;

use crate::identification::{Account, PredictionTable, read_model};
use crate::run::{EpisodeTable, Moment, Summary};
use crate::{RecordError, TableError};

/// What the directory of an identification holds. What its version of the program did not write is `None`.
#[derive(Debug, Clone)]
pub struct ModelRecord {
    /// The account of the identification.
    pub account: Account,
    /// The model.
    pub model: Option<Model>,
    /// What it predicts for the data.
    pub prediction: Option<PredictionTable>,
}

/// What the directory of a run holds. What its version of the program did not write is `None`.
#[derive(Debug, Clone)]
pub struct RunRecord {
    /// The run in numbers.
    pub summary: Summary,
    /// The identification of the model.
    pub identified: Option<ModelRecord>,
    /// The model, where there is no account of it.
    pub model: Option<Model>,
    /// What happened during training.
    pub moments: Vec<Moment>,
    /// The first episode of the evaluation.
    pub episode: Option<EpisodeTable>,
}

/// The file called so, if there is one.
type Files<'a> = &'a dyn Fn(&str) -> Result<Option<String>, RecordError>;

impl ModelRecord {
    /// Reads the record of an identification in `directory`; `None` if there is none.
    ///
    /// # Errors
    /// [`RecordError`] for files that cannot be read or understood.
    pub fn read(directory: &Path) -> Result<Option<Self>, RecordError> {
        Self::of(directory, &|name| read(directory, name))
    }

    /// The record that `files` are, which lie in `directory` or will.
    ///
    /// # Errors
    /// [`RecordError`] for files that cannot be read or understood.
    pub fn of(directory: &Path, files: Files<'_>) -> Result<Option<Self>, RecordError> {
        let Some(account) = files("identify.json")? else { return Ok(None) };
        let account = Account::from_json(&account).map_err(malformed(directory, "identify.json"))?;
        let model = model(directory, files)?;
        let of_csv = |text: String, n| PredictionTable::from_csv(&text, n);
        let prediction = table(directory, files, "prediction.csv", model.as_ref(), of_csv)?;
        Ok(Some(Self { account, model, prediction }))
    }
}

impl RunRecord {
    /// Reads the record of a run in `directory`; `None` if there is none.
    ///
    /// # Errors
    /// [`RecordError`] for files that cannot be read or understood.
    pub fn read(directory: &Path) -> Result<Option<Self>, RecordError> {
        Self::of(directory, &|name| read(directory, name))
    }

    /// The record that `files` are, which lie in `directory` or will.
    ///
    /// # Errors
    /// [`RecordError`] for files that cannot be read or understood.
    pub fn of(directory: &Path, files: Files<'_>) -> Result<Option<Self>, RecordError> {
        let Some(summary) = files("summary.json")? else { return Ok(None) };
        let summary = Summary::from_json(&summary).map_err(malformed(directory, "summary.json"))?;
        let model = model(directory, files)?;
        let of_csv = |text: String, n| EpisodeTable::from_csv(&text, n);
        Ok(Some(Self {
            summary,
            identified: ModelRecord::of(directory, files)?,
            moments: files("events.jsonl")?.map_or_else(Vec::new, |text| Moment::all(&text)),
            episode: table(directory, files, "episode.csv", model.as_ref(), of_csv)?,
            model,
        }))
    }
}

fn model(directory: &Path, files: Files<'_>) -> Result<Option<Model>, RecordError> {
    let read = |text: String| read_model(&text).map_err(malformed(directory, "model.json"));
    files("model.json")?.map(read).transpose()
}

/// The table in the file `name`, whose columns follow from the states of the model.
fn table<T>(
    directory: &Path,
    files: Files<'_>,
    name: &str,
    model: Option<&Model>,
    read: impl Fn(String, usize) -> Result<T, TableError>,
) -> Result<Option<T>, RecordError> {
    let (Some(text), Some(model)) = (files(name)?, model) else { return Ok(None) };
    read(text, model.states().len()).map(Some).map_err(malformed(directory, name))
}

fn read(directory: &Path, name: &str) -> Result<Option<String>, RecordError> {
    let path = directory.join(name);
    match std::fs::read_to_string(&path) {
        Ok(text) => Ok(Some(text)),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(e) => Err(RecordError::io("read", path)(e)),
    }
}

fn malformed<E: std::error::Error + Send + Sync + 'static>(
    directory: &Path,
    name: &str,
) -> impl FnOnce(E) -> RecordError {
    let path = directory.join(name);
    move |e| RecordError::Malformed { path, source: Box::new(e) }
}
