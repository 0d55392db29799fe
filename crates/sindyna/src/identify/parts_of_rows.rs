//! Delays of inputs in parts of rows.

use super::reading::Reading;

/// Parts of a row by which a whole delay is changed at first, and one that is known so far.
pub(super) const ROUGHLY: f64 = 1.0 / 2.0;
pub(super) const FINELY: f64 = 1.0 / 16.0;

/// Part of a row that is none.
const LEAST: f64 = 1e-9;

/// Rows by which a delay is changed in all, at most.
const FARTHEST: f64 = 1.0;

/// Delays of which the score is asked, at most.
const MOST: usize = 16;

/// Part of a row within which nothing is asked beside no delay at all.
const NEAR: f64 = 1.0 / 256.0;

/// Difference of scores within which a delay is as good as the best.
const GAIN: f64 = 0.5;

/// The reading near `from` with the least `score`, −2 ln L of so many `values`, and that. Parabolas through three delays, `by` rows apart at first, tell the next one: of the mean square of
/// what is left, which is one where nothing but the delay is wrong. No input acts before it is there.
pub(super) fn likeliest<E>(
    from: Reading,
    by: f64,
    values: f64,
    mut score: impl FnMut(Reading) -> Result<f64, E>,
) -> Result<(Reading, f64), E> {
    let mut asked: Vec<(f64, f64)> = Vec::new();
    let mut next = Ask { rows: from.rows, inside: false };
    for _ in 0..MOST {
        let best = asked.iter().map(|point| point.1).fold(f64::INFINITY, f64::min);
        let now = score(Reading { rows: next.rows, ..from })?;
        asked.push((next.rows, now));
        asked.sort_by(|a, b| a.0.total_cmp(&b.0));
        let is_settled = next.inside && (now - best).abs() < GAIN;
        match proposed(&asked, by, values).filter(|to| (to.rows - from.rows).abs() <= FARTHEST && to.rows >= 0.0) {
            Some(to) if !is_settled => next = to,
            _ => break,
        }
    }
    let best = asked.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((from.rows, f64::INFINITY));
    Ok((Reading { rows: best.0, ..from }, best.1))
}

/// A delay to be asked of.
struct Ask {
    rows: f64,
    /// Whether it is between others.
    inside: bool,
}

/// Where to ask next: beside the best delay, or at the vertex of the parabola through it and its neighbours. `None` where that was asked already.
fn proposed(asked: &[(f64, f64)], by: f64, values: f64) -> Option<Ask> {
    let beside = |rows| Some(Ask { rows, inside: false });
    let best = (0..asked.len()).min_by(|&a, &b| asked[a].1.total_cmp(&asked[b].1))?;
    let (at, least) = asked[best];
    if !least.is_finite() {
        return None;
    }
    if best + 1 == asked.len() {
        return beside(at + by);
    }
    if best == 0 {
        // Before the row there is nothing.
        return if at > 0.0 { beside((at - by).max(0.0)) } else { halfway(asked) };
    }
    let square = |point: &(f64, f64)| (point.0 - at, ((point.1 - least) / values).exp() - 1.0);
    let ((a, f), (b, g)) = (square(&asked[best - 1]), square(&asked[best + 1]));
    let bent = b * f - a * g;
    let to = at + 0.5 * (b * b * f - a * a * g) / bent;
    (to.is_finite() && (to - at).abs() > LEAST).then_some(Ask { rows: to, inside: true })
}

/// Between the first two, unless they are near.
fn halfway(asked: &[(f64, f64)]) -> Option<Ask> {
    let (first, second) = (asked.first()?.0, asked.get(1)?.0);
    (second - first > NEAR).then_some(Ask { rows: 0.5 * (first + second), inside: false })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_likeliest_delay_is_found_in_few_steps() {
        // What is left is noise, or rounding alone, and grows with what the delay is off.
        for (delay, noise) in
            [(0.3, 0.1), (0.3, 1e-9), (1.62, 0.01), (2.0, 1e-12), (0.0, 1e-3), (0.02, 1e-6), (1.4, 1e-11)]
        {
            let mut count = 0;
            let score = |reading: Reading| {
                count += 1;
                let off: f64 = reading.rows - delay;
                Ok::<_, ()>(1000.0 * (noise * noise + off * off * (1.0 + 0.1 * off)).ln())
            };
            let from = Reading { rows: f64::round(delay), ..Reading::GIVEN };
            let (found, _) = likeliest(from, ROUGHLY, 1000.0, score).expect("no errors");
            assert!((found.rows - delay).abs() <= f64::max(0.1 * noise, LEAST), "{delay}, {noise}: {}", found.rows);
            assert!(count <= MOST, "{count}");
        }
    }
}
