//! One equation of an account.

use serde::{Deserialize, Serialize};
use sindyna_sindy::{Doubt, EquationReport, Form, Identified, InsideParameter, SizeReport};

/// Multiple of the smallest residual that the measurement errors explain, up to which one is explained.
const FLOOR_FACTOR: f64 = 2.0;

/// One equation: its coefficients, and what speaks for and against it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Equation {
    /// The state whose rate (or next value) it gives.
    pub state: String,
    /// The equation as text.
    pub equation: String,
    /// Whether it only says which state is the rate of this one, which was declared and not fitted.
    pub declared: bool,
    /// Unit of the left-hand side, as far as it is known.
    pub unit: String,
    /// Its terms with their coefficients.
    pub terms: Vec<Summand>,
    /// Parameters inside the terms, such as c of tanh(v/c).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parameters: Vec<InsideTerm>,
    /// RMS residual, in that unit; `null` for a declared rate, of which nothing was regressed.
    pub residual: Option<f64>,
    /// RMS residual that rounding and declared noise explain; 0 where that is not known.
    pub floor: f64,
    /// Whether the residual is at most twice the floor, or white where the noise was estimated.
    pub reached_floor: bool,
    /// Why it is not adequate, where the noise was estimated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub doubt: Option<String>,
    /// Whether every subset of this size was looked at.
    pub proved: bool,
    /// The best subset of each size that was tried.
    pub path: Vec<SubsetOfSize>,
    /// Other sets of terms that the data do not distinguish from these.
    #[serde(alias = "ties")]
    pub equally_good: Vec<Vec<String>>,
}

/// One term of an equation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Summand {
    /// The term as text.
    pub term: String,
    /// Its coefficient.
    pub coefficient: f64,
    /// `null` where it is not known, or where nothing was fitted.
    pub standard_error: Option<f64>,
    /// Whether it is a part of the equation that was known.
    #[serde(skip_serializing_if = "std::ops::Not::not", default)]
    pub known: bool,
}

/// A parameter inside a term.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct InsideTerm {
    /// The term as text.
    pub term: String,
    /// Value of the parameter.
    pub value: f64,
    /// `null` where the data do not determine it.
    pub standard_error: Option<f64>,
}

/// The best subset of one size.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SubsetOfSize {
    /// Its terms.
    pub terms: Vec<String>,
    /// RMS residual.
    pub residual: f64,
    /// Akaike's criterion, N ln residual² + 2 k for k terms and N steps; smaller is better.
    pub aic: Option<f64>,
    /// Schwarz's criterion, N ln residual² + k ln N.
    pub bic: Option<f64>,
    /// Whether every subset of this size was looked at.
    pub proved: bool,
}

impl Equation {
    /// Equation `i` of `found`, for a state measured in `unit`; `judged` if its floor is all that sensors explain.
    pub(crate) fn new(found: &Identified, i: usize, unit: &str, judged: bool) -> Self {
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
        let inside = |parameter: &InsideParameter| InsideTerm {
            term: name(&parameter.term),
            value: parameter.value,
            standard_error: Some(parameter.standard_error).filter(|e| e.is_finite()),
        };
        let criterion = |size: &SizeReport, price: f64| {
            let (rows, k) = (report.rows as f64, size.support.len() as f64);
            Some(2.0 * rows * size.residual.ln() + price * k).filter(|v| v.is_finite())
        };
        let size = |size: &SizeReport| SubsetOfSize {
            terms: size.support.iter().map(name).collect(),
            residual: size.residual,
            aic: criterion(size, 2.0),
            bic: criterion(size, (report.rows as f64).ln()),
            proved: size.proved,
        };
        let in_motion = equation.floor > 0.0 && matches!(model.form(), Form::Continuous(_) | Form::SemiImplicit { .. });
        let declared = in_motion && model.kinematic()[i];
        Self {
            state: equation.state.clone(),
            equation: model.equations()[i].clone(),
            declared,
            unit: if model.form() == Form::Discrete { unit.to_owned() } else { per_second(unit) },
            terms: equation.support.iter().zip(&equation.coefficients).enumerate().map(summand).collect(),
            parameters: equation.parameters.iter().map(inside).collect(),
            residual: (!declared).then_some(equation.residual),
            floor: if judged { equation.floor } else { 0.0 },
            reached_floor: judged && equation.reached_floor,
            doubt: equation.doubt.map(|doubt| told(doubt).to_owned()),
            proved: equation.proved,
            path: equation.path.iter().map(size).collect(),
            equally_good: equation.equally_good.iter().map(|other| other.iter().map(name).collect()).collect(),
        }
    }

