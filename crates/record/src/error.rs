//! Why a record could not be written or read.

use std::io;
use std::path::PathBuf;

/// Why a record could not be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordError {
    /// The file system refused.
    #[error("cannot {action} {}", path.display())]
    Io {
        /// What was tried, such as `read`.
        action: &'static str,
        /// With which file or directory.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// Another process works in the directory.
    #[error("{} is in use by another sindyna process", path.display())]
    InUse {
        /// The directory.
        path: PathBuf,
    },
    /// The directory holds a record already.
    #[error("{} exists already; a run never overwrites another", path.display())]
    Exists {
        /// The directory.
        path: PathBuf,
    },
    /// The directory holds no run.
    #[error("{} holds no run: there is no config.toml in it", path.display())]
    NotARun {
        /// The directory.
        path: PathBuf,
    },
    /// No free name is left.
    #[error("no free number for {}", path.display())]
    NoNumberLeft {
        /// The name without a number.
        path: PathBuf,
    },
    /// Where a file should go is something that sindyna did not write.
    #[error("{} {why}", path.display())]
    NotOwn {
        /// The place.
        path: PathBuf,
        /// What is there.
        why: String,
    },
    /// A file has another form than it should.
    #[error("cannot understand {}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// One line of a file has another form than it should.
    #[error("cannot understand {}, line {line}: {why}", path.display())]
    MalformedLine {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong.
        why: String,
    },
    /// A file is of a version that this program does not know.
    #[error("{what} has format {format}; this version reads 1 to {known}")]
    Format {
        /// Which file.
        what: &'static str,
        /// Its version.
        format: u32,
        /// The newest known version.
        known: u32,
    },
    /// Files of a comparison do not belong together.
    #[error("{} is not a file of a comparison: {what}", path.display())]
    Inconsistent {
        /// The directory.
        path: PathBuf,
        /// What does not fit.
        what: String,
        /// Whether it is a digest, which is made of a comparison.
        is_digest: bool,
    },
    /// The directory is no comparison.
    #[error("{} holds no record: there is neither a config.toml nor a compare.toml in it", path.display())]
    NotAComparison {
        /// The directory.
        path: PathBuf,
        /// Why its settings cannot be read.
        source: io::Error,
    },
    /// The comparison has no runs.
    #[error("{} holds no runs", path.display())]
    NoRuns {
        /// The directory.
        path: PathBuf,
    },
    /// A file of a comparison is of another run than its name says.
    #[error("{} holds a run of {method} on {task} with seed {seed}", path.display())]
    OtherRun {
        /// The file.
        path: PathBuf,
        /// The method in it.
        method: String,
        /// The task in it.
        task: String,
        /// The seed in it.
        seed: u64,
    },
    /// A model cannot be stepped.
    #[error(transparent)]
    Model(#[from] crate::identification::ModelFileError),
    /// A state follows from no observation.
    #[error(transparent)]
    Unseen(#[from] sindyna_core::Unseen),
    /// A value has no JSON.
    #[error("a record cannot be written as JSON")]
    Json(#[from] serde_json::Error),
    /// Rows have no CSV.
    #[error("a record cannot be written as CSV")]
    Csv(#[from] csv::Error),
}

impl RecordError {
    /// For `map_err`: what was tried with which path.
    pub(crate) fn io(action: &'static str, path: impl Into<PathBuf>) -> impl FnOnce(io::Error) -> Self {
        let path = path.into();
        move |source| Self::Io { action, path, source }
    }
}
