//! The map from one sample to the next, with its exact derivatives.

use nalgebra::DMatrix;

use super::flow::{Flow, Stage};
use super::tableau::{EIGHTH, FOURTH, Tableau};
use crate::motion::Stepping;

/// Substeps from which on one step of order eight stands for so many of order four: it is the more accurate one.
const OF_EIGHTH: usize = 8;

/// Stages of a step, at most.
const STAGES: usize = 11;

/// Turns of switches within one substep, at most.
const TURNS: usize = 8;

impl Flow {
    /// Scratch space for [`Self::step`].
    pub(crate) fn scratch(&self) -> Scratch {
        let (n, width) = (self.n, self.n + self.n_parameters);
        Scratch {
            registers: vec![0.0; self.tape.n_registers()],
            f: vec![0.0; n],
            coupled: DMatrix::zeros(self.coupled.len(), self.coupled.len()),
            column: vec![0.0; n],
            f_x: vec![0.0; n * n],
            f_xi: vec![0.0; n * self.n_parameters],
            modes: vec![0.0; self.switches.len()],
            sliding: None,
            slopes: vec![0.0; STAGES * n],
            s_stage: vec![0.0; n * width],
            s_slopes: vec![0.0; STAGES * n * width],
        }
    }

    /// Writes x⁺ one step of `dt` \[s\] later, and with `s` also ∂x⁺/∂(x; ξ) (n, n + p), row by row. `visit` sees the stages. `false`
    /// if a number is not finite.
    pub(crate) fn step(
        &self,
        (x, u, dt): (&[f64], &[f64], f64),
        xi: &[f64],
        next: &mut [f64],
        mut s: Option<&mut [f64]>,
        scratch: &mut Scratch,
        visit: &mut dyn FnMut(&Stage<'_>),
    ) -> bool {
        let (n, width) = (self.n, self.n + self.n_parameters);
        next.copy_from_slice(x);
        if let Some(s) = s.as_deref_mut() {
            s.fill(0.0);
            (0..n).for_each(|i| s[i * width + i] = 1.0);
        }
        let mut z = vec![0.0; n + self.n_controls];
        z[n..].copy_from_slice(u);
        match self.stepping {
            Stepping::Euler | Stepping::SemiImplicit { .. } => {
                let (substeps, positions) = match self.stepping {
                    Stepping::SemiImplicit { substeps } => (substeps.max(1), &self.positions[..]),
                    _ => (1, &[][..]),
                };
                let h = dt / substeps as f64;
                for _ in 0..substeps {
                    z[..n].copy_from_slice(next);
                    self.begin(&z[..n], u, xi, scratch);
                    self.rates(&z[..n], u, xi, s.is_some(), scratch);
                    let weight = 1.0 / substeps as f64;
                    visit(&Stage { weight, z: &z, x_dot: &scratch.f, modes: &scratch.modes });
                    (0..n).for_each(|i| next[i] += h * scratch.f[i]);
                    let before = s.as_deref().map(<[f64]>::to_vec);
                    if let (Some(s), Some(before)) = (s.as_deref_mut(), &before) {
                        add_slopes(s, h, before, &scratch.f_x, &scratch.f_xi, n);
                    }
                    for &i in positions {
                        let Some(v) = self.rates[i] else { continue };
                        next[i] = z[i] + h * next[v];
                        if let (Some(s), Some(before)) = (s.as_deref_mut(), &before) {
                            for j in 0..width {
                                s[i * width + j] = before[i * width + j] + h * s[v * width + j];
                            }
                        }
                    }
                }
            }
            Stepping::Continuous { substeps } | Stepping::Classical { substeps } => {
                let (tableau, substeps) = self.scheme(substeps);
                self.begin(x, u, xi, scratch);
                for _ in 0..substeps {
                    self.substep(
                        tableau,
                        (dt / substeps as f64, dt),
                        xi,
                        next,
                        s.as_deref_mut(),
                        &mut z,
                        scratch,
                        visit,
                    );
                }
            }
        }
        next.iter().all(|v| v.is_finite()) && s.is_none_or(|s| s.iter().all(|v| v.is_finite()))
    }

    /// One step of `tableau` over a time h of the interval dt, cut where a switch turns. `z` holds the controls.
    #[expect(clippy::too_many_arguments, reason = "a step and all that is written on its way")]
    fn substep(
        &self,
        tableau: &Tableau,
        (h, dt): (f64, f64),
        xi: &[f64],
        x: &mut [f64],
        mut s: Option<&mut [f64]>,
        z: &mut [f64],
        scratch: &mut Scratch,
        visit: &mut dyn FnMut(&Stage<'_>),
    ) {
        let mut left = h;
        for _ in 0..TURNS {
            let u = &z[self.n..].to_vec();
            let Some((part, switch)) = self.until_turn(tableau, left, (x, u, xi), scratch) else { break };
            self.advance(tableau, (part, part / dt), xi, x, s.as_deref_mut(), z, scratch, visit);
            self.turn(switch, (x, u, xi), s.as_deref_mut(), scratch);
            left -= part;
        }
        self.advance(tableau, (left, left / dt), xi, x, s, z, scratch, visit);
    }

    /// One step of `tableau` over a time h, which has `weight` in the averages. `z` holds the controls.
    #[expect(clippy::too_many_arguments, reason = "a step and all that is written on its way")]
    pub(super) fn advance(
        &self,
        tableau: &Tableau,
        (h, weight): (f64, f64),
        xi: &[f64],
        x: &mut [f64],
        mut s: Option<&mut [f64]>,
        z: &mut [f64],
        scratch: &mut Scratch,
        visit: &mut dyn FnMut(&Stage<'_>),
    ) {
        let (n, width) = (self.n, self.n + self.n_parameters);
        for (stage, row) in tableau.a.iter().enumerate() {
            for i in 0..n {
                let slopes = row.iter().enumerate().map(|(j, a)| a * scratch.slopes[j * n + i]);
                z[i] = x[i] + h * slopes.sum::<f64>();
            }
            let (at, u) = z.split_at(n);
            self.rates(at, u, xi, s.is_some(), scratch);
            if tableau.b[stage] > 0.0 {
                visit(&Stage { weight: tableau.b[stage] * weight, z, x_dot: &scratch.f, modes: &scratch.modes });
            }
            scratch.slopes[stage * n..(stage + 1) * n].copy_from_slice(&scratch.f);
            if let Some(s) = s.as_deref_mut() {
                self.variation(stage, row, h, s, scratch);
            }
        }
        for (stage, b) in tableau.b.iter().enumerate().filter(|(_, b)| **b > 0.0) {
            (0..n).for_each(|i| x[i] += b * h * scratch.slopes[stage * n + i]);
            if let Some(s) = s.as_deref_mut() {
                let slopes = &scratch.s_slopes[stage * n * width..(stage + 1) * n * width];
                s.iter_mut().zip(slopes).for_each(|(s, slope)| *s += b * h * slope);
            }
        }
    }

    /// Times that the rates are computed in one step.
    pub(super) fn n_stages(&self) -> usize {
        match self.stepping {
            Stepping::Euler => 1,
            Stepping::SemiImplicit { substeps } => substeps,
            Stepping::Continuous { substeps } | Stepping::Classical { substeps } => {
                let (tableau, substeps) = self.scheme(substeps);
                tableau.b.len() * substeps
            }
        }
    }

    /// The scheme and its number of steps for an interval of `substeps`: many of them are too few for the classical one.
    fn scheme(&self, substeps: usize) -> (&'static Tableau, usize) {
        if substeps < OF_EIGHTH || self.is_classical() { (&FOURTH, substeps) } else { (&EIGHTH, substeps / OF_EIGHTH) }
    }

    /// The slope of ∂x/∂(x₀; ξ) at stage number `stage`, which is `row` of the scheme.
    fn variation(&self, stage: usize, row: &[f64], h: f64, s: &[f64], scratch: &mut Scratch) {
        let (n, p) = (self.n, self.n_parameters);
        let width = n + p;
        let (before, now) = scratch.s_slopes.split_at_mut(stage * n * width);
        scratch.s_stage.copy_from_slice(s);
        for (slopes, a) in before.chunks_exact(n * width).zip(row).filter(|(_, a)| **a != 0.0) {
            scratch.s_stage.iter_mut().zip(slopes).for_each(|(slot, slope)| *slot += a * h * slope);
        }
        let at = &scratch.s_stage;
        for i in 0..n {
            let row = &mut now[i * width..(i + 1) * width];
            row[..n].fill(0.0);
            row[n..].copy_from_slice(&scratch.f_xi[i * p..(i + 1) * p]);
            for k in 0..n {
                let slope = scratch.f_x[i * n + k];
                if slope != 0.0 {
                    row.iter_mut().zip(&at[k * width..(k + 1) * width]).for_each(|(r, a)| *r += slope * a);
                }
            }
        }
    }
}

/// S after a step of length h of Euler: S + h (∂ẋ/∂x S + [0 | ∂ẋ/∂ξ]), where S was `before`.
fn add_slopes(s: &mut [f64], h: f64, before: &[f64], f_x: &[f64], f_xi: &[f64], n: usize) {
    let width = s.len() / n;
    let p = width - n;
    for (i, row) in s.chunks_exact_mut(width).enumerate() {
        for (f, before) in f_x[i * n..(i + 1) * n].iter().zip(before.chunks_exact(width)) {
            row.iter_mut().zip(before).for_each(|(s, before)| *s += h * f * before);
        }
        row[n..].iter_mut().zip(&f_xi[i * p..(i + 1) * p]).for_each(|(s, v)| *s += h * v);
    }
}

/// Memory a step works in.
#[derive(Debug, Clone)]
pub(crate) struct Scratch {
    pub(super) registers: Vec<f64>,
    pub(super) f: Vec<f64>,
    pub(super) coupled: DMatrix<f64>,
    pub(super) column: Vec<f64>,
    pub(super) f_x: Vec<f64>,
    pub(super) f_xi: Vec<f64>,
    /// What stands for the sign of each switch.
    pub(super) modes: Vec<f64>,
    /// The switch whose argument stays zero, if there is one.
    pub(super) sliding: Option<usize>,
    slopes: Vec<f64>,
    s_stage: Vec<f64>,
    s_slopes: Vec<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::parse;
    use crate::library::Term;

    /// A cart with a pole: rates on the right.
    fn flow(stepping: Stepping) -> (Flow, Vec<f64>) {
        let names: Vec<String> = ["x", "a", "v", "w", "u"].map(String::from).into();
        let term = |text: &str, rate| Term {
            expr: parse(text, &names).expect("a term"),
            name: text.into(),
            complexity: 0,
            rate,
            shape: None,
        };
        let terms = [
            term("u", None),
            term("w^2*sin(a)", None),
            term("cos(a)", Some(3)),
            term("sin(a)", None),
            term("cos(a)", Some(2)),
            term("w", None),
        ];
        let supports = vec![vec![], vec![], vec![0, 1, 2], vec![3, 4, 5]];
        let rates = [Some(2), Some(3), None, None];
        (Flow::new(&terms, (&supports, &[], &[]), &rates, 1, stepping), vec![0.9, 0.045, -0.045, 14.7, -1.5, -0.1])
    }

    #[test]
    fn derivatives_of_a_step_are_those_of_differences() {
        let semi_implicit = [1, 3].map(|substeps| Stepping::SemiImplicit { substeps });
        for stepping in [Stepping::Euler, Stepping::Continuous { substeps: 2 }].into_iter().chain(semi_implicit) {
            let (flow, xi) = flow(stepping);
            let (x, u, dt) = ([0.1, 0.4, -0.3, 0.8], [1.3], 0.1);
            let mut scratch = flow.scratch();
            let mut step = |x: &[f64], xi: &[f64], s: Option<&mut [f64]>| {
                let mut next = vec![0.0; 4];
                assert!(flow.step((x, &u, dt), xi, &mut next, s, &mut scratch, &mut |_| {}));
                next
            };
            let mut s = vec![0.0; 4 * 10];
            step(&x, &xi, Some(&mut s));
            for j in 0..10 {
                let mut at = |h: f64| {
                    let (mut x, mut xi) = (x, xi.clone());
                    if j < 4 {
                        x[j] += h
                    } else {
                        xi[j - 4] += h
                    }
                    step(&x, &xi, None)
                };
                let (up, down) = (at(1e-6), at(-1e-6));
                for i in 0..4 {
                    let difference = (up[i] - down[i]) / 2e-6;
                    assert!((s[i * 10 + j] - difference).abs() < 1e-8, "{stepping:?} {i} {j}");
                }
            }
        }
    }
}
