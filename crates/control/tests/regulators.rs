//! Regulators against closed forms, SciPy, and systems they are to hold.

use ndarray::{Array2, array};
use proptest::prelude::*;
use sindyna_control::{ControlError, Costs, Linear, Lqr, regulate};
use sindyna_core::{
    Channel, Diverged, Dynamics, Held, Kind, Mode, Policy as _, Precision, Rng, Scheme, Seed, Space, Spec, Unseen,
    VectorField,
};

fn close(got: &Array2<f64>, expected: &Array2<f64>, tolerance: f64) {
    assert_eq!(got.dim(), expected.dim());
    for (got, expected) in got.iter().zip(expected) {
        assert!((got - expected).abs() <= tolerance * expected.abs().max(1.0), "{got} is not {expected}");
    }
}

fn costs(state: &[f64], control: &[f64]) -> Costs {
    Costs { state: state.to_vec(), control: control.to_vec() }
}

fn mass(dt: f64) -> Linear {
    Linear { a: array![[1.0, dt], [0.0, 1.0]], b: array![[0.5 * dt * dt], [dt]] }
}

#[test]
fn one_state_has_the_golden_ratio() {
    // x⁺ = x + u and q = r = 1: p = 1 + p − p²/(1 + p), so p² = p + 1 and k = p/(1 + p) = 1/p.
    let found = regulate(&Linear { a: array![[1.0]], b: array![[1.0]] }, &costs(&[1.0], &[1.0])).expect("stabilisable");
    let golden = 0.5 * (1.0 + 5_f64.sqrt());
    close(&found.value, &array![[golden]], 1e-14);
    close(&found.gain, &array![[1.0 / golden]], 1e-14);
    assert!((found.spectral_radius - (1.0 - 1.0 / golden)).abs() < 1e-14);
}

#[test]
fn a_mass_pushed_often_has_the_gain_of_continuous_time() {
    // ẍ = u with ∫ x² + ẋ² + u² dt: u = −x − √3 ẋ (Åström, Murray 2008, *Feedback Systems*, §6.3).
    let dt = 1e-5;
    let found = regulate(&mass(dt), &costs(&[dt, dt], &[dt])).expect("stabilisable");
    close(&found.gain, &array![[1.0, 3_f64.sqrt()]], 3e-5);
}

#[test]
fn gains_are_those_of_scipy() {
    // scipy 1.17.1, solve_discrete_are; K = (R + BᵀPB)⁻¹ BᵀPA.
    let found = regulate(&mass(0.1), &costs(&[1.0, 1.0], &[1.0])).expect("stabilisable");
    let value = array![[17.834931322189007, 10.01249219725043], [10.01249219725043, 17.856586460328874]];
    close(&found.value, &value, 1e-12);
    close(&found.gain, &array![[0.9170745631140975, 1.635596185046635]], 1e-12);
    // A pole on a cart, upright, one Euler step of 0.02 s.
    let (total, moment, length, gravity, dt) = (1.1, 0.05, 0.5, 9.8, 0.02);
    let inertia = length * (4.0 / 3.0 - 0.1 / total);
    let mut a = Array2::eye(4);
    a[[0, 1]] = dt;
    a[[1, 2]] = -dt * moment * gravity / (inertia * total);
    a[[2, 3]] = dt;
    a[[3, 2]] = dt * gravity / inertia;
    let b = array![[0.0], [dt * (1.0 / total + moment / (inertia * total * total))], [0.0], [-dt / (total * inertia)]];
    let costs = costs(&[1.0 / 2.4_f64.powi(2), 0.25, 1.0 / 0.21_f64.powi(2), 0.25], &[0.01]);
    let found = regulate(&Linear { a, b }, &costs).expect("stabilisable");
    let gain = array![[-3.501175315449858, -7.966294396115173, -74.11177003113767, -16.69456496167252]];
    close(&found.gain, &gain, 1e-9);
    assert!((found.spectral_radius - 0.9841468595466812).abs() < 1e-9);
}

#[test]
fn what_controls_do_not_reach_must_be_stable_by_itself() {
    let one = costs(&[1.0, 1.0], &[1.0]);
    let unreached = |a: f64| regulate(&Linear { a: array![[a, 0.0], [0.0, 2.0]], b: array![[0.0], [1.0]] }, &one);
    assert!((unreached(0.9).expect("it dies out").spectral_radius - 0.9).abs() < 1e-12);
    for a in [1.0, 1.1, -1.5] {
        let error = unreached(a).expect_err("it never dies out");
        assert!(matches!(error, ControlError::NotStabilisable { .. }), "{a}: {error}");
    }
}

#[test]
fn bad_input_is_named() {
    let said = |linear: &Linear, costs: &Costs| regulate(linear, costs).expect_err("bad input").to_string();
    assert_eq!(
        said(&mass(0.1), &costs(&[1.0, 0.0], &[1.0])),
        "the cost of state 1 is 0, it must be finite and positive"
    );
    assert_eq!(said(&mass(0.1), &costs(&[1.0], &[1.0])), "A is (2, 2), expected (1, 1)");
    let nan = Linear { a: array![[f64::NAN]], b: array![[1.0]] };
    assert!(matches!(regulate(&nan, &costs(&[1.0], &[1.0])), Err(ControlError::NotStabilisable { .. })));
}

