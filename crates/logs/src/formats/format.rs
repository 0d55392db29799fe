//! Which formats there are beside text, and what is said where one cannot be read.

use std::path::Path;

use crate::LogError;

/// A binary format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Npy,
    Npz,
    Mat,
    Hdf,
    Parquet,
    Mcap,
}

impl Format {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Npy => "an array of NumPy",
            Self::Npz => "an archive of NumPy's arrays",
            Self::Mat => "a MAT file of MATLAB 5 to 7",
            Self::Hdf => "HDF5 (a MAT file of MATLAB 7.3, too)",
            Self::Parquet => "Parquet",
            Self::Mcap => "MCAP",
        }
    }

    pub(super) fn failed(self, path: &Path, reason: String) -> LogError {
        LogError::Malformed { path: path.to_owned(), format: self.name(), reason }
    }

    #[cfg(not(all(feature = "hdf5", feature = "parquet", feature = "mcap")))]
    pub(super) fn built_without(self, path: &Path) -> LogError {
        let feature = match self {
            Self::Parquet => "parquet",
            Self::Mcap => "mcap",
            _ => "hdf5",
        };
        LogError::BuiltWithout { path: path.to_owned(), format: self.name(), feature }
    }
}
