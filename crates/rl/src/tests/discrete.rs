//! Updates over numbered actions: gradients by finite differences, targets, odd batches, the temperature's bound.

use ndarray::array;
use rand::RngExt as _;
use sindyna_core::{AgentError, Batch, Mode, Policy as _, Seed};

use super::{
    STILL, discrete_agent, discrete_batch, distance,
    finite_differences::{Plain, row},
};
use crate::{SacConfig, SacDiscrete, SacError, Scaling};

const M: usize = 3;
const N: usize = 3;
const ROWS: usize = 24;
const TEMPERATURE: f64 = 0.4;

fn small(config: SacConfig) -> SacConfig {
    SacConfig { hidden: vec![16, 16], ..config }
}

/// An agent whose update has left its gradients behind, and the batch.
fn updated() -> (SacDiscrete, Batch) {
    let config = SacConfig {
        hidden: vec![8, 7, 6],
        learning_rate: STILL,
        initial_temperature: TEMPERATURE,
        ..SacConfig::default()
    };
    let (mut sac, batch) = (discrete_agent(config, M, N), discrete_batch(ROWS, M, N));
    sac.update(&batch, &mut Seed::new(0).numpy()).expect("finite losses");
    (sac, batch)
}

/// Σ π (Q - α log π), written out plainly.
fn soft_value(head: &[f64], values: [&[f64]; 2], temperature: f64) -> f64 {
    let normaliser = head.iter().map(|z| z.exp()).sum::<f64>().ln();
    let term = |a: usize| {
        let log_prob = head[a] - normaliser;
        log_prob.exp() * (values[0][a].min(values[1][a]) - temperature * log_prob)
    };
    (0..head.len()).map(term).sum()
}

#[test]
fn critic_gradients_reach_the_action_that_was_taken_and_no_other() {
    let (sac, batch) = updated();
    for critic in &sac.learner.critics {
        let targets = &sac.learner.targets;
        let loss = |net: &Plain| {
            let value = |i: usize| net.run(&row(&batch.observations, i))[batch.actions[[i, 0]] as usize];
            (0..ROWS).map(|i| 0.5 * (value(i) - f64::from(targets[i])).powi(2)).sum::<f64>() / ROWS as f64
        };
        let error = distance(&critic.gradients, &Plain::of(&critic.net).gradient(loss));
        assert!(error < 3e-6, "off by {error:e}");
    }
}

#[test]
fn actor_gradients_are_those_of_a_sum_over_the_actions() {
    let (sac, batch) = updated();
    let critics = sac.learner.critics.each_ref().map(|c| Plain::of(&c.net));
    let loss = |net: &Plain| {
        let of_row = |i: usize| {
            let o = row(&batch.observations, i);
            let values = critics.each_ref().map(|c| c.run(&o));
            -soft_value(&net.run(&o), [&values[0], &values[1]], TEMPERATURE)
        };
        (0..ROWS).map(of_row).sum::<f64>() / ROWS as f64
    };
    let error = distance(&sac.learner.actor_gradients, &Plain::of(&sac.policy.net.net).gradient(loss));
    assert!(error < 3e-6, "off by {error:e}");
}

#[test]
fn truncated_steps_bootstrap_and_terminated_ones_do_not() {
    let config = SacConfig { learning_rate: STILL, discount: 0.9, reward_scale: 2.0, ..SacConfig::default() };
    let mut sac = discrete_agent(small(config), 1, 2);
    // The same transition twice: cut by the time limit, which the flag does not show, and ended for good.
    let batch = Batch {
        observations: array![[0.3], [0.3]],
        actions: array![[1.0], [1.0]],
        rewards: array![1.5, 1.5],
        next_observations: array![[0.4], [0.4]],
        terminated: array![0.0, 1.0],
    };
    sac.update(&batch, &mut Seed::new(0).numpy()).expect("finite losses");
    // In single precision, as the network sees it.
    let next = [f64::from(0.4_f32)];
    let values = sac.learner.critics.each_ref().map(|c| Plain::of(&c.target).run(&next));
    let value = soft_value(&Plain::of(&sac.policy.net.net).run(&next), [&values[0], &values[1]], 1.0);
    assert!((f64::from(sac.learner.targets[0]) - (3.0 + 0.9 * value)).abs() < 1e-6);
    assert_eq!(sac.learner.targets[1], 3.0, "only the scaled reward is left");
}

