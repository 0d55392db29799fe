//! One equation, its coefficients, and what is left over.

use std::fmt::Write as _;

use serde::{Deserialize, Serialize};
use sindyna_sindy::{Doubt, EquationReport, Form, Identified, InsideParameter, SizeReport};

use crate::number::significant;
use crate::table::columns_of;

/// What the residuals of equations are compared with where the noise was estimated.
pub(super) const ESTIMATED: &str = "the estimated noise";

/// One equation.
#[derive(Debug, Serialize)]
pub(crate) struct Equation {
    state: String,
    equation: String,
    /// Whether it only says which state is the rate of this one, which was declared and not fitted.
    declared: bool,
    /// Steps it was fitted to.
    #[serde(skip)]
    rows: usize,
    /// Unit of the left-hand side, as far as it is known.
    unit: String,
    pub(crate) terms: Vec<Summand>,
    /// Parameters inside the terms, such as c of tanh(v/c).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    parameters: Vec<Inside>,
    /// RMS residual, in that unit; `null` for a declared rate, of which nothing was regressed.
    residual: Option<f64>,
    /// RMS residual that rounding and declared noise explain; 0 where that is not known.
    floor: f64,
    reached_floor: bool,
    /// Why it is not adequate, where the noise was estimated.
    #[serde(skip_serializing_if = "Option::is_none")]
    doubt: Option<&'static str>,
    /// Whether every subset of this size was looked at.
    proved: bool,
    /// The best subset of each size that was tried.
    path: Vec<Size>,
    /// Other sets of terms that the data cannot tell from these.
    ties: Vec<Vec<String>>,
}

/// One term of an equation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Summand {
    term: String,
    coefficient: f64,
    /// `null` where it is not known, or where nothing was fitted.
    standard_error: Option<f64>,
    /// Whether it is a part of the equation that was known.
    #[serde(skip_serializing_if = "std::ops::Not::not", default)]
    pub(crate) known: bool,
}

/// A parameter inside a term.
#[derive(Debug, Serialize)]
struct Inside {
    term: String,
    value: f64,
    /// `null` where the data do not determine it.
    standard_error: Option<f64>,
}

/// Significant digits of `value` that go as far as two digits of its error.
fn digits(value: f64, standard_error: Option<f64>) -> usize {
    let known = |error: f64| (value.abs().log10().floor() - error.log10().floor() + 2.0).clamp(2.0, 15.0);
    standard_error.filter(|e| *e > 0.0).map_or(9, |error| known(error) as usize)
}

/// Multiple of the smallest residual that the sensors explain, up to which one is explained.
const FLOOR_FACTOR: f64 = 2.0;

/// The best subset of one size.
#[derive(Debug, Serialize)]
struct Size {
    terms: Vec<String>,
    residual: f64,
    /// Akaike's criterion, N ln residual² + 2 k for k terms and N steps; smaller is better.
    aic: Option<f64>,
    /// Schwarz's criterion, N ln residual² + k ln N.
    bic: Option<f64>,
    proved: bool,
}

impl Equation {
    /// Equation `i` of `found`, for a state measured in `unit`; `judged` if its floor is all that sensors explain.
    pub(super) fn new(found: &Identified, i: usize, unit: &str, judged: bool) -> Self {
        let (model, report) = (&found.model, &found.report);
        let equation: &EquationReport = &report.equations[i];
        let name = |&j: &usize| report.features[j].clone();
        let error = |at: usize| equation.standard_errors.get(at).copied().filter(|e| e.is_finite());
        let known = |at: usize| at + equation.n_known >= equation.support.len();
        let summand = |(at, (j, &coefficient)): (usize, (&usize, &f64))| Summand {
            term: name(j),
            coefficient,
            standard_error: error(at).filter(|_| !known(at)),
            known: known(at),
        };
        let inside = |parameter: &InsideParameter| Inside {
            term: name(&parameter.term),
            value: parameter.value,
            standard_error: Some(parameter.standard_error).filter(|e| e.is_finite()),
        };
        let criterion = |size: &SizeReport, price: f64| {
            let (rows, k) = (report.rows as f64, size.support.len() as f64);
            Some(2.0 * rows * size.residual.ln() + price * k).filter(|v| v.is_finite())
        };
        let size = |size: &SizeReport| Size {
            terms: size.support.iter().map(name).collect(),
            residual: size.residual,
            aic: criterion(size, 2.0),
            bic: criterion(size, (report.rows as f64).ln()),
            proved: size.proved,
        };
        let in_motion = equation.floor > 0.0 && matches!(model.form(), Form::Continuous(_) | Form::SemiImplicit);
        let declared = in_motion && model.kinematic()[i];
        Self {
            state: equation.state.clone(),
            equation: model.equations()[i].clone(),
            declared,
            rows: report.rows,
            unit: if model.form() == Form::Discrete { unit.to_owned() } else { per_second(unit) },
            terms: equation.support.iter().zip(&equation.coefficients).enumerate().map(summand).collect(),
            parameters: equation.parameters.iter().map(inside).collect(),
            residual: (!declared).then_some(equation.residual),
            floor: if judged { equation.floor } else { 0.0 },
            reached_floor: judged && equation.reached_floor,
            doubt: equation.doubt.map(told),
            proved: equation.proved,
            path: equation.path.iter().map(size).collect(),
            ties: equation.ties.iter().map(|tie| tie.iter().map(name).collect()).collect(),
        }
    }

