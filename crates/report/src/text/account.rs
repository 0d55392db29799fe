//! An account of an identification, for people.

use std::fmt::Write as _;

use sindyna_core::Certainty;
use sindyna_core::number::{fixed, significant};
use sindyna_record::identification::{
    Account, Equation, FreeRun, HeldOut, NoiseSource, Offset, StateNoise, StateQuality,
};

use super::aligned;
use crate::numbers::measures as shown;

/// What the residuals of equations are compared with where the noise was estimated.
const ESTIMATED: &str = "the estimated noise";

/// Equally good sets of terms that are listed.
const MOST_EQUAL: usize = 5;

/// What was held out, and how well it is predicted.
fn held_out_lines(held_out: &HeldOut, width: usize) -> String {
    let of = if held_out.logs.is_empty() { String::new() } else { format!(" of {}", held_out.logs.join(", ")) };
    let mut text = format!("\nheld out: {} steps{of}\n", held_out.steps);
    let head = ["prediction of", "over", "windows", "RMSE", "median", "fit [%]"].map(String::from);
    let number = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |v| significant(v, 3));
    let row = |ahead: &FreeRun, i: usize| {
        let (state, fit) = &ahead.fit_percent[i];
        let of = |list: &[(String, Option<f64>)]| number(list.get(i).and_then(|(_, value)| *value));
        let fit = fit.map_or_else(|| "–".to_owned(), |fit| fixed(fit, 1));
        [state.clone(), horizon(ahead), ahead.windows.to_string(), of(&ahead.rmse), of(&ahead.median_rmse), fit]
    };
    let states = held_out.predictions.first().map_or(0, |ahead| ahead.fit_percent.len());
    let rows = (0..states).flat_map(|i| held_out.predictions.iter().map(move |ahead| row(ahead, i)));
    let rows: Vec<[String; 6]> = std::iter::once(head).chain(rows).collect();
    text += aligned(&rows, width).trim_end();
    for ahead in held_out.predictions.iter().filter(|ahead| ahead.diverged > 0) {
        let _ = write!(text, "\n{}", diverged(ahead));
    }
    if let Some(failed) = &held_out.failed {
        let _ = write!(text, "\n  no further predictions: {failed}");
    }
    text
}

/// Why a free run may leave the data.
const FREE_RUN: &str = "free run: simulated from the first sample alone; that of a chaotic or unstable system diverges from the data even with exact equations\n";

/// How far `ahead` goes.
pub(crate) fn horizon(ahead: &FreeRun) -> String {
    match (ahead.seconds, ahead.horizon) {
        (Some(seconds), _) => format!("{} s", significant(seconds, 3)),
        (None, Some(1)) => "1 step".to_owned(),
        (None, Some(steps)) => format!("{steps} steps"),
        (None, None) => "free run".to_owned(),
    }
}

/// That the model diverges in windows of `ahead`.
pub(crate) fn diverged(ahead: &FreeRun) -> String {
    let first = ahead.first_diverged.map_or_else(String::new, |(trajectory, at)| {
        format!(", the first from {} s on in trajectory {trajectory}", significant(at, 4))
    });
    let (count, over) = (ahead.diverged, horizon(ahead));
    format!("the model diverges in {count} of {} windows of {over}{first}", ahead.windows)
        .replace("windows of free run", "free runs")
}

/// How well the samples are predicted that the equations were fitted to.
fn quality(account: &Account, width: usize) -> String {
    if account.quality.is_empty() {
        return String::new();
    }
    let head =
        ["prediction of", "RMSE, one step", "R²", "fit [%]", "RMSE, free run", "R²", "fit [%]"].map(String::from);
    let row = |state: &StateQuality| {
        let [rmse, r2, fit] = shown(Some(&state.one_step));
        let [free_rmse, free_r2, free_fit] = shown(state.free_run.as_ref());
        [state.state.clone(), rmse, r2, fit, free_rmse, free_r2, free_fit]
    };
    let rows: Vec<[String; 7]> = std::iter::once(head).chain(account.quality.iter().map(row)).collect();
    let free = account.quality.iter().any(|state| state.free_run.is_some());
    let free = if free { FREE_RUN } else { "" };
    "\n\n".to_owned() + aligned(&rows, width).trim_end() + "\n" + free
}