#[test]
fn a_batch_with_anything_but_numbers_of_actions_is_refused_and_changes_nothing() {
    let mut rng = Seed::new(0).numpy();
    let mut sac = discrete_agent(small(SacConfig::default()), 2, 3);
    let before = (sac.frozen(), sac.temperature());
    let good = discrete_batch(8, 2, 3);
    for bad in [3.0, -1.0, 0.5, 1e300, f64::NAN, f64::INFINITY] {
        let mut batch = good.clone();
        batch.actions[[4, 0]] = bad;
        let refused = sac.update(&batch, &mut rng).expect_err("no action has this number");
        assert!(matches!(refused, AgentError::Shape { expected: 8, got: 7, .. }), "{bad}: {refused}");
    }
    let wrong = [
        Batch::zeros(0, 2, 1),
        discrete_batch(8, 3, 3),
        Batch { actions: ndarray::Array2::zeros((8, 2)), ..good.clone() },
        Batch { rewards: array![0.0], ..good.clone() },
        Batch { terminated: array![0.0], ..good.clone() },
        Batch { next_observations: array![[0.0, 0.0]], ..good.clone() },
    ];
    for batch in wrong {
        assert!(matches!(sac.update(&batch, &mut rng), Err(AgentError::Shape { .. })));
    }
    assert_eq!(((sac.frozen(), sac.temperature()), sac.updates()), (before, 0));
    assert!(sac.update(&good, &mut rng).is_ok());
}

#[test]
fn a_number_that_is_none_stops_training_before_a_network_moves() {
    let breaks: [fn(&mut Batch); 4] = [
        |b| b.observations[[3, 0]] = f64::NAN,
        |b| b.next_observations[[3, 1]] = f64::NAN,
        |b| b.rewards[3] = f64::INFINITY,
        |b| b.rewards[3] = 1e300,
    ];
    for spoil in breaks {
        let mut sac = discrete_agent(small(SacConfig::default()), 2, 2);
        let state = |sac: &SacDiscrete| (sac.frozen(), sac.learner.critics.each_ref().map(|c| c.net.params.clone()));
        let (before, mut batch) = (state(&sac), discrete_batch(8, 2, 2));
        spoil(&mut batch);
        let result = sac.update(&batch, &mut Seed::new(0).numpy());
        assert!(matches!(result, Err(AgentError::NotFinite { updates: 0, .. })), "{result:?}");
        assert_eq!(state(&sac), before);
    }
}

#[test]
fn a_target_entropy_out_of_reach_does_not_make_the_temperature_run_away() {
    let config = SacConfig {
        learning_rate: 1e-2,
        initial_temperature: 0.1,
        target_entropy: Some(2.0 * 2_f64.ln()),
        ..small(SacConfig::default())
    };
    let (mut sac, batch, mut rng) = (discrete_agent(config, 2, 2), discrete_batch(16, 2, 2), Seed::new(0).numpy());
    let mut largest = 0.0_f64;
    for _ in 0..20_000 {
        largest = largest.max(sac.update(&batch, &mut rng).expect("finite losses").temperature);
    }
    assert!((largest - 1.0).abs() < 1e-12, "ten times the initial one is the bound, got {largest}");
}

#[test]
fn exploit_draws_no_random_number_and_explore_one() {
    let sac = discrete_agent(SacConfig::default(), 2, 3);
    let (mut rng, mut action) = (Seed::new(9).numpy(), [f64::NAN]);
    let before = rng.clone();
    sac.act(&[0.1, -0.2], Mode::Exploit, &mut rng, &mut action);
    assert_eq!(rng, before);
    let mut counts = [0; 3];
    for _ in 0..300 {
        sac.act(&[0.1, -0.2], Mode::Explore, &mut rng, &mut action);
        counts[action[0] as usize] += 1;
    }
    let mut once = before;
    (0..300).for_each(|_| assert!(once.random::<f64>() < 1.0));
    assert_eq!(rng, once);
    assert!(counts.iter().all(|c| *c > 0), "{counts:?}");
}

#[test]
fn rows_of_a_batch_act_as_they_would_alone() {
    let sac = discrete_agent(SacConfig::default(), 3, 4);
    let (batch, mut rng) = (discrete_batch(37, 3, 4), Seed::new(0).numpy());
    let mut together = ndarray::Array2::zeros((37, 1));
    sac.act_batch(batch.observations.view(), Mode::Exploit, &mut rng, together.view_mut());
    let mut alone = [0.0];
    for (o, a) in batch.observations.rows().into_iter().zip(together.rows()) {
        sac.act(&o.to_vec(), Mode::Exploit, &mut rng, &mut alone);
        assert_eq!(a.to_vec(), alone);
    }
}

#[test]
fn one_seed_gives_one_training_to_the_last_bit() {
    let train = |seed| {
        let mut rng = Seed::new(seed).stream("training", 0);
        let mut sac = SacDiscrete::new(SacConfig::default(), Scaling::identity(3), 2, &mut rng).expect("usable");
        let losses: Vec<_> = (0..5).map(|_| sac.update(&discrete_batch(32, 3, 2), &mut rng).expect("finite")).collect();
        (sac.frozen().to_safetensors(), losses)
    };
    assert_eq!(train(4), train(4));
    assert_ne!(train(4).0, train(5).0);
}

#[test]
fn an_agent_without_a_choice_is_refused() {
    for n in [0, 1] {
        let made = SacDiscrete::new(SacConfig::default(), Scaling::identity(1), n, &mut Seed::new(0).numpy());
        assert!(matches!(made.err(), Some(SacError::Setting { name: "n_actions", .. })), "{n}");
    }
}
