//! `sindyna identify`: equations from logged data.

mod record;
mod robot;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use record::{Document, Record};
use serde::Serialize;
use sindyna_core::number::plural;
use sindyna_core::{Dataset, FitError, InterSample, Spec};
use sindyna_logs::{Log, Samples, held_out};
use sindyna_record::identification::{Account, HeldOut};
use sindyna_record::json;
use sindyna_record::run::{RunDir, log_csv};
use sindyna_sindy::{Identifier, NoiseChoice, Watch};
use sindyna_training::problem::{RECORDED_LOG, RECORDED_MODELS};
use sindyna_training::settings::IdentificationConfig;
use sindyna_training::{identified_bytes, predictions, timed};

use super::answer::{Answer, Verdict};
use super::common::Common;
use super::console::{Console, width};
use super::identification::IdentificationOptions;
use super::reading::{ReadingOptions, heading, pairs, source};
use crate::cli::failure::Failure;
use crate::cli::interrupt::Interrupt;
use crate::cli::pages;
use crate::cli::progress::{Looking, Progress};
use crate::identify::{Asked, Delay, Lag, Looked, Unmeasured, elsewhere, looked};

/// Identify equations of motion from logged data
///
/// LOG is a table with one row per sample, one column per state and input, and optionally a time column such as `t`: a CSV file with a header, an NPZ,
/// NPY or MAT file, or an MCAP, Parquet or HDF5 file if the program was built with them. The input of a row is held until the next row. A column
/// `trajectory`, gaps in time, and files separate trajectories. Without --states,
/// states and inputs are recognised by the names of the columns; where that is not possible, the error shows the call that names them. The equations
/// are printed with the standard errors of their coefficients; the output directory holds model.json (for `sindyna export`), identify.json
/// (all results) and report.html.
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true, after_help = EXAMPLE)]
pub(crate) struct Args {
    /// Logs of the same system, with one or more trajectories each; `-` for standard input
    #[arg(value_name = "LOG", required = true)]
    logs: Vec<PathBuf>,
    #[command(flatten)]
    reading: ReadingOptions,
    #[command(flatten)]
    identification: IdentificationOptions,
    /// Rates of states that were not measured, such as `w=th`, estimated with the equations; a column of that name is not used; or `none` [default: columns that
    /// are difference quotients of others, and where the equations leave residuals that no term explains and the data support such a rate]
    #[arg(long, value_name = "RATE=OF", value_delimiter = ',', help_heading = "Log")]
    unmeasured: Vec<String>,
    /// Delay of the inputs in rows; −1 for an input that acted over the step before its row [default: 0; estimated where the equations leave residuals that no
    /// term explains]
    #[arg(long, value_name = "ROWS", value_parser = delay, default_value = "auto", hide_default_value = true, help_heading = "Log")]
    delay: Delay,
    /// Lag of the inputs, behind an actuator of first order: its time constant in seconds [default: 0; estimated where the equations leave residuals that no term
    /// explains]
    #[arg(long, value_name = "S", value_parser = lag, default_value = "auto", hide_default_value = true, help_heading = "Log")]
    lag: Lag,
    /// Behavior of the inputs between samples: `zoh` (zero-order hold, constant), `foh` (first-order hold, linear) or `bl` (band-limited, smooth) [default: zoh;
    /// foh or bl where the equations leave residuals that no term explains and the data support it]
    #[arg(long, value_name = "HOLD", value_parser = intersample, help_heading = "Log")]
    intersample: Option<InterSample>,
    /// Hold-out data for validation: the last share of the log, such as 0.2, or another log of the same system; may be repeated for several logs
    #[arg(long, value_name = "SHARE|LOG", value_parser = holdout, help_heading = "Log")]
    holdout: Vec<Holdout>,
    /// URDF file of the robot: the parameters of its links and joints (masses, inertias, damping, friction, armature) are identified instead of equations, and written into a copy of the
    /// file. Columns are those of joints with their names, else in the order of the joints; forces in N m and N
    #[arg(long, value_name = "FILE", help_heading = "Robot", conflicts_with_all = NOT_OF_ROBOTS)]
    urdf: Option<PathBuf>,
    /// MJCF file of the robot, as with --urdf; inputs are those of its motors, with their gears
    #[arg(long, value_name = "FILE", help_heading = "Robot", conflicts_with = "urdf", conflicts_with_all = NOT_OF_ROBOTS)]
    mjcf: Option<PathBuf>,
    /// Do not write report.html
    #[arg(long)]
    no_report: bool,
    /// Exit with code 1 where not every equation is adequate
    #[arg(long)]
    strict: bool,
    /// Output directory, which must not exist [default: models/LOG, numbered if it exists]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

/// Options about equations, which are not looked for where a robot is given.
const NOT_OF_ROBOTS: [&str; 15] = [
    "unmeasured",
    "delay",
    "lag",
    "intersample",
    "strict",
    "library",
    "terms",
    "known",
    "required",
    "forbidden",
    "signs",
    "solver",
    "threshold",
    "ridge",
    "target",
];

/// What to do about residuals that no term explains.
const HELP: &str = "\
what may help: --inputs COLUMNS for commands that are read as states, --limits STATE=LOW:HIGH where a state
               saturates, --term FORMULA for a term that is missing, such as v*w*abs(w) or, with numbers that are
               known, sqrt(p - 101.3), --unmeasured RATE=OF for an unmeasured rate, --delay ROWS for inputs that act
               late, --lag S for an actuator that follows its input slowly, --intersample foh for inputs that are
               linear between rows, --angles for angles, or none, --target discrete for a map from row to row, a
               log in which states and inputs move more; `sindyna inspect` shows it
";

const EXAMPLE: &str = "\
Example:  sindyna identify examples/logs/pendulum.csv --states th,w --inputs u --angles th";

/// Which states have a rate that was not measured.
fn unmeasured(given: &[String]) -> Result<Unmeasured, Failure> {
    let given: Vec<String> = given.iter().map(|n| n.trim().to_owned()).collect();
    let hint = "--unmeasured w=th says that w is the rate of th, and no column";
    Ok(match pairs("--unmeasured", "RATE=OF", hint, &given)? {
        None => Unmeasured::Auto,
        Some(pairs) if pairs.is_empty() => Unmeasured::None,
        Some(pairs) => Unmeasured::Given(pairs),
    })
}

pub(super) fn delay(text: &str) -> Result<Delay, String> {
    const MOST: f64 = 1000.0;
    match (text, text.parse::<f64>()) {
        ("auto", _) => Ok(Delay::Auto),
        (_, Ok(rows)) if rows.abs() <= MOST => Ok(Delay::Rows(rows)),
        _ => Err(format!("a delay is `auto` or a number of rows from −{MOST} to {MOST}")),
    }
}

pub(super) fn lag(text: &str) -> Result<Lag, String> {
    match (text, text.parse::<f64>()) {
        ("auto", _) => Ok(Lag::Auto),
        (_, Ok(tau)) if (0.0..f64::INFINITY).contains(&tau) => Ok(Lag::Seconds(tau)),
        _ => Err("a lag is `auto` or a time constant in seconds, 0 for none".into()),
    }
}

pub(super) fn intersample(text: &str) -> Result<InterSample, String> {
    match text {
        "zoh" => Ok(InterSample::Zoh),
        "foh" => Ok(InterSample::Foh),
        "bl" => Ok(InterSample::Bl),
        _ => Err("inputs between samples are `zoh` (held), `foh` (linear) or `bl` (smooth)".into()),
    }
}

/// What is held out.
#[derive(Debug, Clone)]
enum Holdout {
    /// The last part of the log.
    Share(f64),
    /// Another one.
    Log(PathBuf),
}

fn holdout(text: &str) -> Result<Holdout, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value < 1.0 => Ok(Holdout::Share(value)),
        Ok(_) => Err("a share must be a number between 0 and 1".into()),
        Err(_) => Ok(Holdout::Log(text.into())),
    }
}

