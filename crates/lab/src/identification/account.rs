//! What was found and how far to believe it, for people and as JSON.

use std::fmt::Write as _;

use serde::Serialize;
use sindyna_core::{Dataset, Spec};
use sindyna_sindy::{EquationReport, Form, Identified, Identifier, LibraryError, Report, SizeReport};

use super::standard_errors::standard_errors;
use crate::number::significant;

/// The account of an identification.
#[derive(Debug, Serialize)]
pub(crate) struct Account {
    /// Steps the equations were fitted to.
    rows: usize,
    /// Steps left out because a channel sat at its declared bound.
    rows_at_limit: usize,
    /// Condition number of the candidate columns, each scaled to unit length; `null` with fewer rows than terms.
    condition: Option<f64>,
    /// Candidate terms.
    features: Vec<String>,
    equations: Vec<Equation>,
}

/// One equation.
#[derive(Debug, Serialize)]
struct Equation {
    state: String,
    equation: String,
    /// Unit of the left-hand side, as far as it is known.
    unit: String,
    terms: Vec<Summand>,
    /// RMS residual, in that unit.
    residual: f64,
    /// RMS residual that rounding explains; 0 where that is not known.
    floor: f64,
    reached_floor: bool,
    /// Whether every subset of this size was looked at.
    proved: bool,
    /// The best subset of each size that was tried.
    path: Vec<Size>,
}

/// One term of an equation.
#[derive(Debug, Serialize)]
struct Summand {
    term: String,
    coefficient: f64,
    /// `null` where it is not known.
    standard_error: Option<f64>,
}

impl Summand {
    /// Significant digits of the coefficient that go as far as two digits of its error.
    fn digits(&self) -> usize {
        let known =
            |error: f64| (self.coefficient.abs().log10().floor() - error.log10().floor() + 2.0).clamp(2.0, 15.0);
        self.standard_error.filter(|e| *e > 0.0).map_or(9, |error| known(error) as usize)
    }
}

/// The best subset of one size.
#[derive(Debug, Serialize)]
struct Size {
    terms: Vec<String>,
    residual: f64,
    proved: bool,
}

impl Account {
    /// The account of `found`, which `identifier` found in `data` of the system `spec`.
    ///
    /// # Errors
    /// [`LibraryError`] if the identifier has no terms; it found none then either.
    pub(crate) fn new(
        found: &Identified,
        identifier: &Identifier,
        spec: &Spec,
        data: &Dataset,
    ) -> Result<Self, LibraryError> {
        let (report, terms) = (&found.report, identifier.terms()?);
        let texts = found.model.equations();
        let equations = report.equations.iter().zip(texts).zip(&spec.state).map(|((equation, text), channel)| {
            let errors = standard_errors(equation, &terms, data);
            let unit = match found.model.form() {
                Form::Discrete => channel.unit.clone(),
                _ => per_second(&channel.unit),
            };
            Equation::new(report, equation, text, unit, &errors)
        });
        Ok(Self {
            rows: report.rows,
            rows_at_limit: report.rows_at_limit,
            condition: Some(report.condition).filter(|c| c.is_finite()),
            features: report.features.clone(),
            equations: equations.collect(),
        })
    }

    /// The equations, each with its terms, and what speaks for them.
    pub(crate) fn text(&self) -> String {
        let mut text = String::from("equations\n");
        for equation in &self.equations {
            let _ = writeln!(text, "  {}", equation.equation);
        }
        for equation in &self.equations {
            text.push('\n');
            text.push_str(&equation.table());
        }
        let _ = write!(text, "\nsteps used: {}", self.rows);
        if self.rows_at_limit > 0 {
            let _ = write!(text, ", left out at a limit: {}", self.rows_at_limit);
        }
        let condition = match self.condition {
            Some(condition) => significant(condition, 2),
            None => "infinite (fewer steps than terms)".into(),
        };
        let _ = writeln!(text, "\ncandidate terms: {}, their condition number: {condition}", self.features.len());
        text
    }
}

