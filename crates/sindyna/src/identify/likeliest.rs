//! Delays of inputs in parts of rows, and whatever else changes gradually with how a log is read.

/// Parts of a row by which a whole delay is changed at first, and one that is known so far.
pub(super) const ROUGHLY: f64 = 1.0 / 2.0;
pub(super) const FINELY: f64 = 1.0 / 16.0;

/// Part of a row that is none.
const LEAST: f64 = 1e-9;

/// Rows by which a delay is changed in all, at most.
const FARTHEST: f64 = 1.0;

/// Values of which the score is asked, at most.
const MOST: usize = 16;

/// Distance from the lowest value within which nothing more is asked.
const NEAR: f64 = 1.0 / 256.0;

/// Difference of scores within which a value is as good as the best.
const GAIN: f64 = 0.5;

/// Delays near one of so many `rows`, as lowest and highest. No input acts before it is there.
pub(super) fn near(rows: f64) -> (f64, f64) {
    ((rows - FARTHEST).max(0.0), rows + FARTHEST)
}

/// The parameter from `low` to `high` with the least `score`, −2 ln L of so many `values`, and that. Parabolas through three values, those about `from` and `by` apart at first, tell the next one: of
/// the mean square of what is left, which is one where nothing but the parameter is wrong.
pub(super) fn likeliest<E>(
    (from, by): (f64, f64),
    (low, high): (f64, f64),
    values: f64,
    mut score: impl FnMut(f64) -> Result<f64, E>,
) -> Result<(f64, f64), E> {
    let mut asked: Vec<(f64, f64)> = Vec::new();
    let mut next = Ask { at: from, inside: false };
    for _ in 0..MOST {
        let best = asked.iter().map(|point| point.1).fold(f64::INFINITY, f64::min);
        let now = score(next.at)?;
        asked.push((next.at, now));
        asked.sort_by(|a, b| a.0.total_cmp(&b.0));
        let is_settled = next.inside && (now - best).abs() < GAIN;
        match proposed(&asked, by, low, values).filter(|to| (low..=high).contains(&to.at)) {
            Some(to) if !is_settled => next = to,
            _ => break,
        }
    }
    Ok(asked.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((from, f64::INFINITY)))
}

/// A parameter to be asked of.
struct Ask {
    at: f64,
    /// Whether it is between others.
    inside: bool,
}

/// Where to ask next: beside the best one, not below `low`, or at the vertex of the parabola through it and its neighbours. `None` where that was asked already.
fn proposed(asked: &[(f64, f64)], by: f64, low: f64, values: f64) -> Option<Ask> {
    let beside = |at| Some(Ask { at, inside: false });
    let best = (0..asked.len()).min_by(|&a, &b| asked[a].1.total_cmp(&asked[b].1))?;
    let (at, least) = asked[best];
    if !least.is_finite() {
        return None;
    }
    if best + 1 == asked.len() {
        return beside(at + by);
    }
    if best == 0 {
        return if at > low { beside((at - by).max(low)) } else { halfway(asked) };
    }
    let square = |point: &(f64, f64)| (point.0 - at, ((point.1 - least) / values).exp() - 1.0);
    let ((a, f), (b, g)) = (square(&asked[best - 1]), square(&asked[best + 1]));
    let bent = b * f - a * g;
    let to = at + 0.5 * (b * b * f - a * a * g) / bent;
    (to.is_finite() && (to - at).abs() > LEAST).then_some(Ask { at: to, inside: true })
}

/// Between the first two, unless they are near.
fn halfway(asked: &[(f64, f64)]) -> Option<Ask> {
    let (first, second) = (asked.first()?.0, asked.get(1)?.0);
    (second - first > NEAR).then_some(Ask { at: 0.5 * (first + second), inside: false })
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
            let score = |at: f64| {
                count += 1;
                let off: f64 = at - delay;
                Ok::<_, ()>(1000.0 * (noise * noise + off * off * (1.0 + 0.1 * off)).ln())
            };
            let from = f64::round(delay);
            let (found, _) = likeliest((from, ROUGHLY), near(from), 1000.0, score).expect("no errors");
            assert!((found - delay).abs() <= f64::max(0.1 * noise, LEAST), "{delay}, {noise}: {found}");
            assert!(count <= MOST, "{count}");
        }
    }
}
