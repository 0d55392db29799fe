//! What sindyna leaves on the disk, as types that others can read and write.
//!
//! - [`run`]: a training run (`summary.json`, `timing.json`, `events.jsonl`, `rollout.csv`, `episode.csv`) and its directory;
//! - [`identification`]: what was identified and how far to believe it (`identify.json`), models (`model.json`) and what they
//!   predict (`prediction.csv`);
//! - [`ModelRecord`], [`RunRecord`]: all of one of them;
//! - [`comparison`]: what runs of several methods came to, one file each, and the digest of all of them.
//!
//! Every JSON file has a format version in its field `format`; where the field is absent it is 1. A reader refuses
//! versions it does not know. Files are written under a temporary name and renamed, so none is ever half there.
//!
//! ```
//! use sindyna_record::run::Evaluation;
//!
//! let evaluation = Evaluation::of(vec![-150.0, -170.0]);
//! assert_eq!((evaluation.mean_return, evaluation.std_return), (-160.0, 10.0));
//! ```
//!
//! Not here: settings of a run, pages and figures, the command line.

pub mod comparison;
mod error;
mod file;
mod format;
pub mod identification;
mod own;
pub mod run;
mod table_csv;
mod whole;

pub use error::RecordError;
pub use file::{cause, is_unfinished, json, save, sweep};
pub use own::Own;
pub use table_csv::{TableError, from_csv, to_csv};
pub use whole::{ModelRecord, RunRecord};
