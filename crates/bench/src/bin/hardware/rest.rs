//! Swing-ups simulated from rest under the torques that were recorded.

use std::fs;
use std::path::Path;

use anyhow::{Context as _, bail};
use ndarray::{Array2, s};
use serde::{Deserialize, Serialize};
use sindyna_bench::study::Result;
use sindyna_core::InterSample;
use sindyna_sindy::{Inputs, Model};

use super::identified::Run;

/// How long is simulated \[s\].
pub(crate) const SPANS: [f64; 3] = [1.0, 2.0, 4.0];

/// One swing-up.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct FromRest {
    pub(crate) log: String,
    /// Root mean square of the errors of both angles over each span \[rad\]; none where the model diverges.
    pub(crate) errors: Vec<Option<f64>>,
}

/// The log at `path`, simulated by the equations of `run` from its first sample.
pub(crate) fn from_rest(run: &Run, path: &Path) -> Result<FromRest> {
    let model = Model::from_json(&run.model)?;
    let (states, inputs) = (model.states().to_vec(), model.controls().to_vec());
    let log = read(path, &[&["time".to_owned()][..], &states, &inputs].concat())?;
    let (time, n) = (log.column(0).to_vec(), states.len());
    let rows = time.iter().take_while(|t| **t - time[0] <= SPANS[SPANS.len() - 1]).count();
    let late = run.delay.round().max(0.0) as usize;
    let u = Array2::from_shape_fn((rows, inputs.len()), |(row, j)| log[[row.saturating_sub(late), 1 + n + j]]);
    let start = u.slice(s![..rows - 1, ..]);
    let end = run.linear.then(|| u.slice(s![1.., ..]));
    let dt: Vec<f64> = time[..rows].windows(2).map(|pair| pair[1] - pair[0]).collect();
    let x = model
        .simulate_at(&log.slice(s![0, 1..=n]).to_vec(), Inputs { start, end, intersample: InterSample::Foh }, &dt)
        .ok();
    let error = |span: &f64| {
        let x = x.as_ref()?;
        let rows = time[..rows].iter().take_while(|t| **t - time[0] <= *span).count();
        let angles = n / 2;
        let square = |(row, i): (usize, usize)| (x[[row, i]] - log[[row, 1 + i]]).powi(2);
        let all = (0..rows).flat_map(|row| (0..angles).map(move |i| (row, i)));
        Some((all.map(square).sum::<f64>() / (rows * angles) as f64).sqrt())
    };
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(FromRest { log: name, errors: SPANS.iter().map(error).collect() })
}

/// These columns of a log.
fn read(path: &Path, columns: &[String]) -> Result<Array2<f64>> {
    let text = fs::read_to_string(path).with_context(|| format!("no {}", path.display()))?;
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().context("an empty log")?.split(',').collect();
    let place = |name: &String| header.iter().position(|h| h == name).with_context(|| format!("no column {name}"));
    let places = columns.iter().map(place).collect::<Result<Vec<_>>>()?;
    let mut values = Vec::new();
    for line in lines {
        let fields: Vec<&str> = line.split(',').collect();
        for &at in &places {
            values.push(fields.get(at).context("too few fields")?.trim().parse::<f64>()?);
        }
    }
    if values.is_empty() {
        bail!("{} has no rows", path.display());
    }
    Ok(Array2::from_shape_vec((values.len() / places.len(), places.len()), values)?)
}
