//! How coarsely a column was measured or written down.

use crate::recording::Recording;
use crate::rounding::Written;
use crate::{Note, lattice};

/// Distance of two neighbouring values of a state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Step {
    /// Nothing that would be seen.
    None,
    /// As its digits show, which are as many as computed numbers have: it was rounded to them, and has no other error.
    Printed(f64),
    /// As its digits show.
    Digits(f64),
    /// As its values show.
    Lattice(f64),
}

impl Step {
    /// The step of which measurement errors come.
    pub(crate) fn size(self) -> Option<f64> {
        match self {
            Self::None | Self::Printed(_) => None,
            Self::Digits(step) | Self::Lattice(step) => Some(step),
        }
    }

    /// The step to which computed numbers were rounded, 0 where they were written in full.
    pub(crate) fn printed(self) -> f64 {
        if let Self::Printed(step) = self { step } else { 0.0 }
    }

    /// Turns it into another unit.
    pub(crate) fn scale(&mut self, factor: f64) {
        if let Self::Printed(step) | Self::Digits(step) | Self::Lattice(step) = self {
            *step *= factor;
        }
    }

    /// What is to be said of it for the state called `state`.
    pub(crate) fn note(&self, state: &str) -> Option<Note> {
        match *self {
            Self::None | Self::Printed(_) => None,
            Self::Digits(step) => Some(Note::Rounded { state: state.to_owned(), step }),
            Self::Lattice(step) => Some(Note::Lattice { state: state.to_owned(), step }),
        }
    }
}

/// The steps of the states of `recordings`: as they were `written`, else as their values show.
pub(crate) fn steps(recordings: &[Recording], written: &[Written]) -> Vec<Step> {
    let values = |i: usize| recordings.iter().flat_map(move |r| r.states.column(i).to_vec());
    let of_values = |i: usize, otherwise: Step| lattice::step(values(i)).map_or(otherwise, Step::Lattice);
    let step = |(i, written): (usize, &Written)| match *written {
        Written::InFull => of_values(i, Step::None),
        Written::Finely { step, .. } => of_values(i, Step::Printed(step)),
        Written::Coarsely(step) => Step::Digits(step),
    };
    written.iter().enumerate().map(step).collect()
}

/// What is to be said of states that were written with fewer digits than they were computed with.
pub(crate) fn printed(steps: &[Step], written: &[Written]) -> Option<Note> {
    let digits = |(step, written): (&Step, &Written)| match (step, written) {
        (Step::Printed(_), Written::Finely { digits, .. }) => Some(*digits),
        _ => None,
    };
    let most = steps.iter().zip(written).filter_map(digits).max();
    most.map(|digits| Note::Printed { digits })
}