/// The share of the log that is held out, or the other logs that are.
fn held_out_of(given: &[Holdout]) -> Result<(Option<f64>, Vec<PathBuf>), Failure> {
    let share = given.iter().find_map(|h| if let Holdout::Share(share) = h { Some(*share) } else { None });
    let logs = given.iter().filter_map(|h| if let Holdout::Log(path) = h { Some(path.clone()) } else { None });
    match (share, logs.collect::<Vec<_>>()) {
        (Some(_), _) if given.len() > 1 => Err(Failure::new("--holdout takes one share or other logs")
            .hint("--holdout b.csv --holdout c.csv holds out two logs")),
        (share, logs) => Ok((share, logs)),
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
    findings: Vec<String>,
    equations: Vec<String>,
    identification: &'a Document<'a>,
}

pub(crate) fn run(args: &Args, console: Console) -> Result<Answer, Failure> {
    if let Some(out) = &args.out {
        RunDir::refuse_existing(out, &FILES)?;
    }
    let urdf = args.urdf.as_deref().map(robot::File::Urdf);
    if let Some(robot) = urdf.or(args.mjcf.as_deref().map(robot::File::Mjcf)) {
        let log = args.reading.read(&args.logs)?;
        let logs: Vec<&Path> = args.logs.iter().map(|log| source(log)).collect();
        let (share, others) = held_out_of(&args.holdout)?;
        if share.is_some() {
            return Err(Failure::new(
                "--holdout takes other logs where a robot is given: the last 30 % are held out already",
            )
            .hint("--holdout b.csv predicts another log"));
        }
        let other = if others.is_empty() { None } else { Some(log.another(&others)?) };
        return robot::run(robot, (&log, &logs), other.as_ref(), args.out.as_deref());
    }
    let mut settings = IdentificationConfig::default();
    args.identification.apply(&mut settings);
    args.identification.check(&settings)?;
    let interrupt = Interrupt::listen()?;
    let progress = Progress::new(console);
    let (share, others) = held_out_of(&args.holdout)?;
    let log = args.reading.read(&args.logs)?;
    // What cannot be read is told before anything is looked for.
    let other = if others.is_empty() { None } else { Some(log.another(&others)?) };
    let logs: Vec<&Path> = args.logs.iter().map(|log| source(log)).collect();
    progress.say(&format!("read: {} rows, {} steps; searching for equations", log.rows, log.data.n_steps()));
    let unmeasured = unmeasured(&args.unmeasured)?;
    let without_noise = args.reading.is_without_noise();
    let identifier_of = |spec: &Spec| -> Result<Identifier, Failure> {
        let identifier = settings.identifier(spec)?;
        Ok(if without_noise { identifier.with_noise(NoiseChoice::Rounding) } else { identifier })
    };
    let identifier = identifier_of(&log.spec)?;
    check_size(&identifier, &log, &split(&log, share)?.0.data)?;
    progress.detail(|| {
        let terms = identifier.terms().map_or(0, |terms| terms.len());
        format!("{terms} candidate terms, at least {} rows needed", identifier.needed_rows())
    });
    let found = args.common.pool()?.install(|| {
        let (go_on, looking) = (|| !interrupt.pressed(), Looking::new(&progress));
        let telling = |stage| looking.tell(stage);
        let asked = Asked {
            unmeasured: &unmeasured,
            delay: args.delay,
            lag: args.lag,
            intersample: args.intersample,
            kept: &|log| Ok(split(log, share).map_err(Trouble::Other)?.0),
            identifier: &|spec| identifier_of(spec).map_err(Trouble::Other),
            watch: &Watch::going_on(&go_on).telling(&telling),
            say: &|tried| progress.say(tried),
        };
        looked(log.clone(), &asked)
    });
    progress.finish();
    let looked = match found {
        Err(_) if interrupt.pressed() => {
            progress.say("interrupted: nothing was written");
            return Ok(Answer::silent(Verdict::Interrupted));
        }
        Err(Trouble::Fit(error)) => return Err(failed(error, logs[0], &log)),
        Err(Trouble::Other(failure)) => return Err(failure),
        Ok(found) => found,
    };
    if interrupt.pressed() {
        progress.say("interrupted: the equations found before are reported");
    }
    let elsewhere =
        other.as_ref().map(|other| elsewhere(other, &looked)).transpose().map_err(|e| held_out_failed(e, &others))?;
    let Looked { found, identifier, log } = looked;
    let (samples, held_out) = split(&log, share)?;
    let Samples { data, times, .. } = &samples;
    let predicted = predictions(&identifier, &found.model, (data, times.as_deref()), &log.spec);
    let mut account = Account::new(&found, &log.spec).with_predictions(predicted.as_ref());
    if let Some(Samples { data, times, .. }) = elsewhere.as_ref().or(held_out.as_ref()) {
        let recordings = timed(identifier.recordings(data)?, times.as_deref());
        let names = others.iter().map(|path| path.display().to_string()).collect();
        account.held_out = Some(
            HeldOut::of(&found.model, &recordings, &account.unmeasured, &found.report.noise_deviations)
                .with_logs(names),
        );
    }

    // What was found is told even if it cannot be written down.
    let record = Record::new(&logs, (&log.spec, &log.notes), settings);
    let document = Document { record: &record, account: &account };
    let predicted = predicted.map(|table| table.to_csv()).transpose()?;
    let mut files = vec![
        ("config.toml", Some(toml::to_string(&record)?.into_bytes())),
        ("prediction.csv", predicted),
        ("model.json", Some(found.model.to_json().into_bytes())),
        (RECORDED_LOG, Some(log_csv(&log.spec, &log.data, log.times.as_deref())?)),
        (RECORDED_MODELS, Some(identified_bytes(&found))),
        ("identify.json", Some(json(&document)?)),
    ];
    if !args.no_report {
        let page = pages::of_files(None, &files);
        files.insert(1, (pages::PAGE, page));
    }
    let written = write(args.out.as_deref(), &record, files);
    let mut text = heading(&logs, &log) + "\n" + &sindyna_report::text::text(&account, width());
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
        findings: log.findings.iter().map(ToString::to_string).collect(),
        equations: found.model.equations(),
        identification: &document,
    };
    let came_out = match missed {
        _ if interrupt.pressed() => Verdict::Interrupted,
        true => Verdict::MissedTarget,
        false => Verdict::Done,
    };
    Ok(Answer::new(came_out, text, &told)?.and(written))
}

