//! Whether a model is adequate, and why not.

use sindyna_core::Certainty;
use sindyna_core::number::significant;
use sindyna_record::identification::{Account, Equation, FreeRun, HeldOut, NoiseSource};

use super::most::MOST_ROWS;
use crate::document::Block;
use crate::numbers::{NONE, fixed, or_none, rough};
use crate::text::{diverged, horizon};

/// Warnings that are shown.
const MOST_WARNINGS: usize = 30;

/// The verdict in one sentence, reasons below it.
pub(super) fn blocks(account: &Account) -> Vec<Block> {
    let floor = match account.noise {
        NoiseSource::Estimated => "the estimated noise",
        NoiseSource::Declared => "the declared noise",
        _ => "rounding",
    };
    let verdict = match account.certainty() {
        Some(Certainty::Exact | Certainty::Adequate) => {
            format!("Adequate: the residuals of all equations are at the noise floor ({floor}).")
        }
        Some(Certainty::Ambiguous) => {
            format!(
                "Ambiguous: the residuals of all equations are at the noise floor ({floor}), but other sets of terms fit equally well, or may."
            )
        }
        Some(Certainty::Doubted) => "Approximation: not every equation is adequate.".into(),
        None => "Not assessed: no noise floor is known for this target.".into(),
    };
    let mut blocks = vec![Block::Verdict { good: account.explained, text: verdict }];
    let reasons = account.equations.iter().filter(|e| !e.reached_floor && e.residual.is_some());
    blocks.extend(reasons.filter_map(reason).take(MOST_WARNINGS).map(Block::text));
    let warnings = account.warnings.iter().take(MOST_WARNINGS);
    blocks.extend(warnings.map(|w| Block::text(format!("Warning: {}.", shortened(w)))));
    if !account.search_complete {
        blocks.push(Block::text("The search for terms reached its limit of operations."));
    }
    blocks
}

fn shortened(text: &str) -> String {
    text.trim_end_matches('.').chars().take(400).collect()
}

fn reason(equation: &Equation) -> Option<String> {
    let residual = equation.residual?;
    let unit = if equation.unit.is_empty() { String::new() } else { format!(" {}", equation.unit) };
    let state = &equation.state;
    let size = format!("Equation of {state}: residual RMSE {}{unit}", rough(residual));
    match (&equation.doubt, equation.floor > 0.0) {
        (Some(doubt), _) => Some(format!("{size}, {doubt}.")),
        (None, true) => Some(format!("{size}, {} times the noise floor.", rough(residual / equation.floor))),
        (None, false) => None,
    }
}

/// Residuals, noise and fit per state.
pub(super) fn quality(account: &Account) -> Block {
    let row = |equation: &Equation| {
        let noise = account.noise_deviations.iter().find(|n| n.state == equation.state);
        [
            equation.state.clone(),
            equation.unit.clone(),
            equation.residual.map_or_else(|| "kinematic".into(), rough),
            if equation.floor > 0.0 { rough(equation.floor) } else { NONE.into() },
            or_none(noise.map(|n| format!("{} {}", rough(n.sigma), n.unit).trim_end().to_owned())),
            or_none(noise.and_then(|n| n.fit_percent).map(|fit| fixed(fit, 1))),
        ]
    };
    let head = ["state", "unit of the rate", "residual RMSE", "noise floor", "noise, estimated", "fit [%]"];
    Block::table(2, head, account.equations.iter().take(MOST_ROWS).map(row).collect())
}

/// How well samples are predicted that the model was not fitted to.
pub(super) fn held_out(held_out: &HeldOut) -> Vec<Block> {
    let head = ["state", "window", "windows", "RMSE", "median RMSE", "fit [%]"].map(String::from).to_vec();
    let number =
        |list: &[(String, Option<f64>)], i: usize| or_none(list.get(i).and_then(|l| l.1).map(|v| significant(v, 3)));
    let row = |ahead: &FreeRun, i: usize| {
        let (state, fit) = &ahead.fit_percent[i];
        let (rmse, median) = (number(&ahead.rmse, i), number(&ahead.median_rmse, i));
        vec![state.clone(), horizon(ahead), ahead.windows.to_string(), rmse, median, or_none(fit.map(|v| fixed(v, 1)))]
    };
    let states = held_out.predictions.first().map_or(0, |ahead| ahead.fit_percent.len()).min(20);
    let rows = (0..states).flat_map(|i| held_out.predictions.iter().map(move |ahead| row(ahead, i))).collect();
    let of = if held_out.logs.is_empty() { String::new() } else { format!(" of {}", held_out.logs.join(", ")) };
    let mut blocks = vec![
        Block::Section("Hold-out validation".into()),
        Block::text(format!(
            "Predictions of {} steps{of} that were not used for fitting, in windows, each simulated from its first sample under the recorded inputs: RMSE and fit \
             percent, 100 (1 − NRMSE), over all windows, and the median of the RMSE of each.",
            held_out.steps
        )),
        Block::Table { words: 2, head, rows },
    ];
    let diverged = held_out.predictions.iter().filter(|ahead| ahead.diverged > 0).map(diverged);
    let failed = held_out.failed.iter().map(|why| format!("no further predictions: {why}"));
    blocks.extend(diverged.chain(failed).map(|line| Block::text(format!("{}.", capital(&line)))));
    blocks
}

fn capital(line: &str) -> String {
    let mut letters = line.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