proptest! {
    #[test]
    fn the_equation_holds_and_the_closed_loop_is_stable(
        entries in proptest::collection::vec(-1.5..1.5, 9), push in proptest::collection::vec(0.2..1.0, 3)
    ) {
        let a = Array2::from_shape_vec((3, 3), entries).expect("nine entries");
        // As many controls as states reach everything.
        let b = Array2::from_diag(&ndarray::Array1::from(push));
        let found = regulate(&Linear { a: a.clone(), b: b.clone() }, &costs(&[1.0, 2.0, 0.5], &[1.0, 0.1, 3.0]))
            .expect("every pair with a regular B is stabilisable");
        prop_assert!(found.spectral_radius < 1.0);
        let closed = &a - &b.dot(&found.gain);
        let (q, r) = (Array2::from_diag(&array![1.0, 2.0, 0.5]), Array2::from_diag(&array![1.0, 0.1, 3.0]));
        // The value of what comes after x is what this step costs and the value of what comes after it.
        let next = &q + &found.gain.t().dot(&r).dot(&found.gain) + closed.t().dot(&found.value).dot(&closed);
        close(&next, &found.value, 1e-9);
    }
}

/// ω̇ = sin θ + u / N·m, upright at θ = 0.
struct Pole;

impl VectorField for Pole {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        x_dot.copy_from_slice(&[x[1], x[0].sin() + u[0]]);
    }
}

fn pole(action_space: Space) -> Spec {
    let rate = Channel::new("ω", "rad/s", Kind::RateOf(0), 1.0);
    Spec {
        name: "pole".into(),
        state: vec![Channel::new("θ", "rad", Kind::Angle, 0.5), rate.clone()],
        observation: vec![
            Channel::new("cos θ", "", Kind::CosOf(0), 1.0),
            Channel::new("sin θ", "", Kind::SinOf(0), 1.0),
            rate,
        ],
        control: vec![Channel::new("u", "N·m", Kind::Plain, 1.0)],
        action_space,
        precision: Precision::F64,
        noise: 0.0,
        dt: 0.05,
    }
}

/// |θ| after `steps` of the regulated pole from 0.3 rad, whose angle is shown `turns` turns further.
fn lean_after(steps: usize, space: Space, turns: f64) -> f64 {
    let (spec, mut rng) = (pole(space), Seed::new(0).numpy());
    let held = Held::new(Pole, Scheme::Rk4 { substeps: 1 }, spec.dt);
    let lqr = Lqr::around(&held, &spec, (&[0.0, 0.0], &[0.0]), &Costs::of_scales(&spec), &mut rng).expect("reachable");
    assert!(lqr.regulator().spectral_radius < 1.0);
    let (mut x, mut next, mut action, mut u) = ([0.3, 0.0], [0.0; 2], [0.0], [0.0]);
    for _ in 0..steps {
        let shown = x[0] + turns * std::f64::consts::TAU;
        lqr.act(&[shown.cos(), shown.sin(), x[1]], Mode::Exploit, &mut rng, &mut action);
        assert!(spec.action_space.control_into(&action, &mut u), "{action:?} is an action");
        held.step(&x, &u, &mut rng, &mut next).expect("a pole stays finite");
        x = next;
    }
    x[0].abs()
}

#[test]
fn a_pole_is_held_by_real_and_by_numbered_actions() {
    let real = Space::Box { low: vec![-1.0], high: vec![1.0] };
    assert!(lean_after(400, real.clone(), 0.0) < 1e-6);
    assert!(lean_after(400, real, 3.0) < 1e-6, "whole turns change nothing");
    // Two pushes never rest, but they keep it up.
    let numbered = Space::Discrete { controls: array![[-1.0], [1.0]] };
    assert!(lean_after(400, numbered, 0.0) < 0.1);
}

#[test]
fn differences_are_slopes_and_hidden_states_are_named() {
    struct Known;
    impl Dynamics for Known {
        fn step(&self, x: &[f64], u: &[f64], _rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
            next.copy_from_slice(&[x[0].exp() + 2.0 * u[0], x[0] * x[1] - u[0]]);
            Diverged::check(next)
        }
    }
    let mut spec = pole(Space::Box { low: vec![-1.0], high: vec![1.0] });
    let linear = Linear::around(&Known, (&[0.5, 3.0], &[0.1]), &mut Seed::new(0).numpy()).expect("finite");
    close(&linear.a, &array![[0.5_f64.exp(), 0.0], [3.0, 0.5]], 1e-8);
    close(&linear.b, &array![[2.0], [-1.0]], 1e-8);

    spec.observation.remove(1);
    let found = regulate(&linear, &costs(&[1.0, 1.0], &[1.0])).expect("stabilisable");
    let error = Lqr::new(found, &spec, (&[0.0, 0.0], &[0.0])).expect_err("a cosine alone does not tell the side");
    assert_eq!(error, ControlError::Unseen(Unseen { state: "θ".into() }));
}
