//! Narrow oscillations that are faster than the motion, such as that of a motor against the rod it drives.

use std::f64::consts::TAU;

use ndarray::ArrayView1;

use super::finding::Finding;
use super::signal::{Signal, median};

/// Samples of a piece of which a spectrum is made.
const PIECE: usize = 256;

/// Pieces at most: more tell no more.
const MOST: usize = 400;

/// How many times as fast as the motion an oscillation is.
const FASTER: usize = 4;

/// How many times as strong as what is around it it is, which chance does not do in a mean of several pieces.
const STRONGER: f64 = 4.0;

/// Share of how the signal changes from which it matters.
const MATTERS: f64 = 0.1;

/// Pieces from which a mean is one.
const FEWEST: usize = 4;

/// The strongest oscillation of `signal`, whose samples are `dt` \[s\] apart.
pub(super) fn of(signal: &Signal<'_>, dt: f64) -> Option<Finding> {
    let pieces: Vec<ArrayView1<'_, f64>> = signal.pieces.iter().map(|piece| piece.values).collect();
    let power = spectrum(&pieces)?;
    // Changes from sample to sample weigh what is fast.
    let change = |k: usize| power[k] * (TAU * k as f64 / PIECE as f64 / 2.0).sin().powi(2) * 4.0;
    let motion = (1..power.len()).max_by(|a, b| power[*a].total_cmp(&power[*b]))?;
    let around = |k: usize| {
        let near = (1..power.len()).filter(|i| i.abs_diff(k) <= 12 && i.abs_diff(k) > 3);
        median(near.map(change).collect()).unwrap_or(f64::INFINITY)
    };
    let width = |peak: usize| peak.saturating_sub(3).max(1)..power.len().min(peak + 4);
    // The flank of the motion has no peak of its own.
    let is_peak = |k: &usize| width(*k).all(|near| change(near) <= change(*k));
    let fast = (FASTER * motion.max(2)..power.len()).filter(is_peak);
    let peak = fast.max_by(|a, b| change(*a).total_cmp(&change(*b)))?;
    let total: f64 = (1..power.len()).map(change).sum();
    let share = width(peak).map(change).sum::<f64>() / total;
    let found = change(peak) > STRONGER * around(peak) && share > MATTERS;
    let rms = width(peak).map(|k| power[k]).sum::<f64>().sqrt();
    let frequency = peak as f64 / (PIECE as f64 * dt);
    found.then(|| Finding::Oscillates { signal: signal.name.to_owned(), frequency, rms, share })
}

/// Variance of each frequency, k per piece, of what `pieces` do around their means; a mean over parts that overlap by half, under a Hann window.
fn spectrum(pieces: &[ArrayView1<'_, f64>]) -> Option<Vec<f64>> {
    let parts: Vec<ArrayView1<'_, f64>> = pieces
        .iter()
        .flat_map(|piece| {
            let begin = (0..=piece.len().saturating_sub(PIECE)).step_by(PIECE / 2).filter(|b| b + PIECE <= piece.len());
            begin.map(|b| piece.slice_move(ndarray::s![b..b + PIECE])).collect::<Vec<_>>()
        })
        .collect();
    if parts.len() < FEWEST {
        return None;
    }
    let parts: Vec<_> = parts.iter().step_by(parts.len().div_ceil(MOST)).collect();
    let turn: Vec<(f64, f64)> = (0..PIECE).map(|i| (TAU * i as f64 / PIECE as f64).sin_cos()).collect();
    let window: Vec<f64> = turn.iter().map(|(_, cos)| 0.5 * (1.0 - cos)).collect();
    let scale = 2.0 / (PIECE as f64 * window.iter().map(|w| w * w).sum::<f64>()) / parts.len() as f64;
    let mut power = vec![0.0; PIECE / 2];
    for part in &parts {
        let mean = part.sum() / PIECE as f64;
        let weighted: Vec<f64> = part.iter().zip(&window).map(|(x, w)| w * (x - mean)).collect();
        for (k, power) in power.iter_mut().enumerate().skip(1) {
            let (mut re, mut im) = (0.0, 0.0);
            for (i, x) in weighted.iter().enumerate() {
                let (sin, cos) = turn[i * k % PIECE];
                re += x * cos;
                im += x * sin;
            }
            *power += scale * (re * re + im * im);
        }
    }
    Some(power)
}
