//! Terms that are made of several: the larger, the smaller, comparisons, tolerances.

use std::f64::consts::FRAC_PI_2;

use super::{Expr, Function};

/// The larger of a and 0.
fn positive(a: Expr) -> Expr {
    Expr::Call(Function::PositivePart, Box::new(a))
}

/// a − b.
fn less(a: Expr, b: Expr) -> Expr {
    Expr::Sub(Box::new(a), Box::new(b))
}

/// 1 where a > b, else 0.
pub(super) fn exceeds(a: Expr, b: Expr) -> Expr {
    Expr::Call(Function::Sign, Box::new(positive(less(a, b))))
}

/// 1 − a.
pub(super) fn complement(a: Expr) -> Expr {
    less(Expr::Constant(1.0), a)
}

/// Value of [`tolerance`] at its margin.
const AT_MARGIN: f64 = 0.1;

/// 1 for an `a` from `low` to `high`, else AT_MARGIN to the power of (distance / margin)².
pub(super) fn tolerance(a: Expr, low: Expr, high: Expr, margin: Expr) -> Expr {
    let outside = Expr::Add(Box::new(positive(less(low, a.clone()))), Box::new(positive(less(a, high))));
    if margin == Expr::Constant(0.0) {
        return complement(Expr::Call(Function::Sign, Box::new(outside)));
    }
    let distance = Expr::Power(Box::new(Expr::Div(Box::new(outside), Box::new(margin))), 2);
    Expr::Call(Function::Exp, Box::new(Expr::Mul(Box::new(Expr::Constant(AT_MARGIN.ln())), Box::new(distance))))
}

/// The angle of the point (x, y), −π to π; NaN at the origin.
///
/// sign(y)·(π/2 − atan(x/|y|)), where the sign of zero is 1.
pub(super) fn angle(y: Expr, x: Expr) -> Expr {
    let side = less(Expr::Constant(1.0), Expr::Constant(2.0).times(exceeds(Expr::Constant(0.0), y.clone())));
    let slope = Expr::Div(Box::new(x), Box::new(Expr::Call(Function::Abs, Box::new(y))));
    let turn = less(Expr::Constant(FRAC_PI_2), Expr::Call(Function::Atan, Box::new(slope)));
    Expr::Mul(Box::new(side), Box::new(turn))
}

/// max(a, b), to rounding.
pub(super) fn larger(a: Expr, b: Expr) -> Expr {
    match (a, b) {
        (Expr::Constant(0.0), a) | (a, Expr::Constant(0.0)) => positive(a),
        (a, b) => Expr::Add(Box::new(b.clone()), Box::new(positive(less(a, b)))),
    }
}

/// min(a, b), to rounding.
pub(super) fn smaller(a: Expr, b: Expr) -> Expr {
    let over = positive(less(a.clone(), b));
    less(a, over)
}

#[cfg(test)]
mod tests {
    use super::super::parse;

    #[test]
    fn the_larger_and_the_smaller_of_two_terms() {
        let names = ["x".to_owned(), "y".to_owned()];
        let at = |text: &str, x: f64, y: f64| parse(text, &names).expect("a term").eval(&[x, y]);
        for (x, y) in [(0.3, -2.0), (-1.5, 0.25), (4.0, 4.5), (-3.0, -3.5)] {
            assert_eq!(at("max(0, -x)", x, y), f64::max(0.0, -x));
            for (text, truth) in
                [("max(x, y)", f64::max(x, y)), ("min(x, y)", f64::min(x, y)), ("clip(x, -1, 2)", x.clamp(-1.0, 2.0))]
            {
                assert!((at(text, x, y) - truth).abs() <= 1e-15, "{text} at {x}, {y}");
            }
        }
        assert!(at("max(x, 0)", f64::NAN, 0.0).is_nan());
        let wrong = |text: &str| parse(text, &names).expect_err("no term").to_string();
        assert_eq!(wrong("max(x)"), "`max(x)`: expected `,` at position 6, found `)`");
        assert_eq!(wrong("clip(x, 1)"), "`clip(x, 1)`: expected `,` at position 10, found `)`");
        assert_eq!(wrong("min(x, 1, 2)"), "`min(x, 1, 2)`: expected `)` at position 9, found `,`");
    }

