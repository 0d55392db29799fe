//! Linear and bilinear systems of many states, whose terms are few among very many candidates.

mod recorded;

use recorded::{assert_equation, record_held, spec};
use sindyna_core::{Certainty, Kind};
use sindyna_sindy::{Identified, Identifier, Recording};

/// Temperatures along a rod that is heated at one end, and loses heat to air of 20 °C.
fn rod(x: &[f64], u: f64) -> Vec<f64> {
    let n = x.len();
    let of = |i: usize| {
        let neighbours = [i.checked_sub(1), Some(i + 1).filter(|j| *j < n)];
        let exchanged: f64 = neighbours.into_iter().flatten().map(|j| 0.4 * (x[j] - x[i])).sum();
        exchanged - 0.03 * (x[i] - 20.0) + if i == 0 { 4.0 * (u + 1.0) } else { 0.0 }
    };
    (0..n).map(of).collect()
}

/// An induction motor in the frame of its stator: currents, fluxes, speed.
fn motor(x: &[f64], u: f64) -> Vec<f64> {
    let [i_a, i_b, f_a, f_b, w] = [x[0], x[1], x[2], x[3], x[4]];
    vec![
        -20.0 * i_a + 70.0 * f_a + 19.0 * f_b * w + 10.0 * u,
        -20.0 * i_b + 70.0 * f_b - 19.0 * f_a * w + 6.0,
        0.9 * i_a - 7.0 * f_a - 2.0 * f_b * w,
        0.9 * i_b - 7.0 * f_b + 2.0 * f_a * w,
        28.0 * f_a * i_b - 28.0 * f_b * i_a - 1.5 * w,
    ]
}

fn identified(states: &[&str], dt: f64, recording: &Recording) -> Identified {
    let kinds: Vec<(&str, Kind)> = states.iter().map(|name| (*name, Kind::Plain)).collect();
    Identifier::new(&spec(&kinds, dt)).identify_recordings(std::slice::from_ref(recording)).expect("equations")
}

#[test]
fn heat_along_a_rod_is_linear() {
    for seed in [0, 1] {
        let recording = record_held(rod, &[20.0; 5], (600, 0.4), (2e-3, 1.0, false), 15, seed);
        let found = identified(&["T1", "T2", "T3", "T4", "T5"], 0.4, &recording);
        let within = 0.1;
        assert_equation(&found, 0, &[("1", 4.6), ("T1", -0.43), ("T2", 0.4), ("u", 4.0)], within);
        assert_equation(&found, 1, &[("1", 0.6), ("T1", 0.4), ("T2", -0.83), ("T3", 0.4)], within);
        assert_equation(&found, 2, &[("1", 0.6), ("T2", 0.4), ("T3", -0.83), ("T4", 0.4)], within);
        assert_equation(&found, 3, &[("1", 0.6), ("T3", 0.4), ("T4", -0.83), ("T5", 0.4)], within);
        assert_equation(&found, 4, &[("1", 0.6), ("T4", 0.4), ("T5", -0.43)], within);
        assert!(found.certainty() >= Certainty::Ambiguous, "{:?}", found.certainty());
    }
}

#[test]
fn an_induction_motor_is_bilinear() {
    for seed in [0, 1] {
        let recording = record_held(motor, &[0.0, 0.0, 0.1, 0.0, 0.0], (800, 0.02), (1e-3, 1.0, false), 12, seed);
        let found = identified(&["i_a", "i_b", "f_a", "f_b", "w"], 0.02, &recording);
        let within = 0.05;
        assert_equation(&found, 0, &[("i_a", -20.0), ("f_a", 70.0), ("f_b·w", 19.0), ("u", 10.0)], within);
        assert_equation(&found, 1, &[("i_b", -20.0), ("f_b", 70.0), ("f_a·w", -19.0), ("1", 6.0)], within);
        assert_equation(&found, 2, &[("i_a", 0.9), ("f_a", -7.0), ("f_b·w", -2.0)], within);
        assert_equation(&found, 3, &[("i_b", 0.9), ("f_b", -7.0), ("f_a·w", 2.0)], within);
        assert_equation(&found, 4, &[("i_b·f_a", 28.0), ("i_a·f_b", -28.0), ("w", -1.5)], within);
    }
}
