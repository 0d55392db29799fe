//! What an update does with terminations, odd batches, numbers that are none, and randomness.

use ndarray::array;
use sindyna_core::{AgentError, Batch, Mode, Policy as _, Seed};

use super::{STILL, agent, batch};
use crate::{Sac, SacConfig, SacError, Scaling};

fn small(config: SacConfig) -> SacConfig {
    SacConfig { hidden: vec![16, 16], ..config }
}

#[test]
fn truncated_steps_bootstrap_and_terminated_ones_do_not() {
    let config = SacConfig { learning_rate: STILL, discount: 0.9, reward_scale: 2.0, ..SacConfig::default() };
    let mut sac = agent(small(config), 1, 1);
    // The same transition twice: cut by the time limit, which the flag does not show, and ended for good.
    let batch = Batch {
        observations: array![[0.3], [0.3]],
        actions: array![[0.1], [0.1]],
        rewards: array![1.5, 1.5],
        next_observations: array![[0.4], [0.4]],
        terminated: array![0.0, 1.0],
    };
    sac.update_with_noise(&batch, &[0.5, 0.5, -0.2, -0.2]).expect("finite losses");
    let (action, log_prob) = (sac.work.drawn.actions[2], sac.work.drawn.log_probs[2]);
    let values = sac.learner.critics.each_mut().map(|c| f64::from(c.target_values(&[0.4, action], 1)[0]));
    let truncated = 2.0 * 1.5 + 0.9 * (values[0].min(values[1]) - log_prob);
    assert!((f64::from(sac.learner.targets[0]) - truncated).abs() < 1e-6, "α is 1");
    assert_eq!(sac.learner.targets[1], 3.0, "only the scaled reward is left");
}

#[test]
fn warm_up_actions_beyond_the_range_count_as_its_ends() {
    let run = |action: f64| {
        let mut sac = agent(small(SacConfig::default()), 2, 1);
        let mut batch = batch(8, 2, 1);
        batch.actions.fill(action);
        sac.update(&batch, &mut Seed::new(1).numpy()).expect("finite losses");
        sac.learner.critics[0].net.params.clone()
    };
    assert_eq!(run(3.0), run(1.0));
    assert_ne!(run(0.9), run(1.0));
}

#[test]
fn batches_of_other_shapes_are_refused_and_change_nothing() {
    let good = batch(6, 2, 1);
    let mut rng = Seed::new(0).numpy();
    let mut sac = agent(small(SacConfig::default()), 2, 1);
    let before = sac.frozen();
    let wrong = [
        Batch::zeros(0, 2, 1),
        batch(6, 3, 1),
        batch(6, 2, 2),
        Batch { rewards: array![0.0], ..good.clone() },
        Batch { terminated: array![0.0], ..good.clone() },
        Batch { next_observations: array![[0.0, 0.0]], ..good.clone() },
        Batch { actions: array![[0.0]], ..good.clone() },
    ];
    for batch in wrong {
        assert!(matches!(sac.update(&batch, &mut rng), Err(AgentError::Shape { .. })));
    }
    assert!(matches!(sac.update_with_noise(&good, &[0.0]), Err(AgentError::Shape { expected: 12, got: 1, .. })));
    assert_eq!((sac.frozen(), sac.updates()), (before, 0));
    assert!(sac.update(&good, &mut rng).is_ok());
}

#[test]
fn a_number_that_is_none_stops_training_before_a_network_moves() {
    let breaks: [fn(&mut Batch); 5] = [
        |b| b.observations[[3, 0]] = f64::NAN,
        |b| b.next_observations[[3, 1]] = f64::NAN,
        |b| b.actions[[3, 0]] = f64::NAN,
        |b| b.rewards[3] = f64::INFINITY,
        |b| b.rewards[3] = 1e300,
    ];
    for spoil in breaks {
        let mut sac = agent(small(SacConfig::default()), 2, 1);
        let before = (sac.frozen(), sac.learner.critics.each_ref().map(|c| c.net.params.clone()));
        let mut batch = batch(8, 2, 1);
        spoil(&mut batch);
        let result = sac.update(&batch, &mut Seed::new(0).numpy());
        assert!(matches!(result, Err(AgentError::NotFinite { updates: 0, .. })), "{result:?}");
        assert_eq!((sac.frozen(), sac.learner.critics.each_ref().map(|c| c.net.params.clone())), before);
    }
}

