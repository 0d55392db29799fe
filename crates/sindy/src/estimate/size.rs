//! How large the terms of equations are, beside the rates they make.

use super::search::Problem;
use crate::shooting::{Contribution, Fit, Flow};

/// How large the terms of a hypothesis are.
pub(super) struct Size {
    /// −2 ln of what is believed of that before there are data.
    pub(super) size: f64,
    /// The largest contribution of a term to the rates, of each equation, as a multiple of these.
    pub(super) contributions: Vec<f64>,
}

impl Problem<'_> {
    /// Contributions are of the size of the rates, or seldom larger: a Cauchy distribution. Terms that cancel are worth it only where the data tell them
    /// so. In an equation with a constant either the zero of its variables means something, or its terms count from some other place, for
    /// which the constant makes up: then what they add beyond the constant is of that size, and the place is one more parameter.
    pub(super) fn size(&self, supports: &[Vec<usize>], flow: &Flow, fit: &Fit) -> Size {
        let contributions = flow.contributions(self.segments, &fit.x, &fit.xi, &self.constants(supports));
        let mut rest = &contributions[..];
        let (mut size, mut largest) = (0.0, Vec::with_capacity(supports.len()));
        for support in supports {
            let (own, later) = rest.split_at(support.len());
            rest = later;
            let of = |contribution: fn(&Contribution) -> f64| {
                let believed = own.iter().map(|c| 2.0 * contribution(c).powi(2).ln_1p()).sum::<f64>();
                (believed, own.iter().map(contribution).fold(0.0, f64::max))
            };
            let from_zero = of(|c| c.whole);
            let mut from_elsewhere = of(|c| c.beyond_constant);
            from_elsewhere.0 += self.samples().ln();
            let has_constant = support.iter().any(|&j| self.is_constant(j));
            let (believed, own) =
                if has_constant && from_elsewhere.0 < from_zero.0 { from_elsewhere } else { from_zero };
            size += believed;
            largest.push(own);
        }
        Size { size, contributions: largest }
    }

    /// For each coefficient of `supports`, the number of that of the constant in its equation.
    fn constants(&self, supports: &[Vec<usize>]) -> Vec<Option<usize>> {
        let mut constants = Vec::new();
        for support in supports {
            let constant = support.iter().position(|&j| self.is_constant(j)).map(|at| constants.len() + at);
            constants.resize(constants.len() + support.len(), constant);
        }
        constants
    }

    /// Whether term `j` is the constant.
    fn is_constant(&self, j: usize) -> bool {
        self.terms[j].rate.is_none() && self.terms[j].expr.is_one()
    }
}
