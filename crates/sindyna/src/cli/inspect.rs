//! `sindyna inspect`: what a log has to offer, before anything is identified in it.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde::Serialize;
use sindyna_core::number::significant;
use sindyna_logs::{Inspection, Log, Signal};
use sindyna_record::save;
use sindyna_report::{Signal as Drawn, log_page, text::aligned};

use super::answer::{Answer, Verdict};
use super::console::width;
use super::reading::{ReadingOptions, heading, source};
use crate::cli::failure::Failure;

/// Show how logs are read, without identification
///
/// Reads logs as `sindyna identify` does, with the same options. Prints states, inputs and sampling intervals; the range and resolution of each signal, and
/// the share of its samples at each limit, where it may be clipped; the share of steps without motion; and the delay between inputs and states.
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true, after_help = EXAMPLE)]
pub(crate) struct Args {
    /// Logs of the same system, with one or more trajectories each; `-` for standard input
    #[arg(value_name = "LOG", required = true)]
    logs: Vec<PathBuf>,
    #[command(flatten)]
    reading: ReadingOptions,
    /// Page to write with plots of all signals, such as log.html
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
}

const EXAMPLE: &str = "\
Example:  sindyna inspect examples/logs/pendulum.csv --report log.html";

/// What `--json` says of a log.
#[derive(Serialize)]
struct Told<'a> {
    rows: usize,
    trajectories: usize,
    notes: Vec<String>,
    findings: Vec<String>,
    duration: f64,
    step: Step,
    stationary: f64,
    signals: Vec<ToldSignal<'a>>,
    responses: Vec<ToldResponse<'a>>,
    report: Option<&'a Path>,
}

#[derive(Serialize)]
struct Step {
    shortest: f64,
    median: f64,
    longest: f64,
}

#[derive(Serialize)]
struct ToldSignal<'a> {
    name: &'a str,
    unit: &'a str,
    lowest: f64,
    highest: f64,
    at_lowest: f64,
    at_highest: f64,
    error: Option<f64>,
    constant: bool,
}

#[derive(Serialize)]
struct ToldResponse<'a> {
    input: &'a str,
    state: &'a str,
    order: usize,
    delay: Option<f64>,
    delay_range: Option<(f64, f64)>,
    correlation: f64,
}

pub(crate) fn run(args: &Args) -> Result<Answer, Failure> {
    if let Some(file) = args.report.as_ref().filter(|file| file.symlink_metadata().is_ok()) {
        return Err(Failure::new(format!("{} exists already", file.display())).hint("name another file with --report"));
    }
    let log = args.reading.read(&args.logs)?;
    let logs: Vec<&Path> = args.logs.iter().map(|log| source(log)).collect();
    let seen = log.inspect();
    let lines = lines(&seen);
    let rows: Vec<[String; 6]> = seen.signals.iter().map(row).collect();
    let mut text =
        heading(&logs, &log) + "\n" + &aligned(&[&[HEAD.map(String::from)], &rows[..]].concat(), width()) + "\n";
    lines.iter().for_each(|line| text += &format!("{line}\n"));
    let mut written = Ok(());
    if let Some(file) = &args.report {
        let name = logs.iter().map(|log| log.display().to_string()).collect::<Vec<_>>().join(", ");
        let told: Vec<String> = heading(&logs, &log).lines().map(str::to_owned).chain(lines.iter().cloned()).collect();
        let page = log_page(&name, &told, (HEAD, rows), &drawn(&log)).html();
        written = save(file, page.as_bytes());
        if written.is_ok() {
            let _ = writeln!(text, "report: {}", file.display());
        }
    }
    let told = Told {
        rows: log.rows,
        trajectories: log.data.n_rollouts(),
        notes: log.notes.iter().map(ToString::to_string).collect(),
        findings: log.findings.iter().map(ToString::to_string).collect(),
        duration: seen.duration,
        step: Step { shortest: seen.steps.0, median: seen.steps.1, longest: seen.steps.2 },
        stationary: seen.stationary,
        signals: seen.signals.iter().map(told_signal).collect(),
        responses: seen
            .responses
            .iter()
            .map(|r| ToldResponse {
                input: &r.input,
                state: &r.state,
                order: r.order,
                delay: r.delay,
                delay_range: r.delay_range,
                correlation: r.correlation,
            })
            .collect(),
        report: args.report.as_deref().filter(|_| written.is_ok()),
    };
    Ok(Answer::new(Verdict::Done, text, &told)?.and(written.map_err(Failure::from)))
}

