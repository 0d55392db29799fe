//! How coarsely a column was measured or written down.

use crate::recording::Recording;
use crate::{Note, lattice};

/// Distance of two neighbouring values of a state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Step {
    /// Nothing that would be seen.
    None,
    /// As its digits show.
    Digits(f64),
    /// As its values show.
    Lattice(f64),
}

impl Step {
    pub(crate) fn size(self) -> Option<f64> {
        match self {
            Self::None => None,
            Self::Digits(step) | Self::Lattice(step) => Some(step),
        }
    }

    /// Turns it into another unit.
    pub(crate) fn scale(&mut self, factor: f64) {
        if let Self::Digits(step) | Self::Lattice(step) = self {
            *step *= factor;
        }
    }

    /// What is to be said of it for the state called `state`.
    pub(crate) fn note(&self, state: &str) -> Option<Note> {
        match *self {
            Self::None => None,
            Self::Digits(step) => Some(Note::Rounded { state: state.to_owned(), step }),
            Self::Lattice(step) => Some(Note::Lattice { state: state.to_owned(), step }),
        }
    }
}

/// The steps of the states of `recordings`: as `digits` show, else as their values do.
pub(crate) fn steps(recordings: &[Recording], digits: &[Option<f64>]) -> Vec<Step> {
    let values = |i: usize| recordings.iter().flat_map(move |r| r.states.column(i).to_vec());
    let of_values = |i: usize| lattice::step(values(i)).map_or(Step::None, Step::Lattice);
    digits.iter().enumerate().map(|(i, step)| step.map_or_else(|| of_values(i), Step::Digits)).collect()
}
