//! Logs as files, so that others get the very same data.

use std::fs;
use std::io::Write as _;
use std::path::Path;

use anyhow::Context as _;
use serde_json::json;

use super::judge::Judge;
use super::system::System;
use crate::log::Log;

/// Writes `log` as `STEM.csv` with 17 digits and what there is to know as `STEM.json` into `folder`: columns `trajectory`, `time`, the
/// states, the inputs. The last sample of a recording has no input: its cells are empty.
///
/// # Errors
/// If a file cannot be written.
pub fn export(folder: &Path, stem: &str, system: &System, log: &Log) -> anyhow::Result<()> {
    fs::create_dir_all(folder)?;
    let judge = Judge::new(system)?;
    let mut csv = Vec::new();
    let names: Vec<String> = ["trajectory".to_owned(), "time".to_owned()].into_iter().chain(log.variables()).collect();
    writeln!(csv, "{}", names.join(","))?;
    for (number, trajectory) in log.trajectories.iter().enumerate() {
        for (row, states) in trajectory.states.rows().into_iter().enumerate() {
            let time = trajectory.times.as_ref().map_or(row as f64 * log.dt, |times| times[row]);
            let input = |k: usize| match trajectory.controls.get((row, k)) {
                Some(value) => format!("{value:.16e}"),
                None => String::new(),
            };
            let cells = states.iter().map(|v| format!("{v:.16e}")).chain((0..log.controls.len()).map(input));
            let cells: Vec<String> = [number.to_string(), format!("{time:.16e}")].into_iter().chain(cells).collect();
            writeln!(csv, "{}", cells.join(","))?;
        }
    }
    let equations = system.equations()?;
    let term = |t: &crate::Term| json!({"text": t.text, "rate": t.rate, "coefficient": t.coefficient});
    let truth: Vec<Vec<_>> = equations.iter().map(|row| row.iter().map(term).collect()).collect();
    let about = json!({
        "system": system.name(), "dt": log.dt, "states": log.states, "roles": log.roles, "inputs": log.controls,
        "judged": system.judged().collect::<Vec<_>>(), "truth": truth, "bounds": judge.bounds(),
    });
    let write = |suffix: &str, content: &[u8]| {
        let path = folder.join(format!("{stem}.{suffix}"));
        fs::write(&path, content).with_context(|| format!("cannot write {}", path.display()))
    };
    write("csv", &csv)?;
    write("json", serde_json::to_string_pretty(&about)?.as_bytes())
}
