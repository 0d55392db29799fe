//! Equations and coefficients.

use sindyna_envs::System;
use sindyna_record::identification::{Account, Equation};
use sindyna_sindy::Model;

use super::mathml;
use super::most::{MOST_ROWS, MOST_STATES};
use crate::document::Block;
use crate::equations::true_coefficients;
use crate::numbers::{NONE, or_none, plural, rough, significant};

/// Terms of a model that are set as mathematics; of more the text is enough.
const MOST_TERMS: usize = 150;

/// Equally good models that are listed.
const MOST_EQUAL: usize = 3;

/// The equations.
pub(super) fn equations(model: &Model, account: Option<&Account>) -> Vec<Block> {
    let terms: usize = (0..model.states().len()).map(|i| model.coefficients(i).len()).sum();
    let text = model.equations().join("\n");
    let mut blocks = vec![Block::Section("Equations".into())];
    blocks.push(if terms <= MOST_TERMS {
        Block::Markup { html: mathml::equations(model, account), text }
    } else {
        Block::Code(text.chars().take(40_000).collect())
    });
    if let Some(account) = account {
        blocks.push(Block::text(format!("Model: {}.", account.stepping)));
        for offset in &account.offsets {
            let zero = mathml::rounded(-offset.offset, 1e-5).0;
            blocks.push(Block::text(format!("The zero of {} is at {zero}.", offset.state)));
        }
        let inside = account.equations.iter().flat_map(|e| &e.parameters).take(MOST_ROWS);
        let inside: Vec<[String; 3]> = inside
            .map(|p| {
                let (value, error) = value_and_error(p.value, p.standard_error);
                [p.term.clone(), value, error]
            })
            .collect();
        if !inside.is_empty() {
            blocks.push(Block::table(1, ["term with a parameter inside", "parameter", "standard error"], inside));
        }
    }
    blocks
}

fn value_and_error(value: f64, error: Option<f64>) -> (String, String) {
    let error = error.filter(|e| *e > 0.0);
    error.map_or_else(
        || (sindyna_core::number::coefficient(value), NONE.into()),
        |error| {
            if error > mathml::SHOWN * value.abs() {
                mathml::rounded(value, error)
            } else {
                (sindyna_core::number::coefficient(value), rough(error))
            }
        },
    )
}

/// Coefficients with their standard errors, and beside the true ones where `system` is known and the terms are true.
pub(super) fn coefficients(account: Option<&Account>, model: &Model, system: Option<&System>) -> Vec<Block> {
    let truth = system.and_then(|system| true_coefficients(system, model));
    let mut blocks = vec![Block::Section("Coefficients".into())];
    if let Some(truth) = truth {
        let errors = |equation: usize, found: f64| {
            let near = |v: f64| (v - found).abs() <= 1e-9 * found.abs();
            account?.equations.get(equation)?.terms.iter().find(|t| near(t.coefficient))?.standard_error
        };
        let row = |s: &crate::equations::Summand| {
            let (value, error) = value_and_error(s.found, errors(s.equation, s.found));
            let state = &model.states()[s.equation];
            let truth = sindyna_core::number::coefficient(s.truth);
            [state.clone(), s.term.clone(), value, error, truth, rough(s.relative_error())]
        };
        let head = ["equation", "term", "identified", "standard error", "true", "relative error"];
        blocks.push(Block::table(2, head, truth.iter().take(MOST_ROWS).map(row).collect()));
        return blocks;
    }
    if system.is_some() {
        blocks.push(Block::text(
            "The terms are not exactly those of the true equations, so coefficients are not compared.",
        ));
    }
    let Some(account) = account else { return if system.is_some() { blocks } else { Vec::new() } };
    let all = account.equations.iter().flat_map(|e| e.terms.iter().map(move |term| (e, term)));
    let total = all.clone().count();
    let rows = all.take(MOST_ROWS).map(|(equation, term)| {
        let (value, error) = value_and_error(term.coefficient, term.standard_error);
        let error = if term.known || equation.declared { "known".into() } else { error };
        [equation.state.clone(), term.term.clone(), value, error]
    });
    blocks.push(Block::table(2, ["equation", "term", "coefficient", "standard error"], rows.collect()));
    if total > MOST_ROWS {
        blocks.push(Block::text(format!("The first {MOST_ROWS} of {total} coefficients; all are in identify.json.")));
    }
    blocks
}

/// Models that the data do not distinguish from these.
pub(super) fn equally_good(account: &Account) -> Vec<Block> {
    let of = |equation: &Equation| {
        let row =
            |other: &Vec<String>| [equation.state.clone(), other.join(", ").chars().take(300).collect::<String>()];
        equation.equally_good.iter().take(MOST_EQUAL).map(row).collect::<Vec<_>>()
    };
    let rows: Vec<[String; 2]> = account.equations.iter().flat_map(of).take(MOST_ROWS).collect();
    if rows.is_empty() {
        return Vec::new();
    }
    let total: usize = account.equations.iter().map(|e| e.equally_good.len()).sum();
    vec![
        Block::Section("Equally good models".into()),
        Block::text(format!(
            "Besides the chosen terms, the data are explained equally well by {}.",
            plural(total, "other model")
        )),
        Block::table(2, ["equation", "terms"], rows),
    ]
}

/// Residuals against the number of terms.
pub(super) fn sizes(account: &Account) -> Vec<Block> {
    let (mut figures, mut rows) = (Vec::new(), Vec::new());
    for equation in account.equations.iter().filter(|e| e.path.len() > 1).take(MOST_STATES) {
        let label = if equation.floor > 0.0 { "residual / noise floor" } else { "residual" };
        let chosen = equation.terms.iter().filter(|t| !t.known).count();
        let sizes: Vec<(usize, f64)> = equation.path.iter().take(60).map(|s| (s.terms.len(), s.residual)).collect();
        figures.push(crate::figure::plots::sizes(&equation.state, label, &sizes, chosen));
        for size in equation.path.iter().take(24) {
            let mark = if size.terms.len() == chosen { "chosen" } else { "" };
            rows.push([
                equation.state.clone(),
                mark.into(),
                size.terms.len().to_string(),
                significant(size.residual, 3),
                or_none(size.aic.map(|v| crate::numbers::fixed(v, 1))),
                or_none(size.bic.map(|v| crate::numbers::fixed(v, 1))),
            ]);
        }
    }
    if figures.is_empty() {
        return Vec::new();
    }
    vec![
        Block::Section("Accuracy against size".into()),
        Block::Figures(figures),
        Block::table(2, ["equation", "", "terms", "residual", "AIC", "BIC"], rows),
    ]
}
