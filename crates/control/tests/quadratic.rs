//! Quadratic rewards: the regulator of a goal is the one that the reward asks for.

use std::sync::Arc;

use ndarray::{Array2, array};
use sindyna_control::{Method, Planner, Rollout, improved};
use sindyna_core::{Channel, Diverged, Dynamics, Kind, Mode, Policy as _, Precision, Rng, Seed, Space, Spec, Task};

const DT: f64 = 0.05;

/// x⁺ = x + h v, v⁺ = v + h (u − 0.2 v), to be held at x = 1.5 for a reward −(q (x⁺ − 1.5)² + r u²).
struct Mass {
    spec: Spec,
    q: f64,
    r: f64,
}

impl Mass {
    fn new(q: f64, r: f64) -> Self {
        let states = vec![Channel::new("x", "m", Kind::Plain, 1.0), Channel::new("v", "m/s", Kind::RateOf(0), 1.0)];
        let spec = Spec {
            name: "mass".into(),
            observation: states.clone(),
            state: states,
            control: vec![Channel::new("u", "N", Kind::Plain, 1.0)],
            action_space: Space::Box { low: vec![-20.0], high: vec![20.0] },
            precision: Precision::F64,
            noise: 0.0,
            dt: DT,
        };
        Self { spec, q, r }
    }

    /// K of u = −K (x − x*) by the Riccati difference equation, of costs on the next state.
    fn gain(&self) -> Array2<f64> {
        let (a, b) = (array![[1.0, DT], [0.0, 1.0 - 0.2 * DT]], array![[0.0], [DT]]);
        let q = array![[self.q, 0.0], [0.0, 0.0]];
        let mut p = Array2::<f64>::zeros((2, 2));
        let mut gain = Array2::zeros((1, 2));
        for _ in 0..20_000 {
            let m = &q + &p;
            let size = self.r + b.t().dot(&m).dot(&b)[[0, 0]];
            gain = b.t().dot(&m).dot(&a) / size;
            p = a.t().dot(&m).dot(&(&a - &b.dot(&gain)));
        }
        gain
    }
}

struct Motion;

impl Dynamics for Motion {
    fn step(&self, x: &[f64], u: &[f64], _rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
        next.copy_from_slice(&[x[0] + DT * x[1], x[1] + DT * (u[0] - 0.2 * x[1])]);
        Diverged::check(next)
    }
}

impl Task for Mass {
    fn spec(&self) -> &Spec {
        &self.spec
    }
    fn max_steps(&self) -> usize {
        400
    }
    fn initial(&self, _rng: &mut Rng, x: &mut [f64]) {
        x.copy_from_slice(&[1.0, 0.0]);
    }
    fn reward(&self, _x: &[f64], _action: &[f64], u: &[f64], next: &[f64]) -> f64 {
        -(self.q * (next[0] - 1.5).powi(2) + self.r * u[0] * u[0])
    }
    fn terminated(&self, _next: &[f64]) -> bool {
        false
    }
}

#[test]
fn the_gain_is_the_one_of_least_cost() {
    for (q, r) in [(1.0, 1.0), (20.0, 0.1), (0.3, 5.0), (1e-3, 1e-4)] {
        let task = Mass::new(q, r);
        let gain = task.gain();
        let planner = Planner::new(Method::Lqr, Arc::new(Motion), Arc::new(task)).expect("all is observed");
        for (x, v) in [(1.6, 0.0), (1.5, 0.1), (1.45, -0.05)] {
            let mut u = [0.0];
            planner.act(&[x, v], Mode::Exploit, &mut Seed::new(0).numpy(), &mut u);
            let exact = -gain[[0, 0]] * (x - 1.5) - gain[[0, 1]] * v;
            assert!((u[0] - exact).abs() < 1e-3 * (0.1 + exact.abs()), "{q} {r} at {x} {v}: {} is not {exact}", u[0]);
        }
    }
}

/// The rollout of `law` from the start.
fn rollout(task: &Mass, law: impl Fn(&[f64]) -> f64) -> Rollout {
    let (mut rng, mut x, mut next) = (Seed::new(0).numpy(), vec![0.0; 2], vec![0.0; 2]);
    task.initial(&mut rng, &mut x);
    let mut rollout = Rollout { start: x.clone(), controls: Vec::new(), earned: 0.0 };
    for _ in 0..task.max_steps() {
        let u = vec![law(&x)];
        Motion.step(&x, &u, &mut rng, &mut next).expect("it stays finite");
        rollout.earned += task.reward(&x, &u, &u, &next);
        rollout.controls.push(u);
        std::mem::swap(&mut x, &mut next);
    }
    rollout
}

#[test]
fn what_is_best_cannot_be_improved_and_what_is_not_becomes_it() {
    let task = Arc::new(Mass::new(1.0, 0.1));
    let gain = task.gain();
    let best = rollout(&task, |x| -gain[[0, 0]] * (x[0] - 1.5) - gain[[0, 1]] * x[1]);
    let improved_of = |rollout: &Rollout| improved(Arc::new(Motion), task.clone(), std::slice::from_ref(rollout));
    assert!(improved_of(&best) - best.earned < 1e-6 * best.earned.abs());
    for law in [|_: &[f64]| 0.0, |x: &[f64]| 0.1 * (1.5 - x[0]) - 0.3 * x[1], |x: &[f64]| x[0] - 1.5] {
        let (poor, improved) = (rollout(&task, law), improved_of(&rollout(&task, law)));
        assert!(poor.earned < 1.2 * best.earned, "{} {}", poor.earned, best.earned);
        assert!((improved - best.earned).abs() < 1e-3 * best.earned.abs(), "{improved} {}", best.earned);
    }
}
