//! Candidate terms with parameters inside.

use std::f64::consts::PI;

use super::shape::{Measure, Parameter, Shape, parameter};
use super::{Input, Role, Term, complexity};
use crate::expr::{Expr, Function};

/// What the data say of a variable.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Extent {
    pub(crate) low: f64,
    pub(crate) high: f64,
    /// Standard deviation.
    pub(crate) spread: f64,
}

impl Extent {
    pub(crate) fn of(values: &[f64]) -> Self {
        let n = values.len().max(1) as f64;
        let mean = values.iter().sum::<f64>() / n;
        Self {
            low: values.iter().copied().fold(f64::INFINITY, f64::min),
            high: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            spread: (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt(),
        }
    }

    /// Whether the values go through half a period of sin ka or more.
    pub(crate) fn turns(self, k: f64) -> bool {
        k * (self.high - self.low) >= PI
    }

    /// The value some `part` of the range above the lowest.
    fn at(self, part: f64) -> f64 {
        self.low + part * (self.high - self.low)
    }
}

/// Scales with which fits start, as parts of the largest value, and their bounds: beyond the second tanh(a/c) is as good as a, and beyond the third
/// a/(c + a) too.
const SCALES: [f64; 3] = [0.1, 0.33, 1.0];
const SMALLEST: f64 = 0.01;
const LINEAR: f64 = 2.0;
const UNSATURATED: f64 = 4.0;

/// Multiple of the lowest value below zero that c of a/(c + a) is at least.
const AWAY: f64 = 2.0;

/// The same of e^(a/c), as multiples of the spread.
const WIDTHS: [f64; 3] = [0.3, 1.0, 3.0];
const WIDTH_BOUNDS: (f64, f64) = (0.03, 4.0);

/// The same of angular frequencies, times the spread.
const FREQUENCIES: [f64; 4] = [0.5, 1.0, 2.0, 4.0];
const FREQUENCY_BOUNDS: (f64, f64) = (0.4, 10.0);

/// Part of the range, below the lowest value, where the zero of √(a − c) is looked for first, and how far; above the highest one that of √(c − a).
const BELOW: f64 = 0.2;
const FAR_BELOW: f64 = 4.0;

/// Multiples of the range below the lowest value where absolute zero is looked for first, and beyond which (a + c)⁴ is as good as a parabola.
const ABSOLUTE: [f64; 2] = [0.5, 2.0];
const PARABOLIC: f64 = 10.0;

/// Parts of the range, from its lowest value, and of the largest value, where kinks are looked for.
const KINKS: [f64; 9] = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];
const DEAD_ZONES: [f64; 6] = [0.1, 0.2, 0.35, 0.5, 0.65, 0.8];

/// The same of exponents.
const EXPONENTS: [f64; 3] = [0.5, 1.5, 3.0];
const EXPONENT_BOUNDS: (f64, f64) = (0.2, 6.0);
const NEGATIVE_EXPONENT: f64 = -1.5;

