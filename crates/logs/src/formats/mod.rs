//! What a log is written in: told by its content, or refused with what its name says that it should be.

mod arrays;
mod budget;
mod format;
#[cfg(feature = "hdf5")]
mod hdf;
mod literal;
mod mat;
#[cfg(feature = "mcap")]
mod mcap;
#[cfg(feature = "mcap")]
mod messages;
mod npy;
mod npz;
#[cfg(feature = "parquet")]
mod parquet;

use std::path::Path;

use crate::table::Table;
use crate::{LogError, LogOptions};
use budget::Budget;
use format::Format;

/// What is known of a file before it is read.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Reading<'a> {
    /// What separates the cells of a text.
    pub(crate) delimiter: Option<u8>,
    /// Which messages of a file with several topics are the log.
    #[cfg_attr(not(feature = "mcap"), allow(dead_code, reason = "only MCAP has topics"))]
    pub(crate) topic: Option<&'a str>,
}

impl<'a> Reading<'a> {
    pub(crate) fn of(options: &'a LogOptions) -> Self {
        Self { delimiter: options.delimiter, topic: options.topic.as_deref() }
    }
}

/// Reads `bytes`, which messages call `path`.
pub(crate) fn read(path: &Path, bytes: Vec<u8>, reading: Reading<'_>) -> Result<Table, LogError> {
    let Some(format) = begun(&bytes) else {
        return match named(path) {
            Some(format) if !bytes.is_empty() => Err(format.failed(path, "it does not begin like one".into())),
            _ => Table::read(path, bytes, reading.delimiter),
        };
    };
    let name = path.file_stem().map_or_else(|| "x".to_owned(), |stem| stem.to_string_lossy().into_owned());
    let arrays = match format {
        Format::Npy => npy::arrays(&bytes, &name, &mut Budget::default()),
        Format::Npz => npz::arrays(&bytes),
        Format::Mat => mat::arrays(&bytes),
        #[cfg(feature = "hdf5")]
        Format::Hdf => guarded(|| hdf::arrays(bytes)),
        #[cfg(feature = "parquet")]
        Format::Parquet => guarded(|| parquet::arrays(bytes)),
        #[cfg(feature = "mcap")]
        Format::Mcap => return mcap::read(path, &bytes, reading.topic),
        #[cfg(not(all(feature = "hdf5", feature = "parquet", feature = "mcap")))]
        _ => return Err(format.built_without(path)),
    };
    arrays::table(path, arrays.map_err(|reason| format.failed(path, reason))?)
}

/// What `read` gives; of readers that panic over some damaged files (`parquet` 60.1: offsets below zero), an error there.
#[cfg(any(feature = "hdf5", feature = "parquet"))]
fn guarded(
    read: impl FnOnce() -> Result<Vec<arrays::Named>, String> + std::panic::UnwindSafe,
) -> Result<Vec<arrays::Named>, String> {
    std::panic::catch_unwind(read).unwrap_or_else(|_| Err("it is damaged".into()))
}

/// How HDF5 begins, after nothing or after a header of MATLAB's; Parquet; MCAP.
const HDF: &[u8] = b"\x89HDF\r\n\x1a\n";
const HDF_HEADER: usize = 512;
const PARQUET: &[u8] = b"PAR1";
const MCAP: &[u8] = b"\x89MCAP0\r\n";

/// The format that `bytes` begin as.
fn begun(bytes: &[u8]) -> Option<Format> {
    Some(match bytes {
        _ if bytes.starts_with(npy::MAGIC) => Format::Npy,
        _ if npz::MAGIC.iter().any(|magic| bytes.starts_with(magic)) => Format::Npz,
        _ if bytes.starts_with(HDF) => Format::Hdf,
        _ if bytes.get(HDF_HEADER..).is_some_and(|rest| rest.starts_with(HDF)) => Format::Hdf,
        _ if mat::is(bytes) => Format::Mat,
        _ if bytes.starts_with(PARQUET) => Format::Parquet,
        _ if bytes.starts_with(MCAP) => Format::Mcap,
        _ => return None,
    })
}

/// The format that a file called `path` should have.
fn named(path: &Path) -> Option<Format> {
    let extension = path.extension()?.to_string_lossy().to_lowercase();
    Some(match extension.as_str() {
        "npy" => Format::Npy,
        "npz" => Format::Npz,
        "mat" => Format::Mat,
        "h5" | "hdf5" => Format::Hdf,
        "parquet" => Format::Parquet,
        "mcap" => Format::Mcap,
        _ => return None,
    })
}
