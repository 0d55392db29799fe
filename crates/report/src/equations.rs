//! The equations found, beside the true ones.

use sindyna_core::{Channel, Spec};
use sindyna_envs::System;
use sindyna_record::comparison::Digest;
use sindyna_record::identification::read_model;
use sindyna_sindy::Model;
use sindyna_truth::{Structure, Truth, structure};

use crate::Catalog;
use crate::stats::median;

/// Points of a task's box at which true rates are taken.
const POINTS: usize = 2_000;

/// The same for a page that is made with every run.
const FEW_POINTS: usize = 500;

/// What the runs with equations on one task found.
pub(crate) struct Equations {
    pub(crate) task: String,
    pub(crate) system: System,
    /// The model of each seed, held against the truth.
    pub(crate) judged: Vec<Judged>,
}

/// One model.
pub(crate) struct Judged {
    pub(crate) seed: u64,
    pub(crate) model: Model,
    /// Real steps and episodes it was found from.
    pub(crate) real_steps: usize,
    pub(crate) real_episodes: usize,
    /// The summands of all equations that were fitted; none unless they have the true terms and no other.
    pub(crate) summands: Option<Vec<Summand>>,
}

/// One term of an equation, with its coefficient as it was found and as it is.
pub(crate) struct Summand {
    /// Number of the equation.
    pub(crate) equation: usize,
    pub(crate) term: String,
    pub(crate) found: f64,
    pub(crate) truth: f64,
}

impl Summand {
    pub(crate) fn relative_error(&self) -> f64 {
        (self.found / self.truth - 1.0).abs()
    }
}

/// The equations that `sindy` found, of every task of which there are any that can be read.
pub(crate) fn equations(digest: &Digest, catalog: &dyn Catalog) -> Vec<Equations> {
    let of = |task: &str| {
        let system = catalog.system(task)?;
        let truth = Truth::of(&system, POINTS);
        let found = digest.models.iter().filter(|found| found.task == task && found.method == "sindy");
        let judged: Vec<Judged> = found
            .filter_map(|found| {
                let run = digest.of(task, &found.method).find(|run| run.seed == found.seed)?;
                let model = read_model(&found.model.to_string()).ok().filter(|model| is_of(system.spec(), model))?;
                let summands = summands(&truth, &model);
                let (real_steps, real_episodes) = (run.real_steps, run.real_episodes);
                Some(Judged { seed: found.seed, model, real_steps, real_episodes, summands })
            })
            .collect();
        (!judged.is_empty()).then(|| Equations { task: task.into(), system, judged })
    };
    digest.tasks().into_iter().filter_map(of).collect()
}

/// Whether `model` is about the states and controls of `spec`: only then can it be held against the truth.
fn is_of(spec: &Spec, model: &Model) -> bool {
    let same = |channels: &[Channel], names: &[String]| channels.iter().map(|c| &c.name).eq(names);
    model.readings().is_none() && same(&spec.state, model.states()) && same(&spec.control, model.controls())
}

fn summands(truth: &Truth, model: &Model) -> Option<Vec<Summand>> {
    let Structure::True { coefficients } = structure(truth, model) else { return None };
    let names: Vec<String> = model.states().iter().chain(model.controls()).cloned().collect();
    let terms = model.shifted_terms();
    let entries = truth.judged().flat_map(|(i, _)| model.coefficients(i).iter().map(move |entry| (i, entry)));
    let summand = |((equation, entry), truth): ((usize, &sindyna_sindy::Entry), f64)| {
        let term = terms[entry.term].pretty(&names).to_string();
        let term = match entry.rate.map(|l| format!("d{}/dt", names[l])) {
            None => term,
            Some(rate) if term == "1" => rate,
            Some(rate) => format!("{term} · {rate}"),
        };
        Summand { equation, term, found: entry.coefficient, truth }
    };
    Some(entries.zip(coefficients).map(summand).collect())
}

/// The coefficients of `model` beside those of the `system` it is a model of; `None` unless it has the true terms and no other.
pub(crate) fn true_coefficients(system: &System, model: &Model) -> Option<Vec<Summand>> {
    is_of(system.spec(), model).then(|| summands(&Truth::of(system, FEW_POINTS), model))?
}

/// The equations of `system` in the form in which `model` was identified, with its terms; `None` unless these are the true ones and no others.
#[must_use]
pub fn true_equations(system: &System, model: &Model) -> Option<Vec<String>> {
    let values: Vec<f64> = true_coefficients(system, model)?.iter().map(|summand| summand.truth).collect();
    Some(model.with_coefficients(&values)?.equations())
}

impl Equations {
    /// How many seeds found the true terms.
    pub(crate) fn true_terms(&self) -> usize {
        self.judged.iter().filter(|judged| judged.summands.is_some()).count()
    }

