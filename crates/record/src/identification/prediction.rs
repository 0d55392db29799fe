//! `prediction.csv`: measured samples and what the model predicts for them.

use sindyna_sindy::{Model, Recording};

use crate::table_csv::{Fields, number_rows, text_of};
use crate::{RecordError, TableError};

/// Samples that follow each other without a gap, from the first on.
const WINDOW: usize = 600;

/// Samples of the rest, evenly spread.
const SPREAD: usize = 900;

/// Measured samples beside one-step predictions and a free run of the model.
///
/// A row per sample: number of the trajectory, number of the sample in it, time from its start \[s\], the states as
/// measured, the inputs from this sample on, the one-step prediction (from the sample before), the free run
/// (from the first sample of the trajectory). The columns are in this order; a name has its unit behind it, such as
/// `θ [rad]`, and predictions say so: `θ [rad] (one-step)`, `θ [rad] (free run)`. A field is empty where there is no value.
/// Up to 1,500 samples are all there. Of more, the first 600, and 900 of the others, without a free run.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PredictionTable {
    /// The states with their units.
    pub states: Vec<String>,
    /// The inputs with their units.
    pub inputs: Vec<String>,
    /// One for each sample.
    pub rows: Vec<PredictionRow>,
}

/// One sample.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PredictionRow {
    /// Number of the trajectory.
    pub trajectory: usize,
    /// Number of the sample in its trajectory.
    pub sample: usize,
    /// Time since the start of the trajectory \[s\].
    pub t: f64,
    /// The states as measured (n).
    pub states: Vec<f64>,
    /// The inputs from this sample on (k); empty for the last one.
    pub inputs: Vec<f64>,
    /// Predicted from the sample before (n); empty where that is not possible.
    pub one_step: Vec<f64>,
    /// Predicted from the first sample of the trajectory (n); empty where that is not possible.
    pub free_run: Vec<f64>,
}

impl PredictionTable {
    /// What `model` predicts for `recordings` of `states` and `inputs`, whose names have their units behind them.
    #[must_use]
    pub fn of(model: &Model, recordings: &[Recording], states: Vec<String>, inputs: Vec<String>) -> Self {
        let samples: usize = recordings.iter().map(|r| r.states.nrows()).sum();
        let stride = samples.saturating_sub(WINDOW).div_ceil(SPREAD).max(1);
        let mut table = Self { states, inputs, rows: Vec::new() };
        let mut seen = 0;
        for (trajectory, recording) in recordings.iter().enumerate() {
            let mut free = recording.states.rows().into_iter().next().map(|row| row.to_vec()).unwrap_or_default();
            for sample in 0..recording.states.nrows() {
                let in_window = seen < WINDOW || stride == 1;
                seen += 1;
                if !in_window && !(seen - WINDOW).is_multiple_of(stride) {
                    continue;
                }
                if sample > 0 && in_window {
                    free = step(model, recording, sample, &free);
                }
                let before = sample.checked_sub(1).map(|i| recording.states.row(i).to_vec());
                table.rows.push(PredictionRow {
                    trajectory,
                    sample,
                    t: recording.times[sample] - recording.times[0],
                    states: recording.states.row(sample).to_vec(),
                    inputs: match sample < recording.controls.nrows() {
                        true => recording.controls.row(sample).to_vec(),
                        false => Vec::new(),
                    },
                    one_step: before.map_or_else(Vec::new, |x| step(model, recording, sample, &x)),
                    free_run: if in_window { free.clone() } else { Vec::new() },
                });
            }
        }
        table
    }

    /// The text of the file.
    ///
    /// # Errors
    /// [`RecordError::Csv`] if it cannot be written.
    pub fn to_csv(&self) -> Result<Vec<u8>, RecordError> {
        let predicted = |how: &'static str| self.states.iter().map(move |name| format!("{name} ({how})"));
        let head = ["trajectory", "sample", "t"].map(String::from).into_iter();
        let head = head.chain(self.states.iter().cloned()).chain(self.inputs.iter().cloned());
        let head: Vec<String> = head.chain(predicted("one-step")).chain(predicted("free run")).collect();
        let (n, k) = (self.states.len(), self.inputs.len());
        let rows = self.rows.iter().map(|row| {
            let mut fields = Fields::of([row.trajectory as f64, row.sample as f64, row.t]);
            fields.add(&row.states, n).add(&row.inputs, k).add(&row.one_step, n).add(&row.free_run, n);
            fields
        });
        text_of(&head, rows)
    }

    /// Reads the file, of a model with `n` states.
    ///
    /// # Errors
    /// [`TableError`] for any other text.
    pub fn from_csv(text: &str, n: usize) -> Result<Self, TableError> {
        let (head, rows) = number_rows(text, 3)?;
        let k = head.len().checked_sub(3 + 3 * n).ok_or(TableError::Columns { got: head.len(), needed: 3 + 3 * n })?;
        let row = |mut fields: Fields| PredictionRow {
            trajectory: fields.whole(),
            sample: fields.whole(),
            t: fields.take(1).first().copied().unwrap_or_default(),
            states: fields.take(n),
            inputs: fields.take(k),
            one_step: fields.take(n),
            free_run: fields.take(n),
        };
        Ok(Self {
            states: head[3..3 + n].to_vec(),
            inputs: head[3 + n..3 + n + k].to_vec(),
            rows: rows.into_iter().map(row).collect(),
        })
    }

    /// Number of the first rows that follow each other without a gap within their trajectories.
    #[must_use]
    pub fn window(&self) -> usize {
        let follows = |pair: &[PredictionRow]| {
            let (a, b) = (&pair[0], &pair[1]);
            b.sample == 0 || (a.trajectory == b.trajectory && b.sample == a.sample + 1)
        };
        self.rows.windows(2).take_while(|pair| follows(pair)).count() + usize::from(!self.rows.is_empty())
    }
}

/// The sample number `sample` of `recording` as it follows from the state `x` at the one before; nothing where the model
/// cannot be stepped.
fn step(model: &Model, recording: &Recording, sample: usize, x: &[f64]) -> Vec<f64> {
    if x.is_empty() {
        return Vec::new();
    }
    if sample > recording.steps() {
        return Vec::new();
    }
    let u = recording.inputs(sample - 1, sample);
    let dt = recording.times[sample] - recording.times[sample - 1];
    // Time stamps are sums of steps, whose rounding is no other interval.
    let dt = if (dt - model.dt()).abs() <= 1e-6 * model.dt() { model.dt() } else { dt };
    model.simulate_at(x, u, &[dt]).map_or_else(|_| Vec::new(), |states| states.row(1).to_vec())
}
