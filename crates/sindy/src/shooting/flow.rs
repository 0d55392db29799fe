//! Equations of given structure, and their rates with exact derivatives.

use sindyna_core::InterSample;

use super::lanes::add;
use super::scratch::{Masses, Scratch};
use super::switches::Switches;
use crate::Expr;
use crate::chain::after_their_rates;
use crate::expr::Tape;
use crate::library::Term;
use crate::motion::Stepping;

/// A summand of an equation: coefficient × term, times the derivative of state `rate` if there is one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Summand {
    pub(super) row: usize,
    /// Number of the term in [`Flow::values`].
    pub(super) term: usize,
    pub(super) rate: Option<usize>,
    pub(super) coefficient: Coefficient,
    /// Whether its term is in the equations; of others the coefficient is zero.
    pub(super) acts: bool,
}

/// Terms of one equation with coefficients that are given.
pub(crate) type Given = Vec<(usize, f64)>;

/// A coefficient that is fitted, by its number, or one that is given.
#[derive(Debug, Clone, Copy)]
pub(super) enum Coefficient {
    Fitted(usize),
    Given(f64),
}

impl Summand {
    /// Its coefficient, if those that are fitted are `xi`.
    pub(super) fn times(&self, xi: &[f64]) -> f64 {
        match self.coefficient {
            Coefficient::Fitted(parameter) => xi[parameter],
            Coefficient::Given(value) => value,
        }
    }
}

/// Equations of given structure, stepped by a scheme: x⁺ = F(x, u; ξ) with ∂F/∂x and ∂F/∂ξ by the variational equations.
#[derive(Debug, Clone)]
pub(crate) struct Flow {
    pub(super) n: usize,
    pub(super) n_controls: usize,
    pub(super) n_parameters: usize,
    /// What the rates are made of, then what their derivatives are.
    pub(super) tape: Tape,
    /// Operations of the tape for the rates alone.
    pub(super) n_ops_of_rates: usize,
    /// Registers of the terms in use.
    pub(super) values: Vec<u32>,
    /// Per term: (state, register) of the partial derivatives that are not zero.
    pub(super) partials: Vec<Vec<(usize, u32)>>,
    pub(super) summands: Vec<Summand>,
    /// Per state: the state that is declared to be its rate.
    pub(super) rates: Vec<Option<usize>>,
    /// States with declared rates, each after its rate.
    pub(super) positions: Vec<usize>,
    pub(super) stepping: Stepping,
    /// States whose rates are multiplied by something in an equation, and those whose equation it is.
    pub(super) coupled: Vec<usize>,
    pub(super) switches: Switches,
    /// Registers of the arguments of the switches.
    pub(super) arguments: Vec<u32>,
    /// Per switch: (state, register) of the partial derivatives of its argument.
    pub(super) gradients: Vec<Vec<(usize, u32)>>,
    /// Parameters inside terms, numbered after the coefficients.
    pub(super) inside: Vec<Inside>,
}

/// A parameter inside a term.
#[derive(Debug, Clone, Copy)]
pub(super) struct Inside {
    /// Number of the term in [`Flow::values`].
    term: usize,
    /// Register of the derivative of the term by it; none where that is zero.
    slope: Option<u32>,
}

/// A place on the way through one step, with its weight in the average.
pub(crate) struct Stage<'a, const L: usize = 1> {
    pub(crate) weight: f64,
    /// (x; u) there.
    pub(crate) z: &'a [[f64; L]],
    /// ẋ there.
    pub(crate) x_dot: &'a [[f64; L]],
    /// What stands there for the sign of each switch of the flow.
    pub(crate) modes: &'a [[f64; L]],
}

/// Number of the first parameter inside a term, until all variables before it are counted; no system has as many.
const PARAMETERS: usize = 1 << 25;

/// Stages of a step, at most.
const STAGES: usize = 11;

/// How much more it takes for every sign that may turn within a step.
const TURNING: usize = 4;

/// Substeps per interval in which derivatives are followed, at most.
const DERIVATIVE_SUBSTEPS: usize = 2;

