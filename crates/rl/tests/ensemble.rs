//! Ensembles against systems whose truth is known.

#![allow(clippy::float_cmp, reason = "where tests compare exactly, the bits are the claim")]

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use ndarray::{Array2, ArrayView2, Axis, concatenate, s};
use rand::RngExt as _;
use rand_distr::{Distribution as _, StandardNormal};
use sindyna_core::{
    Channel, Dataset, Dynamics as _, DynamicsLearner as _, FitError, Kind, Precision, Rng, Seed, Space, Spec,
};
use sindyna_rl::{
    Activation, Ensemble, EnsembleConfig, EnsembleLearner, EnsembleTrainer, Isa, RewardHead, TargetScale,
};

fn spec(state: Vec<Channel>, observation: Vec<Channel>) -> Spec {
    Spec {
        name: "known".into(),
        state,
        observation,
        control: vec![Channel::new("u", "", Kind::Plain, 1.0)],
        action_space: Space::Box { low: vec![-2.0], high: vec![2.0] },
        precision: Precision::F32,
        noise: 0.0,
        dt: 0.05,
    }
}

/// Settings of small networks for quick fits.
fn small() -> EnsembleConfig {
    EnsembleConfig {
        members: 3,
        elites: 2,
        hidden: vec![32, 32],
        weight_decay: vec![1e-5; 3],
        ..EnsembleConfig::janner()
    }
}

fn rng(index: u64) -> Rng {
    Seed::new(7).stream("ensemble test", index)
}

/// x' = x + A x + b u + σ ε, written out.
mod linear {
    pub(super) const A: [[f64; 2]; 2] = [[-0.1, 0.3], [-0.2, -0.05]];
    pub(super) const B: [f64; 2] = [0.0, 0.4];
    pub(super) const SIGMA: [f64; 2] = [0.02, 0.15];

    pub(super) fn mean(x: [f64; 2], u: f64) -> [f64; 2] {
        [0, 1].map(|i| x[i] + A[i][0] * x[0] + A[i][1] * x[1] + B[i] * u)
    }
}

fn linear_spec() -> Spec {
    let states = vec![Channel::new("a", "", Kind::Plain, 1.0), Channel::new("b", "", Kind::Plain, 1.0)];
    spec(states.clone(), states)
}

fn linear_data(n: usize, rng: &mut Rng) -> Dataset {
    let mut data = Dataset::new(2, 1, 1, 0.05);
    for _ in 0..n {
        let x = [(); 2].map(|()| rng.random_range(-1.0..1.0));
        let u = rng.random_range(-2.0..2.0);
        let mean = linear::mean(x, u);
        let next = [0, 1].map(|i| {
            let normal: f64 = StandardNormal.sample(rng);
            mean[i] + linear::SIGMA[i] * normal
        });
        data.begin(&x).expect("finite");
        data.push(&[u], &[u], x[0] - 10.0, &next).expect("finite");
    }
    data
}

#[test]
fn a_linear_gaussian_system_is_recovered_with_its_noise() {
    for activation in [Activation::Swish, Activation::Relu] {
        // The squared error stands still long before small networks have learned how large it is: by the presets' margin,
        // step size and patience, deviations of the smaller noise end up to 40 % too large.
        let config = EnsembleConfig {
            activation,
            learning_rate: 3e-3,
            min_improvement: 0.0,
            patience: 40,
            reward_head: RewardHead::Absent,
            ..small()
        };
        let learner = EnsembleLearner::new(config, &linear_spec()).expect("usable settings");
        let mut rng = rng(0);
        let data = linear_data(4000, &mut rng);
        let model = learner.fit(&data, None, &mut rng).expect("enough rows").expect("a model").model;
        let ensemble = model.ensemble();
        let (mut squares, mut deviations, mut n) = ([0.0; 2], [0.0; 2], 0.0);
        for _ in 0..200 {
            let x = [(); 2].map(|()| rng.random_range(-0.9..0.9));
            let u = rng.random_range(-1.8..1.8);
            let inputs = Array2::from_shape_fn((1, 3), |(_, j)| [x[0], x[1], u][j]);
            for &member in ensemble.elites() {
                let predicted = ensemble.predict(member, inputs.view());
                for i in 0..2 {
                    squares[i] += (x[i] + predicted.mean[[0, i]] - linear::mean(x, u)[i]).powi(2);
                    deviations[i] += predicted.deviation[[0, i]];
                }
                n += 1.0;
            }
        }
        for i in 0..2 {
            let (error, deviation) = ((squares[i] / n).sqrt(), deviations[i] / n);
            assert!(error < 0.3 * linear::SIGMA[i], "{activation:?}: mean of {i} is off by {error}");
            let ratio = deviation / linear::SIGMA[i];
            assert!((0.9..1.1).contains(&ratio), "{activation:?}: noise of {i} is {ratio} of the truth");
        }
        // The model over the state draws from just that.
        let (x, u, mut next) = ([0.4, -0.3], 1.0, [0.0; 2]);
        let (mut sums, mut squares, draws) = ([0.0; 2], [0.0; 2], 2000);
        for _ in 0..draws {
            model.step(&x, &[u], &mut rng, &mut next).expect("finite");
            for i in 0..2 {
                let off = (next[i] - linear::mean(x, u)[i]) / linear::SIGMA[i];
                (sums[i], squares[i]) = (sums[i] + off, squares[i] + off * off);
            }
        }
        for i in 0..2 {
            let (mean, square) = (sums[i] / f64::from(draws), squares[i] / f64::from(draws));
            assert!(mean.abs() < 0.6 && (0.7..1.5).contains(&square), "{activation:?}: {i}: {mean} {square}");
        }
    }
}

