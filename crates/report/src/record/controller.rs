//! Which controller acts.

use sindyna_record::run::{Improvable, Training};

use crate::numbers::{fixed, plural};

/// Planners and what they are.
const PLANNERS: [(&str, &str); 3] = [
    ("lqr", "a linear-quadratic regulator (LQR)"),
    ("ilqr", "an iterative linear-quadratic regulator (iLQR)"),
    ("mppi", "model predictive path integral control (MPPI)"),
];

/// The controller in a few words.
pub(super) fn name(training: &Training) -> String {
    if training.planners.is_empty() {
        return format!("a network trained by {} in the learned model", training.algorithm);
    }
    let known = PLANNERS.iter().find(|(name, _)| *name == training.algorithm).map(|(_, what)| *what);
    format!("{} in the learned model, which is not trained", known.unwrap_or(&training.algorithm))
}

/// How it came about.
pub(super) fn told(training: &Training) -> String {
    let steps = plural(training.model_steps as usize, "step");
    if training.planners.is_empty() {
        return format!("{} updates, {steps} in the model.{}", training.updates, far(training));
    }
    let each = training.planners.iter().map(|planner| format!("{} {}", planner.name, fixed(planner.model_return, 1)));
    let each = each.collect::<Vec<_>>().join(", ");
    let kept = match training.planners.len() {
        1 => String::new(),
        _ => format!(" {} acts: no other has a return that is 1 % higher.", training.algorithm),
    };
    format!(
        "Nothing is trained: the controller plans in the learned model. Mean return there: {each}.{kept}{}",
        far(training)
    )
}

/// How far it is from the best, if it is far.
fn far(training: &Training) -> String {
    let improvable = training.improvable.as_ref().filter(|improvable| improvable.is_large());
    improvable.map_or_else(String::new, |Improvable { episodes, policy, improved }| {
        format!(
            " Warning: in {} in the model it earns {}, and its actions improved by differential dynamic programming {}.",
            plural(*episodes, "episode"),
            fixed(*policy, 1),
            fixed(*improved, 1)
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use sindyna_record::run::PlannerReturn;

    fn training(algorithm: &str, planners: &[(&str, f64)]) -> Training {
        let planner = |&(name, model_return): &(&str, f64)| PlannerReturn { name: name.into(), model_return };
        let empty = serde_json::json!({
            "algorithm": algorithm, "isa": "portable", "updates": 250, "model_steps": 1000, "model_rollouts": 5, "diverged": 0,
            "left_region": 0, "model_return": null, "converged": true, "failure": null,
        });
        let training: Training = serde_json::from_value(empty).expect("all fields are there");
        Training { planners: planners.iter().map(planner).collect(), ..training }
    }

    #[test]
    fn a_planner_says_that_it_plans_and_what_others_had() {
        let planned = training("mppi", &[("lqr", -1_200.0), ("mppi", -150.25)]);
        assert!(name(&planned).starts_with("model predictive path integral control (MPPI)"));
        let says = "Nothing is trained: the controller plans in the learned model. Mean return there: lqr −1,200.0, mppi −150.2. \
                    mppi acts: no other has a return that is 1 % higher.";
        assert_eq!(told(&planned), says);
        let trained = training("sac", &[]);
        assert_eq!(name(&trained), "a network trained by sac in the learned model");
        assert_eq!(told(&trained), "250 updates, 1000 steps in the model.");
    }
}
