//! Logged data for system identification: files in several formats, and what is known of their columns, as trajectories of a declared system.
//!
//! A log is a table of named columns, wherever it is from: text (CSV and its kin), arrays of NumPy (`.npz`, `.npy`), MAT files of MATLAB 5 to 7, and with the
//! features `mcap`, `parquet` and `hdf5` recordings of ROS 2, Parquet, HDF5 and MATLAB 7.3. What a file is, its content tells.
//!
//! [`Log::read`] checks the files row by row, splits them into trajectories, finds the times of samples, and recognises
//! what nobody declared: which column holds the time, in which unit, which state is the rate of which, which two columns are
//! cosine and sine of one angle, to how many digits a column was rounded. Each such decision is a [`Note`]; what makes the
//! samples hard to identify anything in is a [`Finding`]. From there on a log is a
//! [`Spec`](sindyna_core::Spec) and a [`Dataset`](sindyna_core::Dataset) like any other.
//!
//! ```
//! use sindyna_logs::{Log, LogOptions, Note};
//!
//! let text = "t,x,v,u\n0,0,0,1\n0.1,0.01,0.1,1\n0.2,0.03,0.2,-1\n0.3,0.04,0.1,-1\n0.4,0.04,0,0\n";
//! let options = LogOptions::new(["x", "v"]).with_inputs(["u"]);
//! let log = Log::parse("cart.csv", text.to_owned(), &options)?;
//! assert_eq!((log.rows, log.data.n_steps()), (5, 4));
//! assert!(log.notes.iter().any(|note| matches!(note, Note::Rate { rate, of, .. } if rate == "v" && of == "x")));
//! # Ok::<(), sindyna_logs::LogError>(())
//! ```
//!
//! Not here: regression, equations, the command line.

mod alike;
mod angles;
mod circles;
mod clock;
mod column;
mod columns;
mod date;
mod declaration;
mod declare;
mod derivatives;
mod differences;
mod doubts;
mod error;
mod formats;
mod held_out;
mod inspection;
mod jumps;
mod late_rates;
mod lattice;
mod layout;
mod log;
mod missing_code;
mod moments;
mod note;
mod note_text;
mod options;
mod place;
mod positions;
mod quality;
mod quotient;
mod rates;
mod recording;
mod resolution;
mod response;
mod roles;
mod rounding;
mod states;
mod suggestion;
mod table;
mod text;
mod time;
mod time_unit;
mod turned;
mod units;
mod unmeasured;
mod values;

pub use declaration::{DeclarationError, StateOption};
pub use error::LogError;
pub use held_out::{Samples, held_out};
pub use inspection::{Inspection, Response, Signal};
pub use log::Log;
pub use note::Note;
pub use options::{Clock, LogOptions, NO_INPUTS, NO_TIME, TIME, TRAJECTORY};
pub use place::{Place, Row};
pub use quality::{At, Finding};
pub use quotient::{Difference, Quotient};
pub use rates::closes_circle;
pub use suggestion::Suggestion;
pub use time_unit::{TimeUnit, UnitBy};
