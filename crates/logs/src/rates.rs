//! Which states are the rates of others.

use crate::positions::positions;
use crate::recording::Recording;
use crate::{DeclarationError, LogError, Note, StateOption};

/// Largest RMS difference between a state and what another one changes by, as a share of that change.
const CLOSE: f64 = 0.05;

/// Steps over which changes are compared: noise of single samples weighs less on longer ones.
const LAG: usize = 10;

/// A state that was seen to be the rate of another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Seen {
    /// The rate.
    pub(crate) rate: usize,
    /// What it is the rate of.
    pub(crate) of: usize,
    /// RMS difference, as a share of the change.
    pub(crate) off_by: f64,
}

/// The states whose integral another state follows in `recordings`, whose times are in seconds: best match first, every
/// state the rate of one other at most, none its own rate by way of others.
pub(crate) fn recognised(recordings: &[Recording]) -> Vec<Seen> {
    let n = recordings.first().map_or(0, |r| r.states.ncols());
    let pairs = (0..n).flat_map(|of| (0..n).filter(move |rate| *rate != of).map(move |rate| (rate, of)));
    let seen = |(rate, of)| Some(Seen { rate, of, off_by: off_by(recordings, rate, of)? });
    let mut seen: Vec<Seen> = pairs.filter_map(seen).filter(|s| s.off_by <= CLOSE).collect();
    seen.sort_by(|a, b| a.off_by.total_cmp(&b.off_by));
    let mut kept: Vec<Seen> = Vec::new();
    for candidate in seen {
        let pairs: Vec<(usize, usize)> = kept.iter().map(|k| (k.rate, k.of)).collect();
        let pair = (candidate.rate, candidate.of);
        if pairs.iter().all(|k| k.0 != pair.0 && k.1 != pair.1) && !closes_circle(&pairs, pair) {
            kept.push(candidate);
        }
    }
    kept
}

/// Whether following "is the rate of" in `kept` from the state of which `rate` is one leads back to `rate`; each pair is a rate and
/// its state, and `kept` has no circle.
#[must_use]
pub fn closes_circle(kept: &[(usize, usize)], (rate, of): (usize, usize)) -> bool {
    let mut at = of;
    while let Some((_, next)) = kept.iter().find(|(r, _)| *r == at) {
        at = *next;
    }
    at == rate
}

/// The `pairs` of names (rate, state) among the `states`.
pub(crate) fn given(pairs: &[(String, String)], states: &[String]) -> Result<Vec<(usize, usize)>, LogError> {
    let mut rates: Vec<(usize, usize)> = Vec::new();
    for (rate, of) in pairs {
        let both = positions(&[rate.clone(), of.clone()], states, StateOption::Rates)?;
        let (rate_idx, of_idx) = (both[0], both[1]);
        let (rate, of) = (rate.clone(), of.clone());
        if rate_idx == of_idx {
            return Err(DeclarationError::OwnRate { state: rate }.into());
        }
        if let Some(&(r, o)) = rates.iter().find(|(r, o)| *r == rate_idx || *o == of_idx) {
            let (other_rate, other_of) = (states[r].clone(), states[o].clone());
            return Err(DeclarationError::RateTaken { rate, of, other_rate, other_of }.into());
        }
        if closes_circle(&rates, (rate_idx, of_idx)) {
            return Err(DeclarationError::RateCircle { rate, of }.into());
        }
        rates.push((rate_idx, of_idx));
    }
    Ok(rates)
}

/// A note where a state hardly changes by what was declared to be its rate.
pub(crate) fn doubted(states: &[Recording], names: &[String], rate: usize, of: usize) -> Option<Note> {
    /// Difference, as a share of the change, from which nothing speaks for it.
    const DOUBTFUL: f64 = 0.5;
    let off_by = off_by(states, rate, of).filter(|off| *off > DOUBTFUL)?;
    Some(Note::DoubtfulRate { rate: names[rate].clone(), of: names[of].clone(), percent: 100.0 * off_by })
}

/// How much of the new rate a simulated step may have moved by: all of it (semi-implicit Euler), half of it (nature), none
/// (Euler).
const NEW: [f64; 3] = [0.5, 1.0, 0.0];

/// RMS of (change of `of` − integral of `rate`), over the RMS of the change, by the sum that fits best; `None` where
/// nothing changes.
pub(crate) fn off_by(recordings: &[Recording], rate: usize, of: usize) -> Option<f64> {
    let (mut difference, mut change, mut count) = ([0.0; 3], 0.0, 0);
    for recording in recordings {
        let (x, v) = (recording.states.column(of), recording.states.column(rate));
        let lag = LAG.min(x.len() / 4).max(1);
        let steps: Vec<f64> = recording.steps().collect();
        for first in 0..x.len().saturating_sub(lag) {
            let moved = x[first + lag] - x[first];
            for (difference, new) in difference.iter_mut().zip(NEW) {
                let sum = |i: usize| steps[i] * ((1.0 - new) * v[i] + new * v[i + 1]);
                *difference += (moved - (first..first + lag).map(sum).sum::<f64>()).powi(2);
            }
            change += moved * moved;
            count += 1;
        }
    }
    let least = difference.into_iter().fold(f64::INFINITY, f64::min);
    (count >= 3 && change > 0.0).then(|| (least / change).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    fn recording(n: usize, x: impl Fn(f64, usize) -> f64) -> Recording {
        let states = Array2::from_shape_fn((80, n), |(i, j)| x(i as f64 * 0.05, j));
        let times = (0..80).map(|i| f64::from(i) * 0.05).collect();
        Recording { times, states, inputs: Array2::zeros((80, 0)), ..Recording::default() }
    }

    #[test]
    fn rates_are_seen_and_look_alikes_are_not() {
        let check = |n, x: fn(f64, usize) -> f64, expected: &[(usize, usize)]| {
            let seen = recognised(&[recording(n, x)]);
            let mut pairs: Vec<_> = seen.iter().map(|s| (s.rate, s.of)).collect();
            pairs.sort_unstable();
            assert_eq!(pairs, expected, "{seen:?}");
        };
        // An oscillation of 2 rad/s with its rate, whichever comes first; with a copy at another scale.
        check(2, |t, j| [(2.0 * t).sin(), 2.0 * (2.0 * t).cos()][j], &[(1, 0)]);
        check(2, |t, j| [2.0 * (2.0 * t).cos(), (2.0 * t).sin()][j], &[(0, 1)]);
        check(2, |t, j| [(2.0 * t).sin(), (2.0 * t).cos()][j], &[]);
        // Place, speed, acceleration.
        check(3, |t, j| [t.powi(3), 3.0 * t * t, 6.0 * t][j], &[(1, 0), (2, 1)]);
        // sinh and cosh are each the rate of the other: one of them is believed.
        assert_eq!(recognised(&[recording(2, |t, j| [t.sinh(), t.cosh()][j])]).len(), 1);
        // What never changes has no rate.
        check(2, |_, j| [1.0, 0.0][j], &[]);
    }

    #[test]
    fn noise_on_single_samples_does_not_hide_a_rate() {
        let noise = |t: f64| 1e-3 * (1e4 * t).sin();
        let seen = recognised(&[recording(2, |t, j| [t.sin() + noise(t), t.cos() + noise(t + 1.0)][j])]);
        assert_eq!(seen.iter().map(|s| (s.rate, s.of)).collect::<Vec<_>>(), [(1, 0)]);
    }
}
