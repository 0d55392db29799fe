//! `sindyna identify`: equations from logged data.

mod record;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde::Serialize;
use sindyna_core::{Channel, Dataset, FitError, Kind, Precision};
use sindyna_logs::{Log, Note, held_out};
use sindyna_record::identification::{Account, HeldOut};
use sindyna_record::json;
use sindyna_record::run::{RunDir, log_csv};
use sindyna_sindy::{Identifier, NoiseChoice, Watch};

use super::answer::{Answer, Verdict};
use super::common::Common;
use super::console::Console;
use super::identification::IdentificationOptions;
use super::reading::{ReadingOptions, STDIN, source};
use crate::cli::failure::Failure;
use crate::cli::interrupt::Interrupt;
use crate::cli::pages;
use crate::cli::progress::{Looking, Progress};
use crate::problem::{RECORDED_LOG, RECORDED_MODELS};
use crate::settings::IdentificationConfig;
use crate::training::{identified_bytes, predictions};
use record::{Document, Record};
use sindyna_core::number::{plural, significant};

/// Finds equations of motion in logged data, with no learning of a controller
///
/// LOG is a CSV file with a header: a row per sample, a column per state and input, and if there is one a column `t` with
/// the time in seconds. The input of a row is held until the next row. A column `trajectory` tells rollouts apart. Without
/// --states this asks which columns are what, and shows the call. Prints the equations with the standard errors of their
/// coefficients, and leaves a directory with model.json (for `sindyna export`), identify.json (the whole account) and report.html
/// (pictures of it).
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true, after_help = EXAMPLE)]
pub(crate) struct Args {
    /// CSV file with a header, `-` for standard input
    #[arg(value_name = "LOG")]
    log: PathBuf,
    #[command(flatten)]
    reading: ReadingOptions,
    #[command(flatten)]
    identification: IdentificationOptions,
    /// Share of the log, its last rows, that no equation sees and that predictions are compared with, such as 0.2
    #[arg(long, value_name = "SHARE", value_parser = share, help_heading = "Log")]
    holdout: Option<f64>,
    /// Leave out report.html
    #[arg(long)]
    no_report: bool,
    /// Exit with code 1 where the equations are an approximation
    #[arg(long)]
    strict: bool,
    /// Directory to make for the model [default: models/LOG, numbered if it exists]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

/// What to do about residuals that nothing explains.
const HELP: &str = "\
what may help: --limits STATE=LOW:HIGH where something stops or clips, --term FORMULA for a term that is missing, such as
               v*w*abs(w) or exp(-x), a log in which states and inputs move more
";

const EXAMPLE: &str = "\
Example:  sindyna identify examples/logs/pendulum.csv --states th,w --inputs u --angles th";

fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value < 1.0 => Ok(value),
        _ => Err("a share must be a number between 0 and 1".into()),
    }
}

/// What `--json` says of an identification.
#[derive(Serialize)]
struct Told<'a> {
    record: Option<&'a Path>,
    report: Option<PathBuf>,
    rows: usize,
    trajectories: usize,
    notes: Vec<String>,
    equations: Vec<String>,
    identification: &'a Document<'a>,
}

pub(crate) fn run(args: &Args, console: Console) -> Result<Answer, Failure> {
    if let Some(out) = &args.out {
        RunDir::refuse_existing(out, &FILES)?;
    }
    let mut settings = IdentificationConfig::default();
    args.identification.apply(&mut settings);
    args.identification.check(&settings)?;
    let interrupt = Interrupt::listen()?;
    let progress = Progress::new(console);
    let log = args.reading.read(&args.log)?;
    progress.say(&format!("read: {} rows, {} steps; looking for equations", log.rows, log.data.n_steps()));
    let identifier = settings.identifier(&log.spec)?;
    let identifier =
        if args.reading.is_without_noise() { identifier.with_noise(NoiseChoice::Rounding) } else { identifier };
    let (data, held_out) = match args.holdout {
        Some(share) => held_out(&log.data, share)?,
        None => (log.data.clone(), Dataset::new(log.data.observation_dim(), log.data.control_dim(), 1, log.data.dt())),
    };
    check_size(&identifier, &log, &data)?;
    progress.detail(|| {
        format!(
            "{} candidate terms, at least {} rows needed",
            identifier.terms().map_or(0, |terms| terms.len()),
            identifier.needed_rows()
        )
    });
    let found = args.common.pool()?.install(|| {
        let (go_on, looking) = (|| !interrupt.pressed(), Looking::new(&progress));
        identifier.identify_watched(&data, &Watch::going_on(&go_on).telling(&|stage| looking.tell(stage)))
    });
    progress.finish();
    let found = match found {
        Err(FitError::Interrupted) => {
            progress.say("interrupted: nothing was written");
            return Ok(Answer::silent(Verdict::Interrupted));
        }
        found => found.map_err(|e| explain(e, source(&args.log), &log))?,
    };
    let mut account = Account::new(&found, &log.spec);
    if held_out.n_steps() > 0 {
        account.held_out = Some(HeldOut::of(&found.model, &identifier.recordings(&held_out)?));
    }

    // What was found is told even if it cannot be written down.
    let record = Record::new(source(&args.log), &log.spec, settings);
    let document = Document { record: &record, account: &account };
    let predicted = predictions(&identifier, &found.model, &data, &log.spec).map(|table| table.to_csv()).transpose()?;
    let mut files = vec![
        ("config.toml", Some(toml::to_string(&record)?.into_bytes())),
        ("prediction.csv", predicted),
        ("model.json", Some(found.model.to_json().into_bytes())),
        (RECORDED_LOG, Some(log_csv(&log.spec, &log.data)?)),
        (RECORDED_MODELS, Some(identified_bytes(&found))),
        ("identify.json", Some(json(&document)?)),
    ];
    if !args.no_report {
        let page = pages::of_files(None, &files);
        files.insert(1, (pages::PAGE, page));
    }
    let written = write(args.out.as_deref(), &record, files);
    let mut text = heading(source(&args.log), &log) + "\n" + &sindyna_report::text::text(&account);
    if account.explained == Some(false) {
        text += HELP;
    }
    if let Ok(dir) = &written {
        let dir = dir.path().display();
        let _ = writeln!(text, "record: {dir} (model.json, identify.json, prediction.csv, config.toml)");
        if !args.no_report {
            let _ = writeln!(text, "report: {dir}/{}", pages::PAGE);
        }
        let _ = writeln!(text, "as a program: sindyna export {dir} --to python");
    }
    let missed = args.strict && account.explained != Some(true);
    let directory = written.as_ref().ok().map(RunDir::path);
    let told = Told {
        record: directory,
        report: directory.filter(|_| !args.no_report).map(|directory| directory.join(pages::PAGE)),
        rows: log.rows,
        trajectories: log.data.n_rollouts(),
        notes: log.notes.iter().map(ToString::to_string).collect(),
        equations: found.model.equations(),
        identification: &document,
    };
    let came_out = if missed { Verdict::MissedTarget } else { Verdict::Done };
    Ok(Answer::new(came_out, text, &told)?.and(written))
}

