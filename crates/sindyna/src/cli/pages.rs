//! `report.html` of one record: of a run, or of an identification.

use std::path::{Path, PathBuf};

use sindyna_envs::System;
use sindyna_record::run::RunDir;
use sindyna_record::{ModelRecord, RecordError, RunRecord};
use sindyna_report::{Page, model_page, run_page};
use sindyna_sindy::Model;
use sindyna_training::settings::TrainConfig;

use crate::cli::failure::Failure;

/// The page's file in a record.
pub(crate) const PAGE: &str = "report.html";

/// The page of the record in `directory` whose files are read by `file`.
fn page(
    directory: &Path,
    file: &dyn Fn(&str) -> Result<Option<String>, RecordError>,
) -> Result<Option<Page>, RecordError> {
    if let Some(run) = RunRecord::of(directory, file)? {
        return Ok(Some(run_page(&run, file("config.toml")?.and_then(|text| system(&text)).as_ref())));
    }
    let Some(model) = ModelRecord::of(directory, file)? else { return Ok(None) };
    Ok(Some(model_page(&model, &source(&file("identify.json")?.unwrap_or_default()))))
}

/// The page of a record that is to be written with these `files`, and those that lie in `directory` already if there is one.
///
/// A page is a picture of the record: where it cannot be drawn, there is none.
pub(crate) fn of_files(directory: Option<&Path>, files: &[(&'static str, Option<Vec<u8>>)]) -> Option<Vec<u8>> {
    let read = |name: &str| match files.iter().find(|file| file.0 == name) {
        Some((_, contents)) => Ok(contents.as_ref().map(|bytes| String::from_utf8_lossy(bytes).into_owned())),
        None => Ok(directory.and_then(|directory| std::fs::read_to_string(directory.join(name)).ok())),
    };
    page(directory.unwrap_or(Path::new("")), &read).ok().flatten().map(|page| page.html().into_bytes())
}

/// Makes the page of the record in `directory` again; where it is.
pub(crate) fn again(directory: &Path) -> Result<PathBuf, Failure> {
    let dir = RunDir::reopen(directory)?;
    let found = RunRecord::read(directory)?.is_some() || ModelRecord::read(directory)?.is_some();
    if !found {
        return Err(Failure::new(format!("{} holds no results yet", directory.display()))
            .hint(format!("`sindyna train --resume {}` continues a run", directory.display())));
    }
    let Some(html) = of_files(Some(directory), &[]) else {
        return Err(Failure::new(format!("the record in {} cannot be read", directory.display())));
    };
    dir.write(PAGE, &html)?;
    Ok(directory.join(PAGE))
}

/// The true system of a run with the configuration `config`, where it is one that comes along.
pub(super) fn system(config: &str) -> Option<System> {
    TrainConfig::parse(config).ok()?.system()
}

/// The true equations beside those of `model`: in the form in which these were identified, or as they are written by hand where terms differ.
pub(super) fn truth(system: Option<&System>, model: Option<&Model>, by_hand: Vec<String>) -> Vec<String> {
    let same_form = system.zip(model).and_then(|(system, model)| sindyna_report::true_equations(system, model));
    same_form.unwrap_or(by_hand)
}

/// Name of the log that the text of an `identify.json` is about.
fn source(text: &str) -> String {
    let document: serde_json::Value = serde_json::from_str(text).unwrap_or_default();
    let log = document["log"].as_str().unwrap_or("a log").to_owned();
    Path::new(&log).file_name().map_or(log.clone(), |name| name.to_string_lossy().into_owned())
}
