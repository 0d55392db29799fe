//! Instruction sets the update can run with, and which of them this machine has.

use std::{fmt, str::FromStr};

/// Vector instructions of the matrix products.
///
/// Each gives the same bits on every machine and with any number of threads beside it. All but [`Isa::Portable`] give the
/// same bits as each other: every sum is one chain of fused products in the same order, whatever the width of the vectors.
/// [`Isa::Portable`] rounds products and sums apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Isa {
    /// What every machine has.
    Portable,
    /// NEON, 4 numbers at a time.
    Neon,
    /// AVX2 with fused multiply-add, 8 numbers at a time.
    Avx2,
    /// AVX-512, 16 numbers at a time.
    Avx512,
}

/// Why an instruction set cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum IsaError {
    /// No instruction set has this name.
    #[error("no instruction set named `{name}`; known: `portable`, `neon`, `avx2`, `avx512`")]
    Unknown {
        /// The name.
        name: String,
    },
    /// The machine lacks it.
    #[error("this machine has no {isa}; the widest it has is {widest}")]
    Missing {
        /// What was asked for.
        isa: Isa,
        /// What there is.
        widest: Isa,
    },
}

impl Isa {
    /// All of them, the plainest first.
    pub const ALL: [Self; 4] = [Self::Portable, Self::Neon, Self::Avx2, Self::Avx512];

    /// The widest this machine has.
    #[must_use]
    pub fn widest() -> Self {
        Self::ALL.into_iter().rfind(|isa| isa.present()).unwrap_or(Self::Portable)
    }

    /// This instruction set, if the machine has it.
    ///
    /// # Errors
    /// [`IsaError::Missing`] if it has not.
    pub fn checked(self) -> Result<Self, IsaError> {
        if self.present() { Ok(self) } else { Err(IsaError::Missing { isa: self, widest: Self::widest() }) }
    }

    /// The name: `portable`, `neon`, `avx2` or `avx512`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            Self::Neon => "neon",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }

    #[cfg(target_arch = "x86_64")]
    pub(crate) fn present(self) -> bool {
        let avx2 = std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma");
        match self {
            Self::Portable => true,
            Self::Neon => false,
            Self::Avx2 => avx2,
            Self::Avx512 => avx2 && std::is_x86_feature_detected!("avx512f"),
        }
    }

    #[cfg(target_arch = "aarch64")]
    pub(crate) fn present(self) -> bool {
        self == Self::Portable || self == Self::Neon && std::arch::is_aarch64_feature_detected!("neon")
    }

    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    pub(crate) fn present(self) -> bool {
        self == Self::Portable
    }
}

impl fmt::Display for Isa {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Isa {
    type Err = IsaError;

    fn from_str(name: &str) -> Result<Self, IsaError> {
        Self::ALL.into_iter().find(|isa| isa.name() == name).ok_or_else(|| IsaError::Unknown { name: name.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back_and_others_refused() {
        for isa in Isa::ALL {
            assert_eq!(isa.to_string().parse(), Ok(isa));
        }
        assert!(matches!("sse9".parse::<Isa>(), Err(IsaError::Unknown { .. })));
    }

    #[test]
    fn the_widest_is_there_and_so_is_the_plainest() {
        assert_eq!(Isa::widest().checked(), Ok(Isa::widest()));
        assert_eq!(Isa::Portable.checked(), Ok(Isa::Portable));
    }
}
