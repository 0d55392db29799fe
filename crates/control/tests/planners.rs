//! Planners on true systems: what they earn, and that they are the same policy every time.

mod common;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use sindyna_control::{Method, Planner};
use sindyna_core::{Bounded, Dynamics, Environment as _, Inverse, Mode, Policy as _, Seed, Sensors, Simulated, Task};
use sindyna_dyna::evaluate;

fn system(name: &str) -> (Arc<dyn Dynamics>, Arc<dyn Task>) {
    let system = sindyna_envs::find(name).expect("it is registered");
    (Arc::new(Bounded::new(system.dynamics(), &system.spec().state)), system.task())
}

/// Returns of `episodes` episodes.
fn returns((dynamics, task): &(Arc<dyn Dynamics>, Arc<dyn Task>), method: Method, episodes: usize) -> Vec<f64> {
    let planner = Planner::new(method, dynamics.clone(), task.clone()).expect("all is observed");
    let sensors = Sensors::new(task.spec()).expect("all is observed");
    let mut envs = vec![Simulated::new(dynamics.clone(), task.clone(), sensors); episodes];
    evaluate(&mut envs, &planner, episodes, Seed::new(1000), "planners").expect("nothing fails here")
}

fn least(returns: &[f64]) -> f64 {
    returns.iter().copied().fold(f64::INFINITY, f64::min)
}

#[test]
fn ilqr_swings_a_pendulum_up() {
    // Trained policies earn -150 on average over many starts.
    let returns = returns(&system("pendulum"), Method::Ilqr, 4);
    assert!(least(&returns) > -400.0 && returns.iter().sum::<f64>() / 4.0 > -200.0, "{returns:?}");
}

#[test]
fn ilqr_swings_a_pole_on_a_cart_up() {
    let returns = returns(&system("cart-pole-swing-up"), Method::Ilqr, 2);
    assert!(least(&returns) > 225.0, "{returns:?}");
}

#[test]
fn ilqr_finds_an_end_that_nothing_leads_to() {
    let returns = returns(&system("mountain-car"), Method::Ilqr, 2);
    assert!(least(&returns) > 90.0, "{returns:?}");
}

#[test]
fn mppi_swings_a_pendulum_up() {
    let returns = returns(&system("pendulum"), Method::Mppi, 4);
    assert!(least(&returns) > -450.0, "{returns:?}");
}

#[test]
fn a_regulator_finds_what_it_is_to_hold() {
    for name in ["inverted-pendulum", "cart-pole"] {
        let system = system(name);
        let all = f64::from(u32::try_from(system.1.max_steps()).expect("some hundreds"));
        assert!(least(&returns(&system, Method::Lqr, 3)) >= all, "{name}");
    }
}

/// Runs an acrobot from `start` for `steps`; what it earns in the last one.
fn acrobot(method: Method, start: &[f64], steps: usize) -> f64 {
    let task: Arc<dyn Task> = Arc::new(common::Swingup::new());
    let planner = Planner::new(method, common::dynamics(), task.clone()).expect("all is observed");
    let mut env = Simulated::new(common::dynamics(), task.clone(), Sensors::new(task.spec()).expect("all is observed"));
    let mut rng = Seed::new(0).numpy();
    env.reset_to(start, &mut rng);
    let (mut memory, mut action, mut last) = (planner.begin().expect("planners remember"), [0.0], 0.0);
    for _ in 0..steps {
        memory.act(env.observation(), Mode::Exploit, &mut rng, &mut action);
        last = env.step(&action, &mut rng).expect("it stays finite").reward;
    }
    last
}

#[test]
fn an_acrobot_is_caught_where_a_regulator_alone_lets_it_fall() {
    let start = [0.3, -0.2, 0.0, 0.0];
    let (held, planned) = (acrobot(Method::Lqr, &start, 400), acrobot(Method::Ilqr, &start, 400));
    assert!(planned > 0.999 && held < 0.9, "{planned} {held}");
}

#[test]
fn a_plan_is_the_same_every_time_and_follows_the_observation() {
    let (dynamics, task) = system("pendulum");
    for method in [Method::Lqr, Method::Ilqr, Method::Mppi] {
        let planner = Planner::new(method, dynamics.clone(), task.clone()).expect("all is observed");
        let act = |o: &[f64]| {
            let mut action = [0.0];
            planner.act(o, Mode::Exploit, &mut Seed::new(0).numpy(), &mut action);
            let mut first = [0.0];
            planner.begin().expect("planners remember").act(o, Mode::Exploit, &mut Seed::new(7).numpy(), &mut first);
            assert_eq!(action, first, "{method}: a batch is of first steps");
            action[0]
        };
        let (left, right) = (act(&[0.9, 0.435_889_9, 0.0]), act(&[0.9, -0.435_889_9, 0.0]));
        // No torque holds it there: what falls to the left and what falls to the right are mirror images.
        assert!(left.abs() > 0.1 && left * right < 0.0, "{method}: {left} {right}");
    }
}

#[test]
fn who_is_stopped_acts_at_once() {
    let task: Arc<dyn Task> = Arc::new(common::Swingup::new());
    let stop = Arc::new(AtomicBool::new(false));
    let planner =
        Planner::new(Method::Ilqr, common::dynamics(), task.clone()).expect("all is observed").with_stop(stop.clone());
    stop.store(true, Ordering::SeqCst);
    let mut action = [0.0];
    planner.act(&[-1.0, 0.0, 1.0, 0.0, 0.0, 0.0], Mode::Exploit, &mut Seed::new(0).numpy(), &mut action);
    assert!(action[0].abs() <= 1.0);
}

#[test]
fn states_nobody_sees_are_refused() {
    let (dynamics, task) = system("pendulum");
    let blind: Arc<dyn Task> = Arc::new(sindyna_core::Redeclared::new(task, |spec| {
        spec.observation.remove(1);
    }));
    assert!(Inverse::of(blind.spec()).is_err());
    let refusal = Planner::new(Method::Mppi, dynamics, blind).err().expect("an angle cannot be read").to_string();
    assert!(refusal.contains("no observation shows"), "{refusal}");
}
