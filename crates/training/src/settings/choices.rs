//! Settings that are one of a few names.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use sindyna_control::Method;
use sindyna_core::{Explorer, Precision, Spec};
use sindyna_dyna::{Alternating, Rollouts, Swings, Uniform};
use sindyna_rl::Isa;
use sindyna_sindy::{
    BestSubset, CoordinateMode, Differentiator, LibraryChoice, SavitzkyGolay, SolverChoice, Stlsq, Target,
};

/// An enum whose variants have names: in files, on the command line and in messages.
macro_rules! named {
    ($(#[$doc:meta])* $name:ident { $($(#[$about:meta])* $variant:ident = $text:literal,)+ }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]

        pub enum $name {
            $($(#[$about])* #[serde(rename = $text)] #[value(name = $text)] $variant,)+
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(match self { $(Self::$variant => $text,)+ })
            }
        }
    };
}

named! {
    /// Simulator of the system.
    SimulatorName {
        /// Built in
        Native = "native",
        /// MuJoCo, found at run time
        Mujoco = "mujoco",
        /// The program of --pipe
        Pipe = "pipe",
        /// None: there is only a log
        None = "none",
    }
}

named! {
    /// Precision of the recorded states.
    PrecisionName {
        /// Single precision
        F32 = "f32",
        /// Double precision
        F64 = "f64",
    }
}

named! {
    /// Controller.
    #[derive(Default)]
    ControllerName {
        /// Soft actor-critic, trained in the equations
        #[default]
        Sac = "sac",
        /// Linear-quadratic regulator of the equilibrium with the highest reward, with the curvature of the reward there as its weights
        Lqr = "lqr",
        /// Iterative LQR (differential dynamic programming) in receding horizon
        Ilqr = "ilqr",
        /// Model predictive path integral control
        Mppi = "mppi",
        /// The quickest planner (of lqr, ilqr and mppi) with the highest return in the equations
        Auto = "auto",
    }
}

impl ControllerName {
    /// The methods of planning that are tried; none where a policy is trained.
    pub fn methods(&self) -> &'static [Method] {
        match self {
            Self::Sac => &[],
            Self::Lqr => &[Method::Lqr],
            Self::Ilqr => &[Method::Ilqr],
            Self::Mppi => &[Method::Mppi],
            Self::Auto => &Method::ALL,
        }
    }

    /// Whether a policy is trained.
    pub fn trains(&self) -> bool {
        self.methods().is_empty()
    }
}

named! {
    /// Policy of the warm-up.
    ExplorerName {
        /// 6 to 8 steps to one side, then to the other, of random size
        Swings = "swings",
        /// Alternating directions of random size
        Alternating = "alternating",
        /// Uniformly random actions
        Random = "random",
    }
}

named! {
    /// Candidate terms.
    LibraryName {
        /// Chosen from the kinds of the states and inputs (docs/concepts.md)
        Auto = "auto",
        /// The library of the paper
        Paper = "paper",
        /// The library of the paper with terms up to degree 2 for small systems
        PaperDegree2 = "paper-degree2",
    }
}

named! {
    /// Sparse regression.
    SolverName {
        /// Best subset of terms by the extended BIC of its predictions
        BestSubset = "best-subset",
        /// Sequentially thresholded least squares (PySINDy's, and the paper's)
        Stlsq = "stlsq",
        /// All terms, with a ridge weight
        LeastSquares = "least-squares",
    }
}

named! {
    /// Target of the regression.
    TargetName {
        /// Equations of motion with their integration scheme; declared rates are used. With best-subset in recognised
        /// coordinates; otherwise the same as `increment`
        Motion = "motion",
        /// Δx/Δt
        Increment = "increment",
        /// The next state
        Discrete = "discrete",
        /// The derivative by central differences
        Continuous = "continuous",
        /// The derivative after Savitzky–Golay smoothing
        Smoothed = "smoothed",
    }
}

named! {
    /// Coordinates of the states.
    CoordinatesName {
        /// Angles recognised, cosine and sine joined
        Recognised = "recognised",
        /// Observations as states
        Raw = "raw",
    }
}

named! {
    /// Vector instructions of the updates.
    IsaName {
        /// Instructions of every machine
        Portable = "portable",
        /// NEON of 64-bit Arm, which gives the same bytes as AVX2
        Neon = "neon",
        /// AVX2 with fused multiply-add
        Avx2 = "avx2",
        /// AVX-512, which gives the same bytes as AVX2
        Avx512 = "avx512",
    }
}

/// Share of random actions among alternating ones ("occasional random actions", Arora et al. 2022, §4).
const RANDOM_SHARE: f64 = 0.2;

impl ExplorerName {
    /// The explorer for the action space of `spec`.
    pub fn explorer(self, spec: &Spec) -> Box<dyn Explorer> {
        match self {
            Self::Swings => Box::new(Swings::new(spec)),
            Self::Alternating => Box::new(Alternating::new(spec, RANDOM_SHARE)),
            Self::Random => Box::new(Uniform::new(spec)),
        }
    }
}

impl From<PrecisionName> for Precision {
    fn from(name: PrecisionName) -> Self {
        match name {
            PrecisionName::F32 => Self::F32,
            PrecisionName::F64 => Self::F64,
        }
    }
}

impl From<Precision> for PrecisionName {
    fn from(precision: Precision) -> Self {
        match precision {
            Precision::F32 => Self::F32,
            Precision::F64 => Self::F64,
        }
    }
}

impl LibraryName {
    /// The library of this name.
    pub fn library(self) -> LibraryChoice {
        match self {
            Self::Auto => LibraryChoice::Auto,
            Self::Paper => LibraryChoice::Paper,
            Self::PaperDegree2 => LibraryChoice::PaperDegree2,
        }
    }
}

impl SolverName {
    /// The solver, with the settings of those that have some.
    pub fn solver(self, stlsq: Stlsq, ridge: f64) -> SolverChoice {
        match self {
            Self::BestSubset => SolverChoice::BestSubset(BestSubset::default()),
            Self::Stlsq => SolverChoice::Stlsq(stlsq),
            Self::LeastSquares => SolverChoice::LeastSquares { ridge },
        }
    }
}

impl TargetName {
    /// The target of this name.
    pub fn target(self) -> Target {
        let scheme = sindyna_core::Scheme::Rk4 { substeps: 1 };
        match self {
            Self::Motion => Target::Motion,
            Self::Increment => Target::Increment,
            Self::Discrete => Target::Discrete,
            Self::Continuous => Target::Continuous { differentiator: Differentiator::default(), scheme },
            Self::Smoothed => {
                let differentiator = Differentiator::Smoothed(SavitzkyGolay::default());
                Target::Continuous { differentiator, scheme }
            }
        }
    }
}

impl CoordinatesName {
    /// The coordinates of this name.
    pub fn coordinates(self) -> CoordinateMode {
        match self {
            Self::Recognised => CoordinateMode::Recognised,
            Self::Raw => CoordinateMode::Raw,
        }
    }
}

impl IsaName {
    /// The instructions of this name.
    pub fn isa(self) -> Isa {
        match self {
            Self::Portable => Isa::Portable,
            Self::Neon => Isa::Neon,
            Self::Avx2 => Isa::Avx2,
            Self::Avx512 => Isa::Avx512,
        }
    }
}

/// N of Algorithm 1: imagined rollouts for each real one, as `auto`, `inf` or a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImaginedRollouts(pub Rollouts);

impl fmt::Display for ImaginedRollouts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Rollouts::Auto => f.write_str("auto"),
            Rollouts::Unlimited => f.write_str("inf"),
            Rollouts::Count(n) => write!(f, "{n}"),
        }
    }
}

