//! Sums told apart.

use super::Expr;

impl Expr {
    /// The summands of the term, each as a number times a term without one: of −9.81 sin θ + ω it is (−9.81, sin θ), (1, ω).
    pub(crate) fn summands(&self) -> Vec<(f64, Self)> {
        let times = |by: f64, of: &Self| of.summands().into_iter().map(|(c, e)| (by * c, e)).collect::<Vec<_>>();
        match self {
            Self::Add(a, b) => [a.summands(), b.summands()].concat(),
            Self::Sub(a, b) => [a.summands(), times(-1.0, b)].concat(),
            Self::Neg(a) => times(-1.0, a),
            _ => vec![self.factored()],
        }
    }

    /// The number the term is multiplied by, and what is left of it.
    fn factored(&self) -> (f64, Self) {
        match self {
            Self::Constant(c) => (*c, Self::Constant(1.0)),
            Self::Neg(a) => {
                let (c, rest) = a.factored();
                (-c, rest)
            }
            Self::Mul(a, b) => {
                let ((c, left), (d, right)) = (a.factored(), b.factored());
                (c * d, left.times(right))
            }
            Self::Div(a, b) => match (a.factored(), b.factored()) {
                ((c, left), (d, right)) if right.is_one() => (c / d, left),
                ((c, left), (d, right)) => (c / d, Self::Div(Box::new(left), Box::new(right))),
            },
            _ => (1.0, self.clone()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::parse;

    #[test]
    fn numbers_are_taken_out_of_summands() {
        let names: Vec<String> = ["th", "w", "u"].map(String::from).into();
        let told = |text: &str| -> Vec<(f64, String)> {
            let sum = parse(text, &names).expect("a formula").summands();
            sum.into_iter().map(|(c, e)| (c, e.display(&names).to_string())).collect()
        };
        let own = |parts: &[(f64, &str)]| parts.iter().map(|(c, e)| (*c, (*e).to_owned())).collect::<Vec<_>>();
        assert_eq!(told("-9.81*sin(th) + w/2"), own(&[(-9.81, "sin(th)"), (0.5, "w")]));
        assert_eq!(told("3 - (u - 2*w*-4)"), own(&[(3.0, "1"), (-1.0, "u"), (-8.0, "w")]));
        assert_eq!(told("w*(th + u)"), own(&[(1.0, "w*(th + u)")]));
    }
}
