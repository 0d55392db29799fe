//! What is known of a log beforehand.

use sindyna_core::Precision;

/// Column of the time stamps, before any other that could be.
pub const TIME: &str = "t";

/// What to name where no column is one of time stamps.
pub const NO_TIME: &str = "none";

/// What to name where no column is an input.
pub const NO_INPUTS: &str = "none";

/// Column that tells trajectories apart.
pub const TRAJECTORY: &str = "trajectory";

/// What is known of a log's columns. Any value will do: it is checked against the file when that is read.
#[derive(Debug, Clone, PartialEq)]
pub struct LogOptions {
    /// What stands between two cells of a line: one byte that is neither a quote, a line break nor part of a number, a space for any
    /// blanks; `None` for what the lines show.
    pub delimiter: Option<u8>,
    /// Which messages of a file with several topics are the log; `None` for those of the only one.
    pub topic: Option<String>,
    /// Column of the time stamps; `None` for [`TIME`], else one that is called `time`, `timestamp`, `time_ms` or the like; [`NO_TIME`] for none.
    pub time: Option<String>,
    /// Columns and their units, such as (`t`, `ms`) or (`th`, `deg`), whatever the header says of these.
    pub units: Vec<(String, String)>,
    /// Numbers that stand for missing values, such as −999; `None` for what the values show.
    pub missing: Option<Vec<f64>>,
    /// Longest step within a trajectory \[s\]: a longer one is a border; `None` for three times as long as 95 of 100.
    pub gap: Option<f64>,
    /// Columns that are states; none for what the names of all columns say.
    pub states: Vec<String>,
    /// Columns that are inputs, each held until the next row; none for what the names of all columns say, where no states are named either. [`NO_INPUTS`] for a system without inputs.
    pub inputs: Vec<String>,
    /// States that are angles \[rad\]; `None` for what the data show.
    pub angles: Option<Vec<String>>,
    /// States that are rates of others, as (rate, state); `None` for what the data show.
    pub rates: Option<Vec<(String, String)>>,
    /// Pairs of states that are (cosine, sine) of one angle; `None` for what the data show.
    pub circles: Option<Vec<(String, String)>>,
    /// Columns that hold measured derivatives of states, such as accelerations, as (column, state); `None` for those whose names say so and which the data show to
    /// be.
    pub derivatives: Option<Vec<(String, String)>>,
    /// Standard deviations of the measurement noise on states, in their units.
    pub noise: Vec<(String, f64)>,
    /// States with the lowest and highest value they can have: steps that end there are left out of the regression.
    pub limits: Vec<(String, f64, f64)>,
    /// Where the sampling interval comes from.
    pub clock: Clock,
    /// How finely the states were recorded; `None` for what the digits show.
    pub precision: Option<Precision>,
}

/// Where the sampling interval comes from.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Clock {
    /// Time stamps in the column [`LogOptions::time`]: their interval if they are evenly spaced, else each sample has its own time.
    #[default]
    Stamps,
    /// The user \[s\].
    Given(f64),
    /// Interpolation of whatever time stamps there are \[s\].
    Resampled(f64),
}

impl Default for LogOptions {
    fn default() -> Self {
        Self {
            delimiter: None,
            topic: None,
            time: None,
            units: Vec::new(),
            missing: None,
            gap: None,
            states: Vec::new(),
            inputs: Vec::new(),
            angles: None,
            rates: None,
            circles: None,
            derivatives: None,
            noise: Vec::new(),
            limits: Vec::new(),
            clock: Clock::Stamps,
            precision: None,
        }
    }
}

impl LogOptions {
    /// A log whose columns `states` are the states of a system without inputs.
    #[must_use]
    pub fn new<S: Into<String>>(states: impl IntoIterator<Item = S>) -> Self {
        Self { states: states.into_iter().map(Into::into).collect(), ..Self::default() }
    }

    /// The same with the columns `inputs` as inputs.
    #[must_use]
    pub fn with_inputs<S: Into<String>>(self, inputs: impl IntoIterator<Item = S>) -> Self {
        Self { inputs: inputs.into_iter().map(Into::into).collect(), ..self }
    }

    /// The same with the states `angles` as angles \[rad\].
    #[must_use]
    pub fn with_angles<S: Into<String>>(self, angles: impl IntoIterator<Item = S>) -> Self {
        Self { angles: Some(angles.into_iter().map(Into::into).collect()), ..self }
    }

    /// The same with a row every `dt` \[s\], whatever time stamps say.
    #[must_use]
    pub fn with_dt(self, dt: f64) -> Self {
        Self { clock: Clock::Given(dt), ..self }
    }
}
