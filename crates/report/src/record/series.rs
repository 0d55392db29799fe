//! Measured and predicted signals of one record.

use std::collections::BTreeMap;

use sindyna_record::identification::{PredictionRow, PredictionTable, StateQuality};
use sindyna_record::run::EpisodeTable;

use super::most::{MOST_ROWS, MOST_STATES};
use crate::document::Block;
use crate::figure::plots::coverage;
use crate::figure::series::{Line, Series, series};
use crate::numbers::{measures, plural};
use crate::thin::{Point, range};

/// Points of all lines of a kind of figure, which bounds the size of a page.
const POINTS: usize = 2_400;

/// Panels of the coverage.
const PANELS: usize = 4;

/// Points of each of so many lines.
fn each(lines: usize) -> usize {
    (POINTS / lines.max(1)).clamp(120, 600)
}

/// Measured samples against one-step predictions and the free run.
pub(super) fn predictions(table: &PredictionTable, unmeasured: &[String]) -> Vec<Block> {
    let window = &table.rows[..table.window().min(table.rows.len())];
    if window.len() < 2 {
        return Vec::new();
    }
    let (times, borders) = clock(window);
    let many = window.iter().any(|row| row.trajectory != window[0].trajectory);
    let drawn = table.states.len().min(MOST_STATES);
    let figures = (0..drawn).map(|i| {
        let pieces = |of: &dyn Fn(&PredictionRow) -> Option<f64>| {
            let mut pieces: BTreeMap<usize, Vec<Point>> = BTreeMap::new();
            for (row, &t) in window.iter().zip(&times) {
                if let Some(value) = of(row) {
                    pieces.entry(row.trajectory).or_default().push((t, value));
                }
            }
            pieces.into_values().collect::<Vec<_>>()
        };
        let residual = |(row, &t): (&PredictionRow, &f64)| Some((t, row.states.get(i)? - row.one_step.get(i)?));
        let label = &table.states[i];
        let of = Series {
            label,
            time: if many { "t [s], trajectories one after another" } else { "t [s]" },
            lines: vec![
                Line { class: "measured", name: "measured", pieces: pieces(&|row| row.states.get(i).copied()) },
                Line { class: "c4 model", name: "one-step", pieces: pieces(&|row| row.one_step.get(i).copied()) },
                Line { class: "c0 model", name: "free run", pieces: pieces(&|row| row.free_run.get(i).copied()) },
            ],
            residuals: Some(("one-step residual", window.iter().zip(&times).filter_map(residual).collect())),
            borders: borders.clone(),
            most: each(drawn),
        };
        let caption = format!("{label}: measured, predicted one step ahead, and simulated from the first sample");
        series(format!("prediction-{i}"), format!("{label} against time, measured and predicted"), caption, &of)
    });
    let mut blocks = vec![
        Block::Section("Measured and predicted".into()),
        Block::text(
            "One-step prediction: each sample from the one before it. Free run: a simulation from the first sample of each \
             trajectory under the recorded inputs; that of a chaotic system diverges from the measured one even with exact equations. \
             Fit percent: 100 (1 − NRMSE).",
        ),
        quality(&table.quality(unmeasured)),
        Block::Figures(figures.collect()),
    ];
    if table.rows.len() > window.len() {
        blocks.push(Block::text(format!("The first {} samples are drawn.", window.len())));
    }
    if table.states.len() > drawn {
        blocks.push(Block::text(format!("The first {drawn} of {} states are drawn.", table.states.len())));
    }
    blocks
}

/// RMSE, R² and fit percent of every state.
fn quality(states: &[StateQuality]) -> Block {
    let row = |state: &StateQuality| {
        let [rmse, r2, fit] = measures(Some(&state.one_step));
        let [free_rmse, free_r2, free_fit] = measures(state.free_run.as_ref());
        [state.state.clone(), rmse, r2, fit, free_rmse, free_r2, free_fit]
    };
    let head = [
        "state",
        "one step: RMSE",
        "one step: R²",
        "one step: fit [%]",
        "free run: RMSE",
        "free run: R²",
        "free run: fit [%]",
    ];
    Block::table(1, head, states.iter().take(MOST_ROWS).map(row).collect())
}