/// Gymnasium's pendulum: ω' = clip(ω + (15 sin θ + 3 u) Δt, ±8), θ' = θ + ω' Δt.
fn pendulum_step([theta, omega]: [f64; 2], u: f64) -> [f64; 2] {
    let omega = (omega + (15.0 * theta.sin() + 3.0 * u) * 0.05).clamp(-8.0, 8.0);
    [theta + omega * 0.05, omega]
}

fn pendulum_spec() -> Spec {
    let rate = Channel::new("ω", "rad/s", Kind::RateOf(0), 8.0);
    let cosine = Channel::new("cos θ", "", Kind::CosOf(0), 1.0);
    let sine = Channel::new("sin θ", "", Kind::SinOf(0), 1.0);
    spec(vec![Channel::new("θ", "rad", Kind::Angle, 3.1), rate.clone()], vec![cosine, sine, rate])
}

fn shown([theta, omega]: [f64; 2]) -> [f64; 3] {
    [theta.cos(), theta.sin(), omega].map(|v| f64::from(v as f32))
}

/// Rollouts of 200 steps under random torques.
fn pendulum_data(n: usize, rng: &mut Rng) -> Dataset {
    let mut data = Dataset::new(3, 1, 1, 0.05);
    let mut x = [0.0; 2];
    for t in 0..n {
        if t % 200 == 0 {
            x = [rng.random_range(-3.1..3.1), rng.random_range(-1.0..1.0)];
            data.begin(&shown(x)).expect("finite");
        }
        let u = rng.random_range(-2.0..2.0);
        let angle = x[0].sin().atan2(x[0].cos());
        let reward = -(angle * angle + 0.1 * x[1] * x[1] + 0.001 * u * u);
        x = pendulum_step(x, u);
        data.push(&[u], &[u], reward, &shown(x)).expect("finite");
    }
    data
}

/// Inputs (o; u) and increments of all steps.
fn rows(data: &Dataset) -> (Array2<f64>, Array2<f64>) {
    let inputs: Vec<_> =
        data.rollouts().map(|r| concatenate![Axis(1), r.observations.slice(s![..-1, ..]), r.controls]).collect();
    let targets: Vec<_> =
        data.rollouts().map(|r| &r.observations.slice(s![1.., ..]) - &r.observations.slice(s![..-1, ..])).collect();
    let stacked = |parts: &[Array2<f64>]| {
        let views: Vec<ArrayView2<'_, f64>> = parts.iter().map(|part| part.view()).collect();
        ndarray::concatenate(Axis(0), &views).expect("rows of one width")
    };
    (stacked(&inputs), stacked(&targets))
}

#[test]
fn two_thousand_random_steps_tell_how_a_pendulum_moves() {
    // A third of the epochs that it takes until nothing improves; the shares below are then 3 to 4 %.
    let config = EnsembleConfig { max_epochs: Some(45), ..EnsembleConfig::paper() };
    let learner = EnsembleLearner::new(config, &pendulum_spec()).expect("usable settings");
    let mut rng = rng(1);
    let data = pendulum_data(2000, &mut rng);
    let model = learner.fit(&data, None, &mut rng).expect("enough rows").expect("a model").model;
    let (inputs, targets) = rows(&pendulum_data(1000, &mut rng));
    for &member in model.ensemble().elites() {
        let predicted = model.ensemble().predict(member, inputs.view());
        for j in 0..3 {
            let error = (&predicted.mean.column(j) - &targets.column(j)).mapv(|e| e * e).mean().expect("rows").sqrt();
            let share = error / targets.column(j).std(0.0);
            assert!(share < 0.1, "network {member} misses value {j} by {share} of its increments' spread");
        }
    }
    // Over the state an angle goes on where it was, also after many turns.
    let mut next = [0.0; 2];
    for (theta, omega, u) in [(0.3, 1.0, 0.5), (3.1, 4.0, -1.0), (-31.0, -2.0, 1.5), (44.0, 3.0, 0.0)] {
        model.step(&[theta, omega], &[u], &mut rng, &mut next).expect("finite");
        let truth = pendulum_step([theta, omega], u);
        let off = [next[0] - truth[0], next[1] - truth[1]];
        assert!(off[0].abs() < 0.06 && off[1].abs() < 0.3, "from θ = {theta}: off by {off:?}");
    }
    let told = learner.describe(&model);
    assert!(told[0].starts_with("5 networks 4→200→200→200→200→8, 616048 numbers"), "{told:?}");
}

