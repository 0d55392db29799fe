//! What cuts a part of the tree.

/// What cuts a part of the tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Bound {
    /// Nothing: every subset is looked at.
    None,
    /// The residual of all columns that may still be chosen (leaps and bounds).
    Exclusion,
    /// Besides, what the columns gain alone, over the smallest eigenvalue that their correlations allow.
    Gains,
    /// Besides, a dual point of the perspective relaxation: cuts a little more, and costs more time than that saves
    /// where it was measured.
    Relaxation,
}
