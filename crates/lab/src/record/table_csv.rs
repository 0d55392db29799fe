//! Tables as CSV: a line for each row.

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::failure::Failure;

/// The rows in `text`, which has a header.
pub(crate) fn from_csv<T: DeserializeOwned>(text: &str) -> Result<Vec<T>, csv::Error> {
    csv::Reader::from_reader(text.as_bytes()).deserialize().collect()
}

/// `rows` under a header; nothing if there are none.
pub(crate) fn to_csv<T: Serialize>(rows: &[T]) -> Result<Vec<u8>, Failure> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row)?;
    }
    Ok(writer.into_inner()?)
}
