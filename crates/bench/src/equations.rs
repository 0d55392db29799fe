//! Equations as lists of terms: read, evaluated, printed.

use std::fmt;

use anyhow::Context as _;
use sindyna_core::VectorField;
use sindyna_sindy::{Expr, parse};

/// One summand c φ(z), or c φ(z) ẋ_l where `rate` is l.
#[derive(Debug, Clone, PartialEq)]
pub struct Term {
    /// φ as text over the names of states and inputs.
    pub text: String,
    /// The state by whose rate φ is multiplied.
    pub rate: Option<usize>,
    /// c.
    pub coefficient: f64,
    /// Its standard error, where a method tells one.
    pub error: Option<f64>,
}

impl Term {
    /// The term without its coefficient, with the names of the states for its rate.
    #[must_use]
    pub fn label(&self, states: &[String]) -> String {
        match self.rate {
            None => self.text.clone(),
            Some(l) if self.text == "1" => format!("d{}/dt", states[l]),
            Some(l) => format!("{}*d{}/dt", self.text, states[l]),
        }
    }
}

/// A term that can be evaluated.
#[derive(Debug, Clone)]
pub(crate) struct Compiled {
    expr: Expr,
    rate: Option<usize>,
    coefficient: f64,
}

impl Compiled {
    /// φ(z), times ẋ_l where there is one.
    pub(crate) fn value(&self, z: &[f64], rates: &[f64]) -> f64 {
        self.expr.eval(z) * self.rate.map_or(1.0, |l| rates[l])
    }

    pub(crate) fn coefficient(&self) -> f64 {
        self.coefficient
    }
}

/// ẋ_i = Σ c φ(z) + Σ c φ(z) ẋ_l, one row of terms per state.
#[derive(Debug, Clone)]
pub struct Equations {
    rows: Vec<Vec<Compiled>>,
}

impl Equations {
    /// Reads `rows` of terms over `variables`, the states first.
    ///
    /// # Errors
    /// If a term cannot be read.
    pub fn new(rows: &[Vec<Term>], variables: &[String]) -> anyhow::Result<Self> {
        let compiled = |term: &Term| -> anyhow::Result<Compiled> {
            let expr = parse(&term.text, variables).with_context(|| format!("the term `{}`", term.text))?;
            Ok(Compiled { expr, rate: term.rate, coefficient: term.coefficient })
        };
        let row = |terms: &Vec<Term>| terms.iter().map(compiled).collect::<anyhow::Result<Vec<_>>>();
        Ok(Self { rows: rows.iter().map(row).collect::<anyhow::Result<_>>()? })
    }

    /// The terms of equation `i`.
    pub(crate) fn row(&self, i: usize) -> &[Compiled] {
        &self.rows[i]
    }

    /// Whether the rates of `states` depend on each other.
    pub(crate) fn is_implicit(&self, mut states: impl Iterator<Item = usize>) -> bool {
        states.any(|i| self.rows[i].iter().any(|t| t.rate.is_some()))
    }
}

impl VectorField for Equations {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        let z = [x, u].concat();
        let n = self.rows.len();
        let mut matrix = vec![vec![0.0; n + 1]; n];
        for (i, (line, terms)) in matrix.iter_mut().zip(&self.rows).enumerate() {
            line[i] = 1.0;
            for term in terms {
                let value = term.coefficient * term.expr.eval(&z);
                match term.rate {
                    Some(l) => line[l] -= value,
                    None => line[n] += value,
                }
            }
        }
        eliminate(&mut matrix);
        for (i, rate) in x_dot.iter_mut().enumerate() {
            *rate = matrix[i][n] / matrix[i][i];
        }
    }
}

/// Gauss–Jordan elimination of (A | b) with row exchanges; a singular A leaves infinities.
fn eliminate(matrix: &mut [Vec<f64>]) {
    let n = matrix.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|&a, &b| matrix[a][k].abs().total_cmp(&matrix[b][k].abs())).unwrap_or(k);
        matrix.swap(k, pivot);
        let row = matrix[k].clone();
        for (_, other) in matrix.iter_mut().enumerate().filter(|(i, line)| *i != k && line[k] != 0.0) {
            let factor = other[k] / row[k];
            for (value, subtracted) in other.iter_mut().zip(&row).skip(k) {
                *value -= factor * subtracted;
            }
        }
    }
}

/// Why the text of a true equation cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not `COEFFICIENT TERM` or `COEFFICIENT TERM @STATE`")]
pub struct NotASummand(String);

/// Reads summands such as `-9.81/0.5 sin(th); 0.3 cos(th) @w`: coefficient, term and, behind `@`, the state by whose rate the
/// term is multiplied.
///
/// # Errors
/// [`NotASummand`] with the first one that cannot be read.
pub fn summands(text: &str, states: &[String]) -> Result<Vec<Term>, NotASummand> {
    let summand = |part: &str| {
        let bad = || NotASummand(part.to_owned());
        let (coefficient, rest) = part.trim().split_once(' ').ok_or_else(bad)?;
        let coefficient = parse(coefficient, &[]).map_err(|_| bad())?.eval(&[]);
        let (term, rate) = match rest.split_once('@') {
            None => (rest, None),
            Some((term, state)) => (term, Some(states.iter().position(|s| s == state.trim()).ok_or_else(bad)?)),
        };
        Ok(Term { text: term.trim().to_owned(), rate, coefficient, error: None })
    };
    text.split(';').filter(|part| !part.trim().is_empty()).map(summand).collect()
}

impl fmt::Display for Term {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.coefficient, self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn implicit_equations_are_solved() -> anyhow::Result<()> {
        // a' = 3 + 0.5 b', b' = x − 2 a' with x = 1: a' = 1.75, b' = −2.5.
        let names = ["a".to_owned(), "b".to_owned()];
        let rows = [summands("6/2 1; 0.5 1 @b", &names)?, summands("1 a; -2 1 @a", &names)?];
        let mut x_dot = [0.0; 2];
        Equations::new(&rows, &names)?.eval(&[1.0, 0.0], &[], &mut x_dot);
        assert!((x_dot[0] - 1.75).abs() < 1e-15 && (x_dot[1] + 2.5).abs() < 1e-15, "{x_dot:?}");
        assert_eq!(rows[1][1].label(&names), "da/dt");
        Ok(())
    }
}
