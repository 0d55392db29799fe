//! After how long states follow inputs.
//!
//! Rates are not differences from row to row, in which the noise of sensors and whatever oscillates fast is largest, but integrals under a smooth window that
//! is zero at its ends: ∫φ ẋ = −∫φ′ x, and ∫φ ẍ = ∫φ″ x.

use ndarray::Array1;

/// Rows by which a response may be late, and early: a measured torque may come before its row.
const LATEST: usize = 50;
const EARLIEST: usize = 10;

/// Rows of a window; the one in which the response is clearest counts.
const WINDOWS: [usize; 6] = [4, 8, 16, 32, 64, 128];

/// Windows side by side that a trajectory has at least.
const FEWEST: usize = 20;

/// What happened in one trajectory, row by row (T).
pub(crate) struct Signals {
    pub(crate) state: Array1<f64>,
    pub(crate) input: Array1<f64>,
    /// Other inputs.
    pub(crate) others: Vec<Array1<f64>>,
    /// All else that a rate may depend on.
    pub(crate) beside: Vec<Array1<f64>>,
}

/// How a derivative of the state follows the input.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Strongest {
    /// 1 for the rate, 2 for the rate of the rate.
    pub(crate) order: usize,
    /// Rows after which it follows, less than none where it comes before.
    pub(crate) lag: isize,
    /// The rows around it that are within two standard deviations.
    pub(crate) range: (isize, isize),
    /// The partial correlation there: of what is left of both when their linear dependence on all else is taken away.
    pub(crate) correlation: f64,
    /// Windows side by side.
    pub(crate) count: usize,
}

/// Where the `orders` of derivatives follow the input most.
pub(crate) fn strongest(trajectories: &[Signals], orders: &[usize]) -> Strongest {
    let longest = trajectories.iter().map(|s| s.input.len()).max().unwrap_or(0);
    let (latest, earliest) = (LATEST.min(longest / 4), EARLIEST.min(longest / 8));
    let fits = |width: &&usize| **width * FEWEST <= longest;
    let shortest = WINDOWS[..1].iter();
    let found = WINDOWS
        .iter()
        .filter(fits)
        .chain(shortest)
        .flat_map(|width| orders.iter().map(|order| of_window(trajectories, *width, *order, (latest, earliest))));
    let better = |best: Strongest, next: Strongest| {
        if next.correlation.abs() > best.correlation.abs() { next } else { best }
    };
    found.fold(Strongest::default(), better)
}

fn of_window(trajectories: &[Signals], width: usize, order: usize, (latest, earliest): (usize, usize)) -> Strongest {
    let window = Window::new(width);
    // Every lag is judged by the same windows.
    let begins = |s: &Signals| {
        let end = (s.input.len() + 1).saturating_sub(width + 1 + earliest);
        (latest + 1..end).step_by((width / 8).max(1)).collect::<Vec<usize>>()
    };
    let all = |of: &dyn Fn(&Signals, usize) -> f64| -> Array1<f64> {
        trajectories.iter().flat_map(|s| begins(s).into_iter().map(move |i| of(s, i))).collect()
    };
    let (count, others) = trajectories.first().map_or((0, 0), |s| (s.beside.len(), s.others.len()));
    let mut basis = vec![all(&|_, _| 1.0)];
    basis.extend((0..count).map(|j| all(&|s, i| window.mean(&s.beside[j], i))));
    if order == 2 {
        basis.push(all(&|s, i| window.derivative(&s.state, i, 1)));
    }
    let basis = orthonormal(basis);
    let rate = all(&|s, i| window.derivative(&s.state, i, order));
    let at = |lag: isize| {
        let late = |i: usize| i.saturating_add_signed(-lag);
        // Other inputs may be as late.
        let mut beside = basis.clone();
        beside.extend((0..others).map(|j| all(&|s, i| window.held(&s.others[j], late(i)))));
        let beside = if others > 0 { orthonormal(beside) } else { beside };
        let rate = without(&beside, rate.clone());
        let input = without(&beside, all(&|s, i| window.held(&s.input, late(i))));
        let correlation = rate.dot(&input) / (rate.dot(&rate) * input.dot(&input)).sqrt();
        (lag, if correlation.is_finite() { correlation } else { 0.0 })
    };
    let all: Vec<(isize, f64)> = (-(earliest as isize)..=latest as isize).map(at).collect();
    let better = |best: usize, next: usize| if all[next].1.abs() > all[best].1.abs() { next } else { best };
    let best = (0..all.len()).fold(0, better);
    let (lag, correlation) = all[best];
    let rows: usize = trajectories.iter().map(|s| s.input.len()).sum();
    let count = 2 * rows / width;
    let left = |at: usize| 1.0 - all[at].1.powi(2);
    let likely = |at: &usize| count as f64 * (left(*at) / left(best)).ln() <= 4.0;
    let first = (0..=best).rev().take_while(likely).last().unwrap_or(best);
    let last = (best..all.len()).take_while(likely).last().unwrap_or(best);
    Strongest { order, lag, range: (all[first].0, all[last].0), correlation, count }
}

/// φ(s) = (1 − s²)⁴ over so many steps, with its derivatives from row to row.
struct Window {
    weights: [Vec<f64>; 3],
}

