//! Equations as MathML.

use sindyna_core::number::{coefficient, decimals, significant};
use sindyna_record::identification::{Account, Equation, InsideTerm};
use sindyna_sindy::{Entry, Expr, Form, Function, Model};

use crate::escape::escaped;

/// A product.
const TIMES: &str = "<mo>\u{22c5}</mo>";
/// Part of a value above which its error is shown beside it: below, six digits of both are the same.
pub(super) const SHOWN: f64 = 5e-6;
/// An application of a function.
const APPLY: &str = "<mo>\u{2061}</mo>";

/// The equations of `model`, with the standard errors that `account` has: a paragraph each, which breaks between terms.
pub(super) fn equations(model: &Model, account: Option<&Account>) -> String {
    let names: Vec<String> = model.states().iter().chain(model.controls()).cloned().collect();
    let terms = model.shifted_terms();
    let rows = (0..model.states().len()).map(|i| {
        let equation = account.and_then(|a| a.equations.get(i));
        let mut parts = vec![format!("{}<mo form=\"infix\">=</mo>", left(&names[i], model.form()))];
        let mut row = model.coefficients(i).to_vec();
        // What the system does by itself is read first, what is done to it last.
        row.sort_by_key(|entry| terms[entry.term].max_variable().is_some_and(|v| v >= model.states().len()));
        for (place, entry) in row.iter().enumerate() {
            parts.push(summand(place == 0, entry, &terms[entry.term], &names, equation));
        }
        if model.coefficients(i).is_empty() {
            parts.push("<mn>0</mn>".into());
        }
        let parts = parts.iter().map(|part| format!("<math><mrow>{part}</mrow></math>"));
        format!("<p class=\"equation scroll\" tabindex=\"0\">{}</p>\n", parts.collect::<Vec<_>>().join(" "))
    });
    rows.collect()
}

fn left(name: &str, form: Form) -> String {
    match form {
        Form::Increment => fraction(&format!("<mi>Δ</mi>{}", identifier(name)), "<mi>Δ</mi><mi>t</mi>"),
        Form::Discrete => format!("<msup>{}<mo>+</mo></msup>", identifier(name)),
        Form::Continuous(_) | Form::SemiImplicit { .. } => rate(name),
    }
}

/// The derivative of `name`: a dot above a single letter.
fn rate(name: &str) -> String {
    if name.chars().count() == 1 {
        format!("<mover>{}<mo>\u{2d9}</mo></mover>", identifier(name))
    } else {
        fraction(&format!("<mi>d</mi>{}", identifier(name)), "<mi>d</mi><mi>t</mi>")
    }
}

fn fraction(above: &str, below: &str) -> String {
    format!("<mfrac><mrow>{above}</mrow><mrow>{below}</mrow></mfrac>")
}

fn identifier(name: &str) -> String {
    format!("<mi>{}</mi>", escaped(name))
}

fn number(text: &str) -> String {
    match text.split_once('e') {
        Some((mantissa, exponent)) => {
            format!("<mn>{mantissa}</mn>{TIMES}<msup><mn>10</mn><mn>{exponent}</mn></msup>")
        }
        None => format!("<mn>{text}</mn>"),
    }
}

/// `+ (15.00 ± 0.02) sin θ`.
fn summand(first: bool, entry: &Entry, term: &Expr, names: &[String], equation: Option<&Equation>) -> String {
    let c = entry.coefficient;
    let sign = match (first, c < 0.0) {
        (true, false) => "",
        (false, false) => "<mo form=\"infix\">+</mo>",
        (true, true) => "<mo form=\"prefix\">\u{2212}</mo>",
        (false, true) => "<mo form=\"infix\">\u{2212}</mo>",
    };
    let near = |v: f64| (v - c).abs() <= 1e-9 * c.abs();
    let error = equation.and_then(|e| e.terms.iter().find(|t| near(t.coefficient))?.standard_error);
    let (size, exact) = with_error(c.abs(), error);
    let rate = entry.rate.and_then(|l| names.get(l)).map(|name| rate(name));
    let with = Inside { names, parameters: equation.map_or(&[], |e| &e.parameters) };
    let factors: Vec<String> =
        (!term.is_one()).then(|| math(term, with, Needs::Factor)).into_iter().chain(rate).collect();
    let product = factors.join(TIMES);
    match (product.is_empty(), exact && size == "<mn>1</mn>") {
        (true, _) => format!("{sign}{size}"),
        (false, true) => format!("{sign}{product}"),
        (false, false) => format!("{sign}{size}<mspace width=\"0.2em\"/>{product}"),
    }
}

