//! Swing-ups like those of dm_control, planned in the true equations: what each of several starts returns.
//!
//! `cargo test -p sindyna-control --test swingups -- --ignored --nocapture` takes minutes.

#[path = "common/mod.rs"]
mod acrobot;
#[path = "common/cart.rs"]
mod cart;
#[path = "common/rubbing.rs"]
mod rubbing;
#[path = "common/weak.rs"]
mod weak;
#[path = "common/wheel.rs"]
mod wheel;

use std::io::{self, Write as _};
use std::sync::Arc;

use sindyna_control::{Method, Planner};
use sindyna_core::{Acting, Dynamics, Environment as _, Memory as _, Mode, Seed, Sensors, Simulated, Task};
use sindyna_dyna::evaluate;

/// Returns of episodes from start states of development seeds.
fn returns(dynamics: &Arc<dyn Dynamics>, task: Arc<dyn Task>, episodes: usize) -> Vec<f64> {
    let planner = Planner::new(Method::Ilqr, dynamics.clone(), task.clone()).expect("all is observed");
    let sensors = Sensors::new(task.spec()).expect("all is observed");
    let mut envs = vec![Simulated::new(dynamics.clone(), task, sensors); episodes];
    let returns = evaluate(&mut envs, &planner, episodes, Seed::new(1000), "swing-ups").expect("nothing fails here");
    let mean = returns.iter().sum::<f64>() / episodes as f64;
    writeln!(io::stderr(), "mean {mean:.1} of {returns:.1?}").expect("it can be written");
    returns
}

fn least(returns: &[f64]) -> f64 {
    returns.iter().copied().fold(f64::INFINITY, f64::min)
}

fn poles(poles: usize, sparse: bool, episodes: usize) -> f64 {
    let task = cart::Upright::new(poles, sparse);
    least(&returns(&task.dynamics(), Arc::new(task), episodes))
}

#[test]
fn a_pole_is_swung_up_where_only_upright_pays() {
    assert!(poles(1, true, 1) >= 840.0);
}

#[test]
fn a_reaction_wheel_swings_up_a_pendulum_soon() {
    assert!(least(&returns(&wheel::Swingup::dynamics(), Arc::new(wheel::Swingup::new()), 3)) >= 80.0);
}

/// With little torque, from rest: a dozen swings. Friction holds it wherever it stops, and where it rests slopes tell nothing.
#[test]
#[ignore = "takes half a minute"]
fn a_pendulum_with_dry_friction_is_swung_up() {
    let task = rubbing::Swingup::new();
    let dynamics = task.dynamics(1.1);
    assert!(least(&returns(&dynamics, Arc::new(task), 2)) >= 240.0);
}

/// Plans are missed where friction is 7 % more than in the model, as seen through noisy rates; all are upright in the last second.
#[test]
#[ignore = "takes minutes"]
fn a_pendulum_with_more_friction_than_its_model_is_swung_up() {
    let task = Arc::new(rubbing::Swingup::new());
    let (model, system) = (task.dynamics(1.08), task.dynamics(1.155));
    let planner = Planner::new(Method::Ilqr, model, task.clone()).expect("all is observed").with_noise(&[0.005, 0.5]);
    let planner = planner.prepared();
    for episode in 0..10 {
        let sensors = Sensors::new(task.spec()).expect("all is observed");
        let mut env = Simulated::new(system.clone(), task.clone(), sensors);
        let (mut rng, mut policy) = (Seed::new(1000).stream("a twin", episode), Acting::begin(&planner));
        env.reset(&mut rng).expect("nothing fails here");
        let (mut action, mut highest) = ([0.0], Vec::new());
        loop {
            policy.act(env.observation(), Mode::Exploit, &mut rng, &mut action);
            let outcome = env.step(&action, &mut rng).expect("nothing fails here");
            highest.push(-env.state()[0].cos());
            if outcome.truncated {
                break;
            }
        }
        let last = &highest[highest.len() - 20..];
        writeln!(io::stderr(), "{episode}: upright from step {:?}", highest.iter().rposition(|up| *up < 0.95))
            .expect("it can be written");
        assert!(last.iter().all(|up| *up > 0.95), "{episode}: {last:?}");
    }
}

#[test]
#[ignore = "takes minutes"]
fn a_pole_is_swung_up() {
    assert!(poles(1, false, 5) >= 880.0);
}

#[test]
#[ignore = "takes minutes"]
fn two_poles_are_swung_up_from_rest() {
    assert!(poles(2, false, 5) >= 780.0);
}

#[test]
#[ignore = "takes minutes"]
fn three_poles_are_swung_up_from_rest() {
    assert!(poles(3, false, 2) >= 600.0);
}

#[test]
#[ignore = "takes minutes"]
fn an_acrobot_is_swung_up_from_anywhere() {
    let task: Arc<dyn Task> = Arc::new(acrobot::Swingup::new());
    let returns = returns(&acrobot::dynamics(), task, 10);
    assert!(returns.iter().sum::<f64>() >= 6_500.0);
}

/// What an episode from each of some starts returns: planned, and by value iteration on a grid, whose interpolation loses some steps.
#[test]
#[ignore = "takes half a minute"]
fn a_weak_pendulum_is_swung_up_as_soon_as_it_can_be() {
    const STARTS: usize = 20;
    let task: Arc<dyn Task> = Arc::new(weak::Swingup::new());
    let planned = returns(&weak::Swingup::dynamics(), task.clone(), STARTS);
    let lost = weak::Lost::at_best();
    let best = (0..STARTS).map(|episode| {
        let mut x = [0.0; 2];
        task.initial(&mut Seed::new(1000).stream("swing-ups", episode as u64), &mut x);
        lost.earned(&x)
    });
    let best: Vec<f64> = best.collect();
    writeln!(io::stderr(), "by value iteration {best:.1?}").expect("it can be written");
    assert!(planned.iter().zip(&best).all(|(planned, best)| planned + 3.0 >= *best));
}
