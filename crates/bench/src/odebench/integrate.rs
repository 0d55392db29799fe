//! Trajectories to more digits than any comparison needs.

use ndarray::{Array2, aview1};
use sindyna_core::VectorField;

/// Error of a step of fourth order, as part of the state and in its unit. The fifth order, which is gone on with, is then exact to
/// rounding.
const TOLERANCES: (f64, f64) = (1e-13, 1e-15);

/// Steps, rejected ones included, after which a trajectory is given up.
const MOST_STEPS: usize = 2_000_000;

/// c, a and b of Dormand and Prince; the last row of `A` is b.
const A: [[f64; 6]; 6] = [
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];

/// b minus the weights of fourth order.
const E: [f64; 7] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339_200.0, 22.0 / 525.0, -1.0 / 40.0];

/// States (T, n) at `times`, the first of which is that of `start`; none if the trajectory does not stay finite.
///
/// # References
/// Dormand, Prince (1980), Journal of Computational and Applied Mathematics 6(1): RK5(4)7M.
#[must_use]
pub fn integrate(field: &dyn VectorField, start: &[f64], times: &[f64]) -> Option<Array2<f64>> {
    let mut states = Array2::zeros((times.len(), start.len()));
    let (mut x, mut steps) = (start.to_vec(), 0);
    let mut h = (times.last()? - times.first()?) * 1e-4;
    for (row, &end) in times.iter().enumerate() {
        let mut t = if row == 0 { end } else { times[row - 1] };
        while t < end {
            steps += 1;
            if steps > MOST_STEPS {
                return None;
            }
            let last = t + h >= end;
            let tried = if last { end - t } else { h };
            let (next, error) = step(field, &x, tried);
            if error.is_nan() || h < f64::MIN_POSITIVE {
                return None;
            }
            if error <= 1.0 {
                t = if last { end } else { t + tried };
                x = next;
            }
            let factor = 0.9 * error.max(1e-10).powf(-0.2);
            // A step cut short by a sample says little about the next.
            if !last || error > 1.0 {
                h = tried * factor.clamp(0.2, 5.0);
            }
        }
        states.row_mut(row).assign(&aview1(&x));
    }
    states.iter().all(|v: &f64| v.is_finite()).then_some(states)
}

/// The state after `h`, and its error over the tolerance.
fn step(field: &dyn VectorField, x: &[f64], h: f64) -> (Vec<f64>, f64) {
    let n = x.len();
    let mut k = [(); 7].map(|()| vec![0.0; n]);
    field.eval(x, &[], &mut k[0]);
    let mut stage = x.to_vec();
    for (s, row) in A.iter().enumerate() {
        for i in 0..n {
            stage[i] = x[i] + h * row.iter().zip(&k).map(|(a, k)| a * k[i]).sum::<f64>();
        }
        field.eval(&stage, &[], &mut k[s + 1]);
    }
    let part = |i: usize| {
        let error = h * E.iter().zip(&k).map(|(e, k)| e * k[i]).sum::<f64>();
        error / (TOLERANCES.1 + TOLERANCES.0 * x[i].abs().max(stage[i].abs()))
    };
    let error = (0..n).map(part).fold(0.0_f64, |worst, e| if e.is_nan() { e } else { worst.max(e.abs()) });
    // Beyond the domain of a root or a logarithm the step is too long, unless the start is there already.
    let beyond = !stage.iter().chain(&k[6]).all(|v| v.is_finite()) && k[0].iter().all(|v| v.is_finite());
    (stage, if beyond { 1e10 } else { error })
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Oscillator;
    impl VectorField for Oscillator {
        fn eval(&self, x: &[f64], _u: &[f64], x_dot: &mut [f64]) {
            x_dot.copy_from_slice(&[x[1], -x[0]]);
        }
    }

    #[test]
    fn a_turn_comes_back() {
        let times = [0.0, 1.0, std::f64::consts::TAU];
        let states = integrate(&Oscillator, &[1.0, 0.0], &times).expect("an oscillator stays finite");
        assert!((states[(1, 0)] - 1_f64.cos()).abs() < 1e-14, "{states}");
        assert!((states[(2, 0)] - 1.0).abs() < 1e-13 && states[(2, 1)].abs() < 1e-13, "{states}");
    }

    #[test]
    fn what_runs_away_is_none() {
        struct Square;
        impl VectorField for Square {
            fn eval(&self, x: &[f64], _u: &[f64], x_dot: &mut [f64]) {
                x_dot[0] = x[0] * x[0];
            }
        }
        assert!(integrate(&Square, &[1.0], &[0.0, 2.0]).is_none());
    }
}
