//! results/hardware.json and docs/hardware.md.

use serde::{Deserialize, Serialize};
use sindyna_bench::study::{Document, Page, Result, many, short};
use sindyna_core::number::fixed;

use super::identified::Run;
use super::intervals::covered;
use super::rest::{FromRest, SPANS};

/// The result file.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Figures {
    /// Simple pendulum: each log predicted by the equations of the two others.
    pub(crate) simple: Vec<Run>,
    /// Double pendulum: equations of two logs and of two seconds, which predict the others.
    pub(crate) double: Vec<Run>,
    /// Double pendulum: equations of all logs, which predict swing-ups.
    pub(crate) all: Run,
    /// Each log by itself.
    pub(crate) simple_alone: Vec<Run>,
    pub(crate) double_alone: Vec<Run>,
    /// By which equations swing-ups are simulated from rest, and how well.
    pub(crate) swing_ups: Vec<(String, Vec<FromRest>)>,
}

/// docs/hardware.md.
pub(crate) fn page(document: &Document<Figures>) -> Result<String> {
    let figures = &document.figures;
    let runs = || figures.simple.iter().chain(&figures.double).chain([&figures.all]);
    let alone = || figures.simple_alone.iter().chain(&figures.double_alone);
    let diverged: usize = runs().flat_map(|run| &run.predictions).map(|p| p.diverged).sum();
    let windows: usize = runs().flat_map(|run| &run.predictions).map(|p| p.windows).sum();
    let coverage = |runs: &[Run]| {
        let (inside, all) = covered(runs);
        format!("{inside} of {all}")
    };
    let simple = figures.simple.iter().map(|run| {
        let of = |term: &str| run.coefficient("velocity", term);
        let value = |term: &str| {
            of(term).map_or_else(|| "—".into(), |c| format!("{} ± {}", fixed(c.value, 3), fixed(c.standard_error, 2)))
        };
        let ahead = |seconds| short(run.prediction("position", seconds).map(|p| p.median));
        vec![
            run.held_out.join(", "),
            many(run.rows),
            short(Some(run.seconds)),
            value("torque"),
            value("sign velocity"),
            value("velocity"),
            ahead(0.5),
            ahead(1.0),
        ]
    });
    let double = figures.double.iter().map(|run| {
        let ahead = |state, seconds| short(run.prediction(state, seconds).map(|p| p.median));
        vec![
            run.name(),
            many(run.rows),
            short(Some(run.seconds)),
            ahead("pos_meas1", 0.5),
            ahead("pos_meas2", 0.5),
            ahead("pos_meas1", 1.0),
            ahead("pos_meas2", 1.0),
        ]
    });
    let swing_ups = figures.swing_ups.iter().flat_map(|(name, logs)| {
        logs.iter().map(move |log| {
            let errors = log.errors.iter().map(|e| short(*e));
            [name.clone(), log.log.clone()].into_iter().chain(errors).collect::<Vec<String>>()
        })
    });
    let times = runs().chain(alone()).map(|run| vec![run.name(), many(run.rows), short(Some(run.seconds))]);
    let spans = SPANS.map(|span| format!("RMSE over {span} s [rad]"));
    let head: Vec<String> = ["equations of".to_owned(), "swing-up".into()].into_iter().chain(spans).collect();
    let equations = |run: &Run| [vec![format!("# {}", run.name())], run.equations.clone()].concat();
    let lines: Vec<String> = runs().flat_map(equations).collect();
    Ok(Page::new("Logs of real pendulums")
        .text("A simple pendulum and a double pendulum of the DFKI Underactuated Lab (BSD-3-Clause): `torque_limited_simple_pendulum`, `data_measured.csv` of three controllers, and `double_pendulum`, four recordings of design C.1 and four swing-ups. Columns are named where the logs have others besides; no other option is given.")
        .list([
            format!("{} of {} windows of the logs held out diverge.", many(diverged), many(windows)),
            format!("95 % intervals of single logs that contain the estimate of another log: simple pendulum {}, double pendulum {}. Where both logs have the same errors, five of six are expected.", coverage(&figures.simple_alone), coverage(&figures.double_alone)),
        ])
        .section("Simple pendulum")
        .text("Each log is predicted by equations of the two others. Angle [rad]: median over windows of the RMS error. Terms of the acceleration, with standard errors.")
        .table(&["held out", "rows", "time [s]", "torque", "sign velocity", "velocity", "0.5 s", "1 s"], simple)
        .section("Double pendulum")
        .text("Medians over windows of the logs that were not used [rad].")
        .table(&["equations of", "rows", "time [s]", "0.5 s, shoulder", "elbow", "1 s, shoulder", "elbow"], double)
        .text("Swing-ups by differential dynamic programming (`leaderboard`, real hardware v2), simulated from the first sample under the measured torques; both angles. No swing-up was used in an identification.")
        .table(&head, swing_ups)
        .section("Times")
        .text("Wall time of the command on one thread.")
        .table(&["logs", "rows", "time [s]"], times)
        .section("Equations")
        .code(&lines)
        .section("How it was measured")
        .text(&document.made.origin("hardware"))
        .markdown())
}