impl Flow {
    /// The flow of the equations whose terms are numbered in `supports`, one list per state; coefficients are numbered equation by
    /// equation. Terms in `given` are there too, with these coefficients. States with declared `rates` have no terms. Parameters inside the terms
    /// `free` come after all coefficients; those of others stay where fits start.
    pub(crate) fn new(
        terms: &[Term],
        (supports, given, free): (&[Vec<usize>], &[Given], &[usize]),
        rates: &[Option<usize>],
        n_controls: usize,
        stepping: Stepping,
    ) -> Self {
        Self::trying(terms, (supports, given, free), rates, n_controls, stepping, &|_| true)
    }

    /// The same, where those terms of which `acts` does not say so are only tried: their coefficients are zero, and just the derivatives by these are asked
    /// for. Their kinks and jumps are passed over.
    pub(crate) fn trying(
        terms: &[Term],
        (supports, given, free): (&[Vec<usize>], &[Given], &[usize]),
        rates: &[Option<usize>],
        n_controls: usize,
        stepping: Stepping,
        acts: &dyn Fn(usize) -> bool,
    ) -> Self {
        let n = rates.len();
        let is_given = |j: usize| given.iter().flatten().any(|(k, _)| *k == j);
        let acts = |j: usize| is_given(j) || acts(j);
        let mut used: Vec<usize> =
            supports.iter().flatten().chain(given.iter().flatten().map(|(j, _)| j)).copied().collect();
        used.sort_unstable();
        used.dedup();
        let place = |j: &usize| used.partition_point(|u| u < j);
        let mut summands = Vec::new();
        for (row, support) in supports.iter().enumerate() {
            for j in support {
                let coefficient = Coefficient::Fitted(summands.len());
                let (term, rate) = (place(j), terms[*j].rate);
                summands.push(Summand { row, term, rate, coefficient, acts: acts(*j) });
            }
        }
        let n_coefficients = summands.len();
        for (row, given) in given.iter().enumerate() {
            for (j, value) in given {
                let coefficient = Coefficient::Given(*value);
                summands.push(Summand { row, term: place(j), rate: terms[*j].rate, coefficient, acts: true });
            }
        }
        let mut inside = Vec::new();
        let mut values: Vec<Expr> = used.iter().map(|&j| terms[j].expr.clone()).collect();
        for (term, shape) in free.iter().filter_map(|j| Some((place(j), terms[*j].shape.as_ref()?))) {
            values[term] = shape.over(PARAMETERS + inside.len());
            inside.extend((0..shape.len()).map(|_| Inside { term, slope: None }));
        }
        let may_turn = used.iter().zip(&values).filter(|(j, _)| acts(**j)).map(|(_, value)| value);
        let switches = Switches::among(may_turn, n, n + n_controls);
        // Parameters come after the signs, which are counted now.
        let inputs = n + n_controls + switches.len();
        let numbered =
            |e: &Expr| switches.smooth(e).replaced(&|i| i.checked_sub(PARAMETERS).map(|k| Expr::Variable(inputs + k)));
        let values: Vec<Expr> = values.iter().map(numbered).collect();
        let arguments: Vec<Expr> = switches.arguments().iter().map(numbered).collect();
        let slopes = |of: &[Expr]| -> Vec<(usize, usize, Expr)> {
            let of_term = |(at, e): (usize, &Expr)| {
                (0..n).filter_map(|i| e.derivative(i).map(|d| (at, i, d))).collect::<Vec<_>>()
            };
            of.iter().enumerate().flat_map(of_term).collect()
        };
        let acts = |term: &usize| acts(used[*term]);
        let (mut of_values, of_arguments) = (slopes(&values), slopes(&arguments));
        of_values.retain(|(term, _, _)| acts(term));
        let by_inside: Vec<Option<Expr>> =
            inside.iter().enumerate().map(|(k, i)| values[i.term].derivative(inputs + k)).collect();
        let (acting, tried): (Vec<usize>, Vec<usize>) = (0..values.len()).partition(acts);
        let of_arguments_alone = of_arguments.iter().map(|(_, _, d)| d);
        let rates_alone = acting.iter().map(|&term| &values[term]).chain(&arguments).chain(of_arguments_alone);
        let mut tape = Tape::new(inputs + inside.len(), rates_alone);
        let n_ops_of_rates = tape.n_ops();
        let derivatives = of_values.iter().map(|(_, _, d)| d).chain(by_inside.iter().flatten());
        tape.extend(tried.iter().map(|&term| &values[term]).chain(derivatives));
        let mut registers = tape.outputs().iter().copied();
        let mut values = vec![0; values.len()];
        acting.iter().zip(registers.by_ref()).for_each(|(&term, register)| values[term] = register);
        let arguments: Vec<u32> = registers.by_ref().take(arguments.len()).collect();
        let mut gradients = vec![Vec::new(); arguments.len()];
        for ((switch, state, _), register) in of_arguments.iter().zip(registers.by_ref()) {
            gradients[*switch].push((*state, register));
        }
        tried.iter().zip(registers.by_ref()).for_each(|(&term, register)| values[term] = register);
        let mut partials = vec![Vec::new(); values.len()];
        for ((term, state, _), register) in of_values.iter().zip(registers.by_ref()) {
            partials[*term].push((*state, register));
        }
        for (parameter, _) in inside.iter_mut().zip(&by_inside).filter(|(_, d)| d.is_some()) {
            parameter.slope = registers.next();
        }
        let among = summands.iter().filter(|s| s.acts);
        let mut coupled: Vec<usize> = among.filter_map(|s| Some([s.row, s.rate?])).flatten().collect();
        coupled.sort_unstable();
        coupled.dedup();
        // A circle of rates has no order: nothing moves by the new rates then.
        let positions = after_their_rates(n, |i| rates[i]).unwrap_or_default();
        Self {
            n,
            n_controls,
            n_parameters: n_coefficients + inside.len(),
            values,
            partials,
            coupled,
            summands,
            rates: rates.to_vec(),
            positions,
            stepping,
            switches,
            arguments,
            gradients,
            inside,
            tape,
            n_ops_of_rates,
        }
    }

