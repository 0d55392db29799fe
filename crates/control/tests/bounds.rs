//! Positions with bounds: plans stay within them, and earn what the fastest way to them does.

use std::sync::Arc;

use sindyna_control::{Method, Planner};
use sindyna_core::{Channel, Diverged, Dynamics, Environment as _, Kind, Mode, Policy as _, Precision, Rng, Seed};
use sindyna_core::{Sensors, Simulated, Space, Spec, Task};

/// Steps of an episode, s of a step, m/s² at the full control, and the end of the rail and the wanted place in m.
const STEPS: usize = 100;
const DT: f64 = 0.05;
const MOST: f64 = 4.0;
const END: f64 = 1.0;
const WANTED: f64 = 3.0;

/// A cart at x with v, pushed with u; nothing is known of the end of the rail.
struct Cart;

impl Dynamics for Cart {
    fn step(&self, x: &[f64], u: &[f64], _rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
        next[0] = x[0] + DT * x[1] + 0.5 * DT * DT * MOST * u[0];
        next[1] = x[1] + DT * MOST * u[0];
        Diverged::check(next)
    }
}

/// A cart that is to come as near as it can to a place beyond the end of its rail, for a reward −(x⁺ − 3)².
struct Rail(Spec);

impl Rail {
    fn new() -> Self {
        let x = Channel::new("x", "m", Kind::Plain, END).within(-END, END);
        let states = vec![x, Channel::new("v", "m/s", Kind::RateOf(0), 1.0)];
        Self(Spec {
            name: "rail".into(),
            observation: states.clone(),
            state: states,
            control: vec![Channel::new("u", "", Kind::Plain, 1.0)],
            action_space: Space::Box { low: vec![-1.0], high: vec![1.0] },
            precision: Precision::F64,
            noise: 0.0,
            dt: DT,
        })
    }
}

impl Task for Rail {
    fn spec(&self) -> &Spec {
        &self.0
    }
    fn max_steps(&self) -> usize {
        STEPS
    }
    fn initial(&self, _rng: &mut Rng, x: &mut [f64]) {
        x.fill(0.0);
    }
    fn reward(&self, _x: &[f64], _action: &[f64], _u: &[f64], next: &[f64]) -> f64 {
        -(next[0] - WANTED).powi(2)
    }
    fn terminated(&self, _next: &[f64]) -> bool {
        false
    }
}

/// Places after each step, and what they earn, under `control` of the state.
fn run(mut control: impl FnMut(&[f64]) -> f64, start: [f64; 2]) -> (Vec<f64>, f64) {
    let task: Arc<dyn Task> = Arc::new(Rail::new());
    let mut env = Simulated::new(Arc::new(Cart), task.clone(), Sensors::new(task.spec()).expect("all is observed"));
    let mut rng = Seed::new(0).numpy();
    env.reset_to(&start, &mut rng);
    let (mut places, mut earned) = (Vec::new(), 0.0);
    for _ in 0..STEPS {
        let u = control(env.observation());
        earned += env.step(&[u], &mut rng).expect("it stays finite").reward;
        places.push(env.observation()[0]);
    }
    (places, earned)
}

#[test]
fn plans_stay_within_the_bounds_of_positions() {
    for method in [Method::Ilqr, Method::Mppi] {
        let task: Arc<dyn Task> = Arc::new(Rail::new());
        let planner = Planner::new(method, Arc::new(Cart), task).expect("all is observed").prepared();
        for start in [[0.0, 0.0], [-0.9, 0.5], [0.7, -1.0]] {
            let (mut memory, mut action, mut rng) =
                (planner.begin().expect("planners remember"), [0.0], Seed::new(0).numpy());
            let (places, earned) = run(
                |x| {
                    memory.act(x, Mode::Exploit, &mut rng, &mut action);
                    action[0]
                },
                start,
            );
            let farthest = places.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            // The hardest push after which full brakes stop the cart on the rail.
            let (_, fastest) = run(
                |x| {
                    let stops = |u: &f64| {
                        let v = (x[1] + DT * MOST * u).max(0.0);
                        x[0] + DT * x[1] + 0.5 * DT * DT * MOST * u + v * v / (2.0 * MOST) <= END
                    };
                    (0..=200).map(|push| 1.0 - 0.01 * f64::from(push)).find(stops).unwrap_or(-1.0)
                },
                start,
            );
            assert!(farthest < END + 0.02, "{method} {start:?}: {farthest}");
            // Samples find no such way.
            assert!(method == Method::Mppi || earned > 1.003 * fastest, "{method} {start:?}: {earned} of {fastest}");
        }
    }
}
