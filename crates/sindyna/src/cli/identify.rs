//! `sindyna identify`: equations from logged data.

mod record;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use sindyna_core::{Channel, Dataset, FitError, Kind, Precision};
use sindyna_logs::{Clock, Log, LogOptions, Note, held_out};
use sindyna_record::identification::{Account, HeldOut};
use sindyna_record::json;
use sindyna_record::run::RunDir;
use sindyna_sindy::{Identifier, NoiseChoice, Watch};

use super::common::{Common, Verdict, print};
use super::identification::IdentificationOptions;
use crate::cli::failure::Failure;
use crate::cli::interrupt::Interrupt;
use crate::cli::pages;
use crate::cli::progress::{Looking, Progress};
use crate::settings::IdentificationConfig;
use crate::training::predictions;
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
    /// CSV file with a header
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// Columns that are states, such as `th,w`
    #[arg(long, value_name = "NAMES", value_delimiter = ',', help_heading = "Log")]
    states: Vec<String>,
    /// Columns that are inputs, such as `u`; none for a system left to itself
    #[arg(long, value_name = "NAMES", value_delimiter = ',', help_heading = "Log")]
    inputs: Vec<String>,
    /// States that are angles, in radians
    #[arg(long, value_name = "NAMES", value_delimiter = ',', help_heading = "Log")]
    angles: Vec<String>,
    /// States that are rates of others, such as `w=th`; `none` for none [default: what the data show]
    #[arg(long, value_name = "RATE=OF", value_delimiter = ',', help_heading = "Log")]
    rates: Vec<String>,
    /// Pairs of states that are cosine and sine of one angle, such as `c=s`; `none` for none [default: what the data show]
    #[arg(long, value_name = "COS=SIN", value_delimiter = ',', help_heading = "Log")]
    circles: Vec<String>,
    /// Noise on the states: `auto`, rounding where that explains the data and else estimated; `none`, rounding only; or standard deviations in
    /// their units, such as `th=0.001,w=0.01`, below which no error is believed [default: auto]
    #[arg(long, value_name = "auto|none|STATE=SIGMA", value_delimiter = ',', help_heading = "Log")]
    noise: Vec<String>,
    /// Limits that states do not leave, such as `x=-2.4:2.4` for a wall or a clip: steps that end there are left out
    #[arg(long, value_name = "STATE=LOW:HIGH", value_delimiter = ',', help_heading = "Log")]
    limits: Vec<String>,
    /// Seconds between two rows; 1 for a map without seconds [default: from the column `t`]
    #[arg(long, value_name = "S", value_parser = seconds, help_heading = "Log", conflicts_with = "resample")]
    dt: Option<f64>,
    /// Interpolate uneven time stamps to steps of this many seconds
    #[arg(long, value_name = "S", value_parser = seconds, help_heading = "Log")]
    resample: Option<f64>,
    /// How finely the states were measured or computed [default: what the numbers show]
    #[arg(long, value_enum, value_name = "f32|f64", hide_possible_values = true, help_heading = "Log")]
    precision: Option<Float>,
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

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Float {
    F32,
    F64,
}

impl From<Float> for Precision {
    fn from(float: Float) -> Self {
        match float {
            Float::F32 => Self::F32,
            Float::F64 => Self::F64,
        }
    }
}

fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value < 1.0 => Ok(value),
        _ => Err("a share must be a number between 0 and 1".into()),
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("seconds must be a finite number above 0".into()),
    }
}

pub(crate) fn run(args: &Args) -> Result<Verdict, Failure> {
    if let Some(out) = &args.out {
        RunDir::refuse_existing(out, &FILES)?;
    }
    let mut settings = IdentificationConfig::default();
    args.identification.apply(&mut settings);
    args.identification.check(&settings)?;
    let interrupt = Interrupt::listen()?;
    let progress = Progress::new(args.common.quiet);
    let log = Log::read(&args.log, &args.options()?)?;
    progress.say(&format!("read: {} rows, {} steps; looking for equations", log.rows, log.data.n_steps()));
    let identifier = settings.identifier(&log.spec)?;
    let without = args.noise.iter().any(|n| n.trim() == "none");
    let identifier = if without { identifier.with_noise(NoiseChoice::Rounding) } else { identifier };
    let (data, held_out) = match args.holdout {
        Some(share) => held_out(&log.data, share)?,
        None => (log.data.clone(), Dataset::new(log.data.observation_dim(), log.data.control_dim(), 1, log.data.dt())),
    };
    check_size(&identifier, &log, &data)?;
    let found = args.common.pool()?.install(|| {
        let (go_on, looking) = (|| !interrupt.pressed(), Looking::new(&progress));
        identifier.identify_watched(&data, &Watch::going_on(&go_on).telling(&|stage| looking.tell(stage)))
    });
    progress.finish();
    let found = match found {
        Err(FitError::Interrupted) => {
            progress.say("interrupted: nothing was written");
            return Ok(Verdict::Interrupted);
        }
        found => found.map_err(|e| explain(e, &args.log, &log))?,
    };
    let mut account = Account::new(&found, &log.spec);
    if held_out.n_steps() > 0 {
        account.held_out = Some(HeldOut::of(&found.model, &identifier.recordings(&held_out)?));
    }

    // What was found is told even if it cannot be written down.
    let record = Record::new(&args.log, &log.spec, settings);
    let predicted = predictions(&identifier, &found.model, &data, &log.spec).map(|table| table.to_csv()).transpose()?;
    let mut files = vec![
        ("config.toml", Some(toml::to_string(&record)?.into_bytes())),
        ("prediction.csv", predicted),
        ("model.json", Some(found.model.to_json().into_bytes())),
        ("identify.json", Some(json(&Document { record: &record, account: &account })?)),
    ];
    if !args.no_report {
        let page = pages::of_files(None, &files);
        files.insert(1, (pages::PAGE, page));
    }
    let written = write(args.out.as_deref(), &record, files);
    let mut text = heading(&args.log, &log) + "\n" + &sindyna_report::text::text(&account);
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
    print(&text)?;
    let missed = args.strict && account.explained != Some(true);
    written.map(|_| if missed { Verdict::MissedTarget } else { Verdict::Done })
}

