//! Confirmation episodes: when there is one, and what follows from it.

mod common;

use common::{Doubting, EXACT, Given, Line, Push, Student, auto, run, run_seeded, schedule};
use sindyna_core::{
    Certainty, Checkpoint as _, Dataset, DynamicsLearner, FitError, Knowledge, Rng, Seed, Sensors, Simulated,
};
use sindyna_dyna::{Refit, Rollouts, evaluate};

#[test]
fn a_confirmed_prediction_costs_one_real_episode() {
    let mut schedule = schedule();
    schedule.imagined_rollouts = Rollouts::Count(1_000_000);
    let learned = run(&Given(EXACT), &schedule, Student::default(), &|| false);
    let warmup_only = run(&Given(EXACT), &self::schedule(), Student::default(), &|| false);
    assert!(learned.converged);
    assert_eq!(learned.data.n_rollouts(), warmup_only.data.n_rollouts() + 1);
    assert_eq!(learned.updates, warmup_only.updates);
}

#[test]
fn a_failed_prediction_leads_to_more_training() {
    // The model moves half as far as it should, so reality overshoots; refitting does not help this learner.
    let mut schedule = schedule();
    schedule.imagined_rollouts = Rollouts::Count(1_000_000);
    schedule.refit = Refit::AfterRollouts;
    let warmup = run(&Given(EXACT), &self::schedule(), Student::default(), &|| false).data.n_rollouts();
    let agent = Student { eager: true, ..Student::default() };
    let learned = run(&Given(Push { gain: 0.5, ..EXACT }), &schedule, agent, &|| false);
    assert!(learned.data.n_rollouts() > warmup + 1, "{} rollouts", learned.data.n_rollouts());
    assert!(learned.updates > 30 && learned.policy.is_some());
}

/// Whose model is right up to so many steps of data, and another one from then on.
struct Waking(usize, Push);

impl DynamicsLearner for Waking {
    type Model = Push;
    fn fit(&self, data: &Dataset, _: Option<&Push>, _: &mut Rng) -> Result<Option<Knowledge<Push>>, FitError> {
        let model = if data.n_steps() <= self.0 { EXACT } else { self.1.clone() };
        Ok(Some(Knowledge { certainty: Certainty::Adequate, ..Knowledge::certain(model) }))
    }
}

#[test]
fn a_confirmed_return_is_predicted_again_with_the_episode_among_the_data() {
    let rollouts = |next: Push| {
        let learned = run(&Waking(30, next), &auto(), Student::default(), &|| false);
        assert!(learned.policy.is_some() && learned.prediction.is_some());
        learned.data.n_rollouts()
    };
    let confirmed = rollouts(EXACT);
    assert_eq!(confirmed, run(&Given(EXACT), &auto(), Student::default(), &|| false).data.n_rollouts() + 1);
    assert!(
        rollouts(Push { gain: 3.0, ..EXACT }) > confirmed,
        "in the next model the policy overshoots: it is trained anew"
    );
}

/// Whose model moves half as far as the truth up to 30 steps of data, and is exact from then on.
struct Enlightened;

impl DynamicsLearner for Enlightened {
    type Model = Push;
    fn fit(&self, data: &Dataset, _: Option<&Push>, _: &mut Rng) -> Result<Option<Knowledge<Push>>, FitError> {
        let (gain, certainty) = if data.n_steps() <= 30 { (0.5, Certainty::Adequate) } else { (1.0, Certainty::Exact) };
        Ok(Some(Knowledge { certainty, ..Knowledge::certain(Push { gain, ..EXACT }) }))
    }
}

#[test]
fn a_better_policy_found_after_the_last_real_episode_is_handed_over() {
    let mut schedule = auto();
    schedule.optimality.trial_every = 5;
    // Twice as strong: right at gain 1 in the first model, at gain 0.5 in truth.
    let agent = Student { eager: true, ..Student::default() };
    let learned = run(&Enlightened, &schedule, agent, &|| false);
    assert!(learned.data.n_steps() > 30, "the first policy had a real episode");
    let mut kept = Student::default();
    kept.restore(&learned.policy.expect("there were trials").to_bytes()).expect("it is a student's");
    assert!((kept.gain - 0.5).abs() < 1e-9, "the best in the exact model: {}", kept.gain);
    assert!(learned.confirmation.is_none(), "the real episode was another policy's");
}

