//! How a log is read, as options.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use sindyna_core::number::significant;
use sindyna_core::{Channel, Kind, Precision};
use sindyna_logs::{Clock, Finding, Log, LogOptions, Note, UnitBy};
use sindyna_training::settings::PrecisionName;

use crate::cli::failure::Failure;

/// Options that say what the columns of a log are.
#[derive(Debug, clap::Args)]
pub(crate) struct ReadingOptions {
    /// Columns of states, such as `th,w` [default: recognised by their names]
    #[arg(long, value_name = "NAMES", value_delimiter = ',', help_heading = "Log")]
    states: Vec<String>,
    /// Columns of inputs, such as `u`, or `none` for an autonomous system [default: recognised by their names where no states are named]
    #[arg(long, value_name = "NAMES", value_delimiter = ',', help_heading = "Log")]
    inputs: Vec<String>,
    /// States that are angles, or `none` [default: detected]
    #[arg(long, value_name = "NAMES", value_delimiter = ',', help_heading = "Log")]
    angles: Vec<String>,
    /// States that are rates of others, such as `w=th`, or `none` [default: detected]
    #[arg(long, value_name = "RATE=OF", value_delimiter = ',', help_heading = "Log")]
    rates: Vec<String>,
    /// Pairs of states that are cosine and sine of one angle, such as `c=s`, or `none` [default: detected]
    #[arg(long, value_name = "COS=SIN", value_delimiter = ',', help_heading = "Log")]
    circles: Vec<String>,
    /// Columns of measured derivatives of states, such as `ddq1=dq1` for accelerations, or `none`; the equations are fitted to them where they explain them up to
    /// rounding errors [default: detected]
    #[arg(long, value_name = "COLUMN=STATE", value_delimiter = ',', help_heading = "Log")]
    derivatives: Vec<String>,
    /// Measurement noise of the states: `auto` (estimated, unless rounding errors alone explain the residuals), `none` (rounding only), or standard deviations in
    /// their units, such as `th=0.001,w=0.01`, as lower bounds [default: auto]
    #[arg(long, value_name = "auto|none|STATE=SIGMA", value_delimiter = ',', help_heading = "Log")]
    noise: Vec<String>,
    /// Limits of states, such as `x=-2.4:2.4` for a wall or a clip; steps that end at a limit are left out
    #[arg(long, value_name = "STATE=LOW:HIGH", value_delimiter = ',', help_heading = "Log")]
    limits: Vec<String>,
    #[command(flatten)]
    table: TableOptions,
}

/// Options that say how cells and time stamps of a log are read.
#[derive(Debug, Default, PartialEq, clap::Args)]
pub(crate) struct TableOptions {
    /// Sampling interval in seconds, where time stamps jitter or are missing; 1 for a discrete-time map, with --target discrete [default: from time stamps]
    #[arg(long, value_name = "S", value_parser = seconds, help_heading = "Log", conflicts_with = "resample")]
    dt: Option<f64>,
    /// Resample to this interval in seconds by interpolation [default: no resampling]
    #[arg(long, value_name = "S", value_parser = seconds, help_heading = "Log")]
    resample: Option<f64>,
    /// Precision of the recorded states [default: detected]
    #[arg(long, value_enum, value_name = "f32|f64", hide_possible_values = true, help_heading = "Log")]
    precision: Option<PrecisionName>,
    /// Column of the time stamps, or `none` [default: t, else time, timestamp or similar]
    #[arg(long, value_name = "NAME", help_heading = "Log")]
    time_column: Option<String>,
    /// Units of columns, such as `t=ms` or `th=deg`; times are converted to seconds, degrees to radians [default: from the header; of times
    /// from the values]
    #[arg(long, value_name = "COLUMN=UNIT", value_delimiter = ',', help_heading = "Log")]
    units: Vec<String>,
    /// Numbers that stand for missing values, such as `-999`, or `none` [default: an extreme value that is repeated and far from all others of its column]
    #[arg(long, value_name = "NUMBER", value_delimiter = ',', allow_hyphen_values = true, help_heading = "Log")]
    missing: Vec<String>,
    /// Largest interval within a trajectory in seconds, or `inf`; a new trajectory begins after a larger one [default: three times the usual interval]
    #[arg(long, value_name = "S", value_parser = gap, help_heading = "Log")]
    gap: Option<f64>,
    /// Topic of an MCAP file [default: the only one that can be read]
    #[arg(long, value_name = "TOPIC", help_heading = "Log")]
    topic: Option<String>,
    /// Delimiter of the cells: one character, `tab`, or a space for any blanks [default: detected]
    #[arg(long, value_name = "CHARACTER", value_parser = delimiter, help_heading = "Log")]
    delimiter: Option<u8>,
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("seconds must be a finite number above 0".into()),
    }
}

