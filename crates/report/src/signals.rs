//! The page of a log: its signals against time.

use crate::Page;
use crate::document::Block;
use crate::figure::series::{Line, Series, series};
use crate::thin::Point;

/// Points of all figures, which bounds the size of a page.
const POINTS: usize = 6_000;

/// Signals that are drawn.
const MOST: usize = 16;

/// One signal of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    /// The signal with its unit, such as `θ [rad]`.
    pub label: String,
    /// Time \[s\] and value of each sample, in pieces between which there is a gap.
    pub pieces: Vec<Vec<Point>>,
}

/// The page of a log called `source`: `lines` of text, a table with the name of a signal in the first column, and `signals` against time.
#[must_use]
pub fn log_page<const N: usize>(
    source: &str,
    lines: &[String],
    (head, rows): ([&str; N], Vec<[String; N]>),
    signals: &[Signal],
) -> Page {
    let mut blocks: Vec<Block> = lines.iter().map(Block::text).collect();
    blocks.push(Block::Section("Signals".into()));
    blocks.push(Block::table(1, head, rows));
    let drawn = &signals[..signals.len().min(MOST)];
    let figures = drawn.iter().enumerate().map(|(i, signal)| {
        let borders: Vec<f64> = signal.pieces.iter().skip(1).filter_map(|piece| Some(piece.first()?.0)).collect();
        let of = Series {
            label: &signal.label,
            time: if signal.pieces.len() > 1 { "t [s], trajectories one after another" } else { "t [s]" },
            lines: vec![Line { class: "measured", name: "measured", pieces: signal.pieces.clone() }],
            residuals: None,
            borders: if borders.len() > 20 { Vec::new() } else { borders },
            most: (POINTS / drawn.len()).min(1_200),
        };
        series(format!("signal-{i}"), format!("{} against time", signal.label), signal.label.clone(), &of)
    });
    blocks.push(Block::Figures(figures.collect()));
    if signals.len() > drawn.len() {
        blocks.push(Block::text(format!("The first {MOST} of {} signals are drawn.", signals.len())));
    }
    Page { title: format!("Log {source}"), blocks }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_becomes_a_page_without_markup_of_its_own() {
        let pieces = vec![vec![(0.0, 1.0), (1.0, 2.0)], vec![(2.0, 0.0), (3.0, -1.0)]];
        let signals = [Signal { label: "<b> [rad]".into(), pieces }];
        let row = ["<b>".to_owned(), "1".to_owned()];
        let html = log_page("a.csv", &["two rows".into()], (["signal", "lowest"], vec![row]), &signals).html();
        assert!(html.contains("Log a.csv") && html.contains("two rows") && html.contains("<svg"));
        assert!(!html.contains("<b>") && html.contains("&lt;b&gt;"), "{html}");
    }
}