    /// The terms among whose values are jumps, and where.
    pub(crate) fn switches(&self) -> &Switches {
        &self.switches
    }

    pub(crate) fn n_parameters(&self) -> usize {
        self.n_parameters
    }

    /// Scratch space for steps.
    pub(crate) fn scratch<const L: usize>(&self) -> Scratch<L> {
        let (n, width) = (self.n, self.n + self.n_parameters);
        let zeros = |count: usize| vec![[0.0; L]; count];
        Scratch {
            u: Vec::new(),
            ramp: Vec::new(),
            dt: [0.0; L],
            over: 0.0,
            intersample: InterSample::Zoh,
            changed: None,
            registers: zeros(self.tape.n_registers()),
            f: zeros(n),
            masses: Masses::new(self.coupled.len()),
            f_x: zeros(n * n),
            f_xi: zeros(n * self.n_parameters),
            modes: zeros(self.switches.len()),
            turns: [false; L],
            sliding: None,
            slopes: zeros(STAGES * n),
            s_stage: zeros(n * width),
            s_slopes: zeros(STAGES * n * width),
        }
    }

    /// Writes the parameters inside terms to their registers.
    pub(super) fn fill_inside<const L: usize>(&self, registers: &mut [[f64; L]], xi: &[f64]) {
        let first = self.n + self.n_controls + self.switches.len();
        let inside = &xi[self.n_parameters - self.inside.len()..];
        registers[first..].iter_mut().zip(inside).for_each(|(slot, v)| *slot = [*v; L]);
    }

    /// Nodes of the rates that one step computes.
    pub(super) fn n_rates(&self) -> u64 {
        let rates = self.n_ops_of_rates * (1 + TURNING * self.switches.len()) + self.n;
        (self.n_stages() * rates) as u64
    }

    /// Nodes of their derivatives that one step computes.
    pub(super) fn n_slopes(&self) -> u64 {
        (self.n_stages() * (self.tape.n_ops() - self.n_ops_of_rates)) as u64
    }

    /// Whether there are parameters inside terms.
    pub(super) fn is_curved(&self) -> bool {
        !self.inside.is_empty()
    }

    pub(crate) fn stepping(&self) -> Stepping {
        self.stepping
    }