/// Why nothing was found.
enum Trouble {
    Fit(FitError),
    Other(Failure),
}

impl From<FitError> for Trouble {
    fn from(error: FitError) -> Self {
        Self::Fit(error)
    }
}

/// `log`, and its last `share`, which is held out if there is one.
fn split(log: &Log, share: Option<f64>) -> Result<(Samples, Option<Samples>), Failure> {
    match share {
        Some(share) => {
            let (samples, held_out) = held_out(log, share)?;
            Ok((samples, Some(held_out).filter(|h| h.data.n_steps() > 0)))
        }
        None => Ok((log.samples(), None)),
    }
}

/// Refuses what could not be told apart, or not in reasonable time.
fn check_size(identifier: &Identifier, log: &Log, data: &Dataset) -> Result<(), Failure> {
    /// Candidate terms that are still searched in seconds.
    const MOST_TERMS: usize = 2_000;
    let terms = identifier.terms()?.len();
    if terms > MOST_TERMS {
        return Err(Failure::new(format!("{terms} candidate terms are more than the maximum of {MOST_TERMS}"))
            .hint("name fewer states and inputs, or give fewer --term or another --library"));
    }
    let (steps, needed) = (data.n_steps(), identifier.needed_rows());
    if steps < needed {
        let (n, k) = (log.spec.state_dim(), log.spec.control_dim());
        return Err(Failure::new(format!(
            "{} rows make {}, too few: {n} states and {k} inputs need at least {needed}",
            log.rows,
            plural(steps, "step")
        ))
        .hint("use a longer log"));
    }
    Ok(())
}

