//! Following an identification, and ending it early.

use std::fmt;

/// What an identification is doing.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Stage {
    /// Looks for equations that explain the data down to rounding.
    Rounding,
    /// Looks for equations that explain the data but for noise.
    Search {
        /// Part of all operations allowed that were spent so far, from 0 to 1. A search mostly ends long before 1.
        spent: f64,
    },
}

/// Who follows an identification and may end it; by default nobody.
///
/// An identification that is told to stop ends with [`FitError::Interrupted`](sindyna_core::FitError::Interrupted) within a fraction
/// of a second.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    go_on: &'a dyn Fn() -> bool,
    tell: &'a dyn Fn(Stage),
}

impl Default for Watch<'_> {
    fn default() -> Self {
        Self { go_on: &|| true, tell: &|_| {} }
    }
}

impl fmt::Debug for Watch<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Watch").finish_non_exhaustive()
    }
}

impl<'a> Watch<'a> {
    /// An identification that goes on as long as `go_on` says so, which is asked often.
    #[must_use]
    pub fn going_on(go_on: &'a dyn Fn() -> bool) -> Self {
        Self { go_on, ..Self::default() }
    }

    /// The same with `tell` told what the identification is doing, often.
    #[must_use]
    pub fn telling(self, tell: &'a dyn Fn(Stage)) -> Self {
        Self { tell, ..self }
    }

    /// Whether to go on.
    #[must_use]
    pub fn go_on(&self) -> bool {
        (self.go_on)()
    }

    pub(crate) fn asks(&self) -> &'a dyn Fn() -> bool {
        self.go_on
    }

    pub(crate) fn tell(&self, stage: Stage) {
        (self.tell)(stage);
    }
}
