//! The loop counts what it does, and nothing it should not see gets through.

mod common;

use std::cell::Cell;
use std::sync::Arc;

use common::{Doubting, EXACT, Given, Line, Push, Silent, Student, Undecided, auto, run, schedule};
use ndarray::{ArrayView2, ArrayViewMut2};
use sindyna_core::{Checkpoint, Memory, Mode, NoModel, Policy, Rng, Seed, Sensors, Simulated, Spec, Task};
use sindyna_dyna::{Dyna, Rollouts, Schedule, Uniform, evaluate};

#[test]
fn every_real_step_and_reset_is_counted() {
    let learned = run(&Given(EXACT), &schedule(), Student::default(), &|| false);
    assert_eq!(learned.data.n_steps(), 30);
    let early_ends = learned.data.rollouts().filter(|r| r.end != sindyna_core::End::Cut).count();
    assert!(learned.data.n_rollouts() >= 2 && learned.data.n_rollouts() <= 2 + early_ends);
}

#[test]
fn training_stops_when_trials_no_longer_gain_and_keeps_the_best() {
    let learned = run(&Given(EXACT), &schedule(), Student::default(), &|| false);
    assert!(learned.converged);
    // The gain is 1 after 10 updates; the trials at 20 and 30 gain nothing.
    assert_eq!(learned.updates, 30);
    let mut kept = Student::default();
    kept.restore(&learned.policy.expect("there were trials").to_bytes()).expect("it is a student's");
    assert!(kept.gain > 0.99);
    let best = learned.model_return.expect("there were trials");
    assert!(best <= 0.0 && best > -0.02, "only the start state costs anything: {best}");
}

#[test]
fn without_a_model_nothing_is_imagined() {
    let learned = run(&NoModel, &schedule(), Student::default(), &|| false);
    assert!(learned.model.is_none() && learned.policy.is_none());
    assert_eq!((learned.updates, learned.model_steps), (0, 0));
}

#[test]
fn a_diverging_model_is_counted_and_never_taught() {
    let agent = Student::default();
    let shown = Arc::clone(&agent.shown);
    let learned = run(&Given(Push { gain: 1.0, breaks_at: 0.5 }), &schedule(), agent, &|| false);
    assert!(learned.diverged > 0, "random actions reach 0.5 now and then");
    let shown = shown.lock().expect("one thread");
    assert!(shown.iter().all(|(next, reward, _)| next.is_finite() && reward.is_finite()));
}

#[test]
fn a_wild_model_shows_nobody_how_wild_it_is() {
    let agent = Student::default();
    let shown = Arc::clone(&agent.shown);
    let learned = run(&Given(Push { gain: 1e200, ..EXACT }), &schedule(), agent, &|| false);
    assert!(learned.updates > 0 && learned.diverged == 0);
    for (next, reward, _) in shown.lock().expect("one thread").iter() {
        assert!(next.abs() <= 100.0 && reward.abs() <= 1e4, "{next} {reward}");
    }
}

#[test]
fn a_model_that_always_diverges_ends_the_run_without_a_policy() {
    let learned = run(&Given(Push { gain: 1.0, breaks_at: -1.0 }), &schedule(), Student::default(), &|| false);
    assert!(learned.policy.is_none() && !learned.converged);
    assert!(learned.diverged > 0 && learned.updates == 0);
}

