//! One way in which a log may be read: inputs that act earlier or later, or change between rows, or steps of a simulator.

use std::fmt;

use sindyna_core::number::significant;
use sindyna_core::{FitError, InterSample};

use super::between::{between, read};
use super::delay::{delayed, shifted};
use super::lag::{SETTLED, delivered, lagged};
use crate::logs::{Log, Samples};

/// How a log may be read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reading {
    /// Rows by which inputs act later.
    pub(super) rows: f64,
    /// Time constant \[s\] of the lag through which they act; 0 if there is none.
    pub(super) lag: f64,
    /// The part of the first inputs that is behind it where a trajectory begins: one where it had settled, none after rest.
    pub(super) settled: f64,
    /// How they are between rows: held, linear or smooth.
    pub(super) between: InterSample,
    /// Whether the samples are those of a simulator.
    pub(super) simulated: bool,
}

impl Reading {
    /// The log as it stands.
    pub(super) const GIVEN: Self =
        Self { rows: 0.0, lag: 0.0, settled: SETTLED, between: InterSample::Zoh, simulated: false };

    /// `log` as it is read so; `None` if that is as it stands.
    ///
    /// # Errors
    /// [`FitError::Regression`] if no trajectory is longer than the delay.
    pub(super) fn of(self, log: &Log) -> Result<Option<Log>, FitError> {
        let other = match self.between {
            _ if self.lag > 0.0 => Some(lagged(log, (self.lag, self.settled))?),
            InterSample::Zoh => None,
            intersample => Some(between(log, intersample, false)?),
        };
        if self.rows == 0.0 {
            return Ok(other);
        }
        delayed(other.as_ref().unwrap_or(log), self.rows).map(Some)
    }

    /// Whether it has a lag, or a delay of part of a row: what changes gradually.
    pub(super) fn is_gradual(self) -> bool {
        self.lag > 0.0 || self.rows.fract() != 0.0
    }

    /// Rows by which inputs are moved, either way.
    pub(super) fn shift(self) -> f64 {
        self.rows.abs() + if self.between.is_held() { 0.0 } else { 0.5 }
    }

    /// At most `most` steps of `kept` as they are read so, without `margins` at the beginning and the end of each trajectory.
    pub(super) fn samples(self, kept: &Samples, margins: (usize, usize), most: usize) -> Result<Samples, FitError> {
        let times = kept.times.as_deref();
        let other = match self.between {
            _ if self.lag > 0.0 => Some(delivered(&kept.data, times, (self.lag, self.settled))?),
            InterSample::Zoh => None,
            intersample => Some(read(&kept.data, intersample)?),
        };
        shifted(other.as_ref().unwrap_or(&kept.data), times, self.rows, margins, most)
    }
}

impl fmt::Display for Reading {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut parts = Vec::new();
        if self.rows != 0.0 {
            let rows = if (self.rows - 1.0).abs() < f64::EPSILON { "row" } else { "rows" };
            parts.push(format!("a delay of {} {rows}", significant(self.rows, 3)));
        }
        if self.lag > 0.0 {
            parts.push(format!("a lag of {} s", significant(self.lag, 3)));
        }
        match self.between {
            InterSample::Foh => parts.push("first-order hold".to_owned()),
            InterSample::Bl => parts.push("inputs that are smooth between rows".to_owned()),
            _ => {}
        }
        if self.simulated {
            parts.push("steps of a simulator".to_owned());
        }
        f.write_str(&if parts.is_empty() { "the log as it stands".to_owned() } else { parts.join(" and ") })
    }
}
