//! Equations compared by what they predict of samples that they were not fitted to.

use ndarray::s;
use sindyna_core::Spec;
use sindyna_sindy::{Identifier, Model, Recording};

use super::as_read::recordings_of;
use super::unmeasured::hidden;
use crate::logs::Samples;

/// Steps of a window, and number of windows at most: these are spread evenly, so that what one misses says little of the next.
const WINDOW: usize = 10;
const WINDOWS: usize = 30;

/// Probability of what is taken for chance: odds of twenty to one, and one of six readings.
const CHANCE: f64 = 1.0 / (20.0 * 6.0);

/// RMS error of what `model`, found by `identifier`, predicts over each of some windows of `samples` after the first `fitted` steps: of each state that was measured, as a part
/// of its standard deviation. Infinite where it diverges; nothing if there are no such steps.
///
/// `samples` are those of a system `of`, of which `rates`, as (name, state), were not measured.
pub(super) fn missed(
    (model, identifier): (&Model, &Identifier),
    (samples, fitted): (&Samples, usize),
    (of, rates): (&Spec, &[(String, usize)]),
) -> Vec<f64> {
    let Samples { data, times, .. } = samples;
    let spec = identifier.spec();
    let filled = match rates {
        [] => Ok(recordings_of(samples)),
        _ => identifier.filled(model, &hidden(data, times.as_deref(), of, rates)),
    };
    let Ok(recordings) = filled.and_then(|observed| identifier.in_states(observed)) else { return Vec::new() };
    let (mut before, mut starts) = (0, Vec::new());
    for (at, recording) in recordings.iter().enumerate() {
        let first = fitted.saturating_sub(before).min(recording.steps());
        starts.extend(
            (first..).step_by(WINDOW).take_while(|from| from + WINDOW <= recording.steps()).map(|from| (at, from)),
        );
        before += recording.controls.nrows();
    }
    let spread = starts.len().div_ceil(WINDOWS).max(1);
    // Cosine and sine of an angle are two observations of one state.
    let mut sizes = deviations(&recordings, spec.state_dim());
    let is_hidden = |i: &usize| rates.iter().any(|(rate, _)| *rate == spec.state[*i].name);
    (0..sizes.len()).filter(is_hidden).for_each(|i| sizes[i] = 0.0);
    starts.iter().step_by(spread).map(|&(at, from)| window(model, &recordings[at], from, &sizes)).collect()
}

/// The error over the window of `recording` from the step `from` on.
fn window(model: &Model, recording: &Recording, from: usize, sizes: &[f64]) -> f64 {
    let to = from + WINDOW;
    let dt: Vec<f64> = recording.times[from..=to].windows(2).map(|t| t[1] - t[0]).collect();
    let start = recording.states.row(from).to_vec();
    let Ok(ahead) = model.simulate_at(&start, recording.inputs(from, to), &dt) else { return f64::INFINITY };
    let seen = recording.states.slice(s![from..=to, ..]);
    let square = |(i, size): (usize, &f64)| {
        let (ahead, seen) = (ahead.column(i), seen.column(i));
        ahead.iter().zip(seen).map(|(a, b)| ((a - b) / size).powi(2)).sum::<f64>()
    };
    (sizes.iter().enumerate().filter(|(_, size)| **size > 0.0).map(square).sum::<f64>() / WINDOW as f64).sqrt()
}

/// The standard deviations of the first `count` states.
fn deviations(recordings: &[Recording], count: usize) -> Vec<f64> {
    let deviation = |i: usize| {
        let values: Vec<f64> = recordings.iter().flat_map(|r| r.states.column(i).to_vec()).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
    };
    (0..count).map(deviation).collect()
}

/// Which of the lists of errors, over the same windows, is the least: that with the least median, if it is smaller than every other in so many windows that chance does not
/// explain it (sign test).
pub(super) fn clearly_least(errors: &[&[f64]]) -> Option<usize> {
    let windows = errors.iter().map(|e| e.len()).min()?;
    let best = (0..errors.len()).min_by(|&a, &b| median(errors[a]).total_cmp(&median(errors[b])))?;
    let beats = |other: usize| {
        let wins = (0..windows).filter(|&w| errors[best][w] < errors[other][w]).count();
        by_chance(wins, windows) < CHANCE
    };
    (0..errors.len()).filter(|&other| other != best).all(beats).then_some(best)
}

/// The median of `errors`, infinite if there are none.
pub(super) fn median(errors: &[f64]) -> f64 {
    let mut sorted = errors.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::INFINITY)
}

/// The probability of `wins` heads or more in `tosses` of a coin.
fn by_chance(wins: usize, tosses: usize) -> f64 {
    // Of all heads first, then of one less at a time.
    let mut each = 0.5_f64.powi(tosses as i32);
    let mut sum = 0.0;
    for heads in (wins..=tosses).rev() {
        sum += each;
        each *= heads as f64 / (tosses - heads + 1) as f64;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chance_is_binomial() {
        for (wins, tosses, expected) in [(0, 4, 1.0), (4, 4, 1.0 / 16.0), (3, 4, 5.0 / 16.0), (7, 7, 1.0 / 128.0)] {
            assert!((by_chance(wins, tosses) - expected).abs() < 1e-12, "{wins} of {tosses}");
        }
    }

    #[test]
    fn the_least_must_be_so_almost_everywhere() {
        let (low, high): (Vec<f64>, Vec<f64>) = (0..20).map(|w| (1.0 + 0.01 * f64::from(w), 2.0)).unzip();
        let mixed: Vec<f64> = (0..20).map(|w| if w % 2 == 0 { 0.9 } else { 3.0 }).collect();
        assert_eq!(clearly_least(&[&high, &low]), Some(1));
        assert_eq!(clearly_least(&[&low, &mixed]), None);
        assert_eq!(clearly_least(&[&low, &low]), None, "of equal ones none is");
        assert_eq!(clearly_least(&[&[], &[]]), None, "without windows none is");
    }
}