fn squared_error(ensemble: &Ensemble, member: usize, inputs: &Array2<f64>, targets: &Array2<f64>) -> f64 {
    let held_out = &ensemble.report().holdout_rows;
    let (inputs, targets) = (inputs.select(Axis(0), held_out), targets.select(Axis(0), held_out));
    let predicted = ensemble.predict(member, inputs.view());
    (&predicted.mean - &targets).mapv(|e| e * e).mean().expect("rows")
}

#[test]
fn a_fit_that_is_told_to_stop_ends_as_interrupted() {
    let (inputs, targets) = rows(&linear_data(300, &mut rng(2)));
    let stop = Arc::new(AtomicBool::new(true));
    let trainer = EnsembleTrainer::new(small()).expect("usable settings").until(stop);
    let fitted = trainer.fit(inputs.view(), targets.view(), None, &mut rng(3));
    assert!(matches!(fitted, Err(FitError::Interrupted)));
}

#[test]
fn training_stops_when_nobody_improves_and_everybody_gets_their_best_weights_back() {
    // Targets as they are, so that errors in the report have their unit.
    let config = EnsembleConfig { targets: TargetScale::Raw, patience: 2, learning_rate: 0.01, ..small() };
    let (inputs, targets) = rows(&linear_data(300, &mut rng(2)));
    let trainer = EnsembleTrainer::new(config).expect("usable settings");
    let ensemble = trainer.fit(inputs.view(), targets.view(), None, &mut rng(3)).expect("enough rows");
    let report = ensemble.report();
    let last_improvement = report.best_epoch.iter().max().expect("members");
    assert_eq!(report.history.len(), last_improvement + 2 + 2, "three epochs without improvement end it");
    assert!(report.best_epoch.iter().any(|epoch| epoch != last_improvement), "members are best at different times");
    for member in 0..3 {
        let best = report.history[report.best_epoch[member]][member];
        assert_eq!(report.holdout_mse[member], best, "the error of the best epoch, to the bit");
        let measured = squared_error(&ensemble, member, &inputs, &targets);
        assert!((measured / best - 1.0).abs() < 1e-4, "{measured} is not {best}");
        assert!(report.history.iter().all(|errors| errors[member] >= 0.99 * best));
    }
    let elites: Vec<f64> = ensemble.elites().iter().map(|i| report.holdout_mse[*i]).collect();
    let mut all = report.holdout_mse.clone();
    all.sort_by(f64::total_cmp);
    assert_eq!(elites, all[..2], "elites are those with the least error");
}

#[test]
fn one_seed_and_one_instruction_set_give_the_same_bytes() {
    let (inputs, targets) = rows(&linear_data(500, &mut rng(4)));
    let config = EnsembleConfig { max_epochs: Some(3), ..small() };
    for isa in Isa::ALL.into_iter().filter(|isa| isa.checked().is_ok()) {
        let trainer = EnsembleTrainer::new(config.clone()).expect("usable settings").with_isa(isa).expect("present");
        let bits = |seed| -> Vec<u32> {
            let ensemble = trainer.fit(inputs.view(), targets.view(), None, &mut rng(seed)).expect("enough rows");
            ensemble.parameters().map(f32::to_bits).collect()
        };
        assert!(bits(5) == bits(5), "{isa}");
        assert!(bits(5) != bits(6), "{isa}");
    }
}

#[test]
fn a_fit_begins_no_epoch_after_its_steps_are_made() {
    let (inputs, targets) = rows(&linear_data(1000, &mut rng(4)));
    // 1,000 rows, some of them held out, in batches of which the last is not full.
    let config = EnsembleConfig { batch_size: 100, holdout: 0.15, max_steps: Some(10), ..small() };
    let trainer = EnsembleTrainer::new(config).expect("usable settings");
    let ensemble = trainer.fit(inputs.view(), targets.view(), None, &mut rng(5)).expect("enough rows");
    assert_eq!(ensemble.report().training_rows, 850);
    assert_eq!(ensemble.report().history.len(), 2, "9 steps, and 9 more");
}

