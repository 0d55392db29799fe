//! Tables as CSV: a line for each row.

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::RecordError;

/// The rows in `text`, which has a header.
///
/// # Errors
/// What is wrong with a row, and where.
pub fn from_csv<T: DeserializeOwned>(text: &str) -> Result<Vec<T>, csv::Error> {
    csv::Reader::from_reader(text.as_bytes()).deserialize().collect()
}

/// `rows` under a header; nothing if there are none.
///
/// # Errors
/// [`RecordError::Csv`] for rows that are no flat lists of fields.
pub fn to_csv<T: Serialize>(rows: &[T]) -> Result<Vec<u8>, RecordError> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row)?;
    }
    Ok(writer.into_inner().map_err(|e| csv::Error::from(e.into_error()))?)
}

/// Why a table of numbers could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TableError {
    /// It is no CSV.
    #[error(transparent)]
    Csv(#[from] csv::Error),
    /// It has too few columns, or not as many as its states and inputs make.
    #[error("{got} columns, expected {needed} at least")]
    Columns {
        /// Columns found.
        got: usize,
        /// Columns needed.
        needed: usize,
    },
    /// A field holds no number.
    #[error("row {row}: `{field}` is not a number")]
    NotANumber {
        /// The row, from 1, without the header.
        row: usize,
        /// The field.
        field: String,
    },
}

/// The numbers of one row, `None` for an empty field; taken off from the front.
pub(crate) struct Fields(std::collections::VecDeque<Option<f64>>);

impl Fields {
    pub(crate) fn of<const N: usize>(first: [f64; N]) -> Self {
        Self(first.into_iter().map(Some).collect())
    }

    /// Adds `values`, or `width` empty fields where they are not as many or not all finite.
    pub(crate) fn add(&mut self, values: &[f64], width: usize) -> &mut Self {
        let whole = values.len() == width && values.iter().all(|v| v.is_finite());
        self.0.extend((0..width).map(|i| values.get(i).copied().filter(|_| whole)));
        self
    }

    /// The next `width` values; none if one of them is missing.
    pub(crate) fn take(&mut self, width: usize) -> Vec<f64> {
        let values: Vec<Option<f64>> = self.0.drain(..width.min(self.0.len())).collect();
        values.into_iter().collect::<Option<_>>().unwrap_or_default()
    }

    /// The next value as a count.
    pub(crate) fn whole(&mut self) -> usize {
        self.0.pop_front().flatten().unwrap_or(0.0) as usize
    }
}

/// The text of a table of numbers. Rust prints the shortest decimal that reads back as the same float64.
pub(crate) fn text_of(head: &[String], rows: impl Iterator<Item = Fields>) -> Result<Vec<u8>, RecordError> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(head)?;
    for Fields(values) in rows {
        writer.write_record(values.iter().map(|v| v.map_or_else(String::new, |v| v.to_string())))?;
    }
    Ok(writer.into_inner().map_err(|e| csv::Error::from(e.into_error()))?)
}

/// Header and rows of a table of numbers with at least `least` columns.
pub(crate) fn number_rows(text: &str, least: usize) -> Result<(Vec<String>, Vec<Fields>), TableError> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let head: Vec<String> = reader.headers()?.iter().map(String::from).collect();
    if head.len() < least {
        return Err(TableError::Columns { got: head.len(), needed: least });
    }
    let mut rows = Vec::new();
    for record in reader.records() {
        let number = |field: &str| match (field.is_empty(), field.parse::<f64>()) {
            (true, _) => Ok(None),
            (false, Ok(value)) if value.is_finite() => Ok(Some(value)),
            _ => Err(TableError::NotANumber { row: rows.len() + 1, field: field.chars().take(40).collect() }),
        };
        rows.push(Fields(record?.iter().map(number).collect::<Result<_, _>>()?));
    }
    Ok((head, rows))
}