    pub(super) fn text(&self) -> &str {
        &self.equation
    }

    /// Whether the residual is no more than the sensors explain; `None` where that is not known.
    pub(super) fn is_explained(&self) -> Option<bool> {
        (self.floor > 0.0 || self.reached_floor).then_some(self.reached_floor)
    }

    /// Coefficients with their errors, and the residual, which is compared with what `sensors` do.
    pub(super) fn table(&self, sensors: &str) -> String {
        let Some(residual) = self.residual else { return self.declaration() };
        let mut text = self.coefficients();
        let residual = self.quantity(residual);
        let verdict = match (self.reached_floor, self.floor > 0.0) {
            (true, _) if sensors == ESTIMATED => "white noise".into(),
            (false, _) if sensors == ESTIMATED => self.doubt.unwrap_or_default().into(),
            (true, _) => format!("as small as {sensors} explains ({})", significant(self.floor, 2)),
            (false, true) if self.terms.len() >= self.rows => "as many terms as steps leave nothing to judge by".into(),
            (false, true) if self.has_rivals() => {
                format!("as small as {sensors} explains, but other terms explain the data as well")
            }
            (false, true) => {
                let floor = significant(self.floor, 2);
                format!("above what {sensors} explains ({floor}): noise, or a term that is missing")
            }
            (false, false) => "what the sensors explain is not known for this target".into(),
        };
        let search = if self.proved || self.path.is_empty() || sensors == ESTIMATED {
            ""
        } else {
            "; not every subset of this size was tried"
        };
        let _ = writeln!(text, "  residual {residual}: {verdict}{search}");
        if !self.ties.is_empty() {
            let ties: Vec<String> = self.ties.iter().map(|tie| tie.join(", ")).collect();
            let _ = writeln!(text, "  the data cannot tell these terms from: {}", ties.join("; or "));
        }
        text
    }

    /// Why this equation is not all there is, in a few words; `None` if it is, or if that is not known.
    pub(super) fn excess(&self, sensors: &str) -> Option<String> {
        let residual = self.residual.filter(|_| self.is_explained() == Some(false))?;
        let (state, residual, floor) = (&self.state, self.quantity(residual), significant(self.floor, 2));
        if self.terms.len() >= self.rows {
            let (terms, rows) = (self.terms.len(), self.rows);
            return Some(format!(
                "the equation of {state} has {terms} terms for {rows} steps, which leave nothing to judge by"
            ));
        }
        if self.has_rivals() {
            return Some(format!("other terms explain the data on {state} as well"));
        }
        if sensors == ESTIMATED {
            return Some(format!("the equation of {state} leaves {residual} RMS, {}", self.doubt.unwrap_or_default()));
        }
        Some(format!("the equation of {state} leaves {residual} RMS where {sensors} explains {floor}"))
    }

    /// Whether nothing speaks against the equation but others that explain the data down to rounding too.
    fn has_rivals(&self) -> bool {
        self.doubt.is_none() && !self.ties.is_empty() && self.residual.is_some_and(|r| r <= FLOOR_FACTOR * self.floor)
    }

    fn quantity(&self, value: f64) -> String {
        format!("{} {}", significant(value, 2), self.unit).trim_end().to_owned()
    }

    fn left(&self) -> &str {
        self.equation.split(" = ").next().unwrap_or(&self.state)
    }

    fn declaration(&self) -> String {
        let rate = self.terms.first().map_or("", |summand| summand.term.as_str());
        format!("  {}   is {rate}, as declared\n", self.left())
    }

