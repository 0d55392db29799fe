//! Terms and sums in languages that write formulas as C does.

use sindyna_sindy::export::System;
use sindyna_sindy::{Entry, Expr, Function};

/// How a language writes what not all write alike.
pub(super) struct Dialect {
    /// A function of one number.
    pub(super) call: fn(Function, &str) -> String,
    /// A number to a whole power.
    pub(super) power: fn(&str, i32) -> String,
    /// What ends a statement.
    pub(super) end: &'static str,
}

/// `expr` over z = (x; u) with `n` states; everything but numbers and variables in parentheses.
pub(super) fn expression(dialect: &Dialect, expr: &Expr, n: usize) -> String {
    let part = |e: &Expr| expression(dialect, e, n);
    match expr {
        Expr::Constant(c) => number(*c),
        Expr::Variable(i) if *i < n => format!("x[{i}]"),
        Expr::Variable(i) => format!("u[{}]", i - n),
        Expr::Neg(a) => format!("(-{})", part(a)),
        Expr::Add(a, b) => format!("({} + {})", part(a), part(b)),
        Expr::Sub(a, b) => format!("({} - {})", part(a), part(b)),
        Expr::Mul(a, b) => format!("({} * {})", part(a), part(b)),
        Expr::Div(a, b) => format!("({} / {})", part(a), part(b)),
        Expr::Power(a, exponent) => (dialect.power)(&part(a), *exponent),
        Expr::Call(function, a) => (dialect.call)(*function, &part(a)),
    }
}

/// How a coefficient is written: its number, counted through all equations, and its value.
pub(super) type Coefficient<'a> = &'a dyn Fn(usize, f64) -> String;

/// The sum of `entries`, each with the number of its coefficient.
fn sum<'a>(
    dialect: &Dialect,
    system: &System,
    coefficient: Coefficient<'_>,
    entries: impl Iterator<Item = (usize, &'a Entry)>,
) -> String {
    let summand = |(k, entry): (usize, &Entry)| match &system.terms[entry.term] {
        one if one.is_one() => coefficient(k, entry.coefficient),
        term => {
            format!("{} * {}", coefficient(k, entry.coefficient), expression(dialect, term, system.states.len()))
        }
    };
    let summands: Vec<String> = entries.map(summand).collect();
    if summands.is_empty() { "0.0".into() } else { summands.join(" + ") }
}

/// A coefficient as its value.
pub(super) fn value(_: usize, coefficient: f64) -> String {
    number(coefficient)
}

/// `value` with every digit, negative ones in parentheses.
pub(super) fn number(value: f64) -> String {
    if value.is_sign_negative() { format!("({value:?})") } else { format!("{value:?}") }
}

/// Whether a term of `system`, or one of the `others`, holds `function`.
pub(super) fn uses(system: &System, others: &[Expr], function: Function) -> bool {
    fn holds(expr: &Expr, function: Function) -> bool {
        match expr {
            Expr::Constant(_) | Expr::Variable(_) => false,
            Expr::Call(f, a) => *f == function || holds(a, function),
            Expr::Neg(a) | Expr::Power(a, _) => holds(a, function),
            Expr::Add(a, b) | Expr::Sub(a, b) | Expr::Mul(a, b) | Expr::Div(a, b) => {
                holds(a, function) || holds(b, function)
            }
        }
    }
    let terms = system.equations.iter().flatten().map(|entry| &system.terms[entry.term]);
    terms.chain(others).any(|term| holds(term, function))
}

/// The lines `target = …` of all equations; of implicit ones those of the coupling too.
pub(super) fn assignments(
    dialect: &Dialect,
    system: &System,
    target: &str,
    coefficient: Coefficient<'_>,
    coupling: impl Fn(usize, usize) -> String,
) -> String {
    let n = system.states.len();
    let (mut lines, mut first) = (String::new(), 0);
    for (i, row) in system.equations.iter().enumerate() {
        let of = |rate: Option<usize>| {
            let numbered = row.iter().enumerate().filter(move |(_, e)| e.rate == rate);
            numbered.map(move |(k, e)| (first + k, e))
        };
        lines += &format!("    {target}[{i}] = {}{}\n", sum(dialect, system, coefficient, of(None)), dialect.end);
        for l in 0..n {
            if of(Some(l)).next().is_some() {
                let one = if i == l { "1.0" } else { "0.0" };
                let coupled = sum(dialect, system, coefficient, of(Some(l)));
                lines += &format!("    {} = {one} - ({coupled}){}\n", coupling(i, l), dialect.end);
            }
        }
        first += row.len();
    }
    lines
}

/// Numbers separated by commas, some on a line.
pub(super) fn list(numbers: impl Iterator<Item = String>) -> String {
    let all: Vec<String> = numbers.collect();
    let lines: Vec<String> = all.chunks(8).map(|chunk| chunk.join(", ")).collect();
    lines.join(",\n    ")
}