/// A size with its error in parentheses, and whether it stands alone: an error beyond six digits is not shown.
fn with_error(size: f64, error: Option<f64>) -> (String, bool) {
    let Some(error) = error.filter(|e| *e > SHOWN * size) else { return (number(&coefficient(size)), true) };
    let (value, error) = rounded(size, error);
    (
        format!(
            "<mo stretchy=\"false\">(</mo>{}<mo>\u{b1}</mo>{}<mo stretchy=\"false\">)</mo>",
            number(&value),
            number(&error)
        ),
        false,
    )
}

/// `value` with as many digits as its `error`, which has two.
pub(super) fn rounded(value: f64, error: f64) -> (String, String) {
    if !(error > 0.0 && error.is_finite() && value.is_finite()) {
        return (coefficient(value), coefficient(error));
    }
    let digits = 1 - error.log10().floor() as i32;
    if (0..=9).contains(&digits) && value.abs() < 1e6 {
        let digits = digits as usize;
        return (decimals(value, digits), decimals(error, digits));
    }
    (coefficient(value), significant(error, 2))
}

/// What an expression is a part of.
#[derive(Clone, Copy, PartialEq)]
enum Needs {
    Nothing,
    /// A sum stands in parentheses.
    Factor,
}

fn parenthesised(inner: &str) -> String {
    format!("<mrow><mo stretchy=\"false\">(</mo>{inner}<mo stretchy=\"false\">)</mo></mrow>")
}

/// Names of the variables of a term, and the parameters inside it with their standard errors.
#[derive(Clone, Copy)]
struct Inside<'a> {
    names: &'a [String],
    parameters: &'a [InsideTerm],
}

impl Inside<'_> {
    /// A constant of the size `c`, with its standard error where it was fitted, and whether it stands alone.
    fn constant(&self, c: f64) -> (String, bool) {
        let fitted = self.parameters.iter().find(|p| (p.value.abs() - c).abs() <= 1e-9 * c);
        with_error(c, fitted.and_then(|p| p.standard_error))
    }
}

fn math(expr: &Expr, with: Inside<'_>, needs: Needs) -> String {
    let of = |e: &Expr| math(e, with, Needs::Nothing);
    let factor = |e: &Expr| math(e, with, Needs::Factor);
    let sum = |text: String| if needs == Needs::Factor { parenthesised(&text) } else { text };
    match expr {
        Expr::Constant(c) if *c < 0.0 => sum(format!("<mo>\u{2212}</mo>{}", with.constant(-c).0)),
        Expr::Constant(c) => with.constant(*c).0,
        Expr::Variable(i) => with.names.get(*i).map_or_else(|| format!("<mi>z{i}</mi>"), |name| identifier(name)),
        Expr::Neg(a) => sum(format!("<mo>\u{2212}</mo>{}", factor(a))),
        Expr::Add(a, b) => sum(format!("{}<mo>+</mo>{}", of(a), of(b))),
        Expr::Sub(a, b) => sum(format!("{}<mo>\u{2212}</mo>{}", of(a), factor(b))),
        Expr::Mul(a, b) => {
            let between = if matches!((&**a, &**b), (Expr::Constant(_), Expr::Variable(_))) { "" } else { TIMES };
            format!("{}{between}{}", factor(a), factor(b))
        }
        Expr::Div(a, b) => fraction(&of(a), &of(b)),
        Expr::Power(a, n) => match &**a {
            Expr::Call(f, inner) if *n > 1 && has_name(*f) => {
                format!("<msup><mi>{f}</mi><mn>{n}</mn></msup>{APPLY}{}", argument(inner, with))
            }
            Expr::Variable(_) => format!("<msup>{}<mn>{n}</mn></msup>", of(a)),
            _ => format!("<msup>{}<mn>{n}</mn></msup>", parenthesised(&of(a))),
        },
        Expr::Call(Function::Abs, a) => format!("<mrow><mo>|</mo>{}<mo>|</mo></mrow>", of(a)),
        Expr::Call(Function::Sqrt, a) => format!("<msqrt>{}</msqrt>", of(a)),
        Expr::Call(Function::PositivePart, a) => {
            let pair = format!("{}<mo>,</mo><mn>0</mn>", of(a));
            format!("<mi>max</mi>{APPLY}{}", parenthesised(&pair))
        }
        Expr::Call(f, a) => match expr.as_power() {
            Some((base @ Expr::Variable(_), c)) => format!("<msup>{}<mrow>{}</mrow></msup>", of(base), of(c)),
            Some((base, c)) => format!("<msup>{}<mrow>{}</mrow></msup>", parenthesised(&of(base)), of(c)),
            None => format!("<mi>{f}</mi>{APPLY}{}", argument(a, with)),
        },
    }
}

