//! Machines that rub and are touched: equations of pieces.

use ndarray::{Array2, s};
use rand::RngExt as _;
use rand_distr::{Distribution as _, StandardNormal};
use sindyna_core::Seed;
use sindyna_sindy::{Doubt, Entry, Expr, Identified, Identifier, Recording, Signals, Watch};

/// v̇ = −a sin q − b v − c sign v + k u, with hands on it now and then.
struct Rig {
    a: f64,
    b: f64,
    c: f64,
    k: f64,
}

/// Steps of the simulation in a sampling interval.
const FINE: usize = 50;

impl Rig {
    /// One fine step: friction stops what it can stop.
    fn step(&self, q: &mut f64, v: &mut f64, push: f64, h: f64) {
        let free = *v + h * (-self.a * q.sin() - self.b * *v + push);
        *v = free.signum() * (free.abs() - h * self.c).max(0.0);
        *q += h * *v;
    }

    /// 20 s at 200 Hz with jitter: angles on the lattice of an encoder, noisy speeds, the torque as measured; pushed at 4.0, 9.0 and 14.0 s for 0.2 s.
    fn recorded(&self, seed: u64) -> Recording {
        let mut rng = Seed::new(seed).stream("rig", 0);
        let (mut q, mut v, mut time) = (0.3, 0.0, 0.0);
        let (mut times, mut states, mut controls) = (vec![0.0], vec![[q, v]], Vec::new());
        let phase: f64 = rng.random_range(0.0..6.0);
        while time < 20.0 {
            let u = 2.6 * (3.1 * time + phase).sin() + 1.4 * (1.3 * time * (1.0 + 0.06 * time)).sin();
            let dt = 0.005 * (1.0 + 0.02 * rng.random_range(-1.0..1.0));
            let pushed = [4.0, 9.0, 14.0].iter().any(|start| (*start..start + 0.2).contains(&time));
            let push = self.k * u + if pushed { 25.0 } else { 0.0 };
            (0..FINE).for_each(|_| self.step(&mut q, &mut v, push, dt / FINE as f64));
            time += dt;
            let (position, speed): (f64, f64) = (StandardNormal.sample(&mut rng), StandardNormal.sample(&mut rng));
            times.push(time);
            states.push([((q + 2e-4 * position) / 1e-3).round() * 1e-3, v + 0.05 * speed]);
            controls.push(u);
        }
        let states = Array2::from_shape_fn((times.len(), 2), |(t, i)| states[t][i]);
        Recording::new(times, states, Array2::from_shape_fn((controls.len(), 1), |(t, _)| controls[t]))
    }
}

/// The coefficient of the term `name`, with its standard error.
fn coefficient(found: &Identified, name: &str) -> Option<(f64, f64)> {
    let equation = &found.report.equations[1];
    let at = equation.support.iter().position(|j| found.report.features[*j] == name)?;
    Some((equation.coefficients[at], equation.standard_errors[at]))
}

#[test]
fn friction_and_gravity_of_a_rig_that_is_pushed_by_hand() {
    for (seed, rig) in
        [(1000, Rig { a: 17.0, b: 0.1, c: 1.1, k: 4.1 }), (1001, Rig { a: 11.0, b: 0.05, c: 0.6, k: 6.0 })]
    {
        let signals = Signals::new(&["q", "v"], &["u"]).rate("v", "q").expect("a rate");
        let identifier = Identifier::of_signals(&signals, 0.005).expect("signals");
        let found = identifier.identify_recordings(&[rig.recorded(seed)]).expect("equations");
        assert_eq!(found.report.equations[1].doubt, Some(Doubt::Disturbed), "{:?}", found.model.equations());
        for (name, truth, part) in [("sin q", -rig.a, 0.03), ("u", rig.k, 0.03), ("sign v", -rig.c, 0.15)] {
            let (value, error) = coefficient(&found, name).unwrap_or_else(|| panic!("no {name}"));
            assert!((value - truth).abs() < part * truth.abs(), "{seed} {name}: {value} is not {truth}");
            assert!(
                (value - truth).abs() < 4.0 * error + 0.005 * truth.abs(),
                "{seed} {name}: {value} ± {error}, {truth}"
            );
        }
        assert!(found.report.equations[1].support.len() <= 6, "{:?}", found.model.equations());
        let told = found.report.warnings.join(" ");
        assert!(told.contains("do not follow them"), "{told}");
    }
}

