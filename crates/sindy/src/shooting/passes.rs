//! The steps from all samples of a recording.

use ndarray::Array2;

use super::flow::Flow;
use super::step::Inputs;
use crate::data::{Ramp, Segment};

/// Samples whose steps are made side by side.
const LANES: usize = 8;

/// The step from one sample.
pub(crate) struct Made<'a> {
    /// Number of the sample.
    pub(crate) t: usize,
    /// Whether all its numbers are finite.
    pub(crate) finite: bool,
    /// x⁺ (n).
    pub(crate) next: &'a [f64],
    /// ∂x⁺/∂(x; ξ) (n, n + p), row by row; nothing if it was not asked for.
    pub(crate) s: &'a [f64],
}

/// The samples of a recording from which steps are made.
#[derive(Clone, Copy)]
pub(crate) struct Samples<'a> {
    pub(crate) segment: &'a Segment,
    /// The states there (T + 1, n).
    pub(crate) x: &'a Array2<f64>,
    /// A step is made from the first sample, and from every so manieth one.
    pub(crate) every: usize,
}

impl Flow {
    /// Visits the step from every one of `samples`, in their order, until `visit` says no; whether it never did.
    pub(crate) fn each_step(
        &self,
        samples: Samples<'_>,
        xi: &[f64],
        derivatives: bool,
        visit: &mut dyn FnMut(&Made<'_>) -> bool,
    ) -> bool {
        self.side_by_side::<LANES>(samples, xi, derivatives, visit)
    }

    fn side_by_side<const L: usize>(
        &self,
        Samples { segment, x, every }: Samples<'_>,
        xi: &[f64],
        derivatives: bool,
        visit: &mut dyn FnMut(&Made<'_>) -> bool,
    ) -> bool {
        let steps: Vec<usize> = (0..segment.len()).step_by(every).collect();
        let (mut scratch, mut alone) = (self.scratch::<L>(), self.scratch::<1>());
        let (mut now, mut u, mut ramp) = (vec![[0.0; L]; self.n], vec![[0.0; L]; self.n_controls], Vec::new());
        let (mut next, mut of_next) = (vec![[0.0; L]; self.n], vec![0.0; self.n]);
        let mut of_s = self.derivatives_of(derivatives);
        let mut s = vec![[0.0; L]; of_s.len()];
        let mut all = steps.chunks(L);
        all.all(|steps| {
            // Beside the last steps the first of these is made again.
            let at = |l: usize| steps.get(l).copied().unwrap_or(steps[0]);
            for (i, slot) in now.iter_mut().enumerate() {
                *slot = std::array::from_fn(|l| x[[at(l), i]]);
            }
            for (i, slot) in u.iter_mut().enumerate() {
                *slot = std::array::from_fn(|l| segment.u[[at(l), i]]);
            }
            if let Some(Ramp { by, .. }) = &segment.ramp {
                ramp.clear();
                ramp.extend((0..self.n_controls).map(|i| -> [f64; L] { std::array::from_fn(|l| by[[at(l), i]]) }));
            }
            let dt = std::array::from_fn(|l| segment.dt[at(l)]);
            let slopes = derivatives.then_some(&mut s[..]);
            let inputs = Inputs { u: &u, ramp: &ramp, intersample: segment.intersample() };
            let finite = self.step_side_by_side((&now, inputs, dt), xi, &mut next, slopes, &mut scratch, &mut |_| {});
            steps.iter().enumerate().all(|(l, &t)| {
                let mut finite = finite[l];
                if scratch.turns[l] {
                    // A step in which a sign turns has its own stages.
                    let (now, (u, ramp)) = (x.row(t).to_vec(), segment.input(t));
                    let inputs = Inputs::of((&u, &ramp), segment.intersample());
                    let slopes = derivatives.then_some(&mut of_s[..]);
                    let step = (&now[..], inputs, segment.dt[t]);
                    finite = self.step(step, xi, &mut of_next, slopes, &mut alone, &mut |_| {});
                } else {
                    of_next.iter_mut().zip(&next).for_each(|(slot, v)| *slot = v[l]);
                    of_s.iter_mut().zip(&s).for_each(|(slot, v)| *slot = v[l]);
                }
                visit(&Made { t, finite, next: &of_next, s: &of_s })
            })
        })
    }

    /// Room for the derivatives of a step, if they are wanted.
    fn derivatives_of(&self, wanted: bool) -> Vec<f64> {
        vec![0.0; if wanted { self.n * (self.n + self.n_parameters) } else { 0 }]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::parse;
    use crate::library::Term;
    use crate::motion::Stepping;

    #[test]
    fn steps_side_by_side_are_those_made_one_by_one_to_the_last_bit() {
        let names: Vec<String> = ["x", "a", "v", "w", "u"].map(String::from).into();
        let term = |text: &str, rate| Term {
            expr: parse(text, &names).expect("a term"),
            name: text.into(),
            complexity: 0,
            rate,
            shape: None,
        };
        // Thirteen steps: some lanes stay empty. One is at rest, two turn, and one sticks.
        let wave = |t: usize, i: usize| if (t, i) == (3, 2) { 0.0 } else { (0.7 * t as f64 + 1.3 * i as f64).sin() };
        let segment = Segment {
            x: Array2::from_shape_fn((14, 4), |(t, i)| wave(t, i)),
            u: Array2::from_shape_fn((13, 1), |(t, _)| wave(t, 5)),
            dt: (0..13).map(|t| 0.05 + 0.01 * t as f64).collect(),
            ramp: None,
            relative: None,
            of_inputs: Vec::new(),
            corrections: None,
        };
        let smooth = [term("u", None), term("w^2*sin(a)", None), term("cos(a)", Some(3)), term("sin(a)", None)];
        let jumping = [term("u", None), term("sign(v)", None), term("cos(a)", Some(3)), term("sin(a)*abs(w)", None)];
        let continuous = [2, 16].map(|substeps| Stepping::Continuous { substeps });
        let held = [Stepping::Euler, Stepping::SemiImplicit { substeps: 3 }, Stepping::Classical { substeps: 2 }];
        for (terms, xi) in [(smooth, [0.9, 0.045, -0.045, 14.7]), (jumping, [0.9, -0.7, -0.045, 14.7])] {
            for stepping in continuous.into_iter().chain(held) {
                let supports = vec![vec![], vec![], vec![0, 1, 2], vec![3]];
                let rates = [Some(2), Some(3), None, None];
                let flow = Flow::new(&terms, (&supports, &[], &[]), &rates, 1, stepping);
                let mut scratch = flow.scratch();
                let samples = Samples { segment: &segment, x: &segment.x, every: 1 };
                let mut count = 0;
                flow.each_step(samples, &xi, true, &mut |made| {
                    let (mut next, mut s) = (vec![0.0; 4], vec![0.0; 4 * 8]);
                    let (now, u) = (segment.x.row(made.t).to_vec(), segment.u.row(made.t).to_vec());
                    let step = (&now[..], Inputs::held(&u), segment.dt[made.t]);
                    assert!(flow.step(step, &xi, &mut next, Some(&mut s), &mut scratch, &mut |_| {}));
                    assert_eq!((&next[..], &s[..]), (made.next, made.s), "{stepping:?}, step {}", made.t);
                    count += 1;
                    made.finite
                });
                assert_eq!(count, 13);
            }
        }
    }
}
