//! What a variable of the library stands for, as far as it is declared.

/// What is known about a variable before any data are seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// An angle that goes round: it enters only through its sine and cosine.
    Turning,
    /// An angle kept near one place.
    Angle,
    /// A quantity on the real line.
    Plain,
    /// The rate of another state.
    Rate,
    /// A control.
    Control,
}

/// A variable of the library.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Input {
    /// Its name in terms.
    pub name: String,
    /// What it stands for.
    pub role: Role,
    /// Whether its unit is the radian.
    pub in_radians: bool,
}

impl Input {
    /// A variable.
    #[must_use]
    pub fn new(name: &str, role: Role) -> Self {
        Self { name: name.into(), role, in_radians: false }
    }
}