#[test]
fn leaving_the_trusted_region_is_an_end_that_costs() {
    // A model a thousand times too lively jumps out of all that it is followed to.
    struct Tame(Line);
    impl Task for Tame {
        fn spec(&self) -> &Spec {
            self.0.spec()
        }
        fn max_steps(&self) -> usize {
            self.0.max_steps()
        }
        fn initial(&self, rng: &mut Rng, x: &mut [f64]) {
            self.0.initial(rng, x);
        }
        fn reward(&self, x: &[f64], a: &[f64], u: &[f64], next: &[f64]) -> f64 {
            self.0.reward(x, a, u, next)
        }
        fn terminated(&self, _next: &[f64]) -> bool {
            false
        }
    }
    let task = Tame(Line::new(20));
    let sensors = Sensors::new(task.spec()).expect("the observation names the state");
    let mut real = Simulated::new(EXACT, &task, sensors.clone());
    let mut explorer = Uniform::new(task.spec());
    let (schedule, learner, agent) = (schedule(), Given(Push { gain: 1000.0, ..EXACT }), Student::default());
    let shown = Arc::clone(&agent.shown);
    let dyna = Dyna { task: &task, sensors: &sensors, learner: &learner, schedule: &schedule, seed: Seed::new(1) };
    let learned =
        dyna.run(&mut real, &mut explorer, Box::new(agent), &mut Silent, &|| false).expect("nothing fails here");
    assert!(learned.left_region > 0);
    let worst = learned.data.rollouts().flat_map(|r| r.rewards.to_vec()).fold(0.0, f64::min) / (1.0 - 0.9);
    let shown = shown.lock().expect("one thread");
    let ended = shown.iter().filter(|(_, _, terminated)| *terminated == 1.0).map(|(next, ..)| *next);
    let (low, high) = ended.fold((0.0, 0.0), |(low, high): (f64, f64), next| (low.min(next), high.max(next)));
    assert!(low < -10.0 && high > 10.0, "far from all data: {low} and {high}");
    for (next, reward, terminated) in shown.iter() {
        assert_eq!(*next == low || *next == high, *terminated == 1.0, "it ends at the border, and only there");
        if *terminated == 1.0 {
            assert!(*reward <= worst, "{reward} must include the worst value {worst}");
        }
    }
}

#[test]
fn for_finite_n_a_real_rollout_follows_every_n_imagined() {
    let mut schedule = schedule();
    schedule.imagined_rollouts = Rollouts::Count(12);
    (schedule.optimality.patience, schedule.optimality.settled) = (1000, 1000);
    let learned = run(&Given(EXACT), &schedule, Student::default(), &|| false);
    let real_after_warmup = learned.data.n_rollouts() as u64 - 2;
    // Up to `systems` rollouts end in one turn, and the last turn may not have come to its end.
    assert!(
        real_after_warmup >= learned.model_rollouts / (12 + 4) - 1,
        "{real_after_warmup} of {learned:?}",
        learned = learned.model_rollouts
    );
    assert!(real_after_warmup <= learned.model_rollouts / 12 + 1, "and one that confirms");
    assert!(learned.data.n_steps() > 30);
}

#[test]
fn an_interrupted_run_keeps_its_best_policy() {
    let agent = Student::default();
    let shown = Arc::clone(&agent.shown);
    let after_15_updates = || shown.lock().expect("one thread").len() >= 15 * 8;
    let learned = run(&Given(EXACT), &schedule(), agent, &after_15_updates);
    assert!(learned.interrupted && learned.policy.is_some());
    assert_eq!(learned.updates, 15);
}

#[test]
fn a_replay_smaller_than_the_random_steps_is_filled_once() {
    let mut schedule = schedule();
    schedule.replay_capacity = 16;
    assert!(run(&Given(EXACT), &schedule, Student::default(), &|| false).converged);
}

#[test]
fn an_interrupt_in_the_warm_up_keeps_the_data_there_are() {
    let asked = Cell::new(0);
    let stop_after_7 = || {
        asked.set(asked.get() + 1);
        asked.get() > 7
    };
    let learned = run(&Given(EXACT), &schedule(), Student::default(), &stop_after_7);
    assert!(learned.interrupted && learned.model.is_none() && learned.policy.is_none());
    assert_eq!(learned.data.n_steps(), 7);
}

#[test]
fn evaluation_depends_on_the_seed_and_not_on_how_many_systems_share_it() {
    let task = Line::new(20);
    let sensors = Sensors::new(&task.0).expect("the observation names the state");
    let policy = Student { gain: 0.5, ..Student::default() };
    let returns = |systems: usize, seed: u64| {
        let mut envs: Vec<_> = (0..systems).map(|_| Simulated::new(EXACT, &task, sensors.clone())).collect();
        evaluate(&mut envs, &policy, 7, Seed::new(seed), "evaluation").expect("nothing fails here")
    };
    assert_eq!(returns(7, 3), returns(1, 3));
    assert_eq!(returns(7, 3), returns(20, 3));
    assert_ne!(returns(7, 3), returns(7, 4));
}

