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