/// Candidate terms with a parameter c that the data tell, one for each value with which fits start. With a, b straight variables (no angles):
///
/// - tanh(a/c): saturation and smooth friction, of all of them; of those that are no rates:
/// - max(a − c, 0) and max(c − a, 0), a stop, a valve or a diode; max(a − c, 0) − max(−c − a, 0), clearance or a dead zone,
/// - tanh((a − c₁)/c₂), a sigmoid; e^(a/c), e^(−a/c), a²/(c² + a²), sin(c a), cos(c a), √(a − c), the flow out of what is not empty at zero, and √(c − a), into what is supplied at c; (a + c)⁴, radiation at
///   temperatures that are not measured from absolute zero; where they are
///   positive but for noise a/(c + a); where they are positive a^c with positive and negative c, and e^(−c/a), a reaction (Arrhenius),
/// - the exponentials, ratios and negative powers times each other b, negative powers also times b², as forces of magnets and charges are, and the roots times inputs.
pub(crate) fn shaped(inputs: &[Input], extents: &[Extent]) -> Vec<Term> {
    let straight = |i: &usize| {
        !matches!(inputs[*i].role, Role::Angle | Role::Turning)
            && extents[*i].spread > 0.0
            && extents[*i].spread.is_finite()
    };
    let straight: Vec<usize> = (0..inputs.len()).filter(straight).collect();
    let mut terms = Shaped::new(inputs);
    for &a in &straight {
        let extent = extents[a];
        let largest = extent.low.abs().max(extent.high.abs());
        let x = || Box::new(Expr::Variable(a));
        let c = |k: usize| Box::new(parameter(k));
        let over_c = || Expr::Div(x(), c(0));
        let scale = |part: f64, most: f64| positive(part, (SMALLEST, most), largest);
        let place = |start: f64, bounds| Parameter { start, bounds, measure: Measure::Of(extent.spread) };
        for part in SCALES {
            terms.add(call(Function::Tanh, over_c()), vec![scale(part, LINEAR)]);
        }
        if inputs[a].role == Role::Rate {
            continue;
        }
        let beyond = |from: Expr, to: Expr| call(Function::PositivePart, Expr::Sub(Box::new(from), Box::new(to)));
        for at in KINKS {
            let kink = place(extent.at(at), (extent.low, extent.high));
            terms.add(beyond(*x(), *c(0)), vec![kink]);
        }
        let kink = place(extent.at(0.5), (extent.low, extent.high));
        terms.add(beyond(*c(0), *x()), vec![kink]);
        if extent.low < 0.0 && extent.high > 0.0 {
            let below = beyond(Expr::Neg(c(0)), *x());
            let zone = Expr::Sub(Box::new(beyond(*x(), *c(0))), Box::new(below));
            for part in DEAD_ZONES {
                terms.add(zone.clone(), vec![scale(part, 1.0)]);
            }
        }
        for at in [0.25, 0.5, 0.75] {
            let location = place(extent.at(at), (extent.low, extent.high));
            let argument = Expr::Div(Box::new(Expr::Sub(x(), c(0))), c(1));
            let width = positive(0.5, (SMALLEST, LINEAR), extent.spread);
            terms.add(call(Function::Tanh, argument), vec![location, width]);
        }
        for times in FREQUENCIES {
            let frequency = positive(times, FREQUENCY_BOUNDS, 1.0 / extent.spread);
            for f in [Function::Sin, Function::Cos] {
                terms.add(call(f, Expr::Mul(c(0), x())), vec![frequency.clone()]);
            }
        }
        let others: Vec<Expr> = straight.iter().filter(|&&b| b != a).map(|&b| Expr::Variable(b)).collect();
        let factors: Vec<Expr> = std::iter::once(Expr::Constant(1.0)).chain(others).collect();
        let inputs_alone = straight.iter().filter(|&&b| b != a && inputs[b].role == Role::Control);
        for factor in std::iter::once(Expr::Constant(1.0)).chain(inputs_alone.map(|&b| Expr::Variable(b))) {
            let bounds = (extent.at(-FAR_BELOW), extent.low);
            let zero = place(extent.at(-BELOW), bounds);
            terms.add(factor.clone().times(call(Function::Sqrt, Expr::Sub(x(), c(0)))), vec![zero]);
            let supply = place(extent.at(1.0 + BELOW), (extent.high, extent.at(1.0 + FAR_BELOW)));
            terms.add(factor.times(call(Function::Sqrt, Expr::Sub(c(0), x()))), vec![supply]);
        }
        let absolute = Expr::Power(Box::new(Expr::Add(x(), c(0))), 4);
        for spans in ABSOLUTE {
            let zero = place(-extent.at(-spans), (-extent.low, -extent.at(-PARABOLIC)));
            terms.add(absolute.clone(), vec![zero]);
        }
        for factor in &factors {
            if extent.low > 0.0 {
                let middle = extent.at(0.5);
                // It is e^(a/w) around the middle of the range for w = middle²/c.
                let bounds = (1.0 / WIDTH_BOUNDS.1, 1.0 / WIDTH_BOUNDS.0);
                let inverse = Expr::Neg(Box::new(Expr::Div(c(0), x())));
                for times in WIDTHS {
                    let energy = positive(1.0 / times, bounds, middle * middle / extent.spread);
                    terms.add(factor.clone().times(call(Function::Exp, inverse.clone())), vec![energy]);
                }
            }
            for times in WIDTHS {
                let width = positive(times, WIDTH_BOUNDS, extent.spread);
                terms.add(factor.clone().times(call(Function::Exp, over_c())), vec![width.clone()]);
                terms.add(factor.clone().times(call(Function::Exp, Expr::Neg(Box::new(over_c())))), vec![width]);
            }
            for part in SCALES {
                let square = |e: Box<Expr>| Box::new(Expr::Power(e, 2));
                let ratio = Expr::Div(square(x()), Box::new(Expr::Add(square(c(0)), square(x()))));
                terms.add(factor.clone().times(ratio), vec![scale(part, UNSATURATED)]);
                // What is positive may seem negative in noise; the denominator stays away from zero.
                let least = SMALLEST.max(AWAY * (-extent.low / largest));
                if part > least {
                    let ratio = Expr::Div(x(), Box::new(Expr::Add(c(0), x())));
                    terms.add(factor.clone().times(ratio), vec![positive(part, (least, UNSATURATED), largest)]);
                }
            }
        }
        if extent.low > 0.0 {
            let power = call(Function::Exp, Expr::Mul(c(0), Box::new(call(Function::Log, Expr::Variable(a)))));
            for exponent in EXPONENTS {
                terms.add(power.clone(), vec![positive(exponent, EXPONENT_BOUNDS, 1.0)]);
            }
            let squares = factors.iter().skip(1).map(|factor| factor.clone().to_power(2));
            for factor in factors.iter().cloned().chain(squares) {
                let bounds = (-EXPONENT_BOUNDS.1, -EXPONENT_BOUNDS.0);
                let exponent = Parameter { start: NEGATIVE_EXPONENT, bounds, measure: Measure::Of(1.0) };
                terms.add(factor.times(power.clone()), vec![exponent]);
            }
        }
    }
    terms.terms
}