#[test]
fn what_a_policy_keeps_in_mind_ends_with_its_episode() {
    /// Pushes by its first observation for ever.
    struct Stubborn;
    struct First(Option<f64>);
    impl Policy for Stubborn {
        fn act_batch(&self, o: ArrayView2<'_, f64>, mode: Mode, rng: &mut Rng, mut actions: ArrayViewMut2<'_, f64>) {
            for (o, mut a) in o.rows().into_iter().zip(actions.rows_mut()) {
                let mut action = [0.0];
                First(None).act(&o.to_vec(), mode, rng, &mut action);
                a[0] = action[0];
            }
        }
        fn begin(&self) -> Option<Box<dyn Memory + '_>> {
            Some(Box::new(First(None)))
        }
    }
    impl Memory for First {
        fn act(&mut self, o: &[f64], _mode: Mode, _rng: &mut Rng, action: &mut [f64]) {
            action[0] = -0.5 * *self.0.get_or_insert(o[0]);
        }
    }
    // −x₀² Σ (1 − k/2)² over k = 0, 1, 2, 3.
    let task = Line::new(4);
    let sensors = Sensors::new(task.spec()).expect("the observation names the state");
    for systems in [1, 3] {
        let mut envs = vec![Simulated::new(EXACT, &task, sensors.clone()); systems];
        let returns = evaluate(&mut envs, &Stubborn, 7, Seed::new(3), "test").expect("nothing fails here");
        for (i, earned) in returns.iter().enumerate() {
            let mut start = [0.0];
            task.initial(&mut Seed::new(3).stream("test", i as u64), &mut start);
            assert!((earned + 1.5 * start[0] * start[0]).abs() < 1e-15, "episode {i}: {earned} from {start:?}");
        }
    }
}

#[test]
fn schedules_no_run_can_have_are_refused_by_name() {
    let of = |change: fn(&mut Schedule)| {
        let mut schedule = schedule();
        change(&mut schedule);
        schedule
    };
    assert_eq!(schedule().check(), Ok(()));
    for (schedule, name) in [
        (of(|s| s.systems = 0), "systems"),
        (of(|s| s.optimality.trial_episodes = 0), "optimality.trial_episodes"),
        (of(|s| s.optimality.trial_every = 0), "optimality.trial_every"),
        (of(|s| s.discount = 1.0), "discount"),
        (of(|s| s.scattered_starts = 1.5), "scattered_starts"),
        (of(|s| s.scattered_starts = f64::NAN), "scattered_starts"),
        (of(|s| s.imagined_rollouts = Rollouts::Count(0)), "imagined_rollouts"),
        (of(|s| s.batch_size = 0), "batch_size"),
    ] {
        assert_eq!(schedule.check().expect_err(name).name, name);
    }
}

#[test]
fn half_of_the_first_steps_are_chosen_by_what_the_models_disagree_on() {
    let schedule = Schedule { warmup_rollouts: 1, rollout_len: 200, max_real_steps: Some(200), ..auto() };
    let pushes = |schedule: &Schedule| -> Vec<f64> {
        let learned = run(&Undecided(vec![0.8, 1.2]), schedule, Student::default(), &|| false);
        assert_eq!(learned.data.n_steps(), 200, "as many as without");
        learned.data.transitions(0).map(|t| t.action[0]).collect()
    };
    let (chosen, explored) = (pushes(&schedule), pushes(&Schedule { curious: false, ..schedule.clone() }));
    assert_eq!(chosen[..100], explored[..100], "the explorer's");
    assert!(chosen[100..].iter().zip(&explored[100..]).all(|(a, b)| a != b));
}

#[test]
fn where_models_disagree_on_the_return_the_run_says_what_to_collect() {
    let schedule = Schedule { max_real_steps: Some(30), ..auto() };
    let gap = |gains: &[f64]| run(&Undecided(gains.to_vec()), &schedule, Student::default(), &|| false).gap;
    let gap_of_unlike = gap(&[0.2, 1.9]).expect("the interval is wide");
    assert!(gap_of_unlike.share > 0.1 && gap_of_unlike.states.len() == 1 && gap_of_unlike.controls.len() == 1);
    let (low, high) = gap_of_unlike.controls[0];
    assert!(low <= high && low.abs().max(high.abs()) > 0.01, "models disagree where there is a push: {low} to {high}");
    assert_eq!(gap(&[1.0]), None, "models that are all the same");
}

#[test]
fn no_more_real_steps_are_made_than_allowed() {
    let learner = Doubting { model: EXACT, enough: 1000 };
    for (most, steps) in [(30, 30), (59, 50), (60, 60), (100, 80)] {
        let schedule = Schedule { max_real_steps: Some(most), ..auto() };
        let learned = run(&learner, &schedule, Student::default(), &|| false);
        let made = learned.data.n_steps();
        assert!(made <= most && made + 20 > steps, "{made} of {most}");
        assert!(learned.policy.is_some());
    }
}
