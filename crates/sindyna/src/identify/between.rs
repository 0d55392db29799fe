//! Inputs that are linear between samples.

use sindyna_core::InterSample;

use crate::logs::{Log, Note};

/// `log` with inputs that are linear between samples (first-order hold), and a note of it; `given` if that was said.
pub(super) fn linear(log: &Log, given: bool) -> Log {
    let mut notes = log.notes.clone();
    notes.push(Note::FirstOrderHold { given });
    Log { data: log.data.clone().with_intersample(InterSample::Foh), notes, ..log.clone() }
}