    #[test]
    fn comparisons_and_tolerances_are_numbers() {
        let names = ["x".to_owned(), "y".to_owned()];
        let at = |text: &str, x: f64, y: f64| parse(text, &names).expect("a term").eval(&[x, y]);
        for (x, y) in [(0.3, -2.0), (-1.5, 0.25), (4.0, 4.0), (-3.0, -3.5)] {
            for (text, truth) in [("(x < y)", x < y), ("(x <= y)", x <= y), ("(x > y)", x > y), ("(x ≥ y)", x >= y)] {
                assert_eq!(at(text, x, y), f64::from(u8::from(truth)), "{text} at {x}, {y}");
            }
        }
        assert_eq!(at("2*(abs(x) < 1) - (y + 1 > 0)*3", 0.5, 0.0), -1.0);
        assert!(at("(x < 1)", f64::NAN, 0.0).is_nan());
        for (x, margin, truth) in
            [(0.0, 1.0, 1.0), (1.0, 1.0, 1.0), (1.5, 1.0, 0.1_f64.powf(0.25)), (-2.0, 1.0, 0.1), (3.0, 2.0, 0.1)]
        {
            assert!((at("tolerance(x, -1, 1, y)", x, margin) - truth).abs() < 1e-15, "{x}");
        }
        assert_eq!([-1.0, 1.0, 1.1].map(|x| at("tolerance(x, -1, 1, 0)", x, 0.0)), [1.0, 1.0, 0.0]);
        let wrong = |text: &str| parse(text, &names).expect_err("no term").to_string();
        let expected = "an operator or the end (a comparison stands in parentheses)";
        assert_eq!(wrong("x < y"), format!("`x < y`: expected {expected} at position 3, found `<`"));
        for text in ["1 + tolerance(x, 2, 1, 0)", "tolerance(x, 1, 2, -1)"] {
            assert!(wrong(text).contains("needs low ≤ high and a margin of at least 0 (position "), "{}", wrong(text));
        }
        assert_eq!(wrong("(x < y < 1)"), "`(x < y < 1)`: expected `)` at position 8, found `<`");
        assert_eq!(wrong("(x = y)"), "`(x = y)`: expected `)` at position 4, found `=`");
    }

    #[test]
    fn the_angle_of_a_point_is_that_of_all_four_quadrants() {
        let names = ["x".to_owned(), "y".to_owned()];
        let at = |x: f64, y: f64| parse("atan2(y, x)", &names).expect("a term").eval(&[x, y]);
        for (x, y) in [(1.0, 0.0), (0.3, -2.0), (-1.5, 0.25), (-4.0, -4.5), (0.0, 2.0), (0.0, -2.0), (-1.0, 0.0)] {
            assert!((at(x, y) - f64::atan2(y, x)).abs() <= 4.5e-16, "{x}, {y}: {}", at(x, y));
        }
        assert!(at(0.0, 0.0).is_nan());
        let term = parse("2*pi - atan(x)/π", &names).expect("a term");
        assert_eq!(term.eval(&[1.0, 0.0]), std::f64::consts::TAU - 0.25);
        // A variable of that name comes first.
        assert_eq!(parse("pi", &["pi".to_owned()]).expect("a term").eval(&[3.0]), 3.0);
    }

    #[test]
    fn a_term_that_grows_by_what_it_is_made_of_is_refused() {
        let names = ["x".to_owned()];
        for (begin, end) in [("clip(", ",-1,1)"), ("min(", ",1)"), ("max(1,", ")"), ("tolerance(", ",-1,1,1)")] {
            let nested = |n: usize| format!("{}x{}", begin.repeat(n), end.repeat(n));
            assert!(parse(&nested(3), &names).is_ok());
            let error = parse(&nested(60), &names).expect_err("too long");
            assert!(error.to_string().ends_with("more than 1000 operators"), "{error}");
        }
    }
}