fn gap(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 => Ok(value),
        _ => Err("it is a number of seconds above 0, or `inf`".into()),
    }
}

/// What may stand between two cells.
fn delimiter(text: &str) -> Result<u8, String> {
    match text.as_bytes() {
        b"tab" | b"\\t" => Ok(b'\t'),
        [byte @ (b'\t' | b' ' | b',' | b';' | b':' | b'|')] => Ok(*byte),
        _ => Err("it is one of `,`, `;`, `|`, `:`, a space, or `tab`".into()),
    }
}

/// What standard input is called.
pub(crate) const STDIN: &str = "standard input";

/// What the log `log` is called; `-` is standard input.
pub(crate) fn source(log: &Path) -> &Path {
    if log == Path::new("-") { Path::new(STDIN) } else { log }
}

impl ReadingOptions {
    /// The logs at `paths` as one; `-` alone is standard input.
    pub(crate) fn read(&self, paths: &[PathBuf]) -> Result<Log, Failure> {
        let options = self.options()?;
        Ok(match paths {
            [only] if source(only) == Path::new(STDIN) => Log::read_from(STDIN, std::io::stdin().lock(), &options)?,
            _ if paths.iter().any(|path| source(path) == Path::new(STDIN)) => {
                return Err(Failure::new("standard input holds one log only").hint("name files, or `-` alone"));
            }
            _ => Log::read_all(paths, &options)?,
        })
    }

    /// Whether nothing but rounding is to be believed.
    pub(crate) fn is_without_noise(&self) -> bool {
        self.noise.iter().any(|n| n.trim() == "none")
    }

    fn options(&self) -> Result<LogOptions, Failure> {
        let rates = pairs("--rates", "RATE=OF", "--rates w=th declares w as the rate of th", &names(&self.rates))?;
        let hint = "--circles c=s declares c and s as cosine and sine of one angle";
        let circles = pairs("--circles", "COS=SIN", hint, &names(&self.circles))?;
        let hint = "--derivatives ddq=dq declares ddq as the measured derivative of dq";
        let derivatives = pairs("--derivatives", "COLUMN=STATE", hint, &names(&self.derivatives))?;
        let given = names(&self.noise);
        let alone = given.len() == 1 && matches!(given[0].as_str(), "auto" | "none");
        let deviations = if alone { &[][..] } else { &given[..] };
        let noise = deviations.iter().map(|text| deviation(text)).collect::<Result<_, _>>()?;
        let limits = names(&self.limits).iter().map(|text| limit(text)).collect::<Result<_, _>>()?;
        Ok(LogOptions {
            states: names(&self.states),
            inputs: names(&self.inputs),
            angles: match &names(&self.angles)[..] {
                [] => None,
                [only] if only == "none" => Some(Vec::new()),
                angles => Some(angles.to_vec()),
            },
            rates,
            circles,
            derivatives,
            noise,
            limits,
            ..self.table.options()?
        })
    }
}

/// The numbers that stand for missing values.
fn missing(given: &[String]) -> Result<Option<Vec<f64>>, Failure> {
    let number = |text: &String| match text.replace('\u{2212}', "-").parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(Failure::new(format!("--missing: `{text}` is no finite number"))
            .hint("--missing=-999 reads -999 as a missing value, --missing none reads all numbers as they are")),
    };
    match given {
        [] => Ok(None),
        [only] if only == "none" => Ok(Some(Vec::new())),
        codes => codes.iter().map(number).collect::<Result<_, _>>().map(Some),
    }
}

impl TableOptions {
    /// What they say, of columns nothing.
    pub(crate) fn options(&self) -> Result<LogOptions, Failure> {
        let units = names(&self.units);
        let hint = "--units t=ms declares the unit of t as milliseconds";
        Ok(LogOptions {
            delimiter: self.delimiter,
            topic: self.topic.clone(),
            time: self.time_column.clone(),
            units: pairs("--units", "COLUMN=UNIT", hint, &units)?.unwrap_or_default(),
            missing: missing(&names(&self.missing))?,
            gap: self.gap,
            clock: match (self.dt, self.resample) {
                (Some(dt), _) => Clock::Given(dt),
                (None, Some(dt)) => Clock::Resampled(dt),
                (None, None) => Clock::Stamps,
            },
            precision: self.precision.map(Precision::from),
            ..LogOptions::default()
        })
    }
}

