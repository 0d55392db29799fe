//! Equations whose terms jump: dry friction, backlash, valves.

use super::flow::Flow;
use super::scratch::Scratch;
use super::tableau::Tableau;

/// Steps of the search for the time of a turn, at most.
const STEPS: usize = 60;

/// Part of a step to which that time is found.
const EXACT: f64 = 1e-14;

impl Flow {
    /// ẋ at the (x; u) that `scratch` has, and its derivatives, into the scratch space. Where a switch slides, its sign is the number between −1 and 1 with
    /// which its argument stays zero.
    ///
    /// # References
    /// Filippov (1988), Differential Equations with Discontinuous Righthand Sides, §4.
    pub(super) fn rates(&self, xi: &[f64], derivatives: bool, scratch: &mut Scratch) {
        let Some(switch) = scratch.sliding else {
            self.rates_between_switches(xi, derivatives, scratch);
            return;
        };
        let (below, low) = self.on_side(switch, -1.0, xi, scratch);
        let (above, high) = self.on_side(switch, 1.0, xi, scratch);
        scratch.modes[switch] = [(low + high) / (low - high)];
        self.rates_between_switches(xi, derivatives, scratch);
        if !derivatives {
            return;
        }
        // What moves the argument is made up for by the sign: with f = f₀ + m f₁ and ∇a·f = 0,
        // ∂f = (I − f₁ ∇aᵀ/∇a·f₁) ∂f at constant m.
        let along: Vec<f64> = above.iter().zip(&below).map(|([a], [b])| 0.5 * (a - b)).collect();
        let across = 0.5 * (high - low);
        let gradient = self.gradient(switch, scratch);
        for (matrix, width) in [(&mut scratch.f_x, self.n), (&mut scratch.f_xi, self.n_parameters)] {
            for j in 0..width {
                let moved = gradient.iter().map(|(i, g)| g * matrix[i * width + j][0]).sum::<f64>() / across;
                (0..self.n).for_each(|i| matrix[i * width + j][0] -= along[i] * moved);
            }
        }
    }

    /// Derivatives of the argument of a switch, with the states by which they are, where the rates were computed last.
    fn gradient(&self, switch: usize, scratch: &Scratch) -> Vec<(usize, f64)> {
        self.gradients[switch].iter().map(|&(i, register)| (i, scratch.registers[register as usize][0])).collect()
    }

    /// The same at a sample, where nothing is known of the past.
    pub(super) fn rates_at(&self, x: &[f64], u: &[f64], xi: &[f64], scratch: &mut Scratch) {
        scratch.registers.iter_mut().zip(x.iter().chain(u)).for_each(|(slot, v)| *slot = [*v]);
        self.fill_inside(&mut scratch.registers, xi);
        self.begin(xi, scratch);
        self.rates(xi, true, scratch);
    }

    /// Writes the signs of the switches, for the states and controls in `registers`, there and to `modes`.
    pub(super) fn signs<const L: usize>(&self, registers: &mut [[f64; L]], modes: &mut [[f64; L]]) {
        let first = self.n + self.n_controls;
        // An argument may hold other switches, which come before it.
        for _ in 0..modes.len() {
            registers[first..first + modes.len()].copy_from_slice(modes);
            self.tape.run_first(registers, self.n_ops_of_rates);
            for (mode, &register) in modes.iter_mut().zip(&self.arguments) {
                *mode = registers[register as usize].map(|a| if a == 0.0 { 0.0 } else { a.signum() });
            }
        }
        registers[first..first + modes.len()].copy_from_slice(modes);
    }

    /// The signs with which a step from the x that `scratch` has begins.
    pub(super) fn begin(&self, xi: &[f64], scratch: &mut Scratch) {
        scratch.sliding = None;
        if self.switches.is_empty() {
            return;
        }
        self.signs(&mut scratch.registers, &mut scratch.modes);
        for switch in 0..self.switches.len() {
            if scratch.modes[switch] == [0.0] {
                let (_, low) = self.on_side(switch, -1.0, xi, scratch);
                let (_, high) = self.on_side(switch, 1.0, xi, scratch);
                if low > 0.0 && high < 0.0 && scratch.sliding.is_none() {
                    scratch.sliding = Some(switch);
                } else {
                    scratch.modes[switch] = [if high > 0.0 { 1.0 } else { -1.0 }];
                }
            }
        }
    }

    /// The signs with which steps side by side begin. One that has none there begins a step of its own.
    pub(super) fn begin_between_switches<const L: usize>(&self, scratch: &mut Scratch<L>) {
        if self.switches.is_empty() {
            return;
        }
        self.signs(&mut scratch.registers, &mut scratch.modes);
        for mode in &scratch.modes {
            scratch.turns.iter_mut().zip(mode).for_each(|(turns, mode)| *turns |= *mode == 0.0);
        }
    }

