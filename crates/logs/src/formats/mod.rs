//! What a log is written in: told by its content, or refused with what its name says that it should be.

mod arrays;
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

use std::io::Read;
use std::path::Path;

use crate::table::Table;
use crate::{LogError, LogOptions, text};

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
    let Some(format) = Format::of(&bytes) else {
        return match Format::named(path) {
            Some(format) if !bytes.is_empty() => Err(format.failed(path, "it does not begin as one".into())),
            _ => text::read(path, bytes, reading.delimiter),
        };
    };
    let name = path.file_stem().map_or_else(|| "x".to_owned(), |stem| stem.to_string_lossy().into_owned());
    let arrays = match format {
        Format::Npy => npy::arrays(&bytes, &name, &mut Budget::default()),
        Format::Npz => npz::arrays(&bytes),
        Format::Mat => mat::arrays(&bytes),
        #[cfg(feature = "hdf5")]
        Format::Hdf => hdf::arrays(bytes),
        #[cfg(feature = "parquet")]
        Format::Parquet => parquet::arrays(bytes),
        #[cfg(feature = "mcap")]
        Format::Mcap => return mcap::read(path, &bytes, reading.topic),
        #[cfg(not(all(feature = "hdf5", feature = "parquet", feature = "mcap")))]
        _ => return Err(format.built_without(path)),
    };
    arrays::table(path, arrays.map_err(|reason| format.failed(path, reason))?)
}

/// A binary format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Npy,
    Npz,
    Mat,
    Hdf,
    Parquet,
    Mcap,
}

/// How HDF5 begins, after nothing or after a header of MATLAB's; Parquet; MCAP.
const HDF: &[u8] = b"\x89HDF\r\n\x1a\n";
const HDF_HEADER: usize = 512;
const PARQUET: &[u8] = b"PAR1";
const MCAP: &[u8] = b"\x89MCAP0\r\n";

impl Format {
    /// The format that `bytes` begin as.
    fn of(bytes: &[u8]) -> Option<Self> {
        Some(match bytes {
            _ if bytes.starts_with(npy::MAGIC) => Self::Npy,
            _ if npz::MAGIC.iter().any(|magic| bytes.starts_with(magic)) => Self::Npz,
            _ if bytes.starts_with(HDF) => Self::Hdf,
            _ if bytes.get(HDF_HEADER..).is_some_and(|rest| rest.starts_with(HDF)) => Self::Hdf,
            _ if mat::is(bytes) => Self::Mat,
            _ if bytes.starts_with(PARQUET) => Self::Parquet,
            _ if bytes.starts_with(MCAP) => Self::Mcap,
            _ => return None,
        })
    }

    /// The format that a file called `path` should have.
    fn named(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_string_lossy().to_lowercase();
        Some(match extension.as_str() {
            "npy" => Self::Npy,
            "npz" => Self::Npz,
            "mat" => Self::Mat,
            "h5" | "hdf5" => Self::Hdf,
            "parquet" => Self::Parquet,
            "mcap" => Self::Mcap,
            _ => return None,
        })
    }

    fn name(self) -> &'static str {
        match self {
            Self::Npy => "an array of NumPy",
            Self::Npz => "an archive of NumPy's arrays",
            Self::Mat => "a MAT file of MATLAB 5 to 7",
            Self::Hdf => "HDF5 (a MAT file of MATLAB 7.3, too)",
            Self::Parquet => "Parquet",
            Self::Mcap => "MCAP",
        }
    }

    fn failed(self, path: &Path, reason: String) -> LogError {
        LogError::Malformed { path: path.to_owned(), format: self.name(), reason }
    }

    #[cfg(not(all(feature = "hdf5", feature = "parquet", feature = "mcap")))]
    fn built_without(self, path: &Path) -> LogError {
        let feature = match self {
            Self::Parquet => "parquet",
            Self::Mcap => "mcap",
            _ => "hdf5",
        };
        LogError::BuiltWithout { path: path.to_owned(), format: self.name(), feature }
    }
}

/// Bytes that may be unpacked of one file, or that its numbers may take: a small one may unpack to more than any memory.
#[derive(Debug)]
struct Budget {
    left: usize,
}

/// Numbers of a log that are held in memory.
const MOST_NUMBERS: usize = 1 << 25;

impl Default for Budget {
    fn default() -> Self {
        Self { left: 8 * MOST_NUMBERS }
    }
}

impl Budget {
    /// Takes `bytes` of it.
    fn spend(&mut self, bytes: usize) -> Result<(), String> {
        let left = self.left.checked_sub(bytes).ok_or("it has more than 256 MiB of numbers, the most that is read")?;
        self.left = left;
        Ok(())
    }

    /// All that `packed` unpacks to.
    fn read(&mut self, packed: impl Read) -> Result<Vec<u8>, String> {
        let mut bytes = Vec::new();
        let most = self.left as u64 + 1;
        let read = packed.take(most).read_to_end(&mut bytes).map_err(|e| format!("it cannot be unpacked: {e}"))?;
        self.spend(read)?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write as _;

    #[test]
    fn a_small_file_that_unpacks_to_much_is_refused() {
        let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
        packed.write_all(&[0; 1 << 20]).unwrap();
        let packed = packed.finish().unwrap();
        let read = |left: usize| Budget { left }.read(flate2::read::ZlibDecoder::new(&packed[..]));
        assert_eq!(read(1 << 20).unwrap().len(), 1 << 20);
        assert!(packed.len() < 2000 && read((1 << 20) - 1).unwrap_err().contains("more than 256 MiB"));
    }
}