    /// Whether the residual is no more than the measurement errors explain; `None` where that is not known.
    #[must_use]
    pub fn is_explained(&self) -> Option<bool> {
        (self.floor > 0.0 || self.reached_floor).then_some(self.reached_floor)
    }

    /// Whether nothing speaks against the equation but others that explain the data down to rounding too.
    #[must_use]
    pub fn is_ambiguous(&self) -> bool {
        let others = |doubt: &str| doubt == told(Doubt::OtherTerms);
        self.doubt.as_deref().is_none_or(others)
            && !self.equally_good.is_empty()
            && self.residual.is_some_and(|r| r <= FLOOR_FACTOR * self.floor)
    }
}

impl Equation {
    /// Whether other terms were found that explain the data as well.
    #[must_use]
    pub fn has_known_rivals(&self) -> bool {
        self.is_ambiguous() || self.doubt.as_deref() == Some(told(Doubt::OtherTerms))
    }

    /// Whether the data do not determine one of its coefficients.
    #[must_use]
    pub fn is_undetermined(&self) -> bool {
        self.doubt.as_deref() == Some(told(Doubt::Undetermined))
    }

    /// Whether another lag of the inputs was found that explains the data as well.
    #[must_use]
    pub fn has_other_lag(&self) -> bool {
        self.doubt.as_deref() == Some(told(Doubt::OtherLag))
    }

    /// Whether nothing speaks against the equation but other terms that explain the data as well, or may do.
    pub(super) fn has_rivals(&self) -> bool {
        let of_rivals = [Doubt::OtherTerms, Doubt::Unfinished, Doubt::OtherLag, Doubt::Undetermined].map(told);
        self.is_ambiguous() || self.doubt.as_deref().is_some_and(|doubt| of_rivals.contains(&doubt))
    }
}

/// Why an equation is not adequate although the noise is estimated: what to say of its residual.
fn told(doubt: Doubt) -> &'static str {
    match doubt {
        Doubt::TooFewSamples => "of fewer than three samples per term, so the fit cannot be assessed",
        Doubt::Correlated => {
            "correlated from sample to sample: a term is missing or approximated, or a state is not measured"
        }
        Doubt::OtherTerms => "but other sets of terms fit equally well",
        Doubt::NotHeld => "but smaller with inputs that are linear between samples (first-order hold)",
        Doubt::Inconstant => {
            "but the coefficients differ between the halves of the data: a term is missing or approximated"
        }
        Doubt::Unfinished => "but the search for terms reached its limit of operations",
        Doubt::Series => {
            "but correlated, and the last terms explain little of it: they approximate others, as a series does"
        }
        Doubt::Asymmetric => "but the coupling to another joint is not symmetric, as that of masses is",
        Doubt::Cancelling => "but its terms cancel to less than a thousandth of their size: they approximate others",
        Doubt::Still => {
            "but a state among its terms does not move by more than its noise: leave it out, or measure it better"
        }
        Doubt::NoMotion => "but no equation has a term: no candidate term explains more than noise",
        Doubt::Large => {
            "ten times the noise that the smoothness of the signal allows: a term is missing or approximated"
        }
        Doubt::Undetermined => {
            "but the data do not determine one of its coefficients, which is less than two standard errors"
        }
        Doubt::OtherLag => "but another lag of the inputs fits equally well",
        Doubt::Disturbed => "correlated in most segments of the log: the system is disturbed, or a term is missing",
        _ => "above the level of rounding, and no other error was declared",
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
}
