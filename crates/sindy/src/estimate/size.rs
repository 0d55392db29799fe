//! How large the terms of equations are, beside the rates they make.

use super::problem::Problem;
use crate::Expr;
use crate::shooting::{Contribution, Fit, Flow, Place};

/// How large the terms of a hypothesis are.
pub(super) struct Size {
    /// −2 ln of what is believed of that before there are data.
    pub(super) size: f64,
    /// The largest contribution of a term to the rates, of each equation, as a multiple of these.
    pub(super) contributions: Vec<f64>,
}

impl Problem<'_> {
    /// Contributions are of the size of the rates, or seldom larger: a Cauchy distribution. Terms that cancel are worth it only where the data tell them
    /// so. Either the zero of the variables means something, or terms count from some other place, which is one more parameter. There a constant in the
    /// equation makes up for what all terms add; without one, variables by themselves may cancel, as differences of temperatures and levels do, and other
    /// terms add there what they add here.
    pub(super) fn size(&self, supports: &[Vec<usize>], flow: &Flow, fit: &Fit) -> Size {
        let contributions = flow.contributions(self.segments, &fit.x, &fit.xi, &self.places(supports));
        let mut rest = &contributions[..];
        let (mut size, mut largest) = (0.0, Vec::with_capacity(supports.len()));
        for support in supports {
            let (own, later) = rest.split_at(support.len());
            rest = later;
            let has_constant = support.iter().any(|&j| self.is_constant(j));
            let moves = |j: usize| has_constant || self.is_variable(j);
            let from_zero: Vec<f64> = own.iter().map(|c| c.whole).collect();
            let terms = || support.iter().zip(own);
            let left = |(&j, c): (&usize, &Contribution)| if moves(j) { c.beyond_constant } else { c.whole };
            let remaining: f64 = terms().filter(|(j, _)| moves(**j)).map(|(_, c)| c.constant).sum();
            let remaining = if has_constant { 0.0 } else { remaining.abs() };
            let from_elsewhere: Vec<f64> = terms().map(left).chain([remaining]).collect();
            let believed = |all: &[f64]| all.iter().map(|c| 2.0 * (c * c).ln_1p()).sum::<f64>();
            let (here, there) = (believed(&from_zero), believed(&from_elsewhere) + self.samples().ln());
            size += here.min(there);
            // Other terms that hardly change along the data stand for something else, whatever makes up for them.
            let counted = if here < there { from_zero } else { from_elsewhere };
            let is_affine = |j: usize| self.is_constant(j) || self.is_variable(j);
            let cancelling =
                terms().zip(counted).map(|((&j, c), counted)| if is_affine(j) { counted } else { c.whole });
            largest.push(cancelling.fold(0.0, f64::max));
        }
        Size { size, contributions: largest }
    }

    /// Where each coefficient of `supports` stands.
    fn places(&self, supports: &[Vec<usize>]) -> Vec<Place> {
        let mut places: Vec<Place> = Vec::new();
        for (row, support) in supports.iter().enumerate() {
            let constant = support.iter().position(|&j| self.is_constant(j)).map(|at| places.len() + at);
            places.resize(places.len() + support.len(), (row, constant));
        }
        places
    }

    /// Whether term `j` is the constant.
    pub(super) fn is_constant(&self, j: usize) -> bool {
        self.terms[j].rate.is_none() && self.terms[j].expr.is_one()
    }

    /// Whether term `j` is a variable by itself.
    pub(super) fn is_variable(&self, j: usize) -> bool {
        self.terms[j].rate.is_none() && matches!(self.terms[j].expr, Expr::Variable(_))
    }
}