/// What is claimed of all equations together.
fn claim(account: &Account) -> &'static str {
    match (account.certainty(), account.noise) {
        (Some(Certainty::Doubted), _) => "an approximation, ",
        (Some(Certainty::Ambiguous), _) if account.equations.iter().any(Equation::has_other_lag) => {
            "ambiguous (another lag of the inputs fits equally well), "
        }
        (Some(Certainty::Ambiguous), _) if account.equations.iter().any(Equation::has_known_rivals) => {
            "ambiguous (other sets of terms fit equally well), "
        }
        (Some(Certainty::Ambiguous), _) if account.equations.iter().any(Equation::is_undetermined) => {
            "ambiguous (the data do not determine one of the coefficients), "
        }
        (Some(Certainty::Ambiguous), _) => "ambiguous (other sets of terms may fit equally well: not all were tried), ",
        (Some(_), NoiseSource::Estimated) => "adequate among the candidate terms, ",
        _ => "",
    }
}

/// The equations, each with its terms, and what speaks for them; tables take `width` columns at most.
#[must_use]
pub fn text(account: &Account, width: usize) -> String {
    let mut text = format!("equations: {}{}\n", claim(account), account.stepping);
    for equation in &account.equations {
        let _ = writeln!(text, "  {}", equation.equation);
    }
    text += &offset_lines(account);
    for warning in &account.warnings {
        let _ = writeln!(text, "warning: {warning}");
    }
    for equation in &account.equations {
        text.push('\n');
        text.push_str(&table(account, equation, width));
    }
    let _ = write!(text, "\nsteps used: {}", steps(account));
    let condition = match account.condition {
        Some(condition) => significant(condition, 2),
        None => "infinite (fewer steps than terms)".into(),
    };
    if !account.noise_deviations.is_empty() {
        let sigma = |d: &StateNoise| {
            let grows = if d.growing > 0.0 { ", growing with it" } else { "" };
            let sigma = format!("{} {} {}", d.state, significant(d.sigma, 2), d.unit);
            let sigma = sigma.trim_end().to_owned() + grows;
            d.fit_percent.map_or_else(|| sigma.clone(), |fit| format!("{sigma} (fit {} %)", fixed(fit, 1)))
        };
        let all: Vec<String> = account.noise_deviations.iter().map(sigma).collect();
        let _ = write!(text, "\nnoise, estimated: {}", all.join(", "));
    }
    if !account.unmeasured.is_empty() {
        let _ = write!(text, "\nnot measured: {}, estimated with the equations", account.unmeasured.join(", "));
    }
    text += &quality(account, width);
    text += &account.held_out.as_ref().map_or_else(String::new, |held_out| held_out_lines(held_out, width));
    if !account.search_complete {
        text += "\nthe search for terms reached its limit of operations and is incomplete; use fewer rows or states, or fix terms by --require and --forbid";
    }
    let _ = writeln!(text, "\ncandidate terms: {}; condition number: {condition}", account.features.len());
    text
}

/// How the equations are stepped, and whether they are all there is: lines below them.
#[must_use]
pub fn verdict(account: &Account) -> String {
    let mut text = format!("{}\n", account.stepping);
    text += &offset_lines(account);
    for warning in &account.warnings {
        let _ = writeln!(text, "warning: {warning}");
    }
    if account.rows_at_limit + account.rows_astray > 0 {
        let _ = writeln!(text, "steps used: {}", steps(account));
    }
    if account.explained == Some(true) {
        let used = if account.rows_astray > 0 { " of the steps used" } else { "" };
        let _ = writeln!(text, "all residuals{used} are at the level of {}", sensors(account));
    }
    let missed: Vec<String> = account.equations.iter().filter_map(|e| excess(account, e)).collect();
    for excess in &missed {
        let _ = writeln!(text, "not exact: {excess}");
    }
    if !missed.is_empty() {
        text += "more data (--real-steps, or a longer log), another --library or a --term may improve the fit\n";
    }
    text
}

/// How many steps were used, and how many were not.
fn steps(account: &Account) -> String {
    let left_out = |count: usize, why: &str| match count {
        0 => String::new(),
        _ => format!(", left out {why}: {count}"),
    };
    let (at_limit, astray) = (account.rows_at_limit, account.rows_astray);
    account.rows.to_string() + &left_out(at_limit, "at a limit") + &left_out(astray, "as outliers")
}

fn offset_lines(account: &Account) -> String {
    let line = |Offset { state, offset }: &Offset| {
        format!("angle offset: the zero of {state} is at {}\n", significant(-offset, 6))
    };
    account.offsets.iter().map(line).collect()
}