    /// The same equations stepped in another way.
    pub(crate) fn with_stepping(&self, stepping: Stepping) -> Self {
        Self { stepping, ..self.clone() }
    }

    /// Whether all substeps are classical ones of order four, as those of a model are.
    pub(super) fn is_classical(&self) -> bool {
        matches!(self.stepping, Stepping::Classical { .. })
    }

    /// The same with no more substeps than derivatives need: they only point the way to the next iterate.
    pub(crate) fn for_derivatives(&self) -> Self {
        match self.stepping {
            Stepping::Continuous { substeps } => {
                self.with_stepping(Stepping::Continuous { substeps: substeps.min(DERIVATIVE_SUBSTEPS) })
            }
            Stepping::Classical { substeps } => {
                self.with_stepping(Stepping::Classical { substeps: substeps.min(DERIVATIVE_SUBSTEPS) })
            }
            _ => self.clone(),
        }
    }

    /// ẋ at the (x; u) that `scratch` has, with the signs that it has for the switches, and with `derivatives` ∂ẋ/∂x (n, n) and ∂ẋ/∂ξ (n, p), into the
    /// scratch space. NaN where the implicit equations are singular.
    pub(super) fn rates_between_switches<const L: usize>(
        &self,
        xi: &[f64],
        derivatives: bool,
        scratch: &mut Scratch<L>,
    ) {
        if self.is_classical() {
            self.signs(&mut scratch.registers, &mut scratch.modes);
        }
        let Scratch { registers, f, f_x, f_xi, masses, modes, .. } = scratch;
        let (n, p) = (self.n, self.n_parameters);
        let first = n + self.n_controls;
        registers[first..first + modes.len()].copy_from_slice(modes);
        let n_ops = if derivatives { self.tape.n_ops() } else { self.n_ops_of_rates };
        self.tape.run_first(registers, n_ops);
        let value = |s: &Summand| &registers[self.values[s.term] as usize];
        for (f, rate) in f.iter_mut().zip(&self.rates) {
            *f = rate.map_or([0.0; L], |v| registers[v]);
        }
        for s in self.summands.iter().filter(|s| s.acts && s.rate.is_none()) {
            let (times, value) = (s.times(xi), value(s));
            add(&mut f[s.row], |l| times * value[l]);
        }
        let among = &self.coupled;
        if !among.is_empty() {
            let place = |i: usize| among.partition_point(|&k| k < i);
            masses.invert(&|l, matrix| {
                for s in self.summands.iter().filter(|s| s.acts) {
                    if let Some(rate) = s.rate {
                        matrix[(place(s.row), place(rate))] -= s.times(xi) * value(s)[l];
                    }
                }
            });
            masses.solve(among, f, 1);
        }
        if !derivatives {
            return;
        }
        f_x.fill([0.0; L]);
        f_xi.fill([0.0; L]);
        for (i, rate) in self.rates.iter().enumerate() {
            if let Some(v) = rate {
                f_x[i * n + v] = [1.0; L];
            }
        }
        let one = [1.0; L];
        for s in &self.summands {
            let times = s.rate.map_or(&one, |rate| &f[rate]);
            if let Coefficient::Fitted(parameter) = s.coefficient {
                let value = value(s);
                f_xi[s.row * p + parameter] = std::array::from_fn(|l| value[l] * times[l]);
            }
            for &(k, register) in &self.partials[s.term] {
                let (coefficient, slope) = (s.times(xi), &registers[register as usize]);
                add(&mut f_x[s.row * n + k], |l| coefficient * slope[l] * times[l]);
            }
        }
        for (at, parameter) in self.inside.iter().enumerate() {
            let Some(slope) = parameter.slope.map(|register| &registers[register as usize]) else { continue };
            for s in self.summands.iter().filter(|s| s.term == parameter.term) {
                let (coefficient, times) = (s.times(xi), s.rate.map_or(&one, |rate| &f[rate]));
                let place = s.row * p + p - self.inside.len() + at;
                add(&mut f_xi[place], |l| coefficient * slope[l] * times[l]);
            }
        }
        if !among.is_empty() {
            masses.solve(among, f_x, n);
            masses.solve(among, f_xi, p);
        }
    }
}
