//! Why a method or a comparison could not run.

use std::io;
use std::path::PathBuf;

use sindyna_control::ControlError;
use sindyna_core::{EnvError, FitError};
use sindyna_dyna::DynaError;
use sindyna_record::RecordError;
use sindyna_rl::{EnsembleError, SacError};
use sindyna_sindy::LibraryError;
use sindyna_training::Error;

/// Why a method or a comparison could not run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MethodError {
    /// A method that needs the true equations, on a system that does not tell them.
    #[error("the true equations of `{task}` are not known")]
    NoTruth {
        /// Name of the task.
        task: String,
    },
    /// A task for which there is no controller written by hand.
    #[error("there is no expert controller for `{task}`")]
    NoExpert {
        /// Name of the task.
        task: String,
    },
    /// A method that learns on the system, without settings to do so.
    #[error("there are no settings for `{method}`")]
    NoPreset {
        /// Name of the method.
        method: &'static str,
    },
    /// A directory with other files than those of a comparison.
    #[error("{} is not the directory of a comparison", path.display())]
    NotAComparison {
        /// The directory.
        path: PathBuf,
    },
    /// A comparison made with other settings.
    #[error("{} holds runs with other settings: {differ}", path.display())]
    OtherSettings {
        /// The directory.
        path: PathBuf,
        /// Which settings differ, and how.
        differ: String,
    },
    /// A task file that is not the one of the same name in a comparison.
    #[error("{} is another task of that name", path.display())]
    OtherTask {
        /// The file in the comparison.
        path: PathBuf,
    },
    /// A variant that has the name of one with other settings.
    #[error("{} holds runs of a variant `{name}` with other settings", path.display())]
    OtherVariant {
        /// The directory.
        path: PathBuf,
        /// Name of the variant.
        name: String,
    },
    /// An ensemble of networks that cannot be.
    #[error(transparent)]
    Ensemble(#[from] EnsembleError),
    /// A directory that cannot be made.
    #[error("cannot make the directory {}", path.display())]
    Folder {
        /// The directory.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// Settings that TOML cannot hold.
    #[error(transparent)]
    Settings(#[from] toml::ser::Error),
    /// A record that cannot be read or written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A problem, or settings, that cannot be.
    #[error(transparent)]
    Training(#[from] Error),
}

macro_rules! as_training {
    ($($error:ty),*) => {$(
        impl From<$error> for MethodError {
            fn from(error: $error) -> Self {
                Self::Training(error.into())
            }
        }
    )*};
}

as_training!(ControlError, DynaError, EnvError, FitError, LibraryError, SacError);

/// `error` and its causes in one line.
pub(crate) fn chain(error: &dyn std::error::Error) -> String {
    std::iter::successors(error.source(), |cause| cause.source())
        .fold(error.to_string(), |text, cause| format!("{text}: {cause}"))
}
