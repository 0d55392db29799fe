//! Real actions that tell models apart.

use std::collections::VecDeque;

use rand::RngExt as _;
use sindyna_core::{Checkpoint, Dataset, Explorer, Inverse, Rng, Task};

use crate::explore::uniform_action;
use crate::trust::{Evidence, Trust};

/// Plans that are compared.
const PLANS: usize = 48;

/// Steps of a plan.
const AHEAD: usize = 24;

/// Steps of the best plan that are made before there is another one.
const MADE: usize = 8;

/// Steps for which an action is held, at most.
const HELD: usize = 12;

/// Acts so that the models that the data allow disagree on what follows: of many plans of held random actions the one after which most is known of which of them
/// is right.
///
/// What is known after a plan is the log determinant of I + Σ Aᵀ A / M, with a column of A per model: its next state less the mean of all models', in standard deviations
/// of what the sensors' noise leaves open. It is summed over all steps collected so, so what was seen already tells no more.
pub(crate) struct Curious<'a> {
    task: &'a dyn Task,
    trust: &'a Trust,
    inverse: &'a Inverse,
    /// What was seen so far tells.
    seen: Evidence,
    plan: VecDeque<Vec<f64>>,
}

impl<'a> Curious<'a> {
    pub(crate) fn new(task: &'a dyn Task, trust: &'a Trust, inverse: &'a Inverse) -> Self {
        Self { task, trust, inverse, seen: trust.no_evidence(), plan: VecDeque::new() }
    }

    fn random_plan(&self, rng: &mut Rng) -> Vec<Vec<f64>> {
        let space = &self.task.spec().action_space;
        let mut action = vec![0.0; space.action_dim()];
        let longest = rng.random_range(1..=HELD);
        let mut left = 0;
        let mut plan = Vec::with_capacity(AHEAD);
        for _ in 0..AHEAD {
            if left == 0 {
                uniform_action(space, rng, &mut action);
                left = rng.random_range(1..=longest);
            }
            left -= 1;
            plan.push(action.clone());
        }
        plan
    }

    /// What is known once `plan` was made from the state `x` (n).
    fn evidence(&self, mut x: Vec<f64>, plan: &[Vec<f64>]) -> Evidence {
        let mut evidence = self.seen.clone();
        let mut u = vec![0.0; self.task.spec().control_dim()];
        for action in plan {
            self.task.spec().action_space.control_into(action, &mut u);
            match self.trust.observe(&x, &u, &mut evidence) {
                Some(next) if !self.task.terminated(&next) => x = next,
                _ => break,
            }
        }
        evidence
    }
}

impl Checkpoint for Curious<'_> {}

impl Explorer for Curious<'_> {
    fn next(&mut self, so_far: &Dataset, rng: &mut Rng, action: &mut [f64]) {
        let Some(rollout) = so_far.rollouts().last() else {
            return uniform_action(&self.task.spec().action_space, rng, action);
        };
        let steps = rollout.rewards.len();
        let mut x = vec![0.0; self.inverse.n_states()];
        for o in rollout.observations.rows() {
            let near = x.clone();
            self.inverse.state(&o.to_vec(), &near, &mut x);
        }
        if steps == 0 || self.plan.len() <= AHEAD - MADE {
            let plans: Vec<_> = (0..PLANS).map(|_| self.random_plan(rng)).collect();
            let gains: Vec<f64> = plans.iter().map(|plan| self.evidence(x.clone(), plan).known()).collect();
            let best = (0..PLANS).fold(0, |best, i| if gains[i] > gains[best] { i } else { best });
            self.plan = plans[best].iter().cloned().collect();
        }
        if let Some(planned) = self.plan.pop_front() {
            action.copy_from_slice(&planned);
        }
        let mut u = vec![0.0; self.task.spec().control_dim()];
        if self.task.spec().action_space.control_into(action, &mut u) {
            self.trust.observe(&x, &u, &mut self.seen);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use sindyna_core::{Diverged, Dynamics, Seed, Spec, Support};

    /// x' = x + gain u, which differ for pushes to the right alone.
    struct Push(f64);

    impl Dynamics for Push {
        fn step(&self, x: &[f64], u: &[f64], _rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
            next[0] = x[0] + if u[0] > 0.0 { self.0 * u[0] } else { u[0] };
            Diverged::check(next)
        }
    }

    struct Endless(Spec);

    impl Task for Endless {
        fn spec(&self) -> &Spec {
            &self.0
        }
        fn max_steps(&self) -> usize {
            100
        }
        fn initial(&self, _rng: &mut Rng, x: &mut [f64]) {
            x[0] = 0.0;
        }
        fn reward(&self, _x: &[f64], _action: &[f64], _u: &[f64], _next: &[f64]) -> f64 {
            0.0
        }
        fn terminated(&self, _next: &[f64]) -> bool {
            false
        }
    }

    #[test]
    fn what_models_disagree_on_is_done() {
        let task = Endless(crate::one_state::spec());
        let mut data = Dataset::new(1, 1, 1, 0.1);
        data.begin(&[0.0]).expect("finite");
        data.push(&[1.0], &[1.0], 0.0, &[10.0]).expect("finite");
        let models: Vec<Arc<dyn Dynamics>> = vec![Arc::new(Push(0.9)), Arc::new(Push(1.1))];
        let support = Support::of(&task.0, &data, &[]);
        let trust = Trust::new(support, (models[0].clone(), models), Some(vec![0.1]), 0.0);
        let inverse = Inverse::of(&task.0).expect("all is shown");
        let (mut curious, mut rng) = (Curious::new(&task, &trust, &inverse), Seed::new(0).numpy());
        let (mut action, mut sum) = ([0.0], 0.0);
        for _ in 0..100 {
            curious.next(&data, &mut rng, &mut action);
            sum += action[0];
            data.push(&action, &action, 0.0, &[0.0]).expect("finite");
        }
        assert!(sum / 100.0 > 0.3, "0 by chance: {}", sum / 100.0);
        assert!(curious.seen.known() > 1.0 && trust.no_evidence().known().abs() < f64::EPSILON);
    }
}
