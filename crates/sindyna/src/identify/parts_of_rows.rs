//! Delays of inputs in parts of rows.

use super::reading::Reading;

/// Part of a row by which whole delays are changed at first.
pub(super) const HALF: f64 = 0.5;

/// Part of a row by which a delay is changed at last, and how often the change is halved without another delay.
const LAST: f64 = 1.0 / 128.0;
const HALVED: usize = 2;

/// The reading near `from`, whose delay is changed by `first` of a row, then by halves of that: `better` tells which of two others, a little earlier and later, is clearly better than one.
pub(super) fn refined<E>(
    from: Reading,
    first: f64,
    mut better: impl FnMut(Reading, [Reading; 2]) -> Result<Option<Reading>, E>,
) -> Result<Reading, E> {
    let (mut at, mut by, mut halved) = (from, first, 0);
    while by >= LAST && halved < HALVED {
        match better(at, [-by, by].map(|by| Reading { rows: at.rows + by, ..at }))? {
            Some(reading) => (at, halved) = (reading, 0),
            None => halved += 1,
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
            refined(from, HALF, better).expect("no errors").rows
        };
        for delay in [2.5, 0.27, -0.6, 1.01] {
            assert!((near(delay, 0.0) - delay).abs() <= LAST, "{delay}");
        }
        assert_eq!((near(3.1, 0.2), near(3.0, 0.0)), (3.0, 3.0));
    }
}