/// The names in `list`, none of which is empty.
fn names(list: &[String]) -> Vec<String> {
    list.iter().map(|n| n.trim().to_owned()).filter(|n| !n.is_empty()).collect()
}

/// What was read, and what was made of it.
pub(crate) fn heading(paths: &[&Path], log: &Log) -> String {
    let spec = &log.spec;
    let state = |channel: &Channel| {
        let unit = if channel.unit.is_empty() { String::new() } else { format!(" [{}]", channel.unit) };
        match channel.kind {
            Kind::Angle => format!("{}{unit} (angle)", channel.name),
            Kind::RateOf(i) => {
                let hidden =
                    log.notes.iter().any(|n| matches!(n, Note::Unmeasured { rate, .. } if *rate == channel.name));
                let hidden = if hidden { ", not measured" } else { "" };
                format!("{}{unit} (rate of {}{hidden})", channel.name, spec.state[i].name)
            }
            _ => format!("{}{unit}", channel.name),
        }
    };
    let list = |channels: &[Channel]| match channels {
        [] => "none".to_owned(),
        channels => channels.iter().map(state).collect::<Vec<_>>().join(", "),
    };
    let mut text = format!(
        "log: {}, {} rows in {} trajector{}, sampling interval {}{} s\nstates: {}; inputs: {}; precision {}\n",
        paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", "),
        log.rows,
        log.data.n_rollouts(),
        if log.data.n_rollouts() == 1 { "y" } else { "ies" },
        if log.times.is_some() { "about " } else { "" },
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
    for finding in &log.findings {
        let hint = if matches!(finding, Finding::Clips { .. }) { "; --limits excludes such steps" } else { "" };
        let _ = writeln!(text, "data: {finding}{hint}");
    }
    text
}

/// How to say otherwise than a note.
fn instead(note: &Note) -> &'static str {
    match note {
        Note::Circle { .. } => "; --circles none turns this off",
        Note::Derivative { .. } => "; --derivatives none turns this off",
        Note::Rate { .. } => "; --rates none turns this off",
        Note::RateInOtherUnit { .. } => "; --units NAME=UNIT declares it",
        Note::RateScaled { .. } => "; --units t=UNIT declares that of time",
        Note::RateLate { .. } => "; --states without the late one reads the other alone, or move its column",
        Note::Rounded { .. } | Note::Printed { .. } | Note::Lattice { .. } => "; --precision f64 turns this off",
        Note::MissingCode { .. } => "; --missing none turns this off",
        Note::Layout { .. } => "; --delimiter changes this",
        Note::Radians { .. } => "; --units COLUMN=rad turns this off",
        Note::Delayed { .. } => "; --delay 0 turns this off",
        Note::Lagged { .. } => "; --lag 0 turns this off",
        Note::InterSample { given: false, .. } => "; --intersample zoh turns this off",
        Note::Unmeasured { given: false, .. } | Note::Difference(_) => "; --unmeasured none turns this off",
        Note::Angle { .. } | Note::Turned { .. } => "; --angles none turns this off",
        Note::Degrees { .. } => "; --units STATE=deg converts it",
        Note::Roles { .. } => "; --states and --inputs change this",
        Note::Time { by: UnitBy::Header | UnitBy::Date, .. } => "",
        Note::Time { .. } => "; --time-column and --units change this",
        Note::Gaps { .. } => "; --gap S changes this",
        Note::Uneven { .. } => "; --resample S interpolates",
        _ => "",
    }
}

/// The pairs `list` names; none given: `None`; `none`: no pair.
pub(crate) fn pairs(
    option: &str,
    form: &str,
    hint: &str,
    list: &[String],
) -> Result<Option<Vec<(String, String)>>, Failure> {
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
            .hint("--noise th=0.001 declares a standard deviation of 0.001 for the noise of th")
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
            .hint("--limits x=-2.4:2.4 keeps the steps with x between -2.4 and 2.4; inf stands for no limit")
    })
}
