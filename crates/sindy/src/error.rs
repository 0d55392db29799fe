//! Settings that cannot be.

/// A setting out of its range.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{name} must be {wanted}, got {value}")]
pub struct InvalidParam {
    /// Which setting.
    pub name: &'static str,
    /// The value it was given.
    pub value: f64,
    /// What it may be.
    pub wanted: &'static str,
}

pub(crate) fn at_least_zero(name: &'static str, value: f64) -> Result<f64, InvalidParam> {
    if value.is_finite() && value >= 0.0 {
        Ok(value)
    } else {
        Err(InvalidParam { name, value, wanted: "finite and >= 0" })
    }
}

/// A name that names nothing.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("no {what} named `{name}`; known: {known}")]
pub struct UnknownName {
    /// What was looked for.
    pub what: &'static str,
    /// The name.
    pub name: String,
    /// Names that would be right.
    pub known: &'static str,
}
