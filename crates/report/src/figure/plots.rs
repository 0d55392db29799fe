//! Plots of one record: sizes of equations, coverage of data, training, returns.

use std::fmt::Write as _;

use super::axes::{Axes, Axis};
use super::drawing::Figure;
use super::frame::{BOTTOM, LEFT, TOP, WIDTH};
use super::series::short;
use crate::numbers::fixed;
use crate::thin::{Point, range, spread, thinned};

const RIGHT: f64 = WIDTH - 24.0;

/// Dots of a scatter plot.
const DOTS: usize = 600;

/// Samples that are drawn large.
const FEW: usize = 100;

fn axes(x: Axis, y: Axis) -> Axes {
    Axes { x, y, left: LEFT, right: RIGHT, top: TOP, bottom: BOTTOM }
}

fn wide(label: &str, values: impl Iterator<Item = f64>) -> Axis {
    let (low, high) = range(values).unwrap_or((0.0, 1.0));
    let room = 0.04 * (high - low);
    Axis::even(label, low - room, high + room)
}

/// The residual of the best equation of each size; `chosen` is the size that was chosen.
pub(crate) fn sizes(state: &str, label: &str, sizes: &[(usize, f64)], chosen: usize) -> Figure {
    // A residual of zero is drawn at the smallest that is not.
    let (low, high) = range(sizes.iter().map(|s| s.1).filter(|r| *r > 0.0)).unwrap_or((1.0, 1.0));
    let points: Vec<Point> = sizes.iter().map(|&(size, residual)| (size as f64, residual.max(low))).collect();
    let decade = |v: f64| 10_f64.powi(v.log10().floor() as i32);
    let y = Axis::logarithmic(label, decade(low), 10.0 * decade(high));
    let largest = sizes.iter().map(|s| s.0).max().unwrap_or(1).max(1) as f64;
    let axes = axes(Axis::even("number of terms", 0.0, largest).whole(), y);
    let mut text = String::new();
    axes.draw(&mut text);
    axes.line(&mut text, "c0 curve", &points);
    for &point in &points {
        axes.dot(&mut text, "c0", point, 3.0);
    }
    if let Some(&point) = points.iter().find(|p| p.0 as usize == chosen) {
        axes.dot(&mut text, "c4 ring", point, 8.0);
    }
    Figure {
        name: "sizes".into(),
        alternative: format!("Residual of the equation of {state} against its number of terms"),
        caption: format!("{state}: residual of the best equation of each size; the ring is the chosen size, {chosen}"),
        elements: text,
    }
}

/// Where the samples are, in two of the signals.
pub(crate) fn coverage(across: (&str, &[f64]), up: (&str, &[f64])) -> Figure {
    let points: Vec<Point> = across.1.iter().copied().zip(up.1.iter().copied()).collect();
    let axes = axes(wide(&short(across.0), across.1.iter().copied()), wide(&short(up.0), up.1.iter().copied()));
    let mut text = String::new();
    axes.draw(&mut text);
    if points.len() <= FEW {
        points.iter().for_each(|&point| axes.dot(&mut text, "c0", point, 3.0));
    } else {
        axes.dots(&mut text, "c0", &spread(&points, DOTS));
    }
    Figure {
        name: "coverage".into(),
        alternative: format!("Samples: {} against {}", up.0, across.0),
        caption: format!("{} against {}", up.0, across.0),
        elements: text,
    }
}

/// The training curve: return in the model by updates, with times of new fits and returns of real episodes.
pub(crate) fn training(trials: &[Point], fits: &[f64], real: &[Point], threshold: Option<f64>) -> Figure {
    let last = range(trials.iter().chain(real).map(|p| p.0)).map_or(1.0, |r| r.1.max(1.0));
    let returns = trials.iter().chain(real).map(|p| p.1).chain(threshold);
    let axes = axes(Axis::even("updates", 0.0, last).whole(), wide("return in the model", returns));
    let mut text = String::new();
    axes.draw(&mut text);
    if let Some(threshold) = threshold {
        axes.level(&mut text, "mark", threshold);
    }
    for &updates in fits {
        axes.upright(&mut text, "c2 level", updates);
    }
    axes.line(&mut text, "c0 curve", &thinned(trials, 600));
    for &point in &spread(trials, 60) {
        axes.dot(&mut text, "c0", point, 2.4);
    }
    for &point in real {
        axes.dot(&mut text, "c4 ring", point, 7.0);
    }
    let mut caption = String::from("Return of the policy in the model");
    caption += &threshold.map_or_else(String::new, |t| format!("; dotted: threshold {}", fixed(t, 0)));
    caption += if fits.is_empty() { "" } else { "; dashed: the model is identified again" };
    caption += if real.is_empty() { "" } else { "; ring: return of an episode on the system" };
    Figure {
        name: "training".into(),
        alternative: "Training curve: return in the model by updates".into(),
        caption,
        elements: text,
    }
}

/// Returns of the evaluation as a histogram, with the predicted interval of their mean.
pub(crate) fn returns(returns: &[f64], mean: f64, interval: Option<(f64, f64)>, threshold: Option<f64>) -> Figure {
    let ends = interval.iter().flat_map(|(low, high)| [*low, *high]);
    let x = wide("return", returns.iter().copied().chain([mean]).chain(ends).chain(threshold));
    let bins = 24_usize;
    let width = (x.high - x.low) / bins as f64;
    let mut counts = vec![0_usize; bins];
    for value in returns.iter().filter(|v| v.is_finite()) {
        counts[(((value - x.low) / width) as usize).min(bins - 1)] += 1;
    }
    let most = counts.iter().copied().max().unwrap_or(1).max(1) as f64;
    let axes = axes(x, Axis::even("episodes", 0.0, 1.15 * most).whole());
    let mut text = String::new();
    axes.draw(&mut text);
    if let Some((low, high)) = interval {
        let (left, right) = (axes.x(low), axes.x(high));
        let (top, bottom) = (axes.top, axes.bottom);
        let _ = writeln!(
            text,
            r#"<polygon class="c2 band" points="{left:.1},{top} {right:.1},{top} {right:.1},{bottom} {left:.1},{bottom}"/>"#
        );
    }
    for (i, &count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
        let (left, right) = (axes.x(axes.x.low + i as f64 * width), axes.x(axes.x.low + (i + 1) as f64 * width));
        let top = axes.y(count as f64);
        let (right, bottom) = ((right - 1.0).max(left + 1.0), axes.bottom);
        let _ = writeln!(
            text,
            r#"<polygon class="c0 bar" points="{left:.1},{top:.1} {right:.1},{top:.1} {right:.1},{bottom} {left:.1},{bottom}"/>"#
        );
    }
    axes.upright(&mut text, "c0 curve", mean);
    if let Some(threshold) = threshold {
        axes.upright(&mut text, "mark", threshold);
    }
    let mut caption = format!("{} episodes, mean {}", returns.len(), fixed(mean, 1));
    if let Some((low, high)) = interval {
        caption += &format!("; green: predicted interval of the mean, {} to {}", fixed(low, 1), fixed(high, 1));
    }
    caption += &threshold.map_or_else(String::new, |t| format!("; dotted: threshold {}", fixed(t, 0)));
    Figure {
        name: "returns".into(),
        alternative: "Histogram of the returns of the evaluation".into(),
        caption,
        elements: text,
    }
}
