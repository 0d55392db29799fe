//! Libraries as people compose them, in PySINDy's order and with its names.

use super::Term;
use crate::expr::{Expr, Function, ParseError, parse};

/// A recipe for candidate terms over any number of variables.
///
/// Order and names are those of PySINDy 2.1: `1, x0, x1, x0^2, x0 x1, …`, then `sin(1 x0), cos(1 x0), …`.
///
/// # Examples
/// ```
/// use sindyna_sindy::Library;
///
/// let names = ["x0".to_string(), "x1".to_string()];
/// let library = Library::polynomial(2).plus(Library::Custom(vec!["x0*sin(x1)".into()]));
/// let terms = library.terms(&names)?;
/// let names: Vec<_> = terms.iter().map(|t| t.name.as_str()).collect();
/// assert_eq!(names, ["1", "x0", "x1", "x0^2", "x0 x1", "x1^2", "x0*sin(x1)"]);
/// # Ok::<(), sindyna_sindy::LibraryError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Library {
    /// Products of variables up to a degree.
    Polynomial {
        /// Largest sum of powers.
        degree: usize,
        /// Whether products of different variables are included, or powers of single ones only.
        interaction: bool,
        /// Whether the constant is included.
        bias: bool,
    },
    /// sin(k a) and cos(k a), k = 1..=`n_frequencies`, of every variable a.
    Fourier {
        /// Number of frequencies.
        n_frequencies: usize,
    },
    /// The variables themselves.
    Identity,
    /// Terms written by hand over the variables' names, such as `v^2*sin(x)`.
    Custom(Vec<String>),
    /// One library after the other.
    Concat(Vec<Library>),
    /// Every term of the first times every term of the second; the first is the outer loop.
    Tensor(Box<Library>, Box<Library>),
    /// A library over some of the variables only.
    Of {
        /// Numbers of the variables.
        inputs: Vec<usize>,
        /// The library over them.
        library: Box<Library>,
    },
}

/// Why a library has no terms to offer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LibraryError {
    /// A term written by hand cannot be read.
    #[error(transparent)]
    Parse(#[from] ParseError),
    /// A library over a variable there is not.
    #[error("the library asks for variable {index}, there are only {n_variables}")]
    NoSuchVariable {
        /// The variable asked for.
        index: usize,
        /// Number of variables.
        n_variables: usize,
    },
    /// No term at all.
    #[error("the library has no terms")]
    Empty,
    /// More terms than can be handled.
    #[error("the library has more than {limit} terms")]
    TooLarge {
        /// Largest number allowed.
        limit: usize,
    },
}

/// Terms beyond this are surely a mistake.
const MAX_TERMS: usize = 20_000;

impl Library {
    /// All products of variables up to `degree`, the constant included: PySINDy's default library for degree 2.
    #[must_use]
    pub fn polynomial(degree: usize) -> Self {
        Self::Polynomial { degree, interaction: true, bias: true }
    }

    /// sin(k a) and cos(k a) for k = 1..=`n_frequencies`.
    #[must_use]
    pub fn fourier(n_frequencies: usize) -> Self {
        Self::Fourier { n_frequencies }
    }

    /// This library followed by `other`.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        match self {
            Self::Concat(mut parts) => {
                parts.push(other);
                Self::Concat(parts)
            }
            first => Self::Concat(vec![first, other]),
        }
    }

    /// Every term of this library times every term of `other`.
    #[must_use]
    pub fn times(self, other: Self) -> Self {
        Self::Tensor(Box::new(self), Box::new(other))
    }

    /// This library over the variables numbered `inputs` only.
    #[must_use]
    pub fn of(self, inputs: &[usize]) -> Self {
        Self::Of { inputs: inputs.to_vec(), library: Box::new(self) }
    }

    /// The terms over variables called `names`, in order.
    ///
    /// # Errors
    /// [`LibraryError`] if a term cannot be read, a variable is missing, or there is no term at all.
    pub fn terms(&self, names: &[String]) -> Result<Vec<Term>, LibraryError> {
        let all: Vec<usize> = (0..names.len()).collect();
        let terms = self.terms_of(&all, names)?;
        if terms.is_empty() { Err(LibraryError::Empty) } else { Ok(terms) }
    }

    fn terms_of(&self, inputs: &[usize], names: &[String]) -> Result<Vec<Term>, LibraryError> {
        let terms = match self {
            Self::Polynomial { degree, interaction, bias } => polynomial(inputs, names, *degree, *interaction, *bias)?,
            Self::Fourier { n_frequencies } => fourier(inputs, names, *n_frequencies),
            Self::Identity => inputs.iter().map(|&i| term(Expr::Variable(i), names[i].clone())).collect(),
            Self::Custom(texts) => {
                let terms = texts.iter().map(|text| parse(text, names).map(|expr| term(expr, text.trim().to_owned())));
                terms.collect::<Result<_, _>>()?
            }
            Self::Concat(parts) => {
                let mut terms = Vec::new();
                for part in parts {
                    terms.extend(part.terms_of(inputs, names)?);
                }
                terms
            }
            Self::Tensor(a, b) => tensor(&a.terms_of(inputs, names)?, &b.terms_of(inputs, names)?),
            Self::Of { inputs: chosen, library } => {
                let known = |&i: &usize| {
                    let missing = LibraryError::NoSuchVariable { index: i, n_variables: inputs.len() };
                    inputs.get(i).copied().ok_or(missing)
                };
                let chosen: Vec<usize> = chosen.iter().map(known).collect::<Result<_, _>>()?;
                library.terms_of(&chosen, names)?
            }
        };
        if terms.len() > MAX_TERMS { Err(LibraryError::TooLarge { limit: MAX_TERMS }) } else { Ok(terms) }
    }
}

