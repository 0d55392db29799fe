//! The lattice on which an encoder's values lie, found in the values: text that has all digits of a double hides it.

/// Steps to a range, beyond which a lattice is no coarser than noise that nobody sees.
const FINEST: f64 = 1e6;

/// Distinct values from which their common step is no chance.
const DISTINCT: usize = 8;

/// Share of a step by which a value may be off the lattice.
const OFF: f64 = 1e-3;

/// The step of which all differences of `values` are multiples, if there is one that is coarse enough to matter.
pub(crate) fn step(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let reach = values.first()?.abs().max(values.last()?.abs());
    let range = values.last()? - values.first()?;
    // Whole numbers are counts.
    if range <= 0.0 || values.iter().all(|v| v.fract() == 0.0) {
        return None;
    }
    let rounding = 1e-9 * reach.max(range);
    let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).filter(|s| *s > rounding).collect();
    if steps.len() + 1 < DISTINCT {
        return None;
    }
    let finest = range / FINEST;
    // Euclid's algorithm, ended where what is left is rounding.
    let mut common = steps[0];
    for step in &steps {
        let (mut a, mut b) = (*step, common);
        while b > OFF * a.max(common) && b > rounding {
            (a, b) = (b, (a - b * (a / b).round()).abs());
        }
        common = a;
        if common < finest {
            return None;
        }
    }
    let first = values[0];
    let cells = (range / common).round();
    let common = range / cells;
    let fits = |v: &f64| {
        let at = (v - first) / common;
        (at - at.round()).abs() <= 10.0 * OFF + rounding / common
    };
    // A few values far from the others are no lattice, whatever the others are.
    let mut occupied: Vec<i64> = values.iter().map(|v| ((v - first) / common).round() as i64).collect();
    occupied.dedup();
    (occupied.len() >= DISTINCT && values.iter().all(fits)).then_some(common)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_encoders_lattice_is_found_and_smooth_signals_have_none() {
        let encoder = |i: i32| (f64::from(i) * 0.37).sin();
        let rounded = |q: f64, offset: f64| move |i: i32| offset + q * (encoder(i) / q).round();
        let check = |q: f64, offset: f64| {
            let found = step((0..500).map(rounded(q, offset)));
            assert!(found.is_some_and(|f| (f / q - 1.0).abs() < 1e-6), "{q}: {found:?}");
        };
        check(191.0 / 65535.0, -191.0 / 65535.0 / 2.0);
        check(std::f64::consts::TAU / 4096.0, 0.0);
        check(1e-4, 3.0);
        assert_eq!(step((0..500).map(encoder)), None);
        assert_eq!(step((0..500).map(|i| f64::from(encoder(i) as f32))), None, "float32 is no lattice");
        assert_eq!(step((0..500).map(f64::from)), None, "whole numbers are counts");
        assert_eq!(step([0.5, 1.5, 0.5, 1.5].into_iter()), None, "too few to tell");
        let failing = (0..500).map(|i| if i % 40 == 7 { -999.0 } else { encoder(i) });
        assert_eq!(step(failing), None, "a sentinel is no lattice");
    }
}
