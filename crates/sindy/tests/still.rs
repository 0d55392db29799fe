//! States that noise hides: what equations make of them is not called adequate.

use ndarray::Array2;
use rand_distr::{Distribution as _, StandardNormal};
use sindyna_core::Seed;
use sindyna_sindy::{Identifier, Recording, Signals};

/// ċ = 2 u − 0.004 (c − 400)(0.3 + w), ẇ = (0.5 − w)/300 every 30 s, with errors of 0.5 in both: w is between 0.3 and 0.5.
fn recorded(seed: u64) -> Recording {
    let mut rng = Seed::new(seed).stream("still", 0);
    let (mut c, mut w, mut u) = (600.0_f64, 0.3_f64, 0.5);
    let (mut states, mut controls) = (Array2::zeros((120, 2)), Array2::zeros((119, 1)));
    for t in 0..120 {
        let noise: [f64; 2] = std::array::from_fn(|_| StandardNormal.sample(&mut rng));
        (states[[t, 0]], states[[t, 1]]) = (c + 0.5 * noise[0], w + 0.5 * noise[1]);
        if t == 119 {
            break;
        }
        if t % 7 == 0 {
            u = rand::RngExt::random(&mut rng);
        }
        controls[[t, 0]] = u;
        for _ in 0..3000 {
            c += 0.01 * (2.0 * u - 0.004 * (c - 400.0) * (0.3 + w));
            w += 0.01 * (0.5 - w) / 300.0;
        }
    }
    Recording::even(30.0, states, Some(controls))
}

#[test]
fn terms_of_a_state_below_its_noise_are_doubted() {
    let mut doubted = 0;
    for seed in 1000..1008 {
        let signals = Signals::new(&["c", "w"], &["u"]);
        let found = Identifier::of_signals(&signals, 30.0).expect("signals").identify_recordings(&[recorded(seed)]);
        let found = found.expect("equations");
        let [c, w] = [0, 1].map(|i| &found.report.equations[i]);
        let has_w = c.support.iter().any(|j| found.report.features[*j].contains('w'));
        if w.support.is_empty() && has_w {
            assert!(c.doubt.is_some(), "{seed}: {}", found.model);
            doubted += 1;
        }
    }
    assert!(doubted >= 4, "{doubted}");
}

#[test]
fn noise_alone_is_no_system() {
    for seed in 1000..1004 {
        let mut rng = Seed::new(seed).stream("noise", 0);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let states = Array2::from_shape_simple_fn((300, 2), &mut normal);
        let controls = Array2::from_shape_simple_fn((299, 1), &mut normal);
        let signals = Signals::new(&["x", "y"], &["u"]);
        let found = Identifier::of_signals(&signals, 0.01).expect("signals");
        let found = found.identify_recordings(&[Recording::even(0.01, states, Some(controls))]).expect("equations");
        assert!(found.report.equations.iter().all(|e| e.doubt.is_some()), "{seed}: {}", found.model);
    }
}
