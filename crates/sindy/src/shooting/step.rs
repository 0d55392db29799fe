//! The map from one sample to the next, with its exact derivatives.

use sindyna_core::InterSample;

use super::flow::{Flow, Stage};
use super::lanes::add;
use super::scratch::Scratch;
use super::tableau::{EIGHTH, FOURTH, Tableau};
use crate::motion::Stepping;

/// Substeps from which on one step of order eight stands for so many of order four: it is the more accurate one.
const OF_EIGHTH: usize = 8;

/// Turns of switches within one substep, at most.
const TURNS: usize = 8;

/// Inputs over a step.
#[derive(Clone, Copy)]
pub(crate) struct Inputs<'a, const L: usize> {
    /// At its beginning (k).
    pub(crate) u: &'a [[f64; L]],
    /// By how much they change over it (k): nothing if they are held.
    pub(crate) ramp: &'a [[f64; L]],
    /// In which way.
    pub(crate) intersample: InterSample,
}

impl<'a> Inputs<'a, 1> {
    /// Those of one step, by values.
    pub(crate) fn of((u, ramp): (&'a [f64], &'a [f64]), intersample: InterSample) -> Self {
        Self { u: u.as_chunks().0, ramp: ramp.as_chunks().0, intersample }
    }

    /// Inputs that are held.
    #[cfg(test)]
    pub(crate) fn held(u: &'a [f64]) -> Self {
        Self::of((u, &[]), InterSample::Zoh)
    }
}

/// Parts of a step over which inputs do not jump: each as long, with so much of their change.
fn parts(switch: Option<f64>) -> impl Iterator<Item = (f64, Option<f64>)> {
    let all = match switch {
        None => [(1.0, None), (0.0, None)],
        Some(part) => [(part, Some(0.0)), (1.0 - part, Some(1.0))],
    };
    all.into_iter().filter(|(share, _)| *share > 0.0)
}

/// Substeps for a part of a step of which all has so many.
fn substeps_of(substeps: usize, share: f64) -> usize {
    ((share * substeps as f64).ceil() as usize).max(1)
}

/// The rates where the registers are, with derivatives if these are wanted.
type Rates<'a, const L: usize> = &'a dyn Fn(bool, &mut Scratch<L>);