/// What can be done about data in which nothing was found.
fn failed(error: FitError, path: &Path, log: &Log) -> Failure {
    let limited = log.spec.state.iter().filter(|s| s.prior.bounds.0.is_finite() || s.prior.bounds.1.is_finite());
    let limited: Vec<String> = limited.map(|s| format!("`{}`", s.name)).collect();
    let hint = match &error {
        FitError::TooFewRows { .. } if !limited.is_empty() => format!(
            "steps that end at a limit or beyond it are left out: look at the --limits of {}, or use a longer log",
            limited.join(", ")
        ),
        FitError::TooFewRows { .. } => "use a longer log".into(),
        FitError::Regression { .. } if log.times.is_some() => {
            "--resample S interpolates to even steps, which every --target and --solver takes".into()
        }
        _ => log.doubts().unwrap_or_else(|| "try other terms (--library, --term) or another --target".into()),
    };
    Failure::from(anyhow::Error::new(error).context(format!("no equations in {}", path.display()))).hint(hint)
}

/// What can be done about other logs that the model cannot be compared with.
fn held_out_failed(error: FitError, others: &[PathBuf]) -> Failure {
    let names: Vec<String> = others.iter().map(|path| path.display().to_string()).collect();
    Failure::from(anyhow::Error::new(error).context(format!("no predictions of {}", names.join(", "))))
        .hint("it is read as the first log was; --resample S makes the samples of both even")
}

/// The files of a model's directory, in the order in which they are written.
const FILES: [&str; 7] =
    ["config.toml", pages::PAGE, "prediction.csv", "model.json", RECORDED_LOG, RECORDED_MODELS, "identify.json"];

fn write(out: Option<&Path>, record: &Record, files: Vec<(&'static str, Option<Vec<u8>>)>) -> Result<RunDir, Failure> {
    let files: Vec<(&str, Vec<u8>)> = files.into_iter().filter_map(|(name, bytes)| Some((name, bytes?))).collect();
    match out {
        Some(path) => Ok(RunDir::create(path, &files)?),
        None => Ok(RunDir::create_numbered(&Path::new("models").join(record.name()), &files)?),
    }
}
