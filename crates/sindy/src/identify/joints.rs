//! Equations of several joints that one Lagrangian proposes where there is noise.

use std::cell::OnceCell;

use super::Identifier;
use super::estimated::structured;
use crate::LibraryChoice;
use crate::data::{Segment, Smoother, sample_of, without_glitches};
use crate::estimate::{Estimate, Judged, Problem, Structure, judged, leaves_noise};
use crate::library::{Joints, Key, Lagrangian, Term, term};
use crate::mechanics::{Equations, Proposal, proposals, tied};
use crate::motion::Stepping;
use crate::regression::Space;

/// Steps from which Lagrangians are proposed, and to which their parameters are fitted.
const STEPS: usize = 400;
const ALL_STEPS: usize = 3000;

/// Most angles in the waves of what turns in space.
const SPATIAL: usize = 2;

impl Identifier {
    /// The equations of Lagrangians in `terms`; those that are missing there are added if the library is the identifier's own.
    pub(super) fn structures(&self, joints: &Joints, proposed: &[Proposal], terms: &mut Vec<Term>) -> Vec<Structure> {
        let inputs = self.inputs();
        let mut structure = |proposal: &Proposal| {
            let equations = proposal.lagrangian.equations(&proposal.parameters)?;
            let mut rows = vec![Vec::new(); self.rates().len()];
            for (equation, speed) in equations.into_iter().zip(joints.speeds()) {
                let mut place = |((expr, rate), value): (Key, f64)| {
                    let known = terms.iter().position(|t| t.rate == rate && t.expr == expr);
                    let added = || {
                        terms.push(term(&inputs, expr, rate));
                        terms.len() - 1
                    };
                    let at = known.or_else(|| (self.library == LibraryChoice::Auto).then(added))?;
                    Some((at, value))
                };
                rows[speed] = equation.into_iter().map(&mut place).collect::<Option<Vec<_>>>()?;
            }
            Some(structured(rows))
        };
        proposed.iter().filter_map(&mut structure).collect()
    }

    /// The equations of a Lagrangian of `joints` against which nothing speaks but others that are as good, or else what all that were tried propose: bodies in a plane in any
    /// arrangement, then what turns in space. `stepping` is what the steps show.
    pub(super) fn of_joints(
        &self,
        joints: &Joints,
        problem: &Problem<'_>,
        (stepping, space): (Stepping, &Space),
    ) -> Result<Estimate, Vec<Proposal>> {
        let Problem { segments, floor, watch, .. } = *problem;
        let sample = |segments: &[Segment], steps: usize| {
            let sample = sample_of(segments, steps);
            without_glitches(&sample, floor).map_or(sample, |(sample, _)| sample)
        };
        let few = sample(segments, STEPS);
        if (0..floor.len()).any(|i| !few.iter().all(|segment| segment.measures(i))) {
            return Err(Vec::new());
        }
        let signals = Smoother::new(&few, problem.rates, floor, watch.asks()).signals(floor);
        let many = OnceCell::new();
        let is_adequate = |proposal: &Proposal| {
            let fitted = |samples: &[Segment]| {
                let tied = tied(joints, proposal, (samples, floor), stepping)?;
                Some((Equations::new(&tied.lagrangian, &tied.chosen, (space, problem.rates), self.spec.dt)?, tied))
            };
            // What leaves more than noise of a part does so of all.
            if segments.iter().map(Segment::len).sum::<usize>() > ALL_STEPS {
                let (equations, tied) = fitted(&few)?;
                let of_few = Problem { segments: &few, ..*problem };
                if !leaves_noise(&of_few, (&equations, &tied.theta), &signals, stepping) {
                    return None;
                }
            }
            let many = many.get_or_init(|| sample(segments, ALL_STEPS));
            let (equations, tied) = fitted(many)?;
            match judged(problem, (&equations, &tied), stepping) {
                Judged::Adequate(found) => Some(*found),
                Judged::Rounded(right) => {
                    let (equations, tied) = fitted(&sample(&right.segments, ALL_STEPS))?;
                    let problem = Problem { segments: &right.segments, ..*problem };
                    let Judged::Adequate(found) = judged(&problem, (&equations, &tied), stepping) else { return None };
                    let (score, astray) = (found.score + right.price, found.astray + right.astray);
                    Some(Estimate { score, astray, ..*found })
                }
                Judged::Inadequate => None,
            }
        };
        let spatial =
            || (1..=joints.angles().len().min(SPATIAL)).flat_map(|count| Lagrangian::of_some_angles(joints, count));
        let mut all = Vec::new();
        for turns_in_space in [false, true] {
            let tried = if turns_in_space { spatial().collect() } else { Lagrangian::arrangements(joints) };
            let found = proposals((joints, &tried), (&few, &signals.sigma), floor, stepping, (self.effort, watch));
            let best = found.first().filter(|_| self.library == LibraryChoice::Auto && watch.go_on());
            if let Some(adequate) = best.and_then(is_adequate) {
                return Ok(adequate);
            }
            all.extend(found);
        }
        Err(all)
    }
}
