//! Inputs that are linear between samples.

use sindyna_core::InterSample;

use crate::logs::{Log, Note, Samples};

/// `log` with inputs that are linear between samples (first-order hold), and a note of it; `given` if that was said.
pub(super) fn linear(log: &Log, given: bool) -> Log {
    let mut notes = log.notes.clone();
    notes.push(Note::FirstOrderHold { given });
    Log { data: log.data.clone().with_intersample(InterSample::Foh), notes, ..log.clone() }
}

/// Whether every input that changes stays the same before and after most of its changes: it was set from row to row, and no straight line leads from one setting to the next.
pub(super) fn is_set(samples: &Samples) -> bool {
    let count = |j: usize| {
        let (mut changes, mut alone) = (0, 0);
        for rollout in samples.data.rollouts() {
            let u = rollout.controls.column(j);
            let differs = |t: usize| u[t].to_bits() != u[t - 1].to_bits();
            for t in (2..u.len().saturating_sub(1)).filter(|&t| differs(t)) {
                changes += 1;
                alone += usize::from(!differs(t - 1) && !differs(t + 1));
            }
        }
        (changes, alone)
    };
    let all: Vec<(usize, usize)> =
        (0..samples.data.control_dim()).map(count).filter(|(changes, _)| *changes > 0).collect();
    !all.is_empty() && all.iter().all(|(changes, alone)| 2 * alone > *changes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sindyna_core::Dataset;

    #[test]
    fn inputs_that_stay_are_set() {
        let of = |u: &dyn Fn(usize) -> f64| {
            let mut data = Dataset::new(1, 1, 1, 1.0);
            data.begin(&[0.0]).expect("a start");
            (0..100).for_each(|t| data.push(&[u(t)], &[u(t)], 0.0, &[0.0]).expect("a step"));
            is_set(&Samples { data, times: None, derivatives: None })
        };
        assert!(of(&|t| (t / 7) as f64), "steps");
        assert!(!of(&|t| (0.1 * t as f64).sin()), "a sine");
        assert!(!of(&|t| (t / 2) as f64 * 0.1 + (t % 2) as f64 * 0.05), "a ramp");
        assert!(!of(&|_| 1.0), "nothing");
    }
}
