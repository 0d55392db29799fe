//! Performance profiles.

use super::axes::{Axes, Axis};
use super::drawing::Figure;
use super::frame::{BOTTOM, LEFT, NAMES_AT, TOP};
use super::names;
use super::style::colour;
use crate::Catalog;
use crate::scores::profile;

/// Scores the axis begins and ends at: from the random policy to a little beyond the anchor, and what is near the anchor.
const WHOLE: (f64, f64) = (0.0, 1.1);
const TOP_SCORES: (f64, f64) = (0.9, 1.05);

/// The profiles of methods, each with the scores of all its runs, as a whole and near the anchor.
pub(crate) fn profiles(catalog: &dyn Catalog, methods: &[(String, Vec<f64>)]) -> Vec<Figure> {
    let figure = |name: &str, caption: &str, range| Figure {
        name: name.into(),
        alternative: format!("Performance profiles, share of runs against normalised return: {caption}"),
        caption: caption.into(),
        elements: drawing(catalog, methods, range),
    };
    vec![figure("profile", "all returns", WHOLE), figure("profile-top", "returns near 1", TOP_SCORES)]
}

fn drawing(catalog: &dyn Catalog, methods: &[(String, Vec<f64>)], (from, to): (f64, f64)) -> String {
    let axes = Axes {
        x: Axis::even("normalised return τ", from, to),
        y: Axis::even("share of runs with at least τ", 0.0, 1.02),
        left: LEFT,
        right: NAMES_AT,
        top: TOP,
        bottom: BOTTOM,
    };
    let mut text = String::new();
    axes.draw(&mut text);
    // The first method lies on top.
    for (method, scores) in methods.iter().rev() {
        axes.line(&mut text, &format!("{} curve", colour(catalog, method)), &profile(scores, from, to));
    }
    let entries: Vec<(String, &str)> =
        methods.iter().map(|(method, _)| (colour(catalog, method), method.as_str())).collect();
    names::legend(&mut text, &entries, NAMES_AT, TOP);
    text
}
