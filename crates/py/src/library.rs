//! Candidate terms as Python describes them.

use serde::Deserialize;
use sindyna_sindy::Library;

/// A library, written as `{"polynomial": {"degree": 2, …}}`.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Recipe {
    Polynomial { degree: usize, interaction: bool, bias: bool },
    Fourier { n_frequencies: usize },
    Identity,
    Formulas(Vec<String>),
    Concat(Vec<Recipe>),
    Tensor(Box<Recipe>, Box<Recipe>),
    Of { inputs: Vec<usize>, library: Box<Recipe> },
}

impl From<Recipe> for Library {
    fn from(recipe: Recipe) -> Self {
        let of = |recipe: Recipe| Box::new(Self::from(recipe));
        match recipe {
            Recipe::Polynomial { degree, interaction, bias } => Self::Polynomial { degree, interaction, bias },
            Recipe::Fourier { n_frequencies } => Self::Fourier { n_frequencies },
            Recipe::Identity => Self::Identity,
            Recipe::Formulas(formulas) => Self::Custom(formulas),
            Recipe::Concat(parts) => Self::Concat(parts.into_iter().map(Self::from).collect()),
            Recipe::Tensor(a, b) => Self::Tensor(of(*a), of(*b)),
            Recipe::Of { inputs, library } => Self::Of { inputs, library: of(*library) },
        }
    }
}

/// x0, x1, …, u0, u1, ….
pub(crate) fn symbols(n_states: usize, n_controls: usize) -> Vec<String> {
    (0..n_states).map(|i| format!("x{i}")).chain((0..n_controls).map(|i| format!("u{i}"))).collect()
}