impl Equation {
    fn new(report: &Report, equation: &EquationReport, text: String, unit: String, errors: &[f64]) -> Self {
        let name = |&j: &usize| report.features[j].clone();
        let summand = |(at, (j, &coefficient)): (usize, (&usize, &f64))| Summand {
            term: name(j),
            coefficient,
            standard_error: errors.get(at).copied().filter(|e| e.is_finite()),
        };
        let size = |size: &SizeReport| Size {
            terms: size.support.iter().map(name).collect(),
            residual: size.residual,
            proved: size.proved,
        };
        Self {
            state: equation.state.clone(),
            equation: text,
            unit,
            terms: equation.support.iter().zip(&equation.coefficients).enumerate().map(summand).collect(),
            residual: equation.residual,
            floor: equation.floor,
            reached_floor: equation.reached_floor,
            proved: equation.proved,
            path: equation.path.iter().map(size).collect(),
        }
    }

    /// Coefficients with their errors, and the residual.
    fn table(&self) -> String {
        let left = self.equation.split(" = ").next().unwrap_or(&self.state);
        let lines = self.terms.iter().map(|summand| {
            let error = summand.standard_error.map_or_else(|| "not known".into(), |e| significant(e, 2));
            [summand.term.clone(), significant(summand.coefficient, summand.digits()), error]
        });
        let heading = [left.to_owned(), "coefficient".into(), "standard error".into()];
        let lines: Vec<[String; 3]> = std::iter::once(heading).chain(lines).collect();
        let width = |i: usize| lines.iter().map(|line| columns(&line[i])).max().unwrap_or(0);
        let (first, second) = (width(0), width(1));
        let pad = |text: &str, width: usize| " ".repeat(width.saturating_sub(columns(text)));
        let mut text = String::new();
        for [term, coefficient, error] in &lines {
            let (a, b) = (pad(term, first), pad(coefficient, second));
            let _ = writeln!(text, "  {term}{a}   {coefficient}{b}   {error}");
        }
        text + &self.verdict()
    }

    /// The residual, and whether it is all rounding.
    fn verdict(&self) -> String {
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        let residual = significant(self.residual, 2);
        let floor = significant(self.floor, 2);
        let floor = match (self.reached_floor, self.floor > 0.0) {
            (true, _) => format!("no more than rounding explains ({floor})"),
            (false, true) => format!("above what rounding explains ({floor}): noise, or a term that is missing"),
            (false, false) => "what rounding explains is not known for this target".into(),
        };
        let search = if self.proved || self.path.is_empty() { "" } else { "; not every subset of this size was tried" };
        format!("  residual {residual}{unit}: {floor}{search}\n")
    }
}

/// Places `text` takes on a terminal: marks over letters take none.
fn columns(text: &str) -> usize {
    text.chars().filter(|c| !('\u{300}'..='\u{36f}').contains(c)).count()
}

/// The unit of a rate of what is measured in `unit`.
fn per_second(unit: &str) -> String {
    match unit.strip_suffix("/s") {
        _ if unit.is_empty() => String::new(),
        Some(rest) => format!("{rest}/s²"),
        None if unit.contains(['/', '·']) => format!("({unit})/s"),
        None => format!("{unit}/s"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_rates() {
        for (unit, rate) in [("rad", "rad/s"), ("rad/s", "rad/s²"), ("", ""), ("m/s²", "(m/s²)/s")] {
            assert_eq!(per_second(unit), rate);
        }
    }

    #[test]
    fn a_table_lines_up_and_says_what_speaks_for_it() {
        let summand =
            |term: &str, coefficient, standard_error| Summand { term: term.into(), coefficient, standard_error };
        let equation = Equation {
            state: "w".into(),
            equation: "Δw/Δt = 15 sin th − 0.1 w".into(),
            unit: "rad/s²".into(),
            terms: vec![summand("sin th", 15.000_000_213, Some(1.234e-7)), summand("w", -0.1, None)],
            residual: 1.26e-6,
            floor: 2e-6,
            reached_floor: true,
            proved: false,
            path: vec![Size { terms: vec![], residual: 1.0, proved: true }],
        };
        let expected = "\
\u{20} Δw/Δt    coefficient   standard error
\u{20} sin th   15.00000021   1.2e-7
\u{20} w        -0.1          not known
\u{20} residual 1.3e-6 rad/s²: no more than rounding explains (2e-6); not every subset of this size was tried
";
        assert_eq!(equation.table(), expected);
    }
}