/// What is known to be wrong with what sensors say.
fn sensors(account: &Account) -> &'static str {
    match account.noise {
        NoiseSource::Estimated => ESTIMATED,
        NoiseSource::Declared => "noise",
        _ => "rounding",
    }
}

/// Coefficients with their errors, and the residual, which is compared with what the sensors explain.
fn table(account: &Account, equation: &Equation, width: usize) -> String {
    let sensors = sensors(account);
    let Some(residual) = equation.residual else { return declaration(equation) };
    let mut text = coefficients(equation, width);
    let residual = quantity(equation, residual);
    let verdict = match (equation.reached_floor, equation.floor > 0.0) {
        (true, _) if sensors == ESTIMATED => "white, consistent with noise".into(),
        (false, _) if sensors == ESTIMATED => equation.doubt.as_deref().unwrap_or_default().into(),
        (true, _) => format!("at the level of {sensors} ({})", significant(equation.floor, 2)),
        (false, true) if equation.terms.len() >= account.rows => {
            "as many terms as steps: no degrees of freedom are left to test it".into()
        }
        (false, true) if equation.is_ambiguous() => {
            format!("at the level of {sensors}, but other sets of terms fit equally well")
        }
        (false, true) => {
            let floor = significant(equation.floor, 2);
            match doubt_below(equation) {
                Some(doubt) => format!("at the level of {sensors} ({floor}), {doubt}"),
                None => format!("above the level of {sensors} ({floor}): noise, or a missing term"),
            }
        }
        (false, false) => "no noise floor is known for this target".into(),
    };
    let search = if equation.proved || equation.path.is_empty() || sensors == ESTIMATED {
        ""
    } else {
        "; the search did not cover all subsets of this size"
    };
    let of = if sensors == ESTIMATED { "residual (one step, divided by dt)" } else { "residual" };
    let _ = writeln!(text, "  {of} {residual} RMS: {verdict}{search}");
    if !equation.equally_good.is_empty() {
        let mut others: Vec<String> =
            equation.equally_good.iter().take(MOST_EQUAL).map(|other| other.join(", ")).collect();
        let more = equation.equally_good.len() - others.len();
        if more > 0 {
            others.push(format!("{more} more"));
        }
        let _ = writeln!(text, "  equally good sets of terms: {}", others.join("; or "));
    }
    text
}

/// Why this equation is not all there is, in a few words; `None` if it is, or if that is not known.
fn excess(account: &Account, equation: &Equation) -> Option<String> {
    let sensors = sensors(account);
    let residual = equation.residual.filter(|_| equation.is_explained() == Some(false))?;
    let (state, residual, floor) = (&equation.state, quantity(equation, residual), significant(equation.floor, 2));
    if equation.terms.len() >= account.rows {
        let (terms, rows) = (equation.terms.len(), account.rows);
        return Some(format!(
            "the equation of {state} has {terms} terms for {rows} steps: no degrees of freedom are left to test it"
        ));
    }
    if equation.is_ambiguous() {
        return Some(format!("other sets of terms fit {state} equally well"));
    }
    if sensors == ESTIMATED {
        return Some(format!(
            "the residual of the equation of {state} is {residual} RMS, {}",
            equation.doubt.as_deref().unwrap_or_default()
        ));
    }
    let level = match doubt_below(equation) {
        Some(doubt) => format!("at the level of {sensors} ({floor}), {doubt}"),
        None => format!("above the level of {sensors} ({floor})"),
    };
    Some(format!("the residual of the equation of {state} is {residual} RMS, {level}"))
}

/// What speaks against an equation whose residual is no larger than what the sensors explain.
fn doubt_below(equation: &Equation) -> Option<&str> {
    equation.doubt.as_deref().filter(|_| equation.residual.is_some_and(|residual| residual <= equation.floor))
}

fn quantity(equation: &Equation, value: f64) -> String {
    format!("{} {}", significant(value, 2), equation.unit).trim_end().to_owned()
}

fn left(equation: &Equation) -> &str {
    equation.equation.split(" = ").next().unwrap_or(&equation.state)
}

fn declaration(equation: &Equation) -> String {
    let rate = equation.terms.first().map_or("", |summand| summand.term.as_str());
    format!("  {}   is {rate}, not fitted\n", left(equation))
}

