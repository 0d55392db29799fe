//! A state too slow to reach rest within an episode: plans earn what the convex program of the controls does.

use std::sync::Arc;

use sindyna_control::{Method, Planner};
use sindyna_core::{Channel, Diverged, Dynamics, Environment as _, Kind, Mode, Policy as _, Precision, Rng, Seed};
use sindyna_core::{Sensors, Simulated, Space, Spec, Task};

/// Steps of an episode, s of a step, the wanted temperature in °C, and the most that is heated with, in kW.
const STEPS: usize = 120;
const DT: f64 = 60.0;
const WANTED: f64 = 21.0;
const MOST: f64 = 8.0;

/// Air at T and walls at W, heated with P: 200 kJ/K and 5 MJ/K, 0.2, 0.05 and 0.08 kW/K between them and 5 °C outside.
struct Air;

impl Dynamics for Air {
    fn step(&self, x: &[f64], u: &[f64], _rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
        let heat = 0.2 * (x[1] - x[0]);
        next[0] = x[0] + DT * (heat + 0.05 * (5.0 - x[0]) + u[0]) / 200.0;
        next[1] = x[1] + DT * (0.08 * (5.0 - x[1]) - heat) / 5_000.0;
        Diverged::check(next)
    }
}

/// A room that is to be warm, for a reward −0.05 (T⁺ − 21)².
struct Room(Spec);

impl Room {
    fn new() -> Self {
        let states = ["T", "W"].map(|name| Channel::new(name, "degC", Kind::Plain, 10.0)).to_vec();
        Self(Spec {
            name: "room".into(),
            observation: states.clone(),
            state: states,
            control: vec![Channel::new("P", "kW", Kind::Plain, MOST)],
            action_space: Space::Box { low: vec![0.0], high: vec![MOST] },
            precision: Precision::F64,
            noise: 0.0,
            dt: DT,
        })
    }
}

impl Task for Room {
    fn spec(&self) -> &Spec {
        &self.0
    }
    fn max_steps(&self) -> usize {
        STEPS
    }
    fn initial(&self, _rng: &mut Rng, x: &mut [f64]) {
        x.copy_from_slice(&[15.0, 14.0]);
    }
    fn reward(&self, _x: &[f64], _action: &[f64], _u: &[f64], next: &[f64]) -> f64 {
        -0.05 * (next[0] - WANTED).powi(2)
    }
    fn terminated(&self, _next: &[f64]) -> bool {
        false
    }
}

/// Temperatures of the air after each step.
fn temperatures(start: &[f64; 2], controls: &[f64]) -> Vec<f64> {
    let (mut x, mut next, mut rng) = (*start, [0.0; 2], Seed::new(0).numpy());
    let step = |u: &f64| {
        Air.step(&x, &[*u], &mut rng, &mut next).expect("it stays finite");
        x = next;
        x[0]
    };
    controls.iter().map(step).collect()
}

/// The most that controls within their bounds can earn, by coordinate descent on the quadratic program.
fn most(start: &[f64; 2]) -> f64 {
    let still = temperatures(start, &[0.0; STEPS]);
    let mut pulse = [0.0; STEPS];
    pulse[0] = 1.0;
    let answer: Vec<f64> = temperatures(start, &pulse).iter().zip(&still).map(|(one, none)| one - none).collect();
    let (mut u, mut off) = ([0.0; STEPS], still.iter().map(|t| t - WANTED).collect::<Vec<f64>>());
    for _ in 0..5_000 {
        for s in 0..STEPS {
            let (slope, bend) = off[s..].iter().zip(&answer).fold((0.0, 0.0), |(a, b), (o, g)| (a + o * g, b + g * g));
            let change = (u[s] - slope / bend).clamp(0.0, MOST) - u[s];
            u[s] += change;
            off[s..].iter_mut().zip(&answer).for_each(|(off, answer)| *off += change * answer);
        }
    }
    off.iter().map(|off| -0.05 * off * off).sum()
}

#[test]
fn a_plan_is_as_good_as_the_convex_program() {
    let task: Arc<dyn Task> = Arc::new(Room::new());
    let planner = Planner::new(Method::Ilqr, Arc::new(Air), task.clone()).expect("all is observed").prepared();
    for start in [[10.0, 10.0], [20.0, 12.0], [13.0, 18.0], [30.0, 20.0]] {
        let mut env = Simulated::new(Arc::new(Air), task.clone(), Sensors::new(task.spec()).expect("all is observed"));
        let mut rng = Seed::new(0).numpy();
        env.reset_to(&start, &mut rng);
        let (mut memory, mut action, mut earned) = (planner.begin().expect("planners remember"), [0.0], 0.0);
        for _ in 0..STEPS {
            memory.act(env.observation(), Mode::Exploit, &mut rng, &mut action);
            earned += env.step(&action, &mut rng).expect("it stays finite").reward;
        }
        let most = most(&start);
        assert!(earned > 1.01 * most - 1e-3, "{start:?}: {earned} of {most}");
    }
}
