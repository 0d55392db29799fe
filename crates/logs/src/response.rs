//! After how long states follow inputs.

use ndarray::{Array1, ArrayView1};

/// Steps by which a response may be late.
const MOST: usize = 50;

/// What happened in one trajectory, step by step (T): an input, the rate of a state, and all that the rate may depend on besides.
pub(crate) struct Signals<'a> {
    pub(crate) input: ArrayView1<'a, f64>,
    pub(crate) rate: Array1<f64>,
    pub(crate) beside: Vec<Array1<f64>>,
}

/// The number of steps (0 or more) after which the rate follows the input most, and their partial correlation there: of what is left of both when
/// their linear dependence on everything beside is taken away. Also how many steps there were.
pub(crate) fn strongest(trajectories: &[Signals<'_>]) -> (usize, f64, usize) {
    let longest = trajectories.iter().map(|s| s.rate.len()).max().unwrap_or(0);
    let most = MOST.min(longest / 4);
    // Every lag is judged by the same steps.
    let all = |of: &dyn Fn(&Signals<'_>, usize) -> f64| -> Array1<f64> {
        trajectories.iter().flat_map(|s| (most..s.rate.len()).map(move |t| of(s, t))).collect()
    };
    let count = trajectories.first().map_or(0, |s| s.beside.len());
    let mut basis: Vec<Array1<f64>> = vec![all(&|_, _| 1.0)];
    basis.extend((0..count).map(|j| all(&|s, t| s.beside[j][t])));
    let basis = orthonormal(basis);
    let rate = without(&basis, all(&|s, t| s.rate[t]));
    let at = |lag: usize| {
        let input = without(&basis, all(&|s, t| s.input[t - lag]));
        let correlation = rate.dot(&input) / (rate.dot(&rate) * input.dot(&input)).sqrt();
        (lag, if correlation.is_finite() { correlation } else { 0.0 })
    };
    let better = |best: (usize, f64), next: (usize, f64)| if next.1.abs() > best.1.abs() { next } else { best };
    let (lag, correlation) = (0..=most).map(at).fold((0, 0.0), better);
    (lag, correlation, rate.len())
}

/// Directions of `columns`, each without what those before it have (Gram and Schmidt); those that have nothing of their own are left out.
fn orthonormal(columns: Vec<Array1<f64>>) -> Vec<Array1<f64>> {
    let mut basis: Vec<Array1<f64>> = Vec::new();
    for column in columns {
        let size = column.dot(&column).sqrt();
        let own = without(&basis, without(&basis, column));
        let left = own.dot(&own).sqrt();
        if left > 1e-9 * size {
            basis.push(own / left);
        }
    }
    basis
}

fn without(basis: &[Array1<f64>], mut column: Array1<f64>) -> Array1<f64> {
    for direction in basis {
        let share = direction.dot(&column);
        column.scaled_add(-share, direction);
    }
    column
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delay_is_seen_behind_a_stronger_cause_beside() {
        let n = 600;
        let input: Array1<f64> = (0..n).map(|i| ((i * i) as f64 * 0.37).sin()).collect();
        let cause: Array1<f64> = (0..n).map(|i| 20.0 * (0.05 * i as f64).sin()).collect();
        let rate = (0..n).map(|i| cause[i] + if i < 4 { 0.0 } else { input[i - 4] }).collect();
        let (lag, correlation, _) = strongest(&[Signals { input: input.view(), rate, beside: vec![cause] }]);
        assert!(lag == 4 && correlation > 0.999, "{lag} {correlation}");
        let still = Signals { input: input.view(), rate: Array1::zeros(n), beside: Vec::new() };
        assert_eq!(strongest(&[still]).1, 0.0);
    }
}