fn told_signal(signal: &Signal) -> ToldSignal<'_> {
    ToldSignal {
        name: &signal.name,
        unit: &signal.unit,
        lowest: signal.range.0,
        highest: signal.range.1,
        at_lowest: signal.at_ends.0,
        at_highest: signal.at_ends.1,
        error: signal.error,
        constant: signal.constant,
    }
}

const HEAD: [&str; 6] = ["signal", "lowest", "highest", "error", "at lowest", "at highest"];

fn row(signal: &Signal) -> [String; 6] {
    let unit = if signal.unit.is_empty() { String::new() } else { format!(" [{}]", signal.unit) };
    let name = format!("{}{unit}{}", signal.name, if signal.constant { " (constant)" } else { "" });
    let error = signal.error.map_or_else(|| "–".to_owned(), |e| significant(e, 2));
    let percent = |share: f64| format!("{} %", significant(100.0 * share, 2));
    let (low, high) = (significant(signal.range.0, 4), significant(signal.range.1, 4));
    [name, low, high, error, percent(signal.at_ends.0), percent(signal.at_ends.1)]
}

/// What there is to say besides the signals.
fn lines(seen: &Inspection) -> Vec<String> {
    let (shortest, median, longest) = seen.steps;
    let mut lines = vec![
        format!(
            "{} s, steps of {} s ({} to {} s)",
            significant(seen.duration, 3),
            significant(median, 4),
            significant(shortest, 4),
            significant(longest, 4)
        ),
        format!("states stay within their resolution in {} % of the steps", significant(100.0 * seen.stationary, 2)),
    ];
    lines.extend(seen.responses.iter().map(|r| {
        let what = if r.order == 2 { "the second derivative" } else { "the rate" };
        let range = r.delay_range.filter(|(first, last)| first < last);
        let range = range.map_or_else(String::new, |(first, last)| {
            format!(" ({} to {} s)", significant(first, 3), significant(last, 3))
        });
        let when = match r.delay {
            Some(delay) if delay < 0.0 => format!("most strongly {} s before its row{range}", significant(-delay, 3)),
            Some(delay) => format!("most strongly after {} s{range}", significant(delay, 3)),
            None => "with no distinct delay".to_owned(),
        };
        format!("{what} of {} follows {} {when} (correlation {})", r.state, r.input, significant(r.correlation, 2))
    }));
    lines
}

/// All signals against time, trajectories one after another.
fn drawn(log: &Log) -> Vec<Drawn> {
    let spec = &log.spec;
    let mut signals: Vec<Drawn> = spec
        .observation
        .iter()
        .chain(&spec.control)
        .map(|c| {
            let unit = if c.unit.is_empty() { String::new() } else { format!(" [{}]", c.unit) };
            Drawn { label: format!("{}{unit}", c.name), pieces: Vec::new() }
        })
        .collect();
    let mut begun = 0.0;
    for (number, rollout) in log.data.rollouts().enumerate() {
        let own = log.times.as_ref().and_then(|times| times.get(number));
        let time = |t: usize| begun + own.map_or(t as f64 * spec.dt, |times| times[t]);
        let columns = rollout.observations.columns().into_iter().chain(rollout.controls.columns());
        for (signal, column) in signals.iter_mut().zip(columns) {
            signal.pieces.push(column.iter().enumerate().map(|(t, v)| (time(t), *v)).collect());
        }
        begun = time(rollout.controls.nrows()) + spec.dt;
    }
    signals
}