fn coefficients(equation: &Equation, width: usize) -> String {
    let lines = equation.terms.iter().map(|summand| {
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
    let inside = equation.parameters.iter().map(|inside| {
        let error = inside.standard_error.map_or_else(|| "not known".into(), |error| significant(error, 2));
        let value = significant(inside.value, digits(inside.value, inside.standard_error));
        [format!("inside {}", inside.term), value, error]
    });
    let lines = lines.chain(inside);
    let heading = [left(equation).to_owned(), "coefficient".into(), "standard error".into()];
    let lines: Vec<[String; 3]> = std::iter::once(heading).chain(lines).collect();
    aligned(&lines, width.saturating_sub(2)).lines().map(|line| format!("  {line}\n")).collect()
}

/// Significant digits of `value` that go as far as two digits of its error.
fn digits(value: f64, standard_error: Option<f64>) -> usize {
    let known = |error: f64| (value.abs().log10().floor() - error.log10().floor() + 2.0).clamp(2.0, 15.0);
    standard_error.filter(|e| *e > 0.0).map_or(9, |error| known(error) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::WIDTH;
    use sindyna_record::identification::{Stepping, SubsetOfSize, Summand};

    fn account(rows: usize) -> Account {
        Account {
            format: 1,
            rows,
            rows_at_limit: 0,
            rows_astray: 0,
            condition: None,
            features: vec![],
            stepping: Stepping { scheme: "euler".into(), substeps: 1, dt: 0.1 },
            offsets: vec![],
            explained: None,
            equations: vec![],
            noise: NoiseSource::Rounding,
            noise_deviations: vec![],
            unmeasured: vec![],
            search_complete: true,
            warnings: vec![],
            quality: vec![],
            held_out: None,
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
            unit: "rad/s²".into(),
            parameters: vec![],
            terms: vec![summand("sin th", 15.000_000_213, Some(1.234e-7)), summand("w", -0.1, None)],
            residual: Some(1.26e-6),
            floor: 2e-6,
            reached_floor: true,
            doubt: None,
            proved: false,
            path: vec![SubsetOfSize { terms: vec![], residual: 1.0, aic: None, bic: None, proved: true }],
            equally_good: vec![],
        }
    }

    #[test]
    fn a_table_lines_up_and_says_what_speaks_for_it() {
        let expected = "\
\u{20} w\u{307}        coefficient   standard error
\u{20} sin th   15.00000021   1.2e−7
\u{20} w        −0.1          not known
\u{20} residual 1.3e−6 rad/s² RMS: at the level of rounding (2e−6); the search did not cover all subsets of this size
";
        assert_eq!(table(&account(100), &equation(), WIDTH), expected);
    }

    #[test]
    fn equally_good_models_are_listed() {
        let equally_good = vec![vec!["th".into(), "w".into()], vec!["sin 2 th".into()]];
        let table = super::table(&account(100), &Equation { equally_good, ..equation() }, WIDTH);
        assert!(table.ends_with("  equally good sets of terms: th, w; or sin 2 th\n"), "{table}");
        let equally_good: Vec<Vec<String>> = (0..9).map(|i| vec![format!("th^{i}")]).collect();
        let table = super::table(&account(100), &Equation { equally_good, ..equation() }, WIDTH);
        assert!(table.ends_with("; or th^4; or 4 more\n"), "{table}");
    }

    #[test]
    fn what_is_left_over_is_told_with_its_unit() {
        let missed = Equation { residual: Some(0.12), reached_floor: false, ..equation() };
        assert_eq!(missed.is_explained(), Some(false));
        let says = "the residual of the equation of w is 0.12 rad/s² RMS, above the level of rounding (2e−6)";
        assert_eq!(excess(&account(100), &missed).as_deref(), Some(says));
        assert!(
            table(&account(100), &missed, WIDTH)
                .contains("above the level of rounding (2e−6): noise, or a missing term")
        );
        let doubt = Some("but other halves want other coefficients".into());
        let small = Equation { reached_floor: false, doubt, ..equation() };
        let says = "at the level of rounding (2e−6), but other halves want other coefficients";
        assert!(table(&account(100), &small, WIDTH).contains(says));
        assert!(excess(&account(100), &small).is_some_and(|text| text.ends_with(says)));
        let says = "the equation of w has 2 terms for 2 steps: no degrees of freedom are left to test it";
        assert_eq!(excess(&account(2), &missed).as_deref(), Some(says));
        let unknown = Equation { floor: 0.0, ..missed };
        assert_eq!(unknown.is_explained(), None);
    }
}
