//! What was decided about a log without being asked for.

use sindyna_core::InterSample;

use crate::{Difference, Place, TimeUnit, UnitBy};

/// Something that was decided or seen while a log was read, for the user to check.
///
/// [`Display`](std::fmt::Display) says it in a line.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Note {
    /// Columns that are neither states nor inputs.
    Unused {
        /// Their names.
        columns: Vec<String>,
    },
    /// What a file holds that is no column.
    LeftOut {
        /// Names, and why.
        arrays: Vec<(String, String)>,
    },
    /// The states and inputs were told by the names of the columns.
    Roles {
        /// The states.
        states: Vec<String>,
        /// The inputs.
        inputs: Vec<String>,
    },
    /// Which column holds the time, and its unit, where nobody said so.
    Time {
        /// The column.
        column: String,
        /// The unit.
        unit: TimeUnit,
        /// What tells the unit.
        by: UnitBy,
    },
    /// Rows that are there twice were left out.
    Repeated {
        /// How many.
        rows: usize,
        /// Where the first of them. is.
        row: Place,
    },
    /// Steps so long that trajectories end there.
    Gaps {
        /// How many.
        gaps: usize,
        /// The longest \[s\].
        longest: f64,
        /// Where the row it leads to. is.
        row: Place,
        /// Longest step that is none \[s\].
        over: f64,
    },
    /// Samples are not evenly spaced.
    Uneven {
        /// Shortest step \[s\].
        shortest: f64,
        /// Longest step \[s\].
        longest: f64,
        /// A number with few digits near the median \[s\].
        usual: f64,
    },
    /// Cells are not separated by commas, or decimals stand behind one.
    Layout {
        /// What separates cells; a space stands for any blanks.
        delimiter: char,
        /// Whether decimals stand behind a comma.
        decimal_comma: bool,
    },
    /// The file is not UTF-8 and was read as Latin-1.
    Latin,
    /// A number stands for missing values.
    MissingCode {
        /// The column.
        column: String,
        /// The number.
        value: f64,
    },
    /// Rows without a value, after which another trajectory begins.
    Missing {
        /// How many.
        rows: usize,
        /// Column of the first of them.
        column: String,
        /// Where the first of them. is.
        row: Place,
    },
    /// A column was turned into radians.
    Radians {
        /// The column.
        column: String,
        /// The unit it was in.
        unit: String,
    },
    /// The rate of a state was not measured, and is found with the equations.
    Unmeasured {
        /// The rate.
        rate: String,
        /// What it is the rate of.
        of: String,
        /// Whether that was said.
        given: bool,
    },
    /// A state is computed from another one, and was not measured.
    Difference(Difference),
    /// Inputs act later than over the step after their row.
    Delayed {
        /// By how many rows; earlier where it is negative.
        rows: f64,
        /// By how much time \[s\].
        seconds: f64,
        /// Its standard error \[s\], where it was estimated.
        deviation: Option<f64>,
    },
    /// Inputs act through a first-order lag, v' = (u − v)/τ; they are given as v, behind it.
    Lagged {
        /// The time constant τ \[s\].
        seconds: f64,
        /// Its standard error \[s\], where it was estimated.
        deviation: Option<f64>,
    },
    /// Equations with a delay or a lag that the data chose leave more than noise.
    LateUnconfirmed,
    /// Inputs are linear, or smooth, between samples, instead of held.
    InterSample {
        /// How they are.
        intersample: InterSample,
        /// Whether that was said.
        given: bool,
    },
    /// A state was recognised as an angle.
    Angle {
        /// The state.
        state: String,
        /// Whole turns that it spans; `None` for one that is folded into one turn.
        turns: Option<f64>,
    },
    /// A state was taken as an angle: as its name or unit says, because equations without angles explain the data no better, or because equations with
    /// its sine and cosine explain them better.
    Turned {
        /// The state.
        state: String,
        /// Whether its name or unit says so.
        named: bool,
    },
    /// An angle without a unit that may be in degrees.
    Degrees {
        /// The angle.
        state: String,
        /// Largest magnitude.
        reach: f64,
    },
    /// The values of a state lie on a lattice; its step is taken as their measurement error.
    Lattice {
        /// The state.
        state: String,
        /// Distance of two neighbouring values.
        step: f64,
    },
    /// The last line has no line break.
    EndsAbruptly,
    /// An angle that was folded into one turn was made continuous.
    Unwrapped {
        /// The angle.
        state: String,
        /// Jumps by a whole turn that were joined.
        jumps: usize,
    },
    /// One step of a state is far longer than the others.
    Jump {
        /// The state.
        state: String,
        /// Length of the step, in the state's unit.
        step: f64,
        /// Where the row it leads to. is.
        row: Place,
        /// How many times as long as 95 of 100 steps it is.
        times: f64,
    },
    /// A state never changes, so no candidate term has it.
    Still {
        /// The state.
        state: String,
    },
    /// A sampling interval was given although there are time stamps.
    TimeIgnored {
        /// The interval given \[s\].
        dt: f64,
    },
    /// The log was interpolated.
    Resampled {
        /// Every so many seconds.
        dt: f64,
    },
    /// Two columns were recognised as cosine and sine of one angle.
    Circle {
        /// The column that is the cosine.
        cosine: String,
        /// The column that is the sine.
        sine: String,
        /// Name of the angle, which is the state.
        angle: String,
    },
    /// A state was recognised as the rate of another.
    Rate {
        /// The rate.
        rate: String,
        /// The state whose rate it is.
        of: String,
        /// RMS deviation of the change of the state from the integral of the rate, as a share of the change, at least 0.1 \[%\].
        percent: f64,
    },
    /// A state changes as if another one were its rate in some unit that nobody declared.
    RateInOtherUnit {
        /// The rate.
        rate: String,
        /// What it would be the rate of.
        of: String,
        /// The unit.
        unit: String,
    },
    /// A state changes by a thousand times or a thousandth of another one, or by what makes minutes, hours or kilometres per hour of it: their units, or that of time, may be others than they are said to be.
    RateScaled {
        /// The rate.
        rate: String,
        /// What it would be the rate of.
        of: String,
        /// What it would have to be multiplied by.
        factor: f64,
    },
    /// A state changes as if another one were its rate, but for some rows by which one of them is late.
    RateLate {
        /// The rate.
        rate: String,
        /// What it would be the rate of.
        of: String,
        /// By how much the rate is later than the change of the state, negative where it is earlier \[s\].
        by: f64,
    },
    /// The units of a state and of its rate are the other way round.
    RateUnits {
        /// The rate.
        rate: String,
        /// What it is the rate of.
        of: String,
    },
    /// A column is the measured derivative of a state, by its name and by how that changes.
    Derivative {
        /// The column.
        column: String,
        /// The state.
        of: String,
        /// RMS deviation of the change of the state from the integral of the derivative, as a share of the change, at least 0.1 \[%\].
        percent: f64,
    },
    /// The measured derivatives are not used, since no equations explain them to rounding.
    DerivativesUnexplained,
    /// A state was declared the rate of another, which changes otherwise.
    DoubtfulRate {
        /// The rate as declared.
        rate: String,
        /// The state whose rate it should be.
        of: String,
        /// RMS difference, as a share of the change \[%\].
        percent: f64,
    },
    /// A state was written with few digits; the step is taken as its measurement error.
    Rounded {
        /// The state.
        state: String,
        /// Distance of two neighbouring values.
        step: f64,
    },
    /// Some states were written with fewer digits than a float64 has; they are taken as rounded to them.
    Printed {
        /// Most digits of a number of the states that were written so.
        digits: usize,
    },
    /// Trajectories of one row, which have no step, are left out.
    Skipped {
        /// How many.
        trajectories: usize,
    },
}

impl Note {
    /// Whether it is about what the samples of `state` are.
    #[must_use]
    pub fn is_of(&self, state: &str) -> bool {
        match self {
            Self::Lattice { state: of, .. }
            | Self::Rounded { state: of, .. }
            | Self::Rate { rate: of, .. }
            | Self::DoubtfulRate { rate: of, .. }
            | Self::Jump { state: of, .. } => of == state,
            _ => false,
        }
    }
}
