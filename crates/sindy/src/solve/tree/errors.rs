//! How far rounding may be off in products.

/// Bounds on the rounding errors of a node's products.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Errors {
    /// Of the products of columns.
    pub(super) gram: f64,
    /// Of the products of columns with the residual.
    pub(super) overlap: f64,
    /// Of the squared residual.
    pub(super) rss: f64,
    /// Of the residual when it is computed from the columns.
    pub(super) drift: f64,
}