#[test]
fn pieces_are_missed_least_with_inputs_as_late_as_they_are() {
    // Inputs act two rows after theirs: reading k has them act k rows later.
    const LATE: usize = 2;
    const LONGEST: usize = 4;
    let rig = Rig { a: 14.0, b: 0.2, c: 0.8, k: 5.0 };
    let acted = rig.recorded(1002);
    let steps = acted.controls.nrows() - LATE;
    let (times, states) = (&acted.times[LONGEST..=steps], acted.states.slice(s![LONGEST..=steps, ..]));
    let reading = |k: usize| {
        let logged = acted.controls.slice(s![LATE + LONGEST - k..steps + LATE - k, ..]);
        vec![Recording::new(times.iter().map(|t| t - times[0]).collect(), states.to_owned(), logged.to_owned())]
    };
    let signals = Signals::new(&["q", "v"], &["u"]).rate("v", "q").expect("a rate");
    let identifier = Identifier::of_signals(&signals, 0.005).expect("signals");
    let found = identifier.identify_recordings(&reading(0)).expect("equations");
    let readings: Vec<Vec<Recording>> = (0..=LONGEST).map(reading).collect();
    let misfits = identifier.misfits_of_pieces(&found.model, &readings, &Watch::default());
    let medians: Vec<f64> = misfits.expect("shapes").expect("pieces").into_iter().map(median).collect();
    let least = (0..medians.len()).min_by(|&a, &b| medians[a].total_cmp(&medians[b]));
    assert_eq!(least, Some(LATE), "{medians:?}");
    assert!(medians[LATE] < 0.8 * medians[0], "{medians:?}");
    // With that reading coefficients are the true ones.
    let fitted = identifier.fitted_to_pieces(&found.model, reading(LATE), &Watch::default());
    let fitted = fitted.expect("shapes").expect("pieces");
    let is_input = |e: &&Entry| fitted.terms()[e.term] == Expr::Variable(2);
    let gain = fitted.coefficients(1).iter().find(is_input).expect("the input").coefficient;
    assert!((gain - rig.k).abs() < 0.03 * rig.k, "{gain}");
}

fn median(mut of: Vec<f64>) -> f64 {
    of.sort_by(f64::total_cmp);
    of[of.len() / 2]
}

/// Two seconds of a log, as they are in the folder.
fn log(text: &str) -> Recording {
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).map(|line| line.split(',').map(|v| v.parse().expect("a number")).collect()).collect();
    Recording::new(
        rows.iter().map(|row| row[0]).collect(),
        Array2::from_shape_fn((rows.len(), 4), |(t, i)| rows[t][1 + i]),
        Array2::from_shape_fn((rows.len() - 1, 2), |(t, k)| rows[t][5 + k]),
    )
}

#[test]
fn two_seconds_of_a_real_double_pendulum_predict_another_log() {
    let signals = Signals::new(&["q1", "q2", "v1", "v2"], &["u1", "u2"]);
    let signals = signals.rate("v1", "q1").and_then(|s| s.rate("v2", "q2")).expect("rates");
    let signals = signals.angle("q1").and_then(|s| s.angle("q2")).expect("angles");
    let identifier = Identifier::of_signals(&signals, 0.002).expect("signals");
    let found = identifier.identify_recordings(&[log(include_str!("machines/c1_143601.csv"))]).expect("equations");
    let other = log(include_str!("machines/c1_143339.csv"));
    let noise = &found.report.noise_deviations;
    let (mut errors, mut start) = ([Vec::new(), Vec::new()], 0.1);
    let at = |time: f64| other.times.partition_point(|t| t - other.times[0] < time);
    while start + 1.0 < 4.0 {
        let (before, from, to) = (at(start - 0.1), at(start), at(start + 1.0));
        let dt = |range: std::ops::RangeInclusive<usize>| {
            other.times[range].windows(2).map(|t| t[1] - t[0]).collect::<Vec<_>>()
        };
        let (x, u) = (other.states.slice(s![before..=from, ..]), other.controls.slice(s![before..from, ..]));
        let x0 = found.model.state_after(x, u, &dt(before..=from), noise).expect("a state");
        let ahead =
            found.model.simulate_at(&x0, other.controls.slice(s![from..to, ..]), &dt(from..=to)).expect("finite");
        for (i, errors) in errors.iter_mut().enumerate() {
            let squares = (0..=to - from).map(|t| (ahead[[t, i]] - other.states[[from + t, i]]).powi(2));
            errors.push((squares.sum::<f64>() / (to - from + 1) as f64).sqrt());
        }
        start += 0.1;
    }
    for (errors, bound) in errors.into_iter().zip([0.1, 0.1]) {
        let median = median(errors);
        assert!(median < bound, "{median} rad over a second; {:?}", found.model.equations());
    }
}
