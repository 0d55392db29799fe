//! Steps that do not follow the equations of all the others: an impact, an end stop, a clip that nobody declared.

use sindyna_core::{Dynamics as _, Seed};

use super::unseen::unseen;
use super::{Found, Run, Search};

/// Parts of the data that are left out in turn, or looked at by twos.
const PARTS: usize = 6;

/// Errors of one step, in standard deviations, beyond which it is a stray.
const STRAY: f64 = 30.0;

/// Largest share of strays; with more of them the equations are wrong, not the steps.
const MOST: f64 = 0.34;

/// Fewest steps of which some can be told to be strays.
const FEWEST: usize = 12;

impl Search<'_> {
    /// Equations that explain all steps but a few, the runs without these, and how many they are. `None` if there are no
    /// such equations in the first tier.
    ///
    /// Strays come close together in time. So each part of the data is left out once, and every two neighbouring parts are
    /// looked at alone; where what is left can be explained, steps that do not follow are strays.
    pub(crate) fn without_strays(&self) -> Option<(Found, Vec<Run>, usize)> {
        let total: usize = self.runs.iter().map(Run::len).sum();
        if total < FEWEST {
            return None;
        }
        let narrow = crate::motion::System { terms: &self.system.terms[..self.system.core], ..*self.system };
        let search = |runs: &[Run]| Search { system: &narrow, runs, ..*self }.exactly();
        let part = |i: usize| i * total / PARTS;
        let left_out = (0..PARTS).map(|i| (part(i)..part(i + 1), true));
        let alone = (0..PARTS - 1).map(|i| (part(i)..part(i + 2), false));
        for (steps, out) in left_out.chain(alone) {
            let rest = without(self.runs, &|step| steps.contains(&step) == out);
            let Some(found) = search(&rest) else { continue };
            let strays = self.strays(&found);
            let count = strays.iter().filter(|stray| **stray).count();
            if count == 0 || count as f64 > MOST * total as f64 {
                continue;
            }
            let kept = without(self.runs, &|step| strays[step]);
            if let Some(found) = search(&kept) {
                return Some((found, kept, count));
            }
        }
        None
    }

    /// Per step of all runs: whether it misses what `found` predicts.
    fn strays(&self, found: &Found) -> Vec<bool> {
        let dt = self.system.dt;
        let mut rng = Seed::new(0).stream("no randomness", 0);
        let mut strays = Vec::new();
        for run in self.runs {
            let extra = unseen(&found.model, found.stepping, run, dt, true);
            let mut next = vec![0.0; run.x.ncols()];
            for t in 0..run.len() {
                let (x, u) = (run.x.row(t).to_vec(), run.u.row(t).to_vec());
                let follows = found.model.step(&x, &u, &mut rng, &mut next).is_ok()
                    && (0..x.len()).all(|i| {
                        let seen = run.sigma[[t, i]].hypot(run.sigma[[t + 1, i]]).hypot(dt * extra[[t, i]]);
                        (run.x[[t + 1, i]] - next[i]).abs() <= STRAY * seen
                    });
                strays.push(!follows);
            }
        }
        strays
    }
}

/// The runs without the steps that are `out`, counted over all runs; what is left of a run on both sides of such a step are
/// two runs.
fn without(runs: &[Run], out: &dyn Fn(usize) -> bool) -> Vec<Run> {
    let mut kept = Vec::new();
    let mut step = 0;
    for run in runs {
        let mut first = 0;
        for t in 0..=run.len() {
            if t == run.len() || out(step + t) {
                if t > first {
                    kept.push(run.part(first, t));
                }
                first = t + 1;
            }
        }
        step += run.len();
    }
    kept
}