#[test]
fn one_seed_gives_one_training_to_the_last_bit() {
    let train = |seed| {
        let mut rng = Seed::new(seed).stream("training", 0);
        let mut sac = Sac::new(SacConfig::default(), Scaling::identity(3), &[-1.0], &[1.0], &mut rng).expect("usable");
        let first = sac.frozen();
        let losses: Vec<_> = (0..5).map(|_| sac.update(&batch(32, 3, 1), &mut rng).expect("finite")).collect();
        (first, sac.frozen().to_safetensors(), losses)
    };
    assert_eq!(train(4), train(4));
    let (a, b) = (train(4), train(5));
    assert!(a.0 != b.0 && a.1 != b.1);
}

#[test]
fn exploit_draws_no_random_number_and_explore_one_per_action_value() {
    let sac = agent(SacConfig::default(), 2, 2);
    let (mut rng, mut action) = (Seed::new(9).numpy(), [0.0; 2]);
    let before = rng.clone();
    sac.act(&[0.1, -0.2], Mode::Exploit, &mut rng, &mut action);
    assert_eq!(rng, before);
    let exploited = action;
    sac.act(&[0.1, -0.2], Mode::Explore, &mut rng, &mut action);
    assert!(rng != before && action.iter().zip(exploited).all(|(a, b)| *a != b));
}

#[test]
fn scaling_and_action_range_change_units_and_nothing_else() {
    let config = || small(SacConfig::default());
    let train = |scaling, low, high, batch: &Batch| {
        let mut sac = Sac::new(config(), scaling, &[low], &[high], &mut Seed::new(3).numpy()).expect("usable");
        sac.update(batch, &mut Seed::new(4).numpy()).expect("finite losses");
        sac.frozen()
    };
    // Powers of two, so that rescaling is exact.
    let plain = batch(8, 2, 1);
    let mut other = plain.clone();
    other.observations.mapv_inplace(|o| 4.0 * o);
    other.next_observations.mapv_inplace(|o| 4.0 * o);
    other.actions.mapv_inplace(|a| 8.0 * a);
    let fours = Scaling { center: vec![0.0; 2], scale: vec![4.0; 2] };
    let a = train(Scaling::identity(2), -1.0, 1.0, &plain);
    let b = train(fours, -8.0, 8.0, &other);
    assert_eq!(a.net.net, b.net.net);
    let (mut rng, mut from_a, mut from_b) = (Seed::new(0).numpy(), [0.0], [0.0]);
    a.act(&[0.5, 0.25], Mode::Exploit, &mut rng, &mut from_a);
    b.act(&[2.0, 1.0], Mode::Exploit, &mut rng, &mut from_b);
    assert!((8.0 * from_a[0] - from_b[0]).abs() < 1e-14);
}

#[test]
fn rows_of_a_batch_act_as_they_would_alone() {
    let sac = agent(SacConfig::default(), 3, 2);
    let (batch, mut rng) = (batch(37, 3, 2), Seed::new(0).numpy());
    let mut together = ndarray::Array2::zeros((37, 2));
    sac.act_batch(batch.observations.view(), Mode::Exploit, &mut rng, together.view_mut());
    let mut alone = [0.0; 2];
    for (o, a) in batch.observations.rows().into_iter().zip(together.rows()) {
        sac.act(&o.to_vec(), Mode::Exploit, &mut rng, &mut alone);
        assert_eq!(a.to_vec(), alone);
    }
}

#[test]
fn an_unusable_agent_is_refused() {
    let make =
        |low: &[f64], scaling| Sac::new(SacConfig::default(), scaling, low, &[1.0], &mut Seed::new(0).numpy()).err();
    assert!(matches!(make(&[2.0], Scaling::identity(1)), Some(SacError::ActionRange { .. })));
    assert!(matches!(make(&[], Scaling::identity(1)), Some(SacError::ActionEnds { .. })));
    assert!(matches!(make(&[0.0], Scaling::identity(0)), Some(SacError::ScalingWidth { .. })));
    assert!(make(&[0.0], Scaling::identity(1)).is_none());
}
