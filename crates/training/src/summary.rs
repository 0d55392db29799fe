//! A run in numbers.

use sindyna_core::{Channel, Spec};
use sindyna_dyna::{Gap, Learned};
use sindyna_record::identification::Account;
use sindyna_record::run::{
    Collect, Confirmation, Evaluation, Identification, PlannerReturn, Prediction, Span, Summary, Training,
};
use sindyna_rl::Isa;

use crate::in_model::{InModel, kept};
use crate::learner::Fitted;
use crate::problem::Problem;
use crate::settings::TrainConfig;

/// Probability of the interval in which the return is predicted to be.
const LEVEL: f64 = 0.9;

/// The summary of a run with `config`, of an algorithm and instructions, that came to `learned`; `in_model` is `None` for one that was stopped.
pub fn of(
    config: &TrainConfig,
    (algorithm, isa): (&str, Isa),
    problem: &dyn Problem,
    learned: &Learned<Fitted>,
    evaluation: Option<Evaluation>,
    in_model: Option<InModel>,
) -> Summary {
    let (spec, threshold) = (problem.spec(), problem.protocol().solved_at);
    let InModel { coverage, late, improvable } = in_model.unwrap_or_default();
    let identification = learned.model.as_ref().map(|fitted| {
        let model = &fitted.0.model;
        let account = Account::new(&fitted.0, spec);
        Identification {
            method: config.identification.solver.to_string(),
            library: config.identification.library.to_string(),
            features: account.features.len(),
            parameters: model.parameters(),
            nonzero: model.nonzero(),
            nonzero_paper: model.nonzero_paper(),
            rows: account.rows,
            rows_at_limit: account.rows_at_limit,
            rows_astray: account.rows_astray,
            equations: model.equations(),
            stepping: account.stepping,
            offsets: account.offsets,
            explained: account.explained,
            coefficients: account.equations.into_iter().map(|equation| equation.terms).collect(),
        }
    });
    let planners = learned.planned.iter();
    let planners =
        planners.map(|(name, model_return)| PlannerReturn { name: (*name).into(), model_return: *model_return });
    Summary {
        format: 1,
        task: config.task.clone(),
        seed: config.seed,
        real_steps: learned.data.n_steps(),
        real_episodes: learned.data.n_rollouts(),
        solved: evaluation.as_ref().zip(threshold).map(|(e, mark)| e.mean_return >= mark),
        threshold,
        evaluation,
        identification,
        training: Training {
            algorithm: kept(learned).unwrap_or(algorithm).into(),
            planners: planners.collect(),
            isa: isa.name().into(),
            updates: learned.updates,
            model_steps: learned.model_steps,
            model_rollouts: learned.model_rollouts,
            diverged: learned.diverged,
            left_region: learned.left_region,
            model_return: learned.model_return,
            converged: learned.converged,
            prediction: learned.prediction.as_ref().map(|prediction| {
                let (low, high) = prediction.interval(LEVEL, config.evaluation_episodes);
                Prediction { mean: prediction.mean(), level: LEVEL, low, high }
            }),
            confirmation: learned.confirmation.as_ref().map(|c| Confirmation {
                real: c.real,
                predicted: c.expected(),
                spread: c.spread(),
                disagreement: c.disagreement,
                agrees: c.agrees(),
            }),
            collect: learned.gap.as_ref().map(|gap| collect(gap, spec)),
            refit_failure: learned.refit_failure.clone(),
            improvable,
            failure: learned.failure.as_ref().map(ToString::to_string),
            coverage,
            late,
        },
        from_log: problem.log().is_some(),
        input_lag: Some(problem.lag()).filter(|lag| *lag > 0.0),
        input_delay_seconds: Some(problem.delay()).filter(|delay| *delay > 0.0),
        interrupted: learned.interrupted,
    }
}

/// What to collect next of the system of `spec`.
fn collect(Gap { states, controls, share }: &Gap, spec: &Spec) -> Collect {
    let spans = |channels: &[Channel], ranges: &[(f64, f64)]| {
        let span = |(channel, (low, high)): (&Channel, &(f64, f64))| Span {
            channel: channel.name.clone(),
            unit: channel.unit.clone(),
            low: *low,
            high: *high,
        };
        channels.iter().zip(ranges).map(span).collect()
    };
    Collect { share: *share, states: spans(&spec.state, states), controls: spans(&spec.control, controls) }
}
