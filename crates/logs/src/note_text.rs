//! Notes as lines of text.

use std::fmt;

use sindyna_core::InterSample;
use sindyna_core::number::{plural, significant};

use crate::{Difference, Note, UnitBy};

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unused { columns } => match &columns[..] {
                [one] => write!(f, "the column `{one}` is not used"),
                several => {
                    let list: Vec<String> = several.iter().map(|c| format!("`{c}`")).collect();
                    write!(f, "the columns {} are not used", list.join(", "))
                }
            },
            Self::LeftOut { arrays } => {
                let list: Vec<String> = arrays.iter().map(|(name, why)| format!("`{name}` {why}")).collect();
                write!(f, "left out: {}", list.join(", "))
            }
            Self::Roles { states, inputs } => {
                let inputs = if inputs.is_empty() { "none".to_owned() } else { inputs.join(", ") };
                write!(f, "recognised by their names: states {}; inputs {inputs}", states.join(", "))
            }
            Self::Time { column, by: UnitBy::Date, .. } => {
                write!(f, "time: column {column}, dates; in UTC where they have no offset")
            }
            Self::Time { column, unit, by } => {
                write!(f, "time: column {column}, in {unit}")?;
                f.write_str(match by {
                    UnitBy::Default | UnitBy::Date => "",
                    UnitBy::Header => " (by the header)",
                    UnitBy::Rates => " (one state is then the rate of another)",
                    UnitBy::Epoch => " since 1970",
                    UnitBy::Counter => " (whole numbers that are very far apart or uneven)",
                })
            }
            Self::Repeated { rows, row } => {
                let (repeat, are) = if *rows == 1 { ("repeats", "is") } else { ("repeat", "are") };
                write!(
                    f,
                    "{} ({row}) {repeat} the row before, its time included, and {are} left out",
                    plural(*rows, "row")
                )
            }
            Self::Gaps { gaps, longest, row, over } => write!(
                f,
                "{} longer than {} s, the longest {} s before {row}: a new trajectory begins after each",
                plural(*gaps, "interval"),
                significant(*over, 3),
                significant(*longest, 3)
            ),
            Self::Uneven { shortest, longest, usual } => write!(
                f,
                "the sampling interval varies from {} to {} s, its median is about {} s: every sample is used at its own time",
                significant(*shortest, 3),
                significant(*longest, 3),
                significant(*usual, 3)
            ),
            Self::Layout { delimiter, decimal_comma } => {
                let between = match delimiter {
                    '\t' => "tabs".to_owned(),
                    ' ' => "blanks".to_owned(),
                    other => format!("`{other}`"),
                };
                let decimals = if *decimal_comma { ", decimals by a comma" } else { "" };
                write!(f, "cells are separated by {between}{decimals}")
            }
            Self::Latin => f.write_str("the file is not UTF-8; it is read as Latin-1"),
            Self::MissingCode { column, value } => {
                write!(f, "{} in {column} stands for a missing value", significant(*value, 9))
            }
            Self::Missing { rows, column, row } => write!(
                f,
                "{} with a missing value (first: {column} in {row}): a new trajectory begins after each",
                plural(*rows, "row")
            ),
            Self::Radians { column, unit } => write!(f, "{column} is converted from {unit} to radians"),
            Self::Delayed { rows, seconds, deviation } => {
                let unit = if (rows.abs() - 1.0).abs() < f64::EPSILON { "row" } else { "rows" };
                write!(
                    f,
                    "delay of the inputs: {} {unit} ({} s)",
                    significant(*rows, 6),
                    measured(*seconds, *deviation)
                )?;
                match rows {
                    -1.0 => f.write_str(": an input acts over the step before its row"),
                    _ => Ok(()),
                }
            }
            Self::Lagged { seconds, deviation } => {
                write!(f, "lag of the inputs: first order, time constant {} s", measured(*seconds, *deviation))
            }
            Self::LateUnconfirmed => f.write_str(
                "the equations with this delay or lag are an approximation: it explains most of those tried, and may stand for a missing term",
            ),
            Self::InterSample { intersample: InterSample::Bl, .. } => {
                f.write_str("inputs are smooth between samples (band-limited: cubics)")
            }
            Self::InterSample { .. } => f.write_str("inputs are linear between samples (first-order hold)"),
            Self::Unmeasured { rate, of, .. } => {
                write!(f, "{rate}, the rate of {of}, was not measured; it is estimated as a state of the equations")
            }
            Self::Difference(Difference { rate, of, quotient }) => {
                write!(f, "{rate} is the {quotient} difference quotient of {of} and is not used as a measurement")
            }
            Self::Angle { state, turns: Some(turns) } => {
                write!(f, "{state} spans {turns:.1} turns and is used as an angle")
            }
            Self::Angle { state, turns: None } => {
                write!(f, "{state} is used as an angle that is wrapped to one turn")
            }
            Self::Turned { state, named: false } => {
                write!(f, "{state} is used as an angle: equations with its sine and cosine explain the data better")
            }
            Self::Turned { state, named: true } => {
                write!(
                    f,
                    "{state} is used as an angle, as its name or unit says: equations without angles explain the data no better"
                )
            }
            Self::Degrees { state, reach } => {
                write!(f, "{state} reaches {} and is read in radians; it may be in degrees", significant(*reach, 3))
            }
            Self::Lattice { state, step } => {
                write!(f, "{state} has values {} apart; this distance is used as its resolution", significant(*step, 3))
            }
            Self::EndsAbruptly => f.write_str(
                "the last line has no line break; if the log was cut off there, its last number may be incomplete",
            ),
            Self::Unwrapped { state, jumps } => {
                write!(f, "{state} is unwrapped at {} of a whole turn", plural(*jumps, "jump"))
            }
            Self::Jump { state, step, row, times } => write!(
                f,
                "{state} changes by {step:.3} before {row}, {times:.0} times as much as in 95 % of the steps; if a new \
                 trajectory begins there, mark it by a column `trajectory`"
            ),
            Self::Still { state } => {
                write!(f, "{state} is constant, so its effect cannot be identified; no candidate term contains it")
            }
            Self::TimeIgnored { dt } => {
                write!(f, "sampling interval {dt} s, as given; the time stamps agree except for jitter")
            }
            Self::Resampled { dt } => {
                write!(f, "resampled every {dt} s: states by linear interpolation, inputs by means")
            }
            Self::Circle { cosine, sine, angle } => {
                write!(f, "{cosine} and {sine} are used as cosine and sine of one angle, {angle}")
            }
            Self::Rate { rate, of, percent } => {
                write!(f, "{rate} is used as the rate of {of} (RMS deviation at most {percent:.1} %)")
            }
            Self::RateInOtherUnit { rate, of, unit } => {
                write!(
                    f,
                    "{rate} would be the rate of {of} if it were in {unit}; its unit is not declared, and it is used as it is"
                )
            }
            Self::RateScaled { rate, of, factor } => write!(
                f,
                "{rate} would be the rate of {of} if it were multiplied by {}: the unit of one of them, or of time, may be wrong",
                significant(*factor, 4)
            ),
            Self::RateLate { rate, of, by } => {
                let late = if *by > 0.0 { rate } else { of };
                write!(
                    f,
                    "{rate} would be the rate of {of} if {late} were {} s earlier: one of them may be measured late",
                    significant(by.abs(), 3)
                )
            }
            Self::RateUnits { rate, of } => write!(
                f,
                "the unit of {of} is that of a rate of {rate}, but {rate} is the rate of {of}: their names may be interchanged"
            ),
            Self::Derivative { column, of, percent } => {
                write!(f, "{column} is used as the measured derivative of {of} (RMS deviation at most {percent:.1} %)")
            }
            Self::DerivativesUnexplained => {
                f.write_str("the measured derivatives are not used: no equations explain them up to rounding errors")
            }
            Self::DoubtfulRate { rate, of, percent } => {
                write!(
                    f,
                    "{rate} is used as the rate of {of}, as declared, but {of} deviates from it by {percent:.0} %"
                )
            }
            Self::Rounded { state, step } => {
                write!(
                    f,
                    "{state} is recorded in steps of {}; this step is used as its resolution",
                    significant(*step, 3)
                )
            }
            Self::Printed { digits } => {
                write!(f, "states were written with up to {digits} digits; they are read as rounded to these")
            }
            Self::Skipped { trajectories } => {
                let verbs = if *trajectories == 1 { "has no step and is" } else { "have no step and are" };
                write!(f, "{} of one row {verbs} left out", parts(*trajectories))
            }
        }
    }
}

fn parts(count: usize) -> String {
    format!("{count} trajector{}", if count == 1 { "y" } else { "ies" })
}

/// `value` with its standard error, where that is known and can be seen.
fn measured(value: f64, deviation: Option<f64>) -> String {
    let told = significant(value, 6);
    match deviation {
        Some(deviation) if deviation > 1e-6 * value.abs() => format!("{told} ± {}", significant(deviation, 2)),
        _ => told,
    }
}
