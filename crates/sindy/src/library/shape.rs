//! Terms with parameters inside: tanh(x/c), x/(c + x).

use crate::expr::{Expr, Function};
use serde::{Deserialize, Serialize};

/// The number of the first parameter among the variables of [`Shape::formula`]; no system has as many variables.
const FIRST: usize = 1 << 24;

/// A parameter inside a term.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Parameter {
    /// Value with which fits start.
    pub(crate) start: f64,
    /// Values beyond which the term is another one.
    pub(crate) bounds: (f64, f64),
    pub(crate) measure: Measure,
}

/// What is fitted of a parameter: a number that does not depend on units, of which 1 is much.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) enum Measure {
    /// Its logarithm: it is positive.
    Logarithm,
    /// How many of these it is.
    Of(f64),
}

impl Measure {
    fn fitted(self, value: f64) -> f64 {
        match self {
            Self::Logarithm => value.ln(),
            Self::Of(unit) => value / unit,
        }
    }

    fn value(self, fitted: f64) -> f64 {
        match self {
            Self::Logarithm => fitted.exp(),
            Self::Of(unit) => unit * fitted,
        }
    }

    /// The value as a function of what is `fitted`.
    fn of(self, fitted: Expr) -> Expr {
        match self {
            Self::Logarithm => Expr::Call(Function::Exp, Box::new(fitted)),
            Self::Of(unit) => Expr::Mul(Box::new(Expr::Constant(unit)), Box::new(fitted)),
        }
    }
}

/// A family of terms: a formula of variables and of parameters, whose values the data tell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Shape {
    formula: Expr,
    parameters: Vec<Parameter>,
}

/// The parameter number `k` in a formula.
pub(super) fn parameter(k: usize) -> Expr {
    Expr::Variable(FIRST + k)
}

impl Shape {
    pub(super) fn new(formula: Expr, parameters: Vec<Parameter>) -> Self {
        Self { formula, parameters }
    }

    pub(crate) fn len(&self) -> usize {
        self.parameters.len()
    }

    /// Whether the two are the same but for where fits start.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        self.formula == other.formula
    }

    /// What is fitted, at the start.
    pub(crate) fn start(&self) -> Vec<f64> {
        self.parameters.iter().map(|p| p.measure.fitted(p.start)).collect()
    }

    /// What is fitted at `count` values of its parameter, evenly between the bounds; `None` if it has not one parameter.
    pub(crate) fn between(&self, count: usize) -> Option<Vec<Vec<f64>>> {
        let [Parameter { bounds: (low, high), measure, .. }] = self.parameters[..] else { return None };
        let (low, high) = (measure.fitted(low), measure.fitted(high));
        let value = |at: usize| vec![low + (at as f64 + 0.5) / count as f64 * (high - low)];
        Some((0..count).map(value).collect())
    }

    /// Whether all parameters, as they were fitted, are within their bounds.
    pub(crate) fn is_within(&self, fitted: &[f64]) -> bool {
        let within = |(p, v): (&Parameter, f64)| (p.bounds.0..=p.bounds.1).contains(&v);
        self.parameters.iter().zip(self.values(fitted)).all(within)
    }

    /// The values of the parameters that were `fitted`.
    pub(crate) fn values(&self, fitted: &[f64]) -> Vec<f64> {
        self.parameters.iter().zip(fitted).map(|(p, v)| p.measure.value(*v)).collect()
    }

    /// The term with the parameters that were `fitted`.
    pub(crate) fn at(&self, fitted: &[f64]) -> Expr {
        let values = self.values(fitted);
        self.with(&|k| Expr::Constant(values[k]))
    }

    /// The term with what is fitted as variables, from number `first` on.
    pub(crate) fn over(&self, first: usize) -> Expr {
        self.with(&|k| self.parameters[k].measure.of(Expr::Variable(first + k)))
    }

    /// For max(x − c, 0) and max(c − x, 0) the sign of x; none for other terms.
    pub(crate) fn kink(&self) -> Option<f64> {
        let Expr::Call(Function::PositivePart, inside) = &self.formula else { return None };
        match &**inside {
            Expr::Sub(a, _) if matches!(**a, Expr::Variable(i) if i < FIRST) => Some(1.0),
            Expr::Sub(_, b) if matches!(**b, Expr::Variable(i) if i < FIRST) => Some(-1.0),
            _ => None,
        }
    }

    /// Whether one of the two is max(a, 0) and the other max(−a, 0).
    pub(crate) fn is_mirrored(&self, other: &Self) -> bool {
        let difference = |e: &Expr| match e {
            Expr::Call(Function::PositivePart, inside) => match &**inside {
                Expr::Sub(a, b) => Some((a.clone(), b.clone())),
                _ => None,
            },
            _ => None,
        };
        let (own, other) = (difference(&self.formula), difference(&other.formula));
        own.zip(other).is_some_and(|((a, b), (c, d))| a == d && b == c)
    }

    /// The derivative of the term by what is `fitted`, number `k`, there.
    pub(crate) fn slope(&self, k: usize, fitted: &[f64]) -> Option<Expr> {
        let by = self.over(FIRST).derivative(FIRST + k)?;
        Some(by.replaced(&|i| i.checked_sub(FIRST).map(|k| Expr::Constant(fitted[k]))))
    }

    /// The standard error of parameter `k`, if that of what was fitted is `error`.
    pub(crate) fn error(&self, k: usize, fitted: &[f64], error: f64) -> f64 {
        match self.parameters[k].measure {
            Measure::Logarithm => error * fitted[k].exp(),
            Measure::Of(unit) => error * unit,
        }
    }

    /// The term as people write it, with its parameters called c, or c1, c2.
    pub(crate) fn pretty(&self, names: &[String]) -> String {
        let (formula, all) = self.named(names);
        formula.pretty(&all).to_string()
    }

    /// The same as text that can be read back.
    pub(crate) fn name(&self, names: &[String]) -> String {
        let (formula, all) = self.named(names);
        formula.display(&all).to_string()
    }

    fn named(&self, names: &[String]) -> (Expr, Vec<String>) {
        let n = names.len();
        let letters: Vec<String> = match self.len() {
            1 => vec!["c".into()],
            len => (1..=len).map(|k| format!("c{k}")).collect(),
        };
        (self.with(&|k| Expr::Variable(n + k)), [names, &letters].concat())
    }

    /// The term with ones for its parameters.
    pub(crate) fn plainest(&self) -> Expr {
        self.with(&|_| Expr::Constant(1.0))
    }

    fn with(&self, by: &dyn Fn(usize) -> Expr) -> Expr {
        self.formula.replaced(&|i| i.checked_sub(FIRST).map(by))
    }
}
