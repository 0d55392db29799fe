//! Numbers of binary files, and the cells that stand for them.

use std::borrow::Cow;

/// The values of a column.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Values {
    F64(Vec<f64>),
    F32(Vec<f32>),
    I64(Vec<i64>),
    U64(Vec<u64>),
    Text(Vec<String>),
}

impl Values {
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::F64(v) => v.len(),
            Self::F32(v) => v.len(),
            Self::I64(v) => v.len(),
            Self::U64(v) => v.len(),
            Self::Text(v) => v.len(),
        }
    }

    /// The values at `places`.
    pub(crate) fn at(&self, places: impl Iterator<Item = usize>) -> Self {
        match self {
            Self::F64(v) => Self::F64(places.map(|i| v[i]).collect()),
            Self::F32(v) => Self::F32(places.map(|i| v[i]).collect()),
            Self::I64(v) => Self::I64(places.map(|i| v[i]).collect()),
            Self::U64(v) => Self::U64(places.map(|i| v[i]).collect()),
            Self::Text(v) => Self::Text(places.map(|i| v[i].clone()).collect()),
        }
    }

    /// Value number `i` as it would be written in a text; nothing where there is none.
    pub(crate) fn cell(&self, i: usize) -> Cow<'_, str> {
        let number = |v: f64| if v.is_nan() { Cow::Borrowed("") } else { Cow::Owned(written(v)) };
        let cell = match self {
            Self::F64(v) => v.get(i).map(|v| number(*v)),
            Self::F32(v) => v.get(i).map(|v| number(f64::from(*v))),
            Self::I64(v) => v.get(i).map(|v| Cow::Owned(v.to_string())),
            Self::U64(v) => v.get(i).map(|v| Cow::Owned(v.to_string())),
            Self::Text(v) => v.get(i).map(|v| Cow::Borrowed(v.as_str())),
        };
        cell.unwrap_or(Cow::Borrowed(""))
    }
}

/// `value` with as few digits as tell it from every other; with an exponent where zeros would be more.
fn written(value: f64) -> String {
    if value == 0.0 || (1e-5..1e16).contains(&value.abs()) { value.to_string() } else { format!("{value:e}") }
}

/// How a number is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Number {
    /// Bytes of one.
    pub(crate) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The numbers that `cells` store, each of this size, the highest byte first if `big`.
    pub(crate) fn read<'a>(self, big: bool, cells: impl Iterator<Item = &'a [u8]>) -> Values {
        fn all<'a, const N: usize, T>(
            big: bool,
            cells: impl Iterator<Item = &'a [u8]>,
            of: impl Fn([u8; N]) -> T,
        ) -> Vec<T> {
            let ordered = |cell: &[u8]| {
                let mut bytes = [0; N];
                let size = N.min(cell.len());
                bytes[..size].copy_from_slice(&cell[..size]);
                if big {
                    bytes.reverse();
                }
                of(bytes)
            };
            cells.map(ordered).collect()
        }
        match self {
            Self::I8 => Values::I64(all(big, cells, |b| i8::from_le_bytes(b).into())),
            Self::U8 => Values::I64(all(big, cells, |b| u8::from_le_bytes(b).into())),
            Self::I16 => Values::I64(all(big, cells, |b| i16::from_le_bytes(b).into())),
            Self::U16 => Values::I64(all(big, cells, |b| u16::from_le_bytes(b).into())),
            Self::I32 => Values::I64(all(big, cells, |b| i32::from_le_bytes(b).into())),
            Self::U32 => Values::I64(all(big, cells, |b| u32::from_le_bytes(b).into())),
            Self::I64 => Values::I64(all(big, cells, i64::from_le_bytes)),
            Self::U64 => Values::U64(all(big, cells, u64::from_le_bytes)),
            Self::F32 => Values::F32(all(big, cells, f32::from_le_bytes)),
            Self::F64 => Values::F64(all(big, cells, f64::from_le_bytes)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_a_text_would_have_them_and_lose_nothing() {
        let values = [0.1, 5.0, -2.5e-7, 1e300, 0.1 + 0.2, -0.0, f64::MIN_POSITIVE];
        let column = Values::F64(values.to_vec());
        for (i, value) in values.iter().enumerate() {
            assert_eq!(column.cell(i).parse::<f64>().map(f64::to_bits), Ok(value.to_bits()));
        }
        let cells: Vec<_> = (0..4).map(|i| column.cell(i)).collect();
        assert_eq!(cells, ["0.1", "5", "-2.5e-7", "1e300"]);
        assert_eq!(Values::F64(vec![f64::NAN]).cell(0), "", "no value");
        assert_eq!(Values::I64(vec![1_760_000_000_123_456_789]).cell(0), "1760000000123456789");
        assert_eq!(Values::F32(vec![0.1]).cell(0), "0.10000000149011612");
        assert_eq!(column.cell(99), "");
    }

    #[test]
    fn either_order_of_bytes_is_read() {
        let read = |number: Number, big, bytes: &[u8]| number.read(big, bytes.chunks_exact(number.size()));
        assert_eq!(read(Number::I16, false, &[0xfe, 0xff, 1, 0]), Values::I64(vec![-2, 1]));
        assert_eq!(read(Number::I16, true, &[0xff, 0xfe, 0, 1]), Values::I64(vec![-2, 1]));
        assert_eq!(read(Number::F64, true, &1.5_f64.to_be_bytes()), Values::F64(vec![1.5]));
        assert_eq!(read(Number::U64, false, &u64::MAX.to_le_bytes()), Values::U64(vec![u64::MAX]));
    }
}