/// A term of unknown roles: they are looked at where roles are known.
fn term(expr: Expr, name: String) -> Term {
    let complexity = super::complexity(&expr, &[]);
    Term { expr, name, complexity, rate: None, shape: None }
}

fn polynomial(
    inputs: &[usize],
    names: &[String],
    degree: usize,
    interaction: bool,
    bias: bool,
) -> Result<Vec<Term>, LibraryError> {
    let mut terms = Vec::new();
    if bias {
        terms.push(term(Expr::Constant(1.0), "1".into()));
    }
    for d in 1..=degree {
        if !interaction {
            terms.extend(inputs.iter().map(|&i| monomial(&vec![i; d], names)));
            continue;
        }
        // Combinations with repetition, in lexicographic order.
        let mut chosen = vec![0; d];
        while let Some(&first) = chosen.first().filter(|_| !inputs.is_empty()) {
            let factors: Vec<usize> = chosen.iter().map(|&c| inputs[c]).collect();
            terms.push(monomial(&factors, names));
            if terms.len() > MAX_TERMS {
                return Err(LibraryError::TooLarge { limit: MAX_TERMS });
            }
            if first + 1 == inputs.len() {
                break;
            }
            let Some(last) = chosen.iter().rposition(|&c| c + 1 < inputs.len()) else { break };
            let next = chosen[last] + 1;
            chosen[last..].fill(next);
        }
    }
    Ok(terms)
}

/// The product of the variables in `factors`, which are grouped.
fn monomial(factors: &[usize], names: &[String]) -> Term {
    let mut expr = Expr::Constant(1.0);
    let mut parts = Vec::new();
    for group in factors.chunk_by(|a, b| a == b) {
        let n = group.len();
        expr = expr.times(Expr::Variable(group[0]).to_power(n as i32));
        parts.push(if n == 1 { names[group[0]].clone() } else { format!("{}^{n}", names[group[0]]) });
    }
    term(expr, parts.join(" "))
}

fn fourier(inputs: &[usize], names: &[String], n_frequencies: usize) -> Vec<Term> {
    let mut terms = Vec::new();
    for k in 1..=n_frequencies {
        for &i in inputs {
            for function in [Function::Sin, Function::Cos] {
                let name = format!("{function}({k} {})", names[i]);
                terms.push(term(Expr::wave(function, k, Expr::Variable(i)), name));
            }
        }
    }
    terms
}

fn tensor(outer: &[Term], inner: &[Term]) -> Vec<Term> {
    let pairs = outer.iter().flat_map(|a| inner.iter().map(move |b| (a, b)));
    pairs.map(|(a, b)| term(a.expr.clone().times(b.expr.clone()), format!("{} {}", a.name, b.name))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(library: &Library, variables: &[&str]) -> Vec<String> {
        let variables: Vec<String> = variables.iter().map(ToString::to_string).collect();
        library.terms(&variables).expect("terms").into_iter().map(|t| t.name).collect()
    }

    #[test]
    fn orders_and_names_are_pysindys() {
        let cubic = names(&Library::polynomial(3), &["x", "u"]);
        assert_eq!(cubic, ["1", "x", "u", "x^2", "x u", "u^2", "x^3", "x^2 u", "x u^2", "u^3"]);
        let plain = Library::Polynomial { degree: 2, interaction: false, bias: true };
        assert_eq!(names(&plain, &["x", "u"]), ["1", "x", "u", "x^2", "u^2"]);
        let waves = names(&Library::fourier(2), &["x0", "x1"]);
        let expected = ["sin(1 x0)", "cos(1 x0)", "sin(1 x1)", "cos(1 x1)"];
        assert_eq!(waves[..4], expected);
        assert_eq!(waves[4], "sin(2 x0)");
        let product = Library::Identity.times(Library::fourier(1));
        assert_eq!(names(&product, &["x0"]), ["x0 sin(1 x0)", "x0 cos(1 x0)"]);
        assert_eq!(names(&Library::polynomial(2), &["x0", "x1", "x2", "u0", "u1"]).len(), 21);
        assert_eq!(names(&Library::Identity.of(&[1]), &["x0", "x1"]), ["x1"]);
    }

    #[test]
    fn impossible_libraries_say_why() {
        let x = ["x".to_owned()];
        let error = |library: Library| library.terms(&x).expect_err("impossible").to_string();
        assert_eq!(error(Library::Custom(vec![])), "the library has no terms");
        assert_eq!(error(Library::Identity.of(&[1])), "the library asks for variable 1, there are only 1");
        assert!(error(Library::Custom(vec!["sin(y)".into()])).contains("known: x"));
        let names: Vec<String> = (0..100).map(|i| format!("x{i}")).collect();
        let large = Library::polynomial(4).terms(&names);
        assert_eq!(large, Err(LibraryError::TooLarge { limit: MAX_TERMS }));
        assert_eq!(Library::polynomial(0).terms(&x).map(|t| t.len()), Ok(1));
    }
}
