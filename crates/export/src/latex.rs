//! Formulas for LaTeX with amsmath.

use sindyna_core::number::ascii;
use sindyna_sindy::export::{Stepping, System};
use sindyna_sindy::{Entry, Expr, Function};

use super::network::Head;
use super::program::{Program, harmless};

/// Digits of a coefficient.
const DIGITS: usize = 6;

/// A file of LaTeX to be taken into another.
pub(super) fn write(program: &Program) -> String {
    let system = &program.system;
    let mut text = String::from("% Written by sindyna export; needs amsmath.\n");
    text += &program.notes.iter().map(|note| format!("% {}\n", harmless(note))).collect::<String>();
    let names: Vec<String> = system.states.iter().chain(&system.controls).map(|name| symbol(name)).collect();
    text += "\\begin{align}\n";
    let lines: Vec<String> = system
        .equations
        .iter()
        .enumerate()
        .map(|(i, row)| format!("  {} &= {}", left(system, &names[i]), sum(system, row, &names)))
        .collect();
    text += &lines.join(" \\\\\n");
    text += "\n\\end{align}\n";
    if let Some(network) = &program.policy {
        let sizes: Vec<String> = std::iter::once(network.observed())
            .chain(network.layers.iter().map(|layer| layer.outputs))
            .map(|size| size.to_string())
            .collect();
        let action = match &network.head {
            Head::Squashed { .. } => "l + \\tfrac{1}{2} \\left(1 + \\tanh z\\right) \\left(h - l\\right)",
            Head::Largest => "\\operatorname{arg\\,max}_i z_i",
        };
        text += &format!(
            "% The policy: z is a network of layers {} with ReLU; its weights are in policy.safetensors.\n\\begin{{equation}}\n  \\pi(o) = {action}, \\qquad z = W_{{{depth}}} \\max\\left(0, \\dots W_1 \\frac{{o - c}}{{s}} + b_1 \\dots\\right) + b_{{{depth}}}\n\\end{{equation}}\n",
            sizes.join(", "),
            depth = network.layers.len()
        );
    }
    text
}

fn left(system: &System, name: &str) -> String {
    match system.stepping {
        Stepping::Map => format!("{{{name}}}^{{+}}"),
        Stepping::Increment => format!("\\frac{{\\Delta {name}}}{{\\Delta t}}"),
        _ => format!("\\dot{{{name}}}"),
    }
}

fn sum(system: &System, row: &[Entry], names: &[String]) -> String {
    let mut text = String::new();
    for entry in row {
        let sign = match (text.is_empty(), entry.coefficient < 0.0) {
            (true, false) => "",
            (true, true) => "-",
            (false, false) => " + ",
            (false, true) => " - ",
        };
        let size = ascii(entry.coefficient.abs(), DIGITS);
        let term = &system.terms[entry.term];
        let rate = entry.rate.map(|i| left(system, &names[i]));
        let factors: Vec<String> =
            (!term.is_one()).then(|| formula(term, names, true)).into_iter().chain(rate).collect();
        let factors = factors.join(" \\, ");
        text += sign;
        text += &match (factors.is_empty(), size == "1") {
            (true, _) => power_of_ten(&size),
            (false, true) => factors,
            (false, false) => format!("{} \\, {factors}", power_of_ten(&size)),
        };
    }
    if text.is_empty() { "0".into() } else { text }
}

/// `1e-9` as a power of ten.
fn power_of_ten(number: &str) -> String {
    number
        .split_once('e')
        .map_or_else(|| number.to_owned(), |(digits, power)| format!("{digits} \\cdot 10^{{{power}}}"))
}

fn formula(expr: &Expr, names: &[String], tight: bool) -> String {
    let part = |e: &Expr, tight| formula(e, names, tight);
    let text = match expr {
        Expr::Constant(c) if *c < 0.0 => format!("\\left(-{}\\right)", power_of_ten(&ascii(-c, DIGITS))),
        Expr::Constant(c) => power_of_ten(&ascii(*c, DIGITS)),
        Expr::Variable(i) => names[*i].clone(),
        Expr::Neg(a) => format!("-{}", part(a, true)),
        Expr::Add(a, b) => format!("{} + {}", part(a, false), part(b, true)),
        Expr::Sub(a, b) => format!("{} - {}", part(a, false), part(b, true)),
        Expr::Mul(a, b) => format!("{} \\, {}", part(a, true), part(b, true)),
        Expr::Div(a, b) => format!("\\frac{{{}}}{{{}}}", part(a, false), part(b, false)),
        Expr::Power(a, n) => format!("\\left({}\\right)^{{{n}}}", part(a, false)),
        Expr::Call(Function::Abs, a) => format!("\\left|{}\\right|", part(a, false)),
        Expr::Call(Function::Sqrt, a) => format!("\\sqrt{{{}}}", part(a, false)),
        Expr::Call(Function::Sign, a) => format!("\\operatorname{{sgn}}\\left({}\\right)", part(a, false)),
        Expr::Call(Function::PositivePart, a) => format!("\\max\\left({}, 0\\right)", part(a, false)),
        Expr::Call(function, a) => match expr.as_power() {
            Some((base, c)) => format!("\\left({}\\right)^{{{}}}", part(base, false), part(c, false)),
            None if *function == Function::Atan => format!("\\arctan\\left({}\\right)", part(a, false)),
            None => format!("\\{}\\left({}\\right)", function.name(), part(a, false)),
        },
    };
    let loose = matches!(expr, Expr::Add(..) | Expr::Sub(..) | Expr::Neg(_));
    if loose && tight { format!("\\left({text}\\right)") } else { text }
}

/// A name as a symbol: Greek letters by their names, one letter as it is, all else upright and escaped.
fn symbol(name: &str) -> String {
    const GREEK: [(&str, &str); 14] = [
        ("α", "\\alpha"),
        ("β", "\\beta"),
        ("γ", "\\gamma"),
        ("δ", "\\delta"),
        ("ε", "\\varepsilon"),
        ("θ", "\\theta"),
        ("λ", "\\lambda"),
        ("μ", "\\mu"),
        ("ρ", "\\rho"),
        ("σ", "\\sigma"),
        ("τ", "\\tau"),
        ("φ", "\\varphi"),
        ("ψ", "\\psi"),
        ("ω", "\\omega"),
    ];
    if let Some((_, command)) = GREEK.iter().find(|(letter, _)| *letter == name) {
        return (*command).to_owned();
    }
    if name.len() == 1 && name.chars().all(|c| c.is_ascii_alphabetic()) {
        return name.to_owned();
    }
    let escaped: String = name
        .chars()
        .map(|c| match c {
            '_' => "\\_".to_owned(),
            ' ' => " ".to_owned(),
            c if c.is_alphanumeric() || matches!(c, '-' | '.' | '(' | ')' | '/') => c.to_string(),
            _ => "?".to_owned(),
        })
        .collect();
    format!("\\text{{{escaped}}}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_symbols_and_never_commands() {
        for (name, shown) in [
            ("θ", "\\theta"),
            ("x", "x"),
            ("cos_θ", "\\text{cos\\_θ}"),
            ("a}\\input{b}", "\\text{a??input?b?}"),
            ("lynx/100", "\\text{lynx/100}"),
            ("50%\n", "\\text{50??}"),
        ] {
            assert_eq!(symbol(name), shown);
        }
    }
}
