//! Which states are the rates of others.

use std::f64::consts::PI;

use crate::positions::positions;
use crate::recording::Recording;
use crate::{DeclarationError, LogError, Note, StateOption};

/// Largest RMS difference between a state and what another one changes by, as a share of that change.
pub(crate) const CLOSE: f64 = 0.05;

/// Part of that which the noise of single samples may be.
const NOISE: f64 = 0.5;

/// Steps over which changes are compared, at least: noise of single samples weighs less on longer ones.
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

/// Units of rates, and how many radians per second one of each is; those of angles, whose rates are in radians per second, are not among them.
const UNITS: [(&str, f64); 3] = [("deg/s", PI / 180.0), ("rpm", PI / 30.0), ("rev/s", 2.0 * PI)];

/// Factors between units of one quantity, besides those of [`UNITS`], and how near to one of them they are taken for it.
const FACTORS: [f64; 8] = [1e3, 1e-3, 1e6, 1e-6, 60.0, 3600.0, 3.6, 1.0 / 3.6];
const NEAR: f64 = 0.02;

/// Notes of states that no other one was `seen` to be the rate of, and that change by one in another unit.
pub(crate) fn in_other_units(recordings: &[Recording], names: &[String], seen: &[Seen]) -> Vec<Note> {
    let unit = |(rate, of): (usize, usize)| {
        let follows = |factor: f64| off_by_times(recordings, (rate, factor), of).is_some_and(|off| off <= CLOSE);
        let (rate_name, of_name) = (names[rate].clone(), names[of].clone());
        if let Some((unit, _)) = UNITS.iter().find(|(_, factor)| follows(*factor)) {
            return Some(Note::RateInOtherUnit { rate: rate_name, of: of_name, unit: (*unit).to_owned() });
        }
        let factor = factor(recordings, rate, of)?;
        let near = FACTORS.into_iter().find(|unit| (factor / unit - 1.0).abs() <= NEAR)?;
        follows(near).then_some(Note::RateScaled { rate: rate_name, of: of_name, factor: near })
    };
    unrelated(names.len(), seen).filter_map(unit).collect()
}