#[test]
fn rows_held_out_train_nothing_and_others_do() {
    let (inputs, targets) = rows(&linear_data(400, &mut rng(7)));
    // With one epoch there is no choice that the holdout rows could make.
    let trainer = EnsembleTrainer::new(EnsembleConfig { max_epochs: Some(1), ..small() }).expect("usable settings");
    let fit = |inputs: &Array2<f64>, targets: &Array2<f64>| {
        trainer.fit(inputs.view(), targets.view(), None, &mut rng(8)).expect("enough rows")
    };
    let plain = fit(&inputs, &targets);
    let held_out = &plain.report().holdout_rows;
    assert_eq!(held_out.len(), 80);
    let (mut poisoned_inputs, mut poisoned_targets) = (inputs.clone(), targets.clone());
    for &row in held_out {
        poisoned_inputs.row_mut(row).fill(1e3);
        poisoned_targets.row_mut(row).fill(-1e3);
    }
    let poisoned = fit(&poisoned_inputs, &poisoned_targets);
    assert!(plain.parameters().eq(poisoned.parameters()), "a held-out row trained");
    assert!(plain.report().holdout_mse < poisoned.report().holdout_mse, "held-out rows judge");
    assert_eq!(plain.predict(0, inputs.view()), poisoned.predict(0, inputs.view()), "nor does it set a scale");
    let trained = (0..400).find(|row| !held_out.contains(row)).expect("most rows train");
    let mut moved = targets.clone();
    moved[[trained, 0]] += 1.0;
    assert!(!plain.parameters().eq(fit(&inputs, &moved).parameters()));
}

#[test]
fn a_fit_goes_on_where_the_one_before_ended() {
    let learner = EnsembleLearner::new(small(), &linear_spec()).expect("usable settings");
    let (mut rng, data) = (rng(9), linear_data(1000, &mut rng(10)));
    let first = learner.fit(&data, None, &mut rng).expect("enough rows").expect("a model").model;
    let again = learner.fit(&data, Some(&*first), &mut rng).expect("enough rows").expect("a model").model;
    let at = |epoch: usize, report: &sindyna_rl::FitReport| report.history[epoch].iter().sum::<f64>();
    let (cold, warm) = (at(0, first.ensemble().report()), at(0, again.ensemble().report()));
    assert!(warm < 0.5 * cold, "the first epoch of the second fit leaves {warm}, of the first {cold}");
    let other = EnsembleLearner::new(EnsembleConfig { hidden: vec![32, 16], ..small() }, &linear_spec());
    let refused = other.expect("usable settings").fit(&data, Some(&*first), &mut rng).expect_err("other networks");
    assert!(matches!(refused, FitError::Shape { expected: 16, got: 32, .. }), "{refused}");
}

#[test]
fn too_little_or_foreign_data_are_refused_with_numbers() {
    let learner = EnsembleLearner::new(EnsembleConfig::paper(), &linear_spec()).expect("usable settings");
    let mut rng = rng(11);
    let few = learner.fit(&linear_data(9, &mut rng), None, &mut rng).expect_err("nine rows");
    let told = "9 usable rows are too few to identify an ensemble of networks with 0.1 of the rows held out; at least 10 \
                are needed";
    assert_eq!(few.to_string(), told);
    let foreign = learner.fit(&pendulum_data(50, &mut rng), None, &mut rng).expect_err("three observed values");
    assert_eq!(foreign, FitError::Shape { what: "observed values", expected: 2, got: 3 });
}

#[test]
fn trained_numbers_are_as_many_as_the_paper_counts() {
    let count = |config: EnsembleConfig| {
        let config = EnsembleConfig { max_epochs: Some(1), ..config };
        let learner = EnsembleLearner::new(config, &linear_spec()).expect("usable settings");
        let mut rng = rng(12);
        let data = linear_data(20, &mut rng);
        let model = learner.fit(&data, None, &mut rng).expect("enough rows").expect("a model").model;
        assert_eq!(model.ensemble().n_parameters(), learner.n_parameters());
        learner.n_parameters()
    };
    // Two observed values and a control, as on Mountain Car.
    assert_eq!(count(EnsembleConfig::paper()), 613_036);
    assert_eq!(count(EnsembleConfig { reward_head: RewardHead::Absent, ..EnsembleConfig::paper() }), 611_024);
}
