//! What is to be known of equations whose noise was estimated, though it is no doubt of any of them.

use sindyna_core::number::significant;

use super::feature::feature;
use crate::Expr;
use crate::estimate::Estimate;

/// Part of a state's spread beyond which what is not smooth in it may as well be motion.
const COARSE: f64 = 0.3;

/// Warnings of terms that are the same as others on all data.
fn same_on_data(names: &[String], found: &Estimate) -> Vec<String> {
    let told = |(own, other): &(usize, usize)| {
        let (own, other) = (feature(&found.terms[*own], names), feature(&found.terms[*other], names));
        format!(
            "`{own}` and `{other}` are proportional on all data, so the data do not determine which of them the equations contain"
        )
    };
    found.twins.iter().map(told).collect()
}

/// Difference from 1 of the factor of a rate with an offset.
const CLOSE: f64 = 0.05;

/// Standard errors that an offset is at least.
const SIGNIFICANT: f64 = 5.0;

/// Warnings of states that change by another one but for a constant: that one is measured with an offset, and terms of it approximate others.
fn offset_rates(names: &[String], found: &Estimate) -> Vec<String> {
    let n_states = found.fits.len();
    let offset = |i: usize| {
        let (fit, errors) = (&found.fits[i], &found.errors[i]);
        let at = |wanted: &dyn Fn(&Expr) -> bool| fit.support.iter().position(|&j| wanted(&found.terms[j].expr));
        let (one, rate) = (at(&Expr::is_one)?, at(&|e| matches!(e, Expr::Variable(v) if *v < n_states && *v != i))?);
        let (constant, factor) = (fit.coefficients[one], fit.coefficients[rate]);
        let told = fit.support.len() == 2
            && (factor - 1.0).abs() < CLOSE
            && constant.abs() > SIGNIFICANT * errors.get(one).copied().unwrap_or(f64::INFINITY);
        let (state, rate) = (&names[i], feature(&found.terms[fit.support[rate]], names));
        told.then(|| {
            format!(
                "the rate of `{state}` is `{rate}` up to an offset of {}: if the sensor of `{rate}` has this offset, terms with `{rate}` \
                 in other equations are approximations",
                significant(constant, 5)
            )
        })
    };
    (0..n_states).filter_map(offset).collect()
}

/// Warnings of states with unsettled equations that change too much from sample to sample for their noise to be told.
fn too_coarse(names: &[String], found: &Estimate) -> Vec<String> {
    let coarse = |i: &usize| {
        // 1 − fit is what is left as a part of the spread.
        let spread = found.sigma[*i] / (1.0 - found.fit[*i]);
        found.measured[*i] && found.doubts[*i].is_some() && found.signal_noise[*i] > COARSE * spread
    };
    let told = |i: usize| {
        format!(
            "the state `{}` changes so much between samples that its noise cannot be distinguished from its motion: \
             sample faster, or measure its inputs",
            names[i]
        )
    };
    (0..found.fits.len()).filter(coarse).map(told).collect()
}

/// Warnings of inputs whose rounding the states tell.
fn rounded_inputs(names: &[String], found: &Estimate) -> Vec<String> {
    let told = |(input, step): &(usize, f64)| {
        format!(
            "the input `{}` is taken as rounded: errors of up to {}, half its last recorded digit, explain the residuals and are estimated with the equations",
            names[found.fits.len() + input],
            significant(step / 2.0, 2)
        )
    };
    found.corrections.iter().map(told).collect()
}

/// Warnings of coefficients whose declared sign the data contradict.
fn wrong_signs(names: &[String], found: &Estimate) -> Vec<String> {
    let told = |i: usize, (term, coefficient): &(usize, f64)| {
        format!(
            "the data contradict the declared sign of `{}` in the equation of `{}`: without it the coefficient is about {}",
            feature(&found.terms[*term], names),
            names[i],
            significant(*coefficient, 3)
        )
    };
    let of = |(i, terms): (usize, &Vec<(usize, f64)>)| terms.iter().map(|term| told(i, term)).collect::<Vec<_>>();
    found.contradicted.iter().enumerate().flat_map(of).collect()
}

/// Warnings of inputs that are in no equation.
fn without_effect(names: &[String], found: &Estimate) -> Vec<String> {
    let is_used = |input: usize| {
        let contains = |&term: &usize| found.terms[term].expr.has(input);
        found.fits.iter().flat_map(|fit| &fit.support).any(contains)
    };
    let told = |input: usize| {
        format!("no equation contains the input `{}`: it has no effect, or none that these data show", names[input])
    };
    (found.fits.len()..names.len()).filter(|input| !is_used(*input)).map(told).collect()
}

/// All of them.
pub(super) fn of(names: &[String], found: &Estimate) -> Vec<String> {
    [too_coarse, rounded_inputs, same_on_data, offset_rates, wrong_signs, without_effect]
        .map(|told| told(names, found))
        .concat()
}