/// Pairs of different states among `n`, as (rate, of), of which the first was `seen` to be the rate of none, and the second to have none.
pub(crate) fn unrelated(n: usize, seen: &[Seen]) -> impl Iterator<Item = (usize, usize)> {
    let is_free = |&(rate, of): &(usize, usize)| rate != of && seen.iter().all(|s| s.rate != rate && s.of != of);
    (0..n).flat_map(move |of| (0..n).map(move |rate| (rate, of))).filter(is_free)
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
/// nothing changes. Changes are those over the fewest steps, from ten on, over which noise of single samples is small beside them; or over those over which there is most change.
pub(crate) fn off_by(recordings: &[Recording], rate: usize, of: usize) -> Option<f64> {
    off_by_times(recordings, (rate, 1.0), of)
}

/// The same of a rate that is multiplied by a factor.
fn off_by_times(recordings: &[Recording], rate: (usize, f64), of: usize) -> Option<f64> {
    let pairs: Vec<Pair> = recordings.iter().map(|recording| Pair::new(recording, rate, of)).collect();
    let longest = pairs.iter().map(|pair| pair.x.len() / 4).max()?;
    // Over one step the noise of two samples is all there is of a difference, and nearly nothing of what differs slowly.
    let noise = compared(&pairs, 1)?.0;
    let lags = std::iter::successors(Some(LAG), |lag| Some(2 * lag)).take_while(|lag| *lag <= longest.max(LAG));
    let mut best = (0.0, 0.0);
    for (difference, change) in lags.filter_map(|lag| compared(&pairs, lag)) {
        best = if change > best.1 { (difference, change) } else { best };
        if noise <= (NOISE * CLOSE).powi(2) * change {
            break;
        }
    }
    (best.1 > 0.0).then(|| (best.0 / best.1).sqrt())
}

/// What the integral of `rate` must be multiplied by for the changes of `of` over [`LAG`] steps, by least squares.
fn factor(recordings: &[Recording], rate: usize, of: usize) -> Option<f64> {
    let (mut both, mut square) = (0.0, 0.0);
    for Pair { x, integrals } in recordings.iter().map(|recording| Pair::new(recording, (rate, 1.0), of)) {
        let lag = LAG.min(x.len() / 4).max(1);
        for first in 0..x.len().saturating_sub(lag) {
            let by = integrals[0][first + lag] - integrals[0][first];
            both += by * (x[first + lag] - x[first]);
            square += by * by;
        }
    }
    (square > 0.0).then(|| both / square)
}

/// A state and what may be its rate in one recording, with the integral of the latter up to every sample, by each of the sums.
struct Pair {
    x: Vec<f64>,
    integrals: [Vec<f64>; 3],
}

impl Pair {
    fn new(recording: &Recording, (rate, factor): (usize, f64), of: usize) -> Self {
        let v = &recording.states.column(rate) * factor;
        let steps: Vec<f64> = recording.steps().collect();
        let integral = |new: f64| {
            let step = |sum: &mut f64, i: usize| {
                *sum += steps[i] * ((1.0 - new) * v[i] + new * v[i + 1]);
                Some(*sum)
            };
            std::iter::once(0.0).chain((0..v.len().saturating_sub(1)).scan(0.0, step)).collect()
        };
        Self { x: recording.states.column(of).to_vec(), integrals: NEW.map(integral) }
    }
}

/// Mean squares of (change − integral), by the sum that fits best, and of the change, over so many steps; fewer in short recordings. `None` with less than
/// three of them.
fn compared(pairs: &[Pair], lag: usize) -> Option<(f64, f64)> {
    let (mut difference, mut change, mut count) = ([0.0; 3], 0.0, 0_u32);
    for Pair { x, integrals } in pairs {
        let lag = lag.min(x.len() / 4).max(1);
        for first in 0..x.len().saturating_sub(lag) {
            let moved = x[first + lag] - x[first];
            for (difference, sum) in difference.iter_mut().zip(integrals) {
                *difference += (moved - (sum[first + lag] - sum[first])).powi(2);
            }
            change += moved * moved;
            count += 1;
        }
    }
    let least = difference.into_iter().fold(f64::INFINITY, f64::min);
    let mean = |sum: f64| sum / f64::from(count);
    (count >= 3).then(|| (mean(least), mean(change)))
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
    fn rates_in_degrees_and_turns_are_noted() {
        let names = ["th".to_owned(), "w".to_owned()];
        let noted = |factor: f64| {
            let log = [recording(2, |t, j| [(2.0 * t).sin(), factor * 2.0 * (2.0 * t).cos()][j])];
            let seen = recognised(&log);
            in_other_units(&log, &names, &seen).iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
        };
        assert!(noted(180.0 / PI).starts_with("w would be the rate of th if it were in deg/s"));
        assert!(noted(30.0 / PI).contains("in rpm") && noted(0.5 / PI).contains("in rev/s"));
        assert!(noted(1.0).is_empty() && noted(50.0).is_empty());
        assert!(noted(1e3).contains("multiplied by 0.001") && noted(1e-3).contains("multiplied by 1000"));
        assert!(noted(3.6).contains("multiplied by 0.2778"));
    }

    #[test]
    fn noise_on_single_samples_does_not_hide_a_rate() {
        let noise = |t: f64| 1e-3 * (1e4 * t).sin();
        let seen = recognised(&[recording(2, |t, j| [t.sin() + noise(t), t.cos() + noise(t + 1.0)][j])]);
        assert_eq!(seen.iter().map(|s| (s.rate, s.of)).collect::<Vec<_>>(), [(1, 0)]);
        // A place that moves far beside its noise in a second, but not in ten samples; and one whose rate is shown by a slow sensor.
        let noise = |t: f64| 0.01 * (1e4 * t).sin();
        let place = |t: f64, j: usize| [0.4 * t.sin() + noise(t), 0.4 * t.cos() + noise(t + 1.0)][j];
        let seen = recognised(&[long(place)]);
        assert_eq!(seen.iter().map(|s| (s.rate, s.of)).collect::<Vec<_>>(), [(1, 0)]);
        let slow = |t: f64, j: usize| [0.4 * t.sin() + noise(t), 0.4 * (t - 0.15).cos() + noise(t + 1.0)][j];
        assert!(recognised(&[long(slow)]).is_empty());
    }

    /// Two states, every 10 ms.
    fn long(x: impl Fn(f64, usize) -> f64) -> Recording {
        let states = Array2::from_shape_fn((1500, 2), |(i, j)| x(0.01 * i as f64, j));
        let times = (0..1500).map(|i| 0.01 * f64::from(i)).collect();
        Recording { times, states, inputs: Array2::zeros((1500, 0)), ..Recording::default() }
    }
}