/// Whether the function is written by its name.
fn has_name(f: Function) -> bool {
    !matches!(f, Function::Abs | Function::Sqrt | Function::PositivePart)
}

fn argument(a: &Expr, with: Inside<'_>) -> String {
    let inner = math(a, with, Needs::Nothing);
    if matches!(a, Expr::Variable(_)) { format!("<mspace width=\"0.17em\"/>{inner}") } else { parenthesised(&inner) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sindyna_sindy::parse;

    #[test]
    fn every_term_is_valid_xml_whatever_its_names_are() {
        let names = ["<script>alert(1)</script>", "a\"]]>", "\u{202e}b"].map(String::from);
        let z = |i| Box::new(Expr::Variable(i));
        let term = Expr::Mul(Box::new(Expr::Power(Box::new(Expr::Call(Function::Sin, z(0))), 2)), z(1));
        let with = Inside { names: &names, parameters: &[] };
        let text = math(&Expr::Div(Box::new(term), z(2)), with, Needs::Nothing);
        let text = format!("<math>{text}</math>");
        let parsed = roxmltree::Document::parse(&text).unwrap_or_else(|e| panic!("{e}: {text}"));
        let found: Vec<_> = parsed.descendants().filter(|n| n.has_tag_name("mi")).filter_map(|n| n.text()).collect();
        assert_eq!(found, ["sin", "<script>alert(1)</script>", "a\"]]>", "\u{fffd}b"]);
    }

    #[test]
    fn terms_are_written_as_in_a_textbook() {
        let names = ["x".to_string(), "v".to_string()];
        let of = |text: &str| {
            math(&parse(text, &names).expect("it is a term"), Inside { names: &names, parameters: &[] }, Needs::Nothing)
        };
        assert_eq!(
            of("v^2*sin(x)"),
            "<msup><mi>v</mi><mn>2</mn></msup><mo>⋅</mo><mi>sin</mi><mo>\u{2061}</mo><mspace width=\"0.17em\"/><mi>x</mi>"
        );
        assert_eq!(of("v/x"), "<mfrac><mrow><mi>v</mi></mrow><mrow><mi>x</mi></mrow></mfrac>");
        assert!(of("v*abs(v)").contains("<mo>|</mo><mi>v</mi><mo>|</mo>"));
        assert_eq!(of("v^0.7"), "<msup><mi>v</mi><mrow><mn>0.7</mn></mrow></msup>");
    }

    #[test]
    fn a_parameter_inside_a_term_has_its_error() {
        let names = ["v".to_string()];
        let inside = |error| InsideTerm { term: "tanh(v/0.3)".into(), value: 0.3, standard_error: error };
        let of = |error| {
            let parameters = [inside(error)];
            let term = parse("tanh(v/0.3)", &names).expect("it is a term");
            math(&term, Inside { names: &names, parameters: &parameters }, Needs::Nothing)
        };
        assert!(of(Some(0.012)).contains("<mn>0.300</mn><mo>±</mo><mn>0.012</mn>"), "{}", of(Some(0.012)));
        assert!(of(None).contains("<mn>0.3</mn>") && !of(None).contains('±'));
    }

    #[test]
    fn a_value_has_the_digits_of_its_error() {
        assert_eq!(rounded(15.00321, 0.0214), ("15.003".into(), "0.021".into()));
        assert_eq!(with_error(3.0, Some(1e-12)), ("<mn>3</mn>".into(), true));
        assert!(with_error(1e-9, Some(1e-10)).0.contains("<msup><mn>10</mn>"));
    }
}
