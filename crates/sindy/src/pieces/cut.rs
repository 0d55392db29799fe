//! Recordings cut into pieces.

use ndarray::{Array2, s};

use crate::data::Segment;

/// Autocorrelation at which the time scale of a signal is read: that of a sine falls to it in a sixth of its period.
const CORRELATED: f64 = 0.5;

/// Cells of a piece for every time scale, at most.
const CELLS: f64 = 32.0;

/// Length of a piece in time scales.
const LENGTH: f64 = 1.5;

/// A short part of a recording, cut into cells.
#[derive(Debug, Clone)]
pub(super) struct Piece {
    /// Number of the recording.
    pub(super) recording: usize,
    /// Time since the start of the recording \[s\].
    pub(super) start: f64,
    /// Measured states at the borders of the cells (M + 1, n).
    pub(super) x: Array2<f64>,
    /// Inputs, averaged over each cell (M, k).
    pub(super) u: Array2<f64>,
    /// Lengths of the cells \[s\] (M).
    pub(super) dt: Vec<f64>,
}

/// The longest time \[s\] in which one of the `states` forgets where it was; `None` if none moves.
pub(super) fn time_scale(segments: &[Segment], states: &[usize]) -> Option<f64> {
    let steps: usize = segments.iter().map(Segment::len).sum();
    let seconds: f64 = segments.iter().flat_map(|s| &s.dt).sum();
    let mean_step = seconds / steps.max(1) as f64;
    let longest = segments.iter().map(Segment::len).max().unwrap_or(0);
    let of = |&i: &usize| {
        let count: usize = segments.iter().map(|s| s.x.nrows()).sum();
        let mean = segments.iter().map(|s| s.x.column(i).sum()).sum::<f64>() / count.max(1) as f64;
        let correlation = |lag: usize| {
            let (mut sum, mut count) = (0.0, 0.0);
            for segment in segments {
                let x = segment.x.column(i);
                for t in 0..x.len().saturating_sub(lag) {
                    sum += (x[t] - mean) * (x[t + lag] - mean);
                    count += 1.0;
                }
            }
            sum / f64::max(count, 1.0)
        };
        let variance = correlation(0);
        (variance > 0.0).then(|| (1..longest / 2).find(|&lag| correlation(lag) < CORRELATED * variance)).flatten()
    };
    let lag = states.iter().filter_map(of).max()?;
    Some(lag as f64 * mean_step)
}

/// `segments` in pieces of [`LENGTH`] time scales, `scale` \[s\] each.
pub(super) fn pieces(segments: &[Segment], scale: f64) -> Vec<Piece> {
    let mut all = Vec::new();
    for (recording, segment) in segments.iter().enumerate() {
        let mut time = vec![0.0];
        segment.dt.iter().for_each(|dt| time.push(time.last().copied().unwrap_or(0.0) + dt));
        let mut from = 0;
        loop {
            let to = time.partition_point(|t| *t < time[from] + LENGTH * scale);
            if to >= time.len() {
                break;
            }
            all.push(piece(recording, segment, &time, (from, to), scale / CELLS));
            from = to;
        }
    }
    all
}

/// Samples `from` to `to` of a segment, in cells of about `cell` \[s\].
fn piece(recording: usize, segment: &Segment, time: &[f64], (from, to): (usize, usize), cell: f64) -> Piece {
    let mut borders = vec![from];
    let mut at = from;
    while at < to {
        let next = time.partition_point(|t| *t < time[at] + cell).clamp(at + 1, to);
        borders.push(next);
        at = next;
    }
    let cells = borders.len() - 1;
    let u = segment.mean_inputs();
    let average = |(m, k): (usize, usize)| {
        let rows = borders[m]..borders[m + 1];
        let sum: f64 = rows.clone().map(|t| segment.dt[t] * u[[t, k]]).sum();
        sum / (time[rows.end] - time[rows.start])
    };
    Piece {
        recording,
        start: time[from],
        x: Array2::from_shape_fn((cells + 1, segment.x.ncols()), |(m, i)| segment.x[[borders[m], i]]),
        u: Array2::from_shape_fn((cells, segment.u.ncols()), average),
        dt: (0..cells).map(|m| time[borders[m + 1]] - time[borders[m]]).collect(),
    }
}

impl Piece {
    /// Its length \[s\].
    pub(super) fn seconds(&self) -> f64 {
        self.dt.iter().sum()
    }

    /// Its first measured state.
    pub(super) fn first(&self) -> Vec<f64> {
        self.x.slice(s![0, ..]).to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// sin(2π t) with its rate, sampled unevenly.
    fn wave() -> Segment {
        let mut time: Vec<f64> = vec![0.0];
        let mut dt = Vec::new();
        for i in 0..999 {
            dt.push(0.01 + 0.002 * (i % 3) as f64);
            time.push(time[i] + dt[i]);
        }
        let at = |(t, i): (usize, usize)| {
            let phase = std::f64::consts::TAU * time[t];
            if i == 0 { phase.sin() } else { phase.cos() }
        };
        Segment {
            x: Array2::from_shape_fn((1000, 2), at),
            u: Array2::from_shape_fn((999, 1), |(t, _)| time[t]),
            dt,
            ramp: None,
            relative: None,
            of_inputs: Vec::new(),
            corrections: None,
        }
    }

    #[test]
    fn the_time_scale_of_a_sine_is_a_sixth_of_its_period() {
        let scale = time_scale(&[wave()], &[0, 1]).expect("it moves");
        assert!((scale - 1.0 / 6.0).abs() < 0.02, "{scale}");
    }

    #[test]
    fn cells_have_the_average_of_the_input_and_pieces_follow_each_other() {
        let all = pieces(&[wave()], 1.0 / 6.0);
        assert!(all.len() > 30);
        for pair in all.windows(2) {
            assert!((pair[0].start + pair[0].seconds() - pair[1].start).abs() < 1e-9);
            assert_eq!(pair[0].x.row(pair[0].x.nrows() - 1), pair[1].x.row(0));
        }
        // An input that rises with the time is late by less than a cell.
        let mut time = all[3].start;
        for (u, dt) in all[3].u.iter().zip(&all[3].dt) {
            assert!((u - time).abs() < *dt, "{u} {time}");
            time += dt;
        }
    }
}
