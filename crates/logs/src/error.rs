//! Why a log could not be read, with file, line and column where there is one.

use std::fmt;
use std::path::PathBuf;

use sindyna_core::{DatasetError, number::significant};

use crate::declaration::quoted;
use crate::suggestion::Suggestion;
use crate::{DeclarationError, Row};

/// Why a log could not be read or does not fit what was said about it.
///
/// `line` counts from 1, the header included, a row of a binary file from 1 too; `column` is a name of the header.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LogError {
    /// The file cannot be read.
    #[error("cannot read {}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// The file is of a format that this program was built without.
    #[error("{} is {format}, which this build does not read (feature `{feature}`)", path.display())]
    BuiltWithout {
        /// The file.
        path: PathBuf,
        /// What it is.
        format: &'static str,
        /// The feature of the build that reads it.
        feature: &'static str,
    },
    /// The file is not what its beginning or its name says.
    #[error("{} cannot be read as {format}: {reason}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What it should be.
        format: &'static str,
        /// Why it is not.
        reason: String,
    },
    /// Of the arrays in the file none is a column.
    #[error("{} has no column of numbers{}", path.display(), left_out(arrays))]
    NoArrays {
        /// The file.
        path: PathBuf,
        /// What there is, and why it is none.
        arrays: Vec<(String, String)>,
    },
    /// An array was named that is no column.
    #[error("`{column}` of {} is not a column: {why}", path.display())]
    NotAColumn {
        /// The file.
        path: PathBuf,
        /// Its name.
        column: String,
        /// Why not.
        why: String,
    },
    /// The file holds several logs, of which one must be named.
    #[error("{} has messages on several topics: {}", path.display(), quoted(topics))]
    SeveralTopics {
        /// The file.
        path: PathBuf,
        /// The topics that can be read.
        topics: Vec<String>,
    },
    /// A topic was named that is not there.
    #[error("{} has no topic `{topic}` that can be read; known: {}", path.display(), if topics.is_empty() { "none".to_owned() } else { quoted(topics) })]
    UnknownTopic {
        /// The file.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// Those that can be read.
        topics: Vec<String>,
    },
    /// The file is not text.
    #[error("{}, line {line}: not UTF-8 text", path.display())]
    NotText {
        /// The file.
        path: PathBuf,
        /// Number of the line, from 1.
        line: usize,
    },
    /// There is nothing in it.
    #[error("{} is empty", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// There is nothing below the header.
    #[error("{} has a header but no rows", path.display())]
    NoRows {
        /// The file.
        path: PathBuf,
    },
    /// Cells are not separated by what they should be.
    #[error("{}, line {line}: `{header}` is one column", path.display())]
    OneColumn {
        /// The file.
        path: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// The line that should name the columns.
        header: String,
    },
    /// The first line names no columns.
    #[error("{}, line {line}: `{row}` is a row of numbers, not the names of the columns", path.display())]
    NoHeader {
        /// The file.
        path: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// The line.
        row: String,
    },
    /// Two columns have one name.
    #[error("{}, line {line}: columns {first} and {second} are both named `{column}`", path.display())]
    DuplicateColumn {
        /// The file.
        path: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// Number of the first one, from 1.
        first: usize,
        /// Number of the second one.
        second: usize,
        /// Name of the column.
        column: String,
    },
    /// The file ends within a line.
    #[error("{}, line {line}: cut off (`{text}`)", path.display())]
    CutOff {
        /// The file.
        path: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// What is left of the line.
        text: String,
    },
    /// A line within the file is empty.
    #[error("{}, line {line}: empty", path.display())]
    EmptyLine {
        /// The file.
        path: PathBuf,
        /// Number of the line, from 1.
        line: usize,
    },
    /// A line has more or fewer cells than the header.
    #[error("{}, line {line}: {cells} cell{} where the header names {expected} columns", path.display(), if *cells == 1 { "" } else { "s" })]
    Width {
        /// The file.
        path: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// Cells of the line.
        cells: usize,
        /// What there should be.
        expected: usize,
    },
    /// A quotation mark without its second.
    #[error("{}, line {line}: a quote is opened and never closed", path.display())]
    OpenQuote {
        /// The file.
        path: PathBuf,
        /// Number of the line, from 1.
        line: usize,
    },
    /// A cell that must be a number is none.
    #[error("{}, {row}: column `{column}`: {} is not a number", path.display(), Cell(cell))]
    NotANumber {
        /// The file.
        path: PathBuf,
        /// Where.
        row: Row,
        /// Name of the column.
        column: String,
        /// The text.
        cell: String,
    },
    /// A number is NaN or infinite.
    #[error("{}, {row}: column `{column}`: {} is not a finite number", path.display(), Cell(cell))]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// Where.
        row: Row,
        /// Name of the column.
        column: String,
        /// The text.
        cell: String,
    },
    /// The rows of one trajectory do not stand together.
    #[error("{}, {row}: trajectory `{label}` goes on after another one began", path.display())]
    Interleaved {
        /// The file.
        path: PathBuf,
        /// Where.
        row: Row,
        /// The trajectory.
        label: String,
    },
    /// The header gives a unit that this column cannot have.
    #[error("{}, line 1: column `{column}` is in `{unit}`; it must be in {expected}", path.display())]
    Unit {
        /// The file.
        path: PathBuf,
        /// Name of the column.
        column: String,
        /// The unit in the header.
        unit: String,
        /// What there should be.
        expected: &'static str,
    },
    /// No column was named as a state.
    #[error("which of the columns {} are states, and which are inputs?", quoted(columns))]
    ColumnsNotNamed {
        /// The file.
        path: PathBuf,
        /// Columns there are.
        columns: Vec<String>,
        /// Which are likely to be what.
        suggestion: Box<Suggestion>,
    },
    /// There is no column that could be a state.
    #[error("{} has no columns except the time and `trajectory`", path.display())]
    NoColumns {
        /// The file.
        path: PathBuf,
    },
    /// A column was named that is not there.
    #[error("{} has no column named `{column}`; known: {}", path.display(), quoted(known))]
    UnknownColumn {
        /// The file.
        path: PathBuf,
        /// Name of the column.
        column: String,
        /// Names there are.
        known: Vec<String>,
    },
    /// There are no time stamps, and no sampling interval was given.
    #[error("{} has no time column, such as `t` or `time`, and no sampling interval was given", path.display())]
    NoTime {
        /// The file.
        path: PathBuf,
    },
    /// The sampling interval that was given is not that of the time stamps.
    #[error("the sampling interval was given as {} s, but the samples are {} s apart by the time column `{column}`", significant(*dt, 6), significant(*stamps, 6))]
    OtherInterval {
        /// The interval given \[s\].
        dt: f64,
        /// The mean interval of the time stamps, gaps left out \[s\].
        stamps: f64,
        /// Their column.
        column: String,
    },
    /// Resampling needs time stamps.
    #[error("resampling needs a time column, such as `t` or `time`")]
    NoTimeToResample,
    /// Two logs give one column in two units.
    #[error("{}: column `{column}` is in `{unit}`; in {} it is in `{expected}`", path.display(), first.display())]
    OtherUnit {
        /// The file.
        path: PathBuf,
        /// Name of the column.
        column: String,
        /// Its unit there.
        unit: String,
        /// The file read first.
        first: PathBuf,
        /// The unit in that one.
        expected: String,
    },
    /// No log was named.
    #[error("no log was named")]
    NoLog,
    /// No rollout has a step.
    #[error("no trajectory has two rows, so there is no step")]
    NoStep,
    /// The unit of the time stamps is not told by anything.
    #[error("{}: the unit of {column} is not known: it increases by {step} in every row, which may be seconds or a fraction of them", path.display())]
    TimeUnit {
        /// The file.
        path: PathBuf,
        /// Name of the column.
        column: String,
        /// Its increase from row to row.
        step: f64,
    },
    /// Time stands still or runs back.
    #[error("{}, {row}: the time must increase: {column} = {after} follows {before}", path.display())]
    TimeNotIncreasing {
        /// The file.
        path: PathBuf,
        /// Name of the column.
        column: String,
        /// Where.
        row: Row,
        /// Stamp of the row.
        after: String,
        /// Stamp of the row before, and where that is.
        before: String,
    },
    /// Resampling would make more rows than are held in memory.
    #[error("resampling every {dt} s would make {rows:.0} rows; the maximum is {most:.0}")]
    TooManyRows {
        /// The sampling interval \[s\].
        dt: f64,
        /// Rows there would be.
        rows: f64,
        /// Rows there may be.
        most: f64,
    },
    /// A declaration does not fit the log, or contradicts another one.
    #[error(transparent)]
    Declared(#[from] DeclarationError),
    /// The rows do not make a data set.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
}

/// A cell as a message shows it.
struct Cell<'a>(&'a str);

impl fmt::Display for Cell<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() { f.write_str("an empty cell") } else { write!(f, "`{}`", self.0) }
    }
}

/// What was left out, and why.
fn left_out(arrays: &[(String, String)]) -> String {
    /// Arrays that are told.
    const TOLD: usize = 8;
    if arrays.is_empty() {
        return String::new();
    }
    let mut told: Vec<String> = arrays.iter().take(TOLD).map(|(name, why)| format!("`{name}` {why}")).collect();
    told.extend((arrays.len() > TOLD).then(|| "…".to_owned()));
    format!(": {}", told.join(", "))
}