/// Visitor of the stages of a step.
type Visit<'a, const L: usize> = &'a mut dyn FnMut(&Stage<'_, L>);

impl Flow {
    /// Writes x⁺ one step of `dt` \[s\] later under `inputs`, and with `s` also ∂x⁺/∂(x; ξ) (n, n + p), row by row. `visit` sees the stages. `false`
    /// if a number is not finite.
    pub(crate) fn step(
        &self,
        (x, inputs, dt): (&[f64], Inputs<'_, 1>, f64),
        xi: &[f64],
        next: &mut [f64],
        s: Option<&mut [f64]>,
        scratch: &mut Scratch,
        visit: Visit<'_, 1>,
    ) -> bool {
        let (x, next) = (x.as_chunks().0, next.as_chunks_mut().0);
        let mut s = s.map(|s| s.as_chunks_mut().0);
        if self.switches.is_empty() {
            return self.step_side_by_side((x, inputs, [dt]), xi, next, s, scratch, visit)[0];
        }
        self.start((x, inputs, [dt]), xi, next, s.as_deref_mut(), scratch);
        let rates = |derivatives: bool, scratch: &mut Scratch| self.rates(xi, derivatives, scratch);
        let held = |derivatives: bool, scratch: &mut Scratch| {
            self.begin(xi, scratch);
            self.rates(xi, derivatives, scratch);
        };
        match self.stepping {
            Stepping::Euler | Stepping::SemiImplicit { .. } => {
                self.held([dt], next, s.as_deref_mut(), scratch, &held, visit);
            }
            Stepping::Continuous { substeps } | Stepping::Classical { substeps } => {
                let (tableau, substeps) = self.scheme(substeps);
                for (share, changed) in parts(inputs.intersample.switch()) {
                    self.go_on_from(next, changed, scratch);
                    self.begin(xi, scratch);
                    let substeps = substeps_of(substeps, share);
                    for _ in 0..substeps {
                        let h = (share * dt / substeps as f64, dt);
                        self.substep(tableau, h, xi, next, s.as_deref_mut(), scratch, &rates, visit);
                    }
                }
            }
        }
        finite(next, s.as_deref())[0]
    }

    /// The same from `L` samples side by side, with the signs with which each step begins. Where one turns within it, `scratch` says so, and the step is not the right one.
    pub(super) fn step_side_by_side<const L: usize>(
        &self,
        (x, inputs, dt): (&[[f64; L]], Inputs<'_, L>, [f64; L]),
        xi: &[f64],
        next: &mut [[f64; L]],
        mut s: Option<&mut [[f64; L]]>,
        scratch: &mut Scratch<L>,
        visit: Visit<'_, L>,
    ) -> [bool; L] {
        self.start((x, inputs, dt), xi, next, s.as_deref_mut(), scratch);
        let rates = |derivatives: bool, scratch: &mut Scratch<L>| self.rates_between_switches(xi, derivatives, scratch);
        let held = |derivatives: bool, scratch: &mut Scratch<L>| {
            self.begin_between_switches(scratch);
            rates(derivatives, scratch);
        };
        match self.stepping {
            Stepping::Euler | Stepping::SemiImplicit { .. } => {
                self.held(dt, next, s.as_deref_mut(), scratch, &held, visit);
            }
            Stepping::Continuous { substeps } | Stepping::Classical { substeps } => {
                let (tableau, substeps) = self.scheme(substeps);
                for (share, changed) in parts(inputs.intersample.switch()) {
                    self.go_on_from(next, changed, scratch);
                    self.begin_between_switches(scratch);
                    let substeps = substeps_of(substeps, share);
                    let h = (dt.map(|dt| share * dt / substeps as f64), share / substeps as f64);
                    for _ in 0..substeps {
                        self.advance(tableau, h, next, s.as_deref_mut(), scratch, &rates, visit);
                        scratch.over += h.1;
                        self.look_for_turns(next, scratch);
                    }
                }
            }
        }
        finite(next, s.as_deref())
    }

    /// Where a step begins: at x, whose derivative by itself is one.
    fn start<const L: usize>(
        &self,
        (x, Inputs { u, ramp, intersample }, dt): (&[[f64; L]], Inputs<'_, L>, [f64; L]),
        xi: &[f64],
        next: &mut [[f64; L]],
        s: Option<&mut [[f64; L]]>,
        scratch: &mut Scratch<L>,
    ) {
        let (n, width) = (self.n, self.n + self.n_parameters);
        next.copy_from_slice(x);
        if let Some(s) = s {
            s.fill([0.0; L]);
            (0..n).for_each(|i| s[i * width + i] = [1.0; L]);
        }
        scratch.registers[..n].copy_from_slice(x);
        scratch.registers[n..n + u.len()].copy_from_slice(u);
        if !ramp.is_empty() {
            scratch.u.clear();
            scratch.u.extend_from_slice(u);
        }
        scratch.ramp.clear();
        scratch.ramp.extend_from_slice(ramp);
        (scratch.dt, scratch.over, scratch.turns) = (dt, 0.0, [false; L]);
        scratch.intersample = intersample;
        self.fill_inside(&mut scratch.registers, xi);
    }

    /// A part of a step begins at x, with so much of the change of inputs, where they jump.
    fn go_on_from<const L: usize>(&self, x: &[[f64; L]], changed: Option<f64>, scratch: &mut Scratch<L>) {
        scratch.changed = changed;
        if changed.is_some() {
            scratch.registers[..self.n].copy_from_slice(x);
            scratch.put_inputs(self.n, 0.0, [0.0; L]);
        }
    }

    /// Steps of Euler, or of simulators that move positions by the new rates.
    fn held<const L: usize>(
        &self,
        dt: [f64; L],
        next: &mut [[f64; L]],
        mut s: Option<&mut [[f64; L]]>,
        scratch: &mut Scratch<L>,
        rates: Rates<'_, L>,
        visit: Visit<'_, L>,
    ) {
        let (n, width) = (self.n, self.n + self.n_parameters);
        let (substeps, positions) = match self.stepping {
            Stepping::SemiImplicit { substeps } => (substeps.max(1), &self.positions[..]),
            _ => (1, &[][..]),
        };
        let h = dt.map(|dt| dt / substeps as f64);
        for _ in 0..substeps {
            scratch.registers[..n].copy_from_slice(next);
            rates(s.is_some(), scratch);
            let z = &scratch.registers[..n + self.n_controls];
            visit(&Stage { weight: 1.0 / substeps as f64, z, x_dot: &scratch.f, modes: &scratch.modes });
            (0..n).for_each(|i| add(&mut next[i], |l| h[l] * scratch.f[i][l]));
            let before = s.as_deref().map(<[[f64; L]]>::to_vec);
            if let (Some(s), Some(before)) = (s.as_deref_mut(), &before) {
                add_slopes(s, h, before, &scratch.f_x, &scratch.f_xi, n);
            }
            for &i in positions {
                let Some(v) = self.rates[i] else { continue };
                next[i] = std::array::from_fn(|l| scratch.registers[i][l] + h[l] * next[v][l]);
                if let (Some(s), Some(before)) = (s.as_deref_mut(), &before) {
                    for j in 0..width {
                        let (before, rate) = (before[i * width + j], s[v * width + j]);
                        s[i * width + j] = std::array::from_fn(|l| before[l] + h[l] * rate[l]);
                    }
                }
            }
        }
    }

    /// One step of `tableau` over a time h of the interval dt, cut where a switch turns.
    #[expect(clippy::too_many_arguments, reason = "a step and all that is written on its way")]
    fn substep(
        &self,
        tableau: &Tableau,
        (h, dt): (f64, f64),
        xi: &[f64],
        x: &mut [[f64; 1]],
        mut s: Option<&mut [[f64; 1]]>,
        scratch: &mut Scratch,
        rates: Rates<'_, 1>,
        visit: Visit<'_, 1>,
    ) {
        let mut left = h;
        for _ in 0..TURNS {
            let Some((part, switch)) = self.until_turn(tableau, left, x, xi, scratch) else { break };
            self.advance(tableau, ([part], part / dt), x, s.as_deref_mut(), scratch, rates, visit);
            scratch.over += part / dt;
            self.turn(switch, x, xi, s.as_deref_mut(), scratch);
            left -= part;
        }
        self.advance(tableau, ([left], left / dt), x, s, scratch, rates, visit);
        scratch.over += left / dt;
    }

    /// One step of `tableau` over a time h, which has `weight` in the averages.
    #[expect(clippy::too_many_arguments, reason = "a step and all that is written on its way")]
    pub(super) fn advance<const L: usize>(
        &self,
        tableau: &Tableau,
        (h, weight): ([f64; L], f64),
        x: &mut [[f64; L]],
        mut s: Option<&mut [[f64; L]]>,
        scratch: &mut Scratch<L>,
        rates: Rates<'_, L>,
        visit: Visit<'_, L>,
    ) {
        let (n, width) = (self.n, self.n + self.n_parameters);
        for (stage, row) in tableau.a.iter().enumerate() {
            for (i, x) in x.iter().enumerate() {
                let mut slope = [0.0; L];
                for (j, a) in row.iter().enumerate().filter(|(_, a)| **a != 0.0) {
                    let of_stage = &scratch.slopes[j * n + i];
                    add(&mut slope, |l| a * of_stage[l]);
                }
                scratch.registers[i] = std::array::from_fn(|l| x[l] + h[l] * slope[l]);
            }
            scratch.put_inputs(n, row.iter().sum(), h);
            rates(s.is_some(), scratch);
            if tableau.b[stage] > 0.0 {
                let z = &scratch.registers[..n + self.n_controls];
                visit(&Stage { weight: tableau.b[stage] * weight, z, x_dot: &scratch.f, modes: &scratch.modes });
            }
            scratch.slopes[stage * n..(stage + 1) * n].copy_from_slice(&scratch.f);
            if let Some(s) = s.as_deref_mut() {
                self.variation(stage, row, h, s, scratch);
            }
        }
        for (stage, b) in tableau.b.iter().enumerate().filter(|(_, b)| **b > 0.0) {
            let by = h.map(|h| b * h);
            let slopes = &scratch.slopes[stage * n..(stage + 1) * n];
            x.iter_mut().zip(slopes).for_each(|(x, slope)| add(x, |l| by[l] * slope[l]));
            if let Some(s) = s.as_deref_mut() {
                let slopes = &scratch.s_slopes[stage * n * width..(stage + 1) * n * width];
                s.iter_mut().zip(slopes).for_each(|(s, slope)| add(s, |l| by[l] * slope[l]));
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
    fn variation<const L: usize>(
        &self,
        stage: usize,
        row: &[f64],
        h: [f64; L],
        s: &[[f64; L]],
        scratch: &mut Scratch<L>,
    ) {
        let (n, p) = (self.n, self.n_parameters);
        let width = n + p;
        let (before, now) = scratch.s_slopes.split_at_mut(stage * n * width);
        scratch.s_stage.copy_from_slice(s);
        for (slopes, a) in before.chunks_exact(n * width).zip(row).filter(|(_, a)| **a != 0.0) {
            let by = h.map(|h| a * h);
            scratch.s_stage.iter_mut().zip(slopes).for_each(|(slot, slope)| add(slot, |l| by[l] * slope[l]));
        }
        let at = &scratch.s_stage;
        for i in 0..n {
            let row = &mut now[i * width..(i + 1) * width];
            row[..n].fill([0.0; L]);
            row[n..].copy_from_slice(&scratch.f_xi[i * p..(i + 1) * p]);
            for k in 0..n {
                let slope = &scratch.f_x[i * n + k];
                if slope.iter().any(|v| *v != 0.0) {
                    let at = &at[k * width..(k + 1) * width];
                    row.iter_mut().zip(at).for_each(|(r, a)| add(r, |l| slope[l] * a[l]));
                }
            }
        }
    }
}

/// S after a step of length h of Euler: S + h (∂ẋ/∂x S + [0 | ∂ẋ/∂ξ]), where S was `before`.
fn add_slopes<const L: usize>(
    s: &mut [[f64; L]],
    h: [f64; L],
    before: &[[f64; L]],
    f_x: &[[f64; L]],
    f_xi: &[[f64; L]],
    n: usize,
) {
    let width = s.len() / n;
    let p = width - n;
    for (i, row) in s.chunks_exact_mut(width).enumerate() {
        for (f, before) in f_x[i * n..(i + 1) * n].iter().zip(before.chunks_exact(width)) {
            row.iter_mut().zip(before).for_each(|(s, before)| add(s, |l| h[l] * f[l] * before[l]));
        }
        row[n..].iter_mut().zip(&f_xi[i * p..(i + 1) * p]).for_each(|(s, v)| add(s, |l| h[l] * v[l]));
    }
}

/// Whether all numbers of a place are finite.
fn finite<const L: usize>(next: &[[f64; L]], s: Option<&[[f64; L]]>) -> [bool; L] {
    let mut all = [true; L];
    for v in next.iter().chain(s.unwrap_or_default()) {
        all.iter_mut().zip(v).for_each(|(all, v)| *all &= v.is_finite());
    }
    all
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
                assert!(flow.step((x, Inputs::held(&u), dt), xi, &mut next, s, &mut scratch, &mut |_| {}));
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