#[test]
fn an_exact_model_is_believed_and_its_prediction_holds() {
    let learned = run(&Given(EXACT), &auto(), Student::default(), &|| false);
    assert_eq!(learned.data.n_steps(), 30, "the warm-up alone");
    assert!(learned.confirmation.is_none());
    let prediction = learned.prediction.expect("there is a policy");
    let task = Line::new(20);
    let sensors = Sensors::new(&task.0).expect("the observation names the state");
    let mut envs: Vec<_> = (0..100).map(|_| Simulated::new(EXACT, &task, sensors.clone())).collect();
    let policy = learned.policy.expect("there were trials");
    let mean = |seed: u64, envs: &mut Vec<_>| {
        evaluate(envs, &*policy, 100, Seed::new(seed), "evaluation").expect("nothing fails here").iter().sum::<f64>()
            / 100.0
    };
    let (low, high) = prediction.interval(0.9, 100);
    let held = (0..200).filter(|seed| (low..=high).contains(&mean(*seed, &mut envs))).count();
    // The interval is of one sample in the model: its own error is in it.
    assert!((150..=200).contains(&held), "{held} of 200 in {low} to {high}");
}

#[test]
fn doubts_are_met_with_as_much_data_again_and_an_episode_that_confirms() {
    let learned = run(&Doubting { model: EXACT, enough: 100 }, &auto(), Student::default(), &|| false);
    let steps = learned.data.n_steps();
    // The model predicts the new data as well as the first ones: no more are collected, though it is still doubted.
    assert!((60..=80).contains(&steps), "30, 60, and an episode of 20 at most: {steps}");
    assert!(learned.confirmation.expect("it was not believed at once").agrees());
}

/// Finds a model of few data and none of more.
struct OfFew;

impl DynamicsLearner for OfFew {
    type Model = Push;
    fn fit(&self, data: &Dataset, _: Option<&Push>, _: &mut Rng) -> Result<Option<Knowledge<Push>>, FitError> {
        let few =
            (data.n_steps() <= 30).then(|| Knowledge { certainty: Certainty::Doubted, ..Knowledge::certain(EXACT) });
        few.map(Some).ok_or_else(|| FitError::Regression { reason: "no equations follow the data".into() })
    }
}

#[test]
fn a_fit_that_fails_leaves_what_was_known_in_doubt() {
    let learned = run(&OfFew, &auto(), Student::default(), &|| false);
    assert!(learned.model.is_some() && learned.policy.is_some() && !learned.interrupted);
    assert!(learned.data.n_steps() > 30, "something spoke against the model");
    assert!(learned.confirmation.is_some(), "it is not believed without a real episode");
    assert!(learned.refit_failure.is_some_and(|why| why.contains("no equations")), "it is told at the end");
}

#[test]
fn what_reality_did_not_keep_widens_what_is_predicted() {
    let mut schedule = auto();
    schedule.optimality.max_updates = 60;
    let agent = Student { eager: true, ..Student::default() };
    // In the model the goal is reached in one step, in truth it is overshot for ever.
    let wrong = Doubting { model: Push { gain: 0.5, ..EXACT }, enough: 0 };
    let mut broken = 0;
    for seed in 0..10 {
        let learned = run_seeded(seed, &wrong, &schedule, agent.clone(), &|| false);
        let confirmation = learned.confirmation.expect("it was tried");
        // An episode that begins next to the goal tells little.
        if !confirmation.agrees() {
            broken += 1;
            let (low, high) = learned.prediction.expect("there is a policy").interval(0.9, 100);
            assert!(high - low > confirmation.shortfall(), "{low} to {high}");
        }
    }
    assert!(broken > 3, "{broken} of 10");
}