/// A positive parameter that is some `times` the size `typical`.
fn positive(times: f64, bounds: (f64, f64), typical: f64) -> Parameter {
    Parameter { start: times * typical, bounds: (bounds.0 * typical, bounds.1 * typical), measure: Measure::Logarithm }
}

struct Shaped {
    roles: Vec<Role>,
    names: Vec<String>,
    terms: Vec<Term>,
}

impl Shaped {
    fn new(inputs: &[Input]) -> Self {
        Self {
            roles: inputs.iter().map(|i| i.role).collect(),
            names: inputs.iter().map(|i| i.name.clone()).collect(),
            terms: Vec::new(),
        }
    }

    fn add(&mut self, formula: Expr, parameters: Vec<Parameter>) {
        let shape = Shape::new(formula, parameters);
        let expr = shape.at(&shape.start());
        let complexity = complexity(&shape.plainest(), &self.roles);
        self.terms.push(Term { name: shape.name(&self.names), expr, complexity, rate: None, shape: Some(shape) });
    }
}

fn call(f: Function, a: Expr) -> Expr {
    Expr::Call(f, Box::new(a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_and_states_enter_by_the_same_laws_where_their_values_allow_them() {
        let inputs = [Input::new("T", Role::Plain), Input::new("v", Role::Rate), Input::new("u", Role::Control)];
        let names = |extents: &[Extent]| {
            shaped(&inputs, extents).into_iter().map(|t| t.name.replace(' ', "")).collect::<Vec<_>>()
        };
        let extent = |low: f64, high: f64| Extent::of(&[low, high]);
        let all = names(&[extent(300.0, 330.0), extent(-1.0, 1.0), extent(0.5, 2.0)]);
        for wanted in ["u/(c+u)", "exp(c*log(u))", "u*sqrt(T-c)", "exp(-(c/T))", "v*exp(-(c/T))", "tanh(v/c)"] {
            assert!(all.iter().any(|n| n == wanted), "{wanted} is missing in {all:?}");
        }
        // Not of what changes its sign, and none of rates but saturation.
        let signed = names(&[extent(-30.0, 30.0), extent(-1.0, 1.0), extent(-2.0, 2.0)]);
        for unwanted in ["u/(c+u)", "exp(c*log(u))", "exp(-(c/T))", "sqrt(v-c)"] {
            assert!(!signed.iter().any(|n| n == unwanted), "{unwanted}");
        }
    }
}
