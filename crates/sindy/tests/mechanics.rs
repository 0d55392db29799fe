//! Several joints: one Lagrangian proposes the terms of all equations at once.

mod recorded;

use ndarray::Array2;
use rand::RngExt as _;
use sindyna_core::{Kind, Seed, Spec};
use sindyna_sindy::{Identifier, Recording};

const DT: f64 = 0.05;

/// A cart with two poles.
fn spec() -> Spec {
    let (rate, angle) = (Kind::RateOf, Kind::Angle);
    recorded::spec(
        &[("x", Kind::Plain), ("a", angle), ("b", angle), ("v", rate(0)), ("p", rate(1)), ("q", rate(2))],
        DT,
    )
}

/// Rates of a cart with a pole on a pole; b is the angle between the poles.
fn rates([_, a, b, v, p, q]: [f64; 6], u: f64) -> [f64; 6] {
    let (mass, h1, h2, k, j1, j2, gravity) = (12.0, 2.2, 0.9, 0.6, 1.9, 0.6, 9.81);
    let m01 = h1 * a.cos() + h2 * (a + b).cos();
    let m02 = h2 * (a + b).cos();
    let (m11, m12) = (j1 + j2 + 2.0 * k * b.cos(), j2 + k * b.cos());
    let m = [[mass, m01, m02], [m01, m11, m12], [m02, m12, j2]];
    let f = [
        40.0 * u - 0.3 * v + h1 * a.sin() * p * p + h2 * (a + b).sin() * (p + q).powi(2),
        gravity * (h1 * a.sin() + h2 * (a + b).sin()) + k * b.sin() * (2.0 * p * q + q * q) - 0.1 * p,
        gravity * h2 * (a + b).sin() - k * b.sin() * p * p - 0.05 * q,
    ];
    let determinant = |m: [[f64; 3]; 3]| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    let solved = [0, 1, 2].map(|column| {
        let mut with = m;
        (0..3).for_each(|row| with[row][column] = f[row]);
        determinant(with) / determinant(m)
    });
    [v, p, q, solved[0], solved[1], solved[2]]
}

/// `steps` sampling intervals from `x`, five classical steps each.
fn simulated(mut x: [f64; 6], controls: &[f64]) -> Array2<f64> {
    let mut states = Array2::zeros((controls.len() + 1, 6));
    states.row_mut(0).assign(&ndarray::aview1(&x));
    let h = DT / 5.0;
    for (t, u) in controls.iter().enumerate() {
        for _ in 0..5 {
            let moved = |k: [f64; 6], c: f64| std::array::from_fn(|i| x[i] + c * k[i]);
            let k1 = rates(x, *u);
            let k2 = rates(moved(k1, 0.5 * h), *u);
            let k3 = rates(moved(k2, 0.5 * h), *u);
            let k4 = rates(moved(k3, h), *u);
            x = std::array::from_fn(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        }
        states.row_mut(t + 1).assign(&ndarray::aview1(&x));
    }
    states
}

/// Recordings of six steps each, from starts and under controls that are drawn.
fn recordings(steps: usize, seed: u64) -> Vec<(Array2<f64>, Vec<f64>)> {
    let mut rng = Seed::new(seed).stream("mechanics", 0);
    let mut drawn = |half: f64| half * (2.0 * rng.random::<f64>() - 1.0);
    (0..steps / 6)
        .map(|_| {
            let start = [drawn(0.3), drawn(0.5), drawn(0.5), drawn(1.0), drawn(1.0), drawn(1.0)];
            let controls: Vec<f64> = (0..6).map(|_| drawn(1.0)).collect();
            (simulated(start, &controls), controls)
        })
        .collect()
}

/// Thirteen parameters are in twenty-four coefficients of the three equations.
#[test]
fn a_cart_with_two_poles_is_exact_from_sixty_steps() {
    let own = |controls: &[f64]| Array2::from_shape_vec((controls.len(), 1), controls.to_vec()).expect("a column");
    let log: Vec<Recording> =
        recordings(60, 1).into_iter().map(|(x, u)| Recording::even(DT, x, Some(own(&u)))).collect();
    let found = Identifier::new(&spec()).identify_recordings(&log).expect("equations");
    assert!(found.report.equations.iter().all(|e| e.reached_floor), "{found}");
    for (states, controls) in recordings(120, 2) {
        let start = states.row(0).to_vec();
        let ahead = found.model.simulate(&start, own(&controls).view()).expect("finite");
        let worst = (&ahead - &states).iter().fold(0.0_f64, |worst, e| worst.max(e.abs()));
        assert!(worst < 1e-6, "{worst:e}\n{found}");
    }
}
