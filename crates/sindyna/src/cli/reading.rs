//! How a log is read, as options.

use std::path::Path;

use sindyna_core::Precision;
use sindyna_logs::{Clock, Log, LogOptions, TIME};

use crate::cli::failure::Failure;
use crate::settings::PrecisionName;

/// Options that say what the columns of a log are.
#[derive(Debug, clap::Args)]
pub(crate) struct ReadingOptions {
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
    precision: Option<PrecisionName>,
    /// Column of the time stamps in seconds [default: t]
    #[arg(long, value_name = "NAME", help_heading = "Log")]
    time_column: Option<String>,
    /// What separates cells: one character, or `tab` [default: ,]
    #[arg(long, value_name = "CHARACTER", value_parser = delimiter, help_heading = "Log")]
    delimiter: Option<u8>,
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("seconds must be a finite number above 0".into()),
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
    /// The log at `path`; `-` is standard input.
    pub(crate) fn read(&self, path: &Path) -> Result<Log, Failure> {
        let options = self.options()?;
        let source = source(path);
        Ok(if source == Path::new(STDIN) {
            Log::read_from(source, std::io::stdin().lock(), &options)?
        } else {
            Log::read(path, &options)?
        })
    }

    /// Whether nothing but rounding is to be believed.
    pub(crate) fn is_without_noise(&self) -> bool {
        self.noise.iter().any(|n| n.trim() == "none")
    }

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
            delimiter: self.delimiter.unwrap_or(b','),
            time: self.time_column.clone().unwrap_or_else(|| TIME.into()),
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