    /// Notes which of the steps side by side that have come to `x` have a switch that has turned by then. Classical steps turn theirs at every stage.
    pub(super) fn look_for_turns<const L: usize>(&self, x: &[[f64; L]], scratch: &mut Scratch<L>) {
        if self.switches.is_empty() || self.is_classical() {
            return;
        }
        let Scratch { registers, modes, turns, .. } = scratch;
        registers[..self.n].copy_from_slice(x);
        self.tape.run_first(registers, self.n_ops_of_rates);
        for (mode, &argument) in modes.iter().zip(&self.arguments) {
            let margin = mode.iter().zip(&registers[argument as usize]).map(|(mode, argument)| mode * argument);
            turns.iter_mut().zip(margin).for_each(|(turns, margin)| *turns |= margin.is_nan() || margin < 0.0);
        }
    }

    /// ẋ with the sign `side` for a switch, and the rate of its argument.
    fn on_side(&self, switch: usize, side: f64, xi: &[f64], scratch: &mut Scratch) -> (Vec<[f64; 1]>, f64) {
        let mode = std::mem::replace(&mut scratch.modes[switch], [side]);
        self.rates_between_switches(xi, false, scratch);
        scratch.modes[switch] = mode;
        let rate = self.gradient(switch, scratch).iter().map(|(i, g)| g * scratch.f[*i][0]).sum();
        (scratch.f.clone(), rate)
    }

    /// The time after which the first switch turns in a step from x over `left`, and which it is; `None` if none does.
    pub(super) fn until_turn(
        &self,
        tableau: &Tableau,
        left: f64,
        x: &[[f64; 1]],
        xi: &[f64],
        scratch: &mut Scratch,
    ) -> Option<(f64, usize)> {
        if self.switches.is_empty() || self.is_classical() {
            return None;
        }
        let rates = |derivatives: bool, scratch: &mut Scratch| self.rates(xi, derivatives, scratch);
        scratch.put_inputs(self.n, 0.0, [left]);
        let (mut before, _) = self.margin(x, xi, scratch);
        let mut margin = |time: f64| {
            let mut at = x.to_vec();
            self.advance(tableau, ([time], 0.0), &mut at, None, scratch, &rates, &mut |_| {});
            self.margin(&at, xi, scratch)
        };
        let (mut early, mut late) = (0.0, left);
        let (mut beyond, mut switch) = margin(late);
        // Numbers that are none are told by the step that is made with them.
        if before.is_nan() || beyond.is_nan() || beyond >= 0.0 {
            return None;
        }
        before = before.max(0.0);
        // The Illinois method: secants whose weight is halved on the side that stays.
        let mut last = None;
        for _ in 0..STEPS {
            if late - early <= EXACT * left || before == 0.0 {
                break;
            }
            let middle = (early + (late - early) * before / (before - beyond)).max(early).min(late);
            let (at, which) = margin(middle);
            if at.is_nan() {
                return None;
            }
            let is_late = at < 0.0;
            if is_late {
                (late, beyond, switch) = (middle, at, which);
                before *= if last == Some(is_late) { 0.5 } else { 1.0 };
            } else {
                (early, before) = (middle, at);
                beyond *= if last == Some(is_late) { 0.5 } else { 1.0 };
            }
            last = Some(is_late);
        }
        Some((late, switch))
    }

    /// By how much the first switch is from turning at x, and which it is; below zero it has turned.
    fn margin(&self, x: &[[f64; 1]], xi: &[f64], scratch: &mut Scratch) -> (f64, usize) {
        scratch.registers[..self.n].copy_from_slice(x);
        self.rates(xi, false, scratch);
        let of = |switch: usize| match scratch.sliding {
            Some(sliding) if sliding == switch => 1.0 - scratch.modes[switch][0].abs(),
            _ => scratch.modes[switch][0] * scratch.registers[self.arguments[switch] as usize][0],
        };
        let margins = (0..self.switches.len()).map(|switch| (of(switch), switch));
        let least = |a: (f64, usize), b: (f64, usize)| if b.0 < a.0 || b.0.is_nan() { b } else { a };
        margins.reduce(least).unwrap_or((f64::INFINITY, 0))
    }

