//! Columns that were computed as differences of others.

use sindyna_core::Precision;

use crate::quotient::{Difference, Quotient};
use crate::recording::Recording;

/// Samples between the first and the last of a trajectory that are compared, at least.
const FEWEST: usize = 10;

/// Times as far as rounding that rates at other moments must be from the quotient: else a measured rate would be one too.
const DISTINCT: f64 = 10.0;

/// Rounding of numbers and of what is computed with them, relative to the largest.
const OF_F64: f64 = 1e-14;
const OF_F32: f64 = 2.5e-7;

/// The states `names` whose values in `recordings`, evenly `dt` \[s\] apart, are difference quotients of those of another one up to rounding: `steps` are the distances of
/// neighbouring numbers as they were written, 0 where that is in full, and `None` for a state that is no column.
pub(crate) fn seen(
    (recordings, names): (&[Recording], &[String]),
    (steps, precision): (&[Option<f64>], Precision),
    dt: f64,
) -> Vec<Difference> {
    let relative = if precision == Precision::F32 { OF_F32 } else { OF_F64 };
    let error = |i: usize, step: f64| {
        let values = recordings.iter().flat_map(|r| r.states.column(i).to_vec());
        step + relative * values.fold(0.0, |m: f64, v| m.max(v.abs()))
    };
    let columns = || (0..names.len()).filter_map(|i| Some((i, steps[i]?)));
    let of_rate = |(rate, step): (usize, f64)| {
        let quotient = |(of, step_of): (usize, f64)| {
            let of_errors = error(of, step_of) / dt + error(rate, step);
            let quotient = quotient(recordings, rate, of, dt, of_errors)?;
            Some(Difference { rate: names[rate].clone(), of: names[of].clone(), quotient })
        };
        columns().filter(|(of, _)| *of != rate).find_map(quotient)
    };
    columns().filter_map(of_rate).collect()
}

/// How column `rate` was computed of column `of`, if it is that up to `rounding`, and no rate of another moment is.
fn quotient(recordings: &[Recording], rate: usize, of: usize, dt: f64, rounding: f64) -> Option<Quotient> {
    let (mut off, mut compared) = ([0.0_f64; 3], 0);
    // How far measured rates are from quotients: by accelerations, and by their changes.
    let (mut second, mut third) = (0.0_f64, 0.0_f64);
    for recording in recordings {
        let (v, x) = (recording.states.column(rate), recording.states.column(of));
        for k in 1..x.len().saturating_sub(1) {
            let (back, ahead) = ((x[k] - x[k - 1]) / dt, (x[k + 1] - x[k]) / dt);
            for (off, quotient) in off.iter_mut().zip([back, ahead, 0.5 * (back + ahead)]) {
                *off = off.max((v[k] - quotient).abs());
            }
            second = second.max((ahead - back).abs());
            if k > 1 {
                third = third.max((ahead - 2.0 * back + (x[k - 1] - x[k - 2]) / dt).abs());
            }
            compared += 1;
        }
    }
    let told =
        [(Quotient::Backward, second / 2.0), (Quotient::Forward, second / 2.0), (Quotient::Central, third / 6.0)];
    let is = |(off, (_, apart)): &(f64, (Quotient, f64))| *off <= rounding && *apart > DISTINCT * rounding;
    let found = off.into_iter().zip(told).find(is)?;
    (compared >= FEWEST).then_some(found.1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    const DT: f64 = 0.01;

    /// Positions and rates of an oscillation, the numbers of both rounded to `step`.
    fn recording(rate: impl Fn(f64) -> f64, step: f64) -> Vec<Recording> {
        let round = |v: f64| if step > 0.0 { (v / step).round() * step } else { v };
        let value = |(k, i): (usize, usize)| {
            let t = k as f64 * DT;
            round(if i == 0 { position(t) } else { rate(t) })
        };
        vec![Recording { states: Array2::from_shape_fn((100, 2), value), ..Recording::default() }]
    }

    fn position(t: f64) -> f64 {
        (5.0 * t).sin()
    }

    #[test]
    fn quotients_are_told_from_rates_that_were_measured() {
        let names = ["x", "v"].map(String::from);
        let of = |rate: &dyn Fn(f64) -> f64, step: f64| {
            let found = seen((&recording(rate, step), &names), (&[Some(step); 2], Precision::F64), DT);
            assert!(found.iter().all(|d| (&*d.rate, &*d.of) == ("v", "x")), "{found:?}");
            found.first().map(|d| d.quotient)
        };
        let back = |t: f64| (position(t) - position(t - DT)) / DT;
        let central = |t: f64| (position(t + DT) - position(t - DT)) / (2.0 * DT);
        for step in [0.0, 1e-9, 1e-5] {
            assert_eq!(of(&back, step), Some(Quotient::Backward), "{step}");
            assert_eq!(of(&|t| back(t + DT), step), Some(Quotient::Forward), "{step}");
            assert_eq!(of(&|t| 5.0 * (5.0 * t).cos(), step), None, "{step}: measured");
            assert_eq!(of(&|t| 0.5 * back(t), step), None, "{step}: another unit");
        }
        assert_eq!(of(&central, 0.0), Some(Quotient::Central));
        assert_eq!(of(&central, 1e-5), None, "what was measured would be that too");
        assert_eq!(of(&back, 1e-2), None, "nothing is told");
    }
}