    fn coefficients(&self) -> String {
        let lines = self.terms.iter().map(|summand| {
            let error = match summand.standard_error {
                Some(error) => significant(error, 2),
                None if summand.known => "as given".into(),
                None => "not known".into(),
            };
            [
                summand.term.clone(),
                significant(summand.coefficient, digits(summand.coefficient, summand.standard_error)),
                error,
            ]
        });
        let inside = self.parameters.iter().map(|inside| {
            let error = inside.standard_error.map_or_else(|| "not known".into(), |error| significant(error, 2));
            let value = significant(inside.value, digits(inside.value, inside.standard_error));
            [format!("inside {}", inside.term), value, error]
        });
        let lines = lines.chain(inside);
        let heading = [self.left().to_owned(), "coefficient".into(), "standard error".into()];
        let lines: Vec<[String; 3]> = std::iter::once(heading).chain(lines).collect();
        let width = |i: usize| lines.iter().map(|line| columns_of(&line[i])).max().unwrap_or(0);
        let (first, second) = (width(0), width(1));
        let pad = |text: &str, width: usize| " ".repeat(width.saturating_sub(columns_of(text)));
        let mut text = String::new();
        for [term, coefficient, error] in &lines {
            let (a, b) = (pad(term, first), pad(coefficient, second));
            let _ = writeln!(text, "  {term}{a}   {coefficient}{b}   {error}");
        }
        text
    }
}

/// Why an equation is not adequate although the noise is estimated: what to say of its residual.
fn told(doubt: Doubt) -> &'static str {
    match doubt {
        Doubt::TooFewSamples => "of fewer than three samples a term, which leave nothing to judge by",
        Doubt::Correlated => {
            "correlated from sample to sample: a term is missing or approximated, or a state is not measured"
        }
        Doubt::OtherTerms => "but other terms explain the data as well",
        Doubt::Inconstant => {
            "but the first and the second half of the data want other coefficients: a term is missing or approximated"
        }
        Doubt::Unfinished => "but the search for terms ended before it had tried all that it would",
        Doubt::Cancelling => "but its terms cancel to less than a thousandth of themselves: they approximate others",
        Doubt::Large => "ten times what the smoothness of the signal allows: a term is missing or approximated",
        _ => "more than rounding, and no other error was allowed",
    }
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

    fn equation() -> Equation {
        let summand = |term: &str, coefficient, standard_error| Summand {
            term: term.into(),
            coefficient,
            standard_error,
            known: false,
        };
        Equation {
            state: "w".into(),
            equation: "w\u{307} = 15 sin th − 0.1 w".into(),
            declared: false,
            rows: 100,
            unit: "rad/s²".into(),
            parameters: vec![],
            terms: vec![summand("sin th", 15.000_000_213, Some(1.234e-7)), summand("w", -0.1, None)],
            residual: Some(1.26e-6),
            floor: 2e-6,
            reached_floor: true,
            doubt: None,
            proved: false,
            path: vec![Size { terms: vec![], residual: 1.0, aic: None, bic: None, proved: true }],
            ties: vec![],
        }
    }

    #[test]
    fn a_table_lines_up_and_says_what_speaks_for_it() {
        let expected = "\
\u{20} w\u{307}        coefficient   standard error
\u{20} sin th   15.00000021   1.2e-7
\u{20} w        -0.1          not known
\u{20} residual 1.3e-6 rad/s²: as small as rounding explains (2e-6); not every subset of this size was tried
";
        assert_eq!(equation().table("rounding"), expected);
    }

    #[test]
    fn ties_are_told() {
        let ties = vec![vec!["th".into(), "w".into()], vec!["sin 2 th".into()]];
        let table = Equation { ties, ..equation() }.table("rounding");
        assert!(table.ends_with("  the data cannot tell these terms from: th, w; or sin 2 th\n"), "{table}");
    }

    #[test]
    fn what_is_left_over_is_told_with_its_unit() {
        let missed = Equation { residual: Some(0.12), reached_floor: false, ..equation() };
        assert_eq!(missed.is_explained(), Some(false));
        let says = "the equation of w leaves 0.12 rad/s² RMS where rounding explains 2e-6";
        assert_eq!(missed.excess("rounding").as_deref(), Some(says));
        assert!(missed.table("rounding").contains("above what rounding explains (2e-6): noise, or a term"));
        let crowded = Equation { rows: 2, ..missed };
        let says = "the equation of w has 2 terms for 2 steps, which leave nothing to judge by";
        assert_eq!(crowded.excess("rounding").as_deref(), Some(says));
        let unknown = Equation { floor: 0.0, ..crowded };
        assert_eq!(unknown.is_explained(), None);
    }
}