    /// Turns `switch` at x, and `s` = ∂x/∂(x₀; ξ) with it: the time of the turn depends on them too.
    ///
    /// # References
    /// Leine, Nijmeijer (2004), Dynamics and Bifurcations of Non-Smooth Mechanical Systems, §7.
    pub(super) fn turn(
        &self,
        switch: usize,
        x: &[[f64; 1]],
        xi: &[f64],
        s: Option<&mut [[f64; 1]]>,
        scratch: &mut Scratch,
    ) {
        scratch.registers[..self.n].copy_from_slice(x);
        self.rates(xi, false, scratch);
        if scratch.sliding == Some(switch) {
            // The rates go on as they were.
            scratch.modes[switch][0] = scratch.modes[switch][0].signum();
            scratch.sliding = None;
            return;
        }
        let side = scratch.modes[switch][0];
        let before = scratch.f.clone();
        let gradient = self.gradient(switch, scratch);
        let (_, beyond) = self.on_side(switch, -side, xi, scratch);
        if beyond * side > 0.0 && scratch.sliding.is_none() {
            scratch.sliding = Some(switch);
        } else {
            scratch.modes[switch] = [-side];
        }
        let Some(s) = s else { return };
        self.rates(xi, false, scratch);
        let speed: f64 = gradient.iter().map(|(i, g)| g * before[*i][0]).sum();
        if speed == 0.0 {
            return;
        }
        let width = self.n + self.n_parameters;
        for j in 0..width {
            let earlier = gradient.iter().map(|(i, g)| g * s[i * width + j][0]).sum::<f64>() / speed;
            (0..self.n).for_each(|i| s[i * width + j][0] += (scratch.f[i][0] - before[i][0]) * earlier);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::parse;
    use crate::library::Term;
    use crate::motion::Stepping;
    use crate::shooting::Inputs;

    /// A mass on a spring with dry friction: v̇ = −9 x − 1.5 sign v + u.
    fn flow(substeps: usize) -> (Flow, [f64; 3]) {
        let names: Vec<String> = ["x", "v", "u"].map(String::from).into();
        let term = |text: &str| Term {
            expr: parse(text, &names).expect("a term"),
            name: text.into(),
            complexity: 0,
            rate: None,
            shape: None,
        };
        let terms = ["x", "sign(v)", "u"].map(term);
        let flow = Flow::new(
            &terms,
            (&[vec![], vec![0, 1, 2]], &[], &[]),
            &[Some(1), None],
            1,
            Stepping::Continuous { substeps },
        );
        (flow, [-9.0, -1.5, 1.0])
    }

    fn step(flow: &Flow, x: [f64; 2], u: f64, xi: &[f64], s: Option<&mut [f64]>) -> [f64; 2] {
        let mut next = [0.0; 2];
        assert!(flow.step((&x, Inputs::held(&[u]), 0.1), xi, &mut next, s, &mut flow.scratch(), &mut |_| {}));
        next
    }

    /// The exact solution of ẍ = −9 x + c: an oscillation about c/9.
    fn oscillation(x: [f64; 2], c: f64, t: f64) -> [f64; 2] {
        let (sin, cos) = (3.0 * t).sin_cos();
        let from = x[0] - c / 9.0;
        [c / 9.0 + from * cos + x[1] / 3.0 * sin, -3.0 * from * sin + x[1] * cos]
    }

    #[test]
    fn a_step_through_a_jump_is_as_accurate_as_one_beside_it() {
        let (flow, xi) = flow(128);
        let (x, u) = ([1.0, 0.4], 2.0);
        let at_rest = f64::atan(x[1] / (3.0 * (x[0] - (u - 1.5) / 9.0))) / 3.0;
        let turned = oscillation(x, u - 1.5, at_rest);
        assert!(turned[1].abs() < 1e-14 && (0.0..0.1).contains(&at_rest), "{at_rest}");
        let expected = oscillation(turned, u + 1.5, 0.1 - at_rest);
        let next = step(&flow, x, u, &xi, None);
        for i in 0..2 {
            assert!((next[i] - expected[i]).abs() < 1e-12, "{next:?} is not {expected:?}");
        }
    }

    #[test]
    fn what_friction_holds_stays_where_it_is() {
        let (flow, xi) = flow(8);
        // −9 x + u = 0.6 < 1.5.
        let next = step(&flow, [0.1, 0.02], 1.5, &xi, None);
        let later = step(&flow, next, 1.5, &xi, None);
        assert!(next[1].abs() < 1e-13 && (next[0] - later[0]).abs() < 1e-13, "{next:?} {later:?}");
        // And moves when it is pushed harder.
        assert!(step(&flow, next, 4.0, &xi, None)[1] > 0.1);
    }

    #[test]
    fn derivatives_through_a_jump_and_into_rest_are_those_of_differences() {
        let (flow, xi) = flow(8);
        for (x, u) in [([1.0, 0.4], 2.0), ([0.1, 0.02], 1.5), ([0.3, -0.1], -1.0)] {
            let mut s = [0.0; 10];
            step(&flow, x, u, &xi, Some(&mut s));
            for j in 0..5 {
                let at = |h: f64| {
                    let (mut x, mut xi) = (x, xi);
                    if j < 2 {
                        x[j] += h
                    } else {
                        xi[j - 2] += h
                    }
                    step(&flow, x, u, &xi, None)
                };
                let (up, down) = (at(1e-6), at(-1e-6));
                for i in 0..2 {
                    let difference = (up[i] - down[i]) / 2e-6;
                    assert!((s[i * 5 + j] - difference).abs() < 1e-7, "{x:?} {i} {j}: {} {difference}", s[i * 5 + j]);
                }
            }
        }
    }
}
