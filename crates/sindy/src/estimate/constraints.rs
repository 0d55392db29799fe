//! What is known of an equation before its terms are looked for.

/// Constraints on one equation; terms by their number.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Constraints {
    /// Terms with coefficients that are given.
    pub(crate) fixed: Vec<(usize, f64)>,
    /// Terms the equation has, with any coefficient.
    pub(crate) required: Vec<usize>,
    /// Terms it does not have.
    pub(crate) forbidden: Vec<usize>,
    /// Signs that coefficients have, where the equation has these terms.
    pub(crate) signs: Vec<(usize, f64)>,
}

impl Constraints {
    /// Whether nothing is known.
    pub(super) fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Whether the equation may have term `j` with a coefficient that is fitted.
    pub(super) fn allows(&self, j: usize) -> bool {
        !self.forbidden.contains(&j) && !self.fixed.iter().any(|(k, _)| *k == j)
    }

    /// Whether the coefficients have the signs they should.
    pub(super) fn agrees(&self, support: &[usize], coefficients: &[f64]) -> bool {
        let wrong = |(j, sign): &(usize, f64)| support.iter().zip(coefficients).any(|(k, c)| k == j && c * sign < 0.0);
        !self.signs.iter().any(wrong)
    }
}