impl Args {
    fn options(&self) -> Result<LogOptions, Failure> {
        let names = |list: &[String]| -> Vec<String> {
            list.iter().map(|n| n.trim().to_owned()).filter(|n| !n.is_empty()).collect()
        };
        let rates = pairs("--rates", "RATE=OF", "--rates w=th says that w is the rate of th", &names(&self.rates))?;
        let hint = "--circles c=s says that c and s are cosine and sine of one angle";
        let circles = pairs("--circles", "COS=SIN", hint, &names(&self.circles))?;
        let given = names(&self.noise);
        let alone = given.len() == 1 && matches!(given[0].as_str(), "auto" | "none");
        let deviations = if alone { &[][..] } else { &given[..] };
        let noise = deviations.iter().map(|text| deviation(text)).collect::<Result<_, _>>()?;
        let limits = names(&self.limits).iter().map(|text| limit(text)).collect::<Result<_, _>>()?;
        Ok(LogOptions {
            states: names(&self.states),
            inputs: names(&self.inputs),
            angles: names(&self.angles),
            rates,
            circles,
            noise,
            limits,
            clock: match (self.dt, self.resample) {
                (Some(dt), _) => Clock::Given(dt),
                (None, Some(dt)) => Clock::Resampled(dt),
                (None, None) => Clock::Stamps,
            },
            precision: self.precision.map(Precision::from),
        })
    }
}

/// The pairs `list` names; none given: `None`; `none`: no pair.
fn pairs(option: &str, form: &str, hint: &str, list: &[String]) -> Result<Option<Vec<(String, String)>>, Failure> {
    let pair = |text: &String| match text.split_once('=') {
        Some((one, other)) => Ok((one.trim().to_owned(), other.trim().to_owned())),
        None => Err(Failure::new(format!("{option} takes {form} or `none`, got `{text}`")).hint(hint)),
    };
    match list {
        [] => Ok(None),
        [only] if only == "none" => Ok(Some(Vec::new())),
        given => given.iter().map(pair).collect::<Result<_, _>>().map(Some),
    }
}

/// `th=0.001`.
fn deviation(text: &str) -> Result<(String, f64), Failure> {
    let parts =
        text.split_once('=').and_then(|(name, sigma)| Some((name.trim().to_owned(), sigma.trim().parse().ok()?)));
    parts.filter(|(_, sigma): &(String, f64)| sigma.is_finite() && *sigma > 0.0).ok_or_else(|| {
        Failure::new(format!("--noise takes `auto`, `none`, or STATE=SIGMA with SIGMA above 0, got `{text}`"))
            .hint("--noise th=0.001 says that the sensor of th is off by 0.001 as a standard deviation")
    })
}

/// `x=-2.4:2.4`.
fn limit(text: &str) -> Result<(String, f64, f64), Failure> {
    let parts = text.split_once('=').and_then(|(name, range)| Some((name, range.split_once(':')?)));
    let numbers = parts.and_then(|(name, (low, high))| {
        Some((name.trim().to_owned(), low.trim().parse::<f64>().ok()?, high.trim().parse::<f64>().ok()?))
    });
    numbers.filter(|(_, low, high)| low < high).ok_or_else(|| {
        Failure::new(format!("--limits takes STATE=LOW:HIGH with LOW below HIGH, got `{text}`"))
            .hint("--limits x=-2.4:2.4 says that x stays between -2.4 and 2.4; inf for no limit on one side")
    })
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
const FILES: [&str; 5] = ["config.toml", pages::PAGE, "prediction.csv", "model.json", "identify.json"];

fn write(out: Option<&Path>, record: &Record, files: Vec<(&'static str, Option<Vec<u8>>)>) -> Result<RunDir, Failure> {
    let files: Vec<(&str, Vec<u8>)> = files.into_iter().filter_map(|(name, bytes)| Some((name, bytes?))).collect();
    match out {
        Some(path) => Ok(RunDir::create(path, &files)?),
        None => {
            let name = Path::new(&record.log).file_stem().unwrap_or("log".as_ref());
            Ok(RunDir::create_numbered(&Path::new("models").join(name), &files)?)
        }
    }
}