/// Refuses what could not be told apart, or not in reasonable time.
fn check_size(identifier: &Identifier, log: &Log, data: &Dataset) -> Result<(), Failure> {
    /// Candidate terms that are still searched in seconds.
    const MOST_TERMS: usize = 2_000;
    let terms = identifier.terms()?.len();
    if terms > MOST_TERMS {
        return Err(Failure::new(format!(
            "{terms} candidate terms are more than the {MOST_TERMS} that can be searched"
        ))
        .hint("name fewer states and inputs, or give fewer --term or another --library"));
    }
    let (steps, needed) = (data.n_steps(), identifier.needed_rows());
    if steps < needed {
        let (n, k) = (log.spec.state_dim(), log.spec.control_dim());
        return Err(Failure::new(format!(
            "{} rows make {steps} steps, too few: {n} states and {k} inputs need at least {needed}",
            log.rows
        ))
        .hint("give it a longer log"));
    }
    Ok(())
}

/// What can be done about data in which nothing was found.
fn explain(error: FitError, path: &Path, log: &Log) -> Failure {
    let limited = log.spec.state.iter().filter(|s| s.bounds.0.is_finite() || s.bounds.1.is_finite());
    let limited: Vec<String> = limited.map(|s| format!("`{}`", s.name)).collect();
    let hint = match &error {
        FitError::TooFewRows { .. } if !limited.is_empty() => format!(
            "steps that end at a limit or beyond it are left out: look at the --limits of {}, or give it a longer log",
            limited.join(", ")
        ),
        FitError::TooFewRows { .. } => "give it a longer log".into(),
        _ => log.doubts().unwrap_or_else(|| "other terms (--library, --term) or another --target may do".into()),
    };
    Failure::from(anyhow::Error::new(error).context(format!("no equations in {}", path.display()))).hint(hint)
}

/// What was read, and what was made of it.
fn heading(path: &Path, log: &Log) -> String {
    let spec = &log.spec;
    let state = |channel: &Channel| {
        let unit = if channel.unit.is_empty() { String::new() } else { format!(" [{}]", channel.unit) };
        match channel.kind {
            Kind::Angle => format!("{}{unit} (angle)", channel.name),
            Kind::RateOf(i) => format!("{}{unit} (rate of {})", channel.name, spec.state[i].name),
            _ => format!("{}{unit}", channel.name),
        }
    };
    let list = |channels: &[Channel]| match channels {
        [] => "none".to_owned(),
        channels => channels.iter().map(state).collect::<Vec<_>>().join(", "),
    };
    let mut text = format!(
        "log: {}, {} rows in {}, a step every {} s\nstates: {}; inputs: {}; numbers as fine as {}\n",
        path.display(),
        log.rows,
        plural(log.data.n_rollouts(), "rollout"),
        significant(spec.dt, 9),
        list(&spec.state),
        list(&spec.control),
        match spec.precision {
            Precision::F32 => "float32",
            Precision::F64 => "float64",
        }
    );
    for note in &log.notes {
        let _ = writeln!(text, "note: {note}{}", instead(note));
    }
    text
}

/// How to say otherwise than a note.
fn instead(note: &Note) -> &'static str {
    match note {
        Note::Circle { .. } => "; say --circles none to stop this",
        Note::Rate { .. } => "; say --rates none to stop this",
        Note::Rounded { .. } => "; say --precision f64 to stop this",
        _ => "",
    }
}

/// The files of a model's directory, in the order in which they are written.
const FILES: [&str; 7] =
    ["config.toml", pages::PAGE, "prediction.csv", "model.json", RECORDED_LOG, RECORDED_MODELS, "identify.json"];

fn write(out: Option<&Path>, record: &Record, files: Vec<(&'static str, Option<Vec<u8>>)>) -> Result<RunDir, Failure> {
    let files: Vec<(&str, Vec<u8>)> = files.into_iter().filter_map(|(name, bytes)| Some((name, bytes?))).collect();
    match out {
        Some(path) => Ok(RunDir::create(path, &files)?),
        None => {
            let stem = Path::new(&record.log).file_stem().filter(|_| record.log != STDIN);
            let name = stem.unwrap_or("log".as_ref());
            Ok(RunDir::create_numbered(&Path::new("models").join(name), &files)?)
        }
    }
}
