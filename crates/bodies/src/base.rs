//! Base parameters: the combinations of parameters that motions can tell.

use nalgebra::{DMatrix, DVector};

use crate::Tree;
use crate::regressor::inverse_dynamics;

/// Motions drawn for each parameter.
const DRAWN: usize = 4;

/// Part of a column that is not in the span of those before it, below which it is.
const NOTHING: f64 = 1e-8;

/// Part of the largest column below which one is rounding alone: a parameter that no motion moves.
const ROUNDING: f64 = 1e-12;

/// Coefficients that are written as they are, not rounded to zero.
const SMALL: f64 = 1e-9;

/// The combinations of the parameters of a tree that any motion can tell.
#[derive(Debug, Clone, PartialEq)]
pub struct Base {
    /// Of each combination the parameters with their factors, that with factor 1 first.
    pub combinations: Vec<Vec<(usize, f64)>>,
    /// Number of all parameters.
    pub(crate) n_parameters: usize,
}

impl Base {
    /// The combinations for `tree`: parameters in their order, less those whose effect is that of a combination of earlier ones, which they are added to.
    ///
    /// # References
    /// Gautier (1991), Journal of Robotic Systems 8(4): base parameters by QR decomposition.
    #[must_use]
    pub fn of(tree: &Tree) -> Self {
        let n = tree.len();
        let n_parameters = tree.names().len();
        let mut draws = Spread::default();
        let mut all = DMatrix::zeros(0, n_parameters);
        for _ in 0..(DRAWN * n_parameters).div_ceil(n) {
            let mut drawn = |scale: f64| (0..n).map(|_| scale * draws.next()).collect::<Vec<f64>>();
            let rows = inverse_dynamics(tree, &drawn(3.0), &drawn(3.0), &drawn(10.0));
            let at = all.nrows();
            all = all.resize_vertically(at + n, 0.0);
            all.rows_mut(at, n).copy_from(&rows);
        }
        let largest = all.column_iter().map(|column| column.norm()).fold(0.0, f64::max);
        let mut independent: Vec<usize> = Vec::new();
        // Orthonormal directions of these, and what each column is of them.
        let mut directions: Vec<DVector<f64>> = Vec::new();
        let mut combinations: Vec<Vec<(usize, f64)>> = Vec::new();
        for p in 0..n_parameters {
            let column = all.column(p).into_owned();
            let size = column.norm();
            if size <= ROUNDING * largest {
                continue;
            }
            let mut rest = column.clone();
            // Twice is enough.
            for _ in 0..2 {
                for direction in &directions {
                    let part = direction.dot(&rest);
                    rest.axpy(-part, direction, 1.0);
                }
            }
            if rest.norm() > NOTHING * size {
                directions.push(rest.normalize());
                independent.push(p);
                combinations.push(vec![(p, 1.0)]);
                continue;
            }
            let before = all.select_columns(&independent);
            let Ok(factors) = before.svd(true, true).solve(&column, 1e-12) else { continue };
            for (combination, factor) in combinations.iter_mut().zip(factors.iter()) {
                if factor.abs() > SMALL {
                    combination.push((p, *factor));
                }
            }
        }
        Self { combinations, n_parameters }
    }

    /// Number of combinations.
    #[must_use]
    pub fn len(&self) -> usize {
        self.combinations.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.combinations.is_empty()
    }

    /// The columns of `rows` (N, 13 n) that stand for the combinations (N, b).
    pub(crate) fn columns(&self, rows: &DMatrix<f64>) -> DMatrix<f64> {
        rows.select_columns(&self.combinations.iter().map(|c| c[0].0).collect::<Vec<_>>())
    }

    /// The values of the combinations (b) for all `parameters` (13 n).
    #[must_use]
    pub fn values(&self, parameters: &[f64]) -> Vec<f64> {
        self.combinations.iter().map(|c| c.iter().map(|(p, factor)| factor * parameters[*p]).sum()).collect()
    }

    /// The combinations of the values `base` (b) as all parameters (13 n), zero but for the first of each combination.
    pub(crate) fn as_parameters(&self, base: &[f64]) -> Vec<f64> {
        let mut all = vec![0.0; self.n_parameters];
        self.combinations.iter().zip(base).for_each(|(c, value)| all[c[0].0] = *value);
        all
    }

    /// Combination `i` in words, such as `Izz(link1) + 0.09 m(link2)`.
    #[must_use]
    pub fn told(&self, i: usize, names: &[String]) -> String {
        let mut text = String::new();
        for (at, (p, factor)) in self.combinations[i].iter().enumerate() {
            let (sign, size) = (if *factor < 0.0 { "\u{2212}" } else { "+" }, factor.abs());
            let number = if (size - 1.0).abs() < SMALL { String::new() } else { format!("{} ", shortened(size)) };
            match at {
                0 => text += &names[*p],
                _ => text += &format!(" {sign} {number}{}", names[*p]),
            }
        }
        text
    }
}

/// A number with up to four digits.
fn shortened(value: f64) -> String {
    let text = format!("{value:.3e}");
    text.parse::<f64>().map_or(text, |value| value.to_string())
}

/// Numbers from −1 to 1, spread without order.
#[derive(Default)]
struct Spread(u32);

impl Spread {
    fn next(&mut self) -> f64 {
        // The fractional parts of multiples of irrational numbers.
        self.0 += 1;
        let step = f64::from(self.0) * (2.0 + f64::from(self.0 % 7)).sqrt() * 0.618_033_988_749_894_9;
        2.0 * step.fract() - 1.0
    }
}
