//! Delays of inputs in parts of rows.

use super::reading::Reading;

/// Parts of a row by which a whole delay is changed, at first and at last; and by which one that is known so far is.
pub(super) const ROUGHLY: (f64, f64) = (1.0 / 2.0, 1.0 / 16.0);
pub(super) const FINELY: (f64, f64) = (1.0 / 8.0, 1.0 / 128.0);

/// The reading near `from`, whose delay is changed by the `first` part of a row, then by halves of that down to the `last`: `better` tells which of two others, a little earlier
/// and later, is clearly better than one. No input acts before it is there.
pub(super) fn refined<E>(
    from: Reading,
    (first, last): (f64, f64),
    mut better: impl FnMut(Reading, [Reading; 2]) -> Result<Option<Reading>, E>,
) -> Result<Reading, E> {
    let (mut at, mut by) = (from, first);
    while by >= last {
        if let Some(reading) = better(at, [-by, by].map(|by| Reading { rows: (at.rows + by).max(0.0), ..at }))? {
            at = reading;
        }
        by *= 0.5;
    }
    Ok(at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delay_is_found_where_it_is_told_apart() {
        let near = |delay: f64, least: f64| {
            let from = Reading { rows: delay.round(), ..Reading::GIVEN };
            let off = |reading: &Reading| (reading.rows - delay).abs();
            let better = |at: Reading, both: [Reading; 2]| {
                Ok::<_, ()>(both.into_iter().find(|other| off(other) + least < off(&at)))
            };
            refined(refined(from, ROUGHLY, better)?, FINELY, better).map(|reading| reading.rows)
        };
        for delay in [2.5, 0.27, 0.0, 1.01] {
            assert!((near(delay, 0.0).expect("no errors") - delay).abs() <= FINELY.1, "{delay}");
        }
        assert_eq!(near(-0.3, 0.0), Ok(0.0), "no input acts before it is there");
        assert_eq!((near(3.1, 0.2), near(3.0, 0.0)), (Ok(3.0), Ok(3.0)));
    }
}
