//! Parquet: columns of numbers, and of lists of them.

use bytes::Bytes;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::{Field, Row};

use super::arrays::{Array, Named};
use super::budget::Budget;
use crate::values::Values;

/// The columns in `bytes`.
pub(super) fn arrays(bytes: Vec<u8>) -> Result<Vec<Named>, String> {
    let told = |e: parquet::errors::ParquetError| e.to_string();
    let reader = SerializedFileReader::new(Bytes::from(bytes)).map_err(told)?;
    let mut budget = Budget::default();
    for group in reader.metadata().row_groups() {
        for column in group.columns() {
            budget.spend(usize::try_from(column.uncompressed_size()).map_err(|_| "a column has a size below zero")?)?;
        }
    }
    let mut columns: Vec<(String, Collected)> = Vec::new();
    for (number, row) in reader.get_row_iter(None).map_err(told)?.enumerate() {
        let row: Row = row.map_err(told)?;
        for (i, (name, field)) in row.get_column_iter().enumerate() {
            if columns.len() == i {
                columns.push((name.clone(), Collected::default()));
            }
            budget.spend(if let Field::ListInternal(list) = field { 16 * list.len() } else { 16 })?;
            columns[i].1.push(number, field);
        }
    }
    Ok(columns.into_iter().map(|(name, column)| (name, column.array())).collect())
}

/// A column so far.
#[derive(Default)]
struct Collected {
    kind: Kind,
    whole: Vec<i64>,
    broken: Vec<f64>,
    texts: Vec<String>,
    unit: &'static str,
    /// Numbers in each row, if rows are lists.
    width: Option<usize>,
    failure: Option<String>,
}

#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
enum Kind {
    #[default]
    Unknown,
    Whole,
    Narrow,
    Broken,
    Text,
}

impl Collected {
    fn push(&mut self, row: usize, field: &Field) {
        if self.failure.is_some() {
            return;
        }
        let Field::ListInternal(list) = field else { return self.one(field) };
        let elements = list.elements();
        if *self.width.get_or_insert(elements.len()) != elements.len() {
            self.failure = Some(format!("has a list of another length in row {}", row + 1));
            return;
        }
        elements.iter().for_each(|element| self.one(element));
    }

    fn one(&mut self, field: &Field) {
        let (kind, whole, broken) = match field {
            Field::Null => (Kind::Unknown, 0, f64::NAN),
            Field::Bool(v) => (Kind::Whole, i64::from(*v), 0.0),
            Field::Byte(v) => (Kind::Whole, i64::from(*v), 0.0),
            Field::Short(v) => (Kind::Whole, i64::from(*v), 0.0),
            Field::Int(v) => (Kind::Whole, i64::from(*v), 0.0),
            Field::Long(v) => (Kind::Whole, *v, 0.0),
            Field::UByte(v) => (Kind::Whole, i64::from(*v), 0.0),
            Field::UShort(v) => (Kind::Whole, i64::from(*v), 0.0),
            Field::UInt(v) => (Kind::Whole, i64::from(*v), 0.0),
            Field::ULong(v) => (Kind::Whole, i64::try_from(*v).unwrap_or(i64::MAX), 0.0),
            Field::TimestampMillis(v) => self.time("ms", *v),
            Field::TimestampMicros(v) => self.time("us", *v),
            Field::Float16(v) => (Kind::Narrow, 0, f64::from(f32::from(*v))),
            Field::Float(v) => (Kind::Narrow, 0, f64::from(*v)),
            Field::Double(v) => (Kind::Broken, 0, *v),
            Field::Str(v) => {
                self.texts.push(v.clone());
                (Kind::Text, 0, 0.0)
            }
            _ => {
                self.failure = Some("is not a column of numbers".into());
                return;
            }
        };
        match (self.kind, kind) {
            (Kind::Unknown, _) => self.kind = kind,
            (_, Kind::Unknown) => {}
            (before, now) if before == now => {}
            _ => self.failure = Some("has values of several types".into()),
        }
        self.whole.push(whole);
        // What is missing among whole numbers has no other sign.
        self.broken.push(if kind == Kind::Whole { whole as f64 } else { broken });
    }

    fn time(&mut self, unit: &'static str, value: i64) -> (Kind, i64, f64) {
        self.unit = unit;
        (Kind::Whole, value, 0.0)
    }

    fn array(self) -> Result<Array, String> {
        if let Some(failure) = self.failure {
            return Err(failure);
        }
        let missing = self.broken.iter().any(|v| v.is_nan());
        let values = match self.kind {
            Kind::Unknown => return Err("is empty".into()),
            Kind::Text if self.texts.len() < self.broken.len() => return Err("is text with gaps".into()),
            Kind::Text => Values::Text(self.texts),
            Kind::Whole if !missing => Values::I64(self.whole),
            Kind::Narrow => Values::F32(self.broken.iter().map(|v| *v as f32).collect()),
            Kind::Whole | Kind::Broken => Values::F64(self.broken),
        };
        let shape = match self.width {
            Some(width) if width > 0 => vec![values.len() / width, width],
            _ => vec![values.len()],
        };
        Ok(Array { shape, values, columns_first: false, unit: self.unit.to_owned() })
    }
}