impl Window {
    fn new(width: usize) -> Self {
        let per_row = 2.0 / width as f64;
        let all = |of: &dyn Fn(f64, f64) -> f64| {
            let place = |j: usize| -1.0 + per_row * j as f64;
            (0..=width).map(|j| of(place(j), 1.0 - place(j).powi(2))).collect::<Vec<f64>>()
        };
        let first = all(&|s, r| -8.0 * s * r.powi(3) * per_row);
        let second = all(&|s, r| (48.0 * s * s * r.powi(2) - 8.0 * r.powi(3)) * per_row * per_row);
        Self { weights: [all(&|_, r| r.powi(4)), first, second] }
    }

    fn mean(&self, x: &Array1<f64>, begin: usize) -> f64 {
        self.weights[0].iter().enumerate().map(|(j, w)| w * x[begin + j]).sum()
    }

    /// The same of an input that is held from row to row: around a row it is half of that one and half of the one before.
    fn held(&self, u: &Array1<f64>, begin: usize) -> f64 {
        self.weights[0].iter().enumerate().map(|(j, w)| 0.5 * w * (u[begin + j] + u[begin + j - 1])).sum()
    }

    fn derivative(&self, x: &Array1<f64>, begin: usize, order: usize) -> f64 {
        let sum: f64 = self.weights[order].iter().enumerate().map(|(j, w)| w * x[begin + j]).sum();
        if order == 1 { -sum } else { sum }
    }
}

/// Directions of `columns`, each without what those before it have (Gram and Schmidt); those that have nothing of their own are left out.
pub(crate) fn orthonormal(columns: Vec<Array1<f64>>) -> Vec<Array1<f64>> {
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

/// `column` without what it has of the directions of `basis`.
pub(crate) fn without(basis: &[Array1<f64>], mut column: Array1<f64>) -> Array1<f64> {
    for direction in basis {
        let share = direction.dot(&column);
        column.scaled_add(-share, direction);
    }
    column
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pendulum under an input that acts so many rows late: angle, rate as a shaken sensor shows it, and input, each 5 ms apart.
    fn pendulum(late: usize, input: impl Fn(f64, f64, f64) -> f64) -> [Array1<f64>; 3] {
        const DT: f64 = 0.005;
        let chance = |i: usize| (((i + 1) as f64 * 12.9898).sin() * 43_758.547).fract();
        let (mut q, mut v) = (0.3_f64, 0.0_f64);
        let (mut qs, mut vs, mut us) = (Vec::new(), Vec::new(), Vec::<f64>::new());
        for i in 0..4000 {
            let shaken = (188.5 * DT * i as f64).sin();
            us.push(input(DT * i as f64, q, v) + 0.5 * (188.5 * DT * i as f64 + 1.0).sin());
            qs.push(q);
            vs.push(v + shaken + 0.1 * chance(i));
            let u = if i < late { 0.0 } else { us[i - late] };
            for _ in 0..5 {
                v += 0.2 * DT * (-20.0 * q.sin() - 0.9 * (v / 0.05).tanh() + 5.3 * u);
                q += 0.2 * DT * v;
            }
        }
        [qs, vs, us].map(Array1::from)
    }

    #[test]
    fn a_delay_is_seen_under_a_controller_and_an_oscillation() {
        let check = |late: usize, input: &dyn Fn(f64, f64, f64) -> f64| {
            let [q, v, u] = pendulum(late, input);
            let beside = vec![q.clone(), v.clone(), q.mapv(f64::sin), q.mapv(f64::cos)];
            let found = strongest(&[Signals { state: v, input: u, others: Vec::new(), beside }], &[1]);
            let (late, range) = (late as isize, found.range.0 - 1..=found.range.1 + 1);
            assert!(range.contains(&late) && found.correlation > 0.9, "{late}: {found:?}");
            found.lag.abs_diff(late)
        };
        for late in [0, 2, 6] {
            let off = [
                check(late, &|t, _, _| 2.0 * (1.3 * t).sin() + 1.2 * (0.5 * t * t).sin()),
                check(late, &|_, q, v| (-0.08 * v * (0.5 * v * v - 20.0 * q.cos() - 20.0)).clamp(-1.4, 1.4)),
                check(late, &|t, q, v| 8.0 * (1.5 * (2.0 * t).sin() - q) - v + (0.5 * t * t).sin()),
            ];
            assert!(off.iter().all(|off| *off <= 2), "{late}: {off:?}");
            // Slow sines tell little of a delay, and say so.
            check(late, &|t, _, _| 2.0 * (1.3 * t).sin() + 1.2 * (3.1 * t + 1.0).sin());
        }
    }

    #[test]
    fn a_second_input_and_positions_alone_do_not_confuse_it() {
        let n = 3000;
        let signal = |a: f64| -> Array1<f64> { (0..n).map(|i| ((i * i) as f64 * a).sin()).collect() };
        let (one, other) = (signal(1e-5), signal(1.37e-5));
        let (mut x, mut v) = (vec![0.0], 0.0);
        for i in 0..n - 1 {
            v += 0.01 * (one[i] - 5.0 * if i < 8 { 0.0 } else { other[i - 8] } - v - 4.0 * x[i]);
            x.push(x[i] + 0.01 * v);
        }
        let state = Array1::from(x);
        let signals = Signals { beside: vec![state.clone()], state, input: other, others: vec![one] };
        let found = strongest(&[signals], &[1, 2]);
        assert!(found.order == 2 && found.lag.abs_diff(8) <= 1 && found.correlation < -0.9, "{found:?}");
        let still = Signals { state: Array1::zeros(n), input: signal(1e-5), others: Vec::new(), beside: Vec::new() };
        assert_eq!(strongest(&[still], &[1]).correlation, 0.0);
    }
}