impl FromStr for ImaginedRollouts {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match (text, text.parse()) {
            ("auto", _) => Ok(Self(Rollouts::Auto)),
            ("inf", _) => Ok(Self(Rollouts::Unlimited)),
            (_, Ok(n)) if n > 0 => Ok(Self(Rollouts::Count(n))),
            _ => Err(format!("must be `auto`, `inf` or a number from 1, got `{text}`")),
        }
    }
}

impl Serialize for ImaginedRollouts {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for ImaginedRollouts {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_library_of_equations() {
        use clap::ValueEnum as _;
        for target in TargetName::value_variants() {
            assert_eq!(target.to_string().parse(), Ok(target.target()));
        }
        for library in LibraryName::value_variants() {
            assert_eq!(library.to_string().parse(), Ok(library.library()));
        }
        for isa in IsaName::value_variants() {
            assert_eq!(isa.to_string().parse(), Ok(isa.isa()));
        }
        for coordinates in CoordinatesName::value_variants() {
            assert_eq!(coordinates.to_string().parse(), Ok(coordinates.coordinates()));
        }
        for text in ["auto", "inf", "7"] {
            assert_eq!(text.parse::<ImaginedRollouts>().map(|r| r.to_string()), Ok(text.to_owned()));
        }
        assert!("0".parse::<ImaginedRollouts>().is_err());
    }
}
