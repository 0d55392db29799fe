//! Options of an identification from a log.

use sindyna_core::{InterSample, Spec};
use sindyna_sindy::{Identifier, Watch};

use super::unmeasured::Unmeasured;
use crate::logs::{Log, Samples};

/// Delay of the inputs in rows.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Delay {
    /// None, unless equations leave residuals that no term explains, and the data support a delay.
    #[default]
    Auto,
    /// A number of rows; −1 for an input that acted over the step before its row.
    Rows(f64),
}

/// Lag through which inputs act: that of an actuator of first order.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Lag {
    /// None, unless equations leave residuals that no term explains, and the data support a lag.
    #[default]
    Auto,
    /// A time constant \[s\]; 0 for none.
    Seconds(f64),
}

/// What to identify, and with which options.
pub(crate) struct Asked<'a, E> {
    pub(crate) unmeasured: &'a Unmeasured,
    pub(crate) delay: Delay,
    pub(crate) lag: Lag,
    /// What inputs do between samples; `None`: they are held, unless equations leave residuals that no term explains, and the data support
    /// first-order hold.
    pub(crate) intersample: Option<InterSample>,
    /// The part of a log that equations are identified from.
    pub(crate) kept: &'a (dyn Fn(&Log) -> Result<Samples, E> + Sync),
    /// Makes an identifier for a system.
    pub(crate) identifier: &'a (dyn Fn(&Spec) -> Result<Identifier, E> + Sync),
    pub(crate) watch: &'a Watch<'a>,
    /// Receives progress messages.
    pub(crate) say: &'a (dyn Fn(&str) + Sync),
}