/// Time of each row with trajectories one after another, and where they begin.
fn clock(rows: &[PredictionRow]) -> (Vec<f64>, Vec<f64>) {
    let gap =
        rows.windows(2).filter(|p| p[0].trajectory == p[1].trajectory).map(|p| p[1].t - p[0].t).next().unwrap_or(0.0);
    let (mut times, mut borders, mut offset) = (Vec::new(), Vec::new(), 0.0);
    for (row, before) in rows.iter().zip(std::iter::once(None).chain(rows.iter().map(Some))) {
        if before.is_some_and(|before| before.trajectory != row.trajectory) {
            offset = times.last().copied().unwrap_or(0.0) + gap;
            borders.push(offset);
        }
        times.push(offset + row.t);
    }
    if borders.len() > 20 {
        borders.clear();
    }
    (times, borders)
}

/// Where the samples are.
pub(super) fn coverages(table: &PredictionTable) -> Vec<Block> {
    let (n, k) = (table.states.len(), table.inputs.len());
    let rows: Vec<&PredictionRow> = table.rows.iter().filter(|row| row.inputs.len() == k).collect();
    let column = |i: usize| -> Vec<f64> {
        let value = |row: &&PredictionRow| if i < n { row.states.get(i) } else { row.inputs.get(i - n) }.copied();
        rows.iter().filter_map(value).collect()
    };
    let label = |i: usize| if i < n { &*table.states[i] } else { &*table.inputs[i - n] };
    let states = (0..n).step_by(2).filter(|&i| n > 1 && i < n).map(|i| (i.min(n - 2), i.min(n - 2) + 1));
    let mut pairs: Vec<(usize, usize)> = states.take(PANELS - usize::from(k > 0)).collect();
    if k > 0 && n > 0 {
        pairs.push((n - 1, n));
    }
    let figures: Vec<_> =
        pairs.iter().map(|&(a, b)| coverage((label(a), &column(a)), (label(b), &column(b)))).collect();
    let ranges = (0..n + k).take(MOST_ROWS).filter_map(|i| {
        let (low, high) = range(column(i).into_iter())?;
        let shown = |v: f64| sindyna_core::number::significant(v, 4);
        Some([label(i).to_owned(), if i < n { "state" } else { "input" }.to_owned(), shown(low), shown(high)])
    });
    let mut blocks = vec![Block::Section("Coverage of the data".into())];
    blocks.push(Block::text(
        "The range of each signal, and where the measured samples are: a dot for each, in the plane of two states (the phase plane, where one is the \
         rate of the other) and of a state and an input. Equations are compared with data only there.",
    ));
    blocks.push(Block::table(2, ["signal", "", "lowest", "highest"], ranges.collect()));
    if !figures.is_empty() {
        blocks.push(Block::Figures(figures));
    }
    blocks
}

/// States and inputs of an episode over the model's prediction.
pub(super) fn episode(episode: &EpisodeTable) -> Vec<Block> {
    let (n, k) = (episode.states.len(), episode.inputs.len());
    let drawn = n.min(MOST_STATES) + k.min(PANELS);
    let signals = (0..n.min(MOST_STATES)).chain(n..n + k.min(PANELS));
    let figures = signals.map(|i| {
        let label = if i < n { &episode.states[i] } else { &episode.inputs[i - n] };
        let real: Vec<Point> = episode
            .rows
            .iter()
            .filter_map(|row| Some((row.t, if i < n { *row.states.get(i)? } else { *row.inputs.get(i - n)? })))
            .collect();
        let model: Vec<Point> = episode
            .rows
            .iter()
            .filter_map(|row| {
                Some((row.t, if i < n { *row.model_states.get(i)? } else { *row.model_inputs.get(i - n)? }))
            })
            .collect();
        let of = Series {
            label,
            time: "t [s]",
            lines: vec![
                Line { class: "measured", name: "measured", pieces: vec![real] },
                Line { class: "c0 model", name: "model", pieces: vec![model] },
            ],
            residuals: None,
            borders: Vec::new(),
            most: each(drawn),
        };
        let caption = format!("{label}: measured on the system, and the model's prediction under the same policy");
        series(format!("episode-{i}"), format!("{label} in one episode"), caption, &of)
    });
    let steps = plural(episode.rows.len().saturating_sub(1), "step");
    let total: f64 = episode.rows.iter().filter_map(|row| row.reward).sum();
    let text = format!(
        "The first episode of the evaluation has {steps} and the return {}. The model predicts it from the same start state.",
        crate::numbers::fixed(total, 1)
    );
    vec![Block::text(text), Block::Figures(figures.collect())]
}