    /// Median and largest, over the seeds with the true terms, of the largest relative error of a coefficient.
    pub(crate) fn errors(&self) -> Option<(f64, f64)> {
        let worst = |summands: &Vec<Summand>| summands.iter().map(Summand::relative_error).fold(0.0, f64::max);
        let worst: Vec<f64> = self.judged.iter().filter_map(|judged| judged.summands.as_ref()).map(worst).collect();
        Some((median(&worst)?, worst.into_iter().fold(0.0, f64::max)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::tests::Some7;
    use sindyna_record::comparison::Outcome;

    /// ω̇ = a sin θ + b u + c ω² of the pendulum, of which the truth has a = 15, b = 3, c = 0.
    fn found(seed: u64, a: f64, b: f64, c: f64) -> Outcome {
        let mut row =
            vec![serde_json::json!({"term": 1, "coefficient": a}), serde_json::json!({"term": 2, "coefficient": b})];
        if c != 0.0 {
            row.push(serde_json::json!({"term": 3, "coefficient": c}));
        }
        let model = serde_json::json!({
            "format": 2, "states": ["θ", "ω"], "controls": ["u"], "form": "semi_implicit", "dt": 0.05,
            "terms": ["ω", "sin(θ)", "u", "ω^2"], "n_features": 45, "kinematic": [true, false],
            "equations": [[{"term": 0, "coefficient": 1.0}], row],
        });
        Outcome { model: Some(model), real_steps: 10, real_episodes: 1, ..Outcome::new("pendulum", "sindy", seed) }
    }

    #[test]
    fn models_of_anything_else_are_left_out() {
        let change = |from: &str, to: &str| {
            let mut outcome = found(0, 15.0, 3.0, 0.0);
            let text = outcome.model.take().map(|model| model.to_string()).unwrap_or_default();
            assert!(text.contains(from), "{text} has no {from}");
            outcome.model = serde_json::from_str(&text.replace(from, to)).ok();
            let mut digest = Digest::default();
            digest.add(&outcome, None);
            equations(&digest, &Some7).len()
        };
        assert_eq!(change("0.05", "0.05"), 1);
        for (from, to) in [
            (r#"["θ","ω"]"#, r#"["θ","w"]"#),
            (r#""controls":["u"]"#, r#""controls":["u","v"]"#),
            // The speed is said to be the input.
            (r#"[{"coefficient":1.0,"term":0}]"#, r#"[{"coefficient":1.0,"term":2}]"#),
            (r#""semi_implicit""#, r#""continuous","scheme":{"rk4":{"substeps":1000000000}}"#),
        ] {
            assert_eq!(change(from, to), 0, "{to}");
        }
        // One equation where there should be two.
        let mut outcome = found(0, 15.0, 3.0, 0.0);
        outcome.model = Some(serde_json::json!({
            "format": 2, "states": ["θ"], "controls": ["u"], "form": "increment", "dt": 0.05, "terms": ["u"], "n_features": 1,
            "kinematic": [false], "equations": [[{"term": 0, "coefficient": 1.0}]],
        }));
        let mut digest = Digest::default();
        digest.add(&outcome, None);
        assert!(equations(&digest, &Some7).is_empty());
    }

    #[test]
    fn coefficients_are_held_against_the_true_ones() {
        let mut digest = Digest::default();
        for outcome in [found(0, 15.0, 3.03, 0.0), found(1, 15.0, 3.0, 0.0), found(2, 15.0, 3.0, 0.1)] {
            digest.add(&outcome, None);
        }
        let all = equations(&digest, &Some7);
        let [pendulum] = &all[..] else { panic!("one task has equations") };
        assert_eq!((pendulum.true_terms(), pendulum.judged.len()), (2, 3));
        let (median, largest) = pendulum.errors().expect("two have the true terms");
        assert!((median - 0.005).abs() < 1e-9 && (largest - 0.01).abs() < 1e-9, "{median} {largest}");
        let summands = pendulum.judged[0].summands.as_ref().expect("the terms are true");
        let terms: Vec<_> = summands.iter().map(|s| (s.equation, s.term.as_str(), s.found)).collect();
        assert_eq!(terms, [(1, "sin θ", 15.0), (1, "u", 3.03)]);
        assert!((summands[1].truth - 3.0).abs() < 1e-11);
        let (model, system) = (&pendulum.judged[0].model, &pendulum.system);
        assert_eq!(
            true_equations(system, model),
            Some(vec!["θ\u{307} = ω".into(), "ω\u{307} = 15 sin θ + 3 u".into()])
        );
        assert_eq!(true_equations(system, &pendulum.judged[2].model), None, "one term is not true");
    }
}
