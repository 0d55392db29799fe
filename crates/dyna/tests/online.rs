//! Learning while acting: what is counted, what is mixed, and when it ends.

mod common;

use common::{Given, Line, Push, Student};
use sindyna_core::{NoModel, Seed, Sensors, Simulated, Task as _};
use sindyna_dyna::{Branches, Checks, Online, OnlineSchedule, Practised, Uniform};

const TRUTH: Push = Push { gain: 1.0, breaks_at: f64::INFINITY };

fn schedule(branches: Option<Branches>) -> OnlineSchedule {
    OnlineSchedule {
        real_steps: 60,
        first_steps: 20,
        held_steps: 1,
        updates_per_step: 3,
        batch_size: 20,
        replay_capacity: 1000,
        branches,
        checks: Checks { every: 10, episodes: 4, until: None },
    }
}

fn branches() -> Branches {
    Branches { every: 8, per_step: 5, length: 2, rounds_kept: 1, real_share: 0.25 }
}

fn run(schedule: &OnlineSchedule, model: Option<Push>, student: Student) -> Practised<Push> {
    let (task, student) = (Line::new(12), Box::new(student));
    let sensors = Sensors::new(task.spec()).expect("x is shown");
    let mut env = Simulated::new(TRUTH, &task, &sensors);
    let mut judges = vec![env.clone(); 2];
    let mut explorer = Uniform::new(task.spec());
    let seed = Seed::new(4);
    match model {
        Some(model) => Online { task: &task, sensors: &sensors, learner: &Given(model), schedule, seed }
            .run(&mut env, &mut judges, &mut explorer, student, &|| false)
            .expect("a simulation runs"),
        None => {
            let online = Online { task: &task, sensors: &sensors, learner: &NoModel, schedule, seed };
            let left = online.run(&mut env, &mut judges, &mut explorer, student, &|| false).expect("a simulation runs");
            assert!(left.model.is_none());
            Practised {
                model: None,
                policy: left.policy,
                real_steps: left.real_steps,
                real_episodes: left.real_episodes,
                updates: left.updates,
                model_steps: left.model_steps,
                diverged: left.diverged,
                checks: left.checks,
                reached: left.reached,
                failure: left.failure,
                interrupted: left.interrupted,
            }
        }
    }
}

#[test]
fn real_steps_updates_and_checks_are_counted() {
    let left = run(&schedule(None), None, Student::default());
    assert_eq!((left.real_steps, left.updates, left.model_steps), (60, 3 * 40, 0));
    assert!(left.real_episodes >= 5, "an episode has at most twelve steps: {}", left.real_episodes);
    let curve: Vec<_> = left.checks.iter().map(|c| (c.real_steps, c.updates, c.returns.len())).collect();
    assert_eq!(curve, [(10, 0, 4), (20, 0, 4), (30, 30, 4), (40, 60, 4), (50, 90, 4), (60, 120, 4)]);
    // The student gets better with every update.
    assert!(left.checks[5].mean() > left.checks[0].mean());
}

#[test]
fn a_batch_is_mixed_of_real_and_imagined_steps() {
    // The model moves twice as far, so its steps are told from real ones by their length.
    let student = Student::default();
    let shown = student.shown.clone();
    let model = Push { gain: 4.0, breaks_at: f64::INFINITY };
    let left = run(&schedule(Some(branches())), Some(model), student);
    // Five rounds of 8 · 5 rollouts of at most two steps.
    assert!((5 * 40..=5 * 80).contains(&left.model_steps), "{}", left.model_steps);
    let shown = shown.lock().expect("one thread");
    // A quarter of each batch of twenty is real and comes first; only the model goes beyond 1.4 in one step.
    let beyond = |wanted: fn(usize) -> bool| {
        let rows = shown.iter().enumerate().filter(|(i, _)| wanted(i % 20));
        rows.filter(|(_, (next, ..))| next.abs() > 1.4).count()
    };
    assert_eq!(beyond(|i| i < 5), 0);
    assert!(beyond(|i| i >= 5) > shown.len() / 10);
    for (next, reward, terminated) in shown.iter() {
        assert_eq!(*terminated, f64::from(u8::from(next.abs() > 1.0)), "the task ends, not the model");
        assert!(*reward <= 0.0);
    }
}

#[test]
fn rollouts_begin_where_the_real_system_was_and_diverging_ones_are_counted() {
    // Wherever it begins, the model has no finite next state.
    let model = Push { gain: 1.0, breaks_at: -1.0 };
    let left = run(&schedule(Some(branches())), Some(model), Student::default());
    assert!(left.model_steps > 0);
    assert_eq!(left.diverged, left.model_steps);
    assert_eq!(left.updates, 120, "real steps are learned from all the same");
}

#[test]
fn a_run_ends_at_the_first_check_that_reaches_what_is_wanted() {
    let mut schedule = schedule(None);
    schedule.checks = Checks { every: 5, episodes: 4, until: Some(-0.05) };
    let left = run(&schedule, None, Student::default());
    assert!(left.reached && left.real_steps < 60, "{}", left.real_steps);
    let (last, before) = left.checks.split_last().expect("there was a check");
    assert!(last.mean() >= -0.05 && before.iter().all(|check| check.mean() < -0.05));
}

#[test]
fn one_seed_gives_the_same_run() {
    let of = |model: Option<Push>| run(&schedule(model.as_ref().map(|_| branches())), model, Student::default()).checks;
    assert_eq!(of(None), of(None));
    assert_eq!(of(Some(TRUTH)), of(Some(TRUTH)));
}
