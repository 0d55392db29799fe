//! What to collect next: where the models that the data allow disagree on what a policy does.

use sindyna_core::{Acting, EnvError, Environment as _, Memory as _, Mode, Policy, Seed};

use crate::belief::Belief;
use crate::imagine::Trial;

/// Episodes in the models.
const EPISODES: usize = 16;

/// Steps of each, evenly spread, at which the models are compared.
const COMPARED: usize = 100;

/// Part of the steps, those on which the models disagree most, that a gap is made of.
const WORST: f64 = 0.1;

/// Part of these that is left out at either end of a range.
const OUTLIERS: f64 = 0.05;

/// Where a policy goes and the models that the data allow disagree: what to collect next.
#[derive(Debug, Clone, PartialEq)]
pub struct Gap {
    /// From where to where each state is (n).
    pub states: Vec<(f64, f64)>,
    /// The same of each control (k).
    pub controls: Vec<(f64, f64)>,
    /// Share of all their disagreement along the policy's episodes.
    pub share: f64,
}

impl Gap {
    /// Where `policy` goes and the models of `belief` disagree most; `None` if they agree everywhere.
    pub(crate) fn of(belief: &Belief<'_>, policy: &dyn Policy, seed: Seed) -> Result<Option<Self>, EnvError> {
        let mut steps: Vec<(f64, Vec<f64>)> = Vec::new();
        let n = belief.task.spec().state_dim();
        for i in 0..EPISODES {
            let mut rng = seed.stream("gap", i as u64);
            let mut system = Trial::new(belief, i);
            system.reset(&mut rng)?;
            let mut action = vec![0.0; system.spec().action_space.action_dim()];
            let (mut policy, mut visited) = (Acting::begin(policy), Vec::new());
            loop {
                policy.act(system.observation(), Mode::Exploit, &mut rng, &mut action);
                let before = system.state().to_vec();
                let outcome = system.step(&action, &mut rng)?;
                visited.push([&before, system.control()].concat());
                if outcome.terminated || outcome.truncated {
                    break;
                }
            }
            let every = visited.len().div_ceil(COMPARED);
            let compared = visited.into_iter().step_by(every.max(1));
            steps.extend(compared.map(|step| (belief.trust.disagreement(&step[..n], &step[n..]), step)));
        }
        steps.retain(|(disagreement, _)| disagreement.is_finite());
        steps.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        let sum = |steps: &[(f64, Vec<f64>)]| steps.iter().map(|(disagreement, _)| disagreement).sum::<f64>();
        let worst = &steps[..((WORST * steps.len() as f64).ceil() as usize).min(steps.len())];
        let (all, most) = (sum(&steps), sum(worst));
        let Some((_, first)) = worst.first().filter(|_| all > 0.0) else { return Ok(None) };
        let range = |i: usize| {
            let mut values: Vec<f64> = worst.iter().map(|(_, step)| step[i]).collect();
            values.sort_by(f64::total_cmp);
            let at = |share: f64| values[(share * (values.len() - 1) as f64).round() as usize];
            (at(OUTLIERS), at(1.0 - OUTLIERS))
        };
        let states = (0..n).map(range).collect();
        Ok(Some(Self { states, controls: (n..first.len()).map(range).collect(), share: most / all }))
    }
}
