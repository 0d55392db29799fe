//! Arrays of NumPy: `.npy`, and `.npz` with several of them.
//!
//! Read here, not by a crate: `npyz` 0.9 brings a grammar of Python's literals (`pest`) and integers of any size for a header of three keys.
//! Objects, which are pickled programs, are not read.

use super::arrays::{Array, Named};
use super::budget::Budget;
use super::literal::{Literal, parse};
use crate::values::{Number, Values};

/// How the file begins.
pub(super) const MAGIC: &[u8] = b"\x93NUMPY";

/// The array, or arrays if it is one of records, that `bytes` hold; one without a name of its own is called `name`.
pub(super) fn arrays(bytes: &[u8], name: &str, budget: &mut Budget) -> Result<Vec<Named>, String> {
    let (header, data) = header(bytes)?;
    let Literal::Map(entries) = parse(header)? else { return Err("its header is no dictionary".into()) };
    let get = |key: &str| {
        let found = entries.iter().find(|(name, _)| name == key).map(|(_, value)| value);
        found.ok_or_else(|| format!("its header has no `{key}`"))
    };
    let shape = get("shape")?.sizes().ok_or("its shape is no tuple of whole numbers")?;
    let columns_first = matches!(get("fortran_order")?, Literal::Bool(true));
    let count = shape.iter().try_fold(1_usize, |all, n| all.checked_mul(*n)).ok_or("its shape is too large")?;
    let fields = match get("descr")? {
        Literal::Text(descr) => vec![(name.to_owned(), Element::of(descr), 1)],
        Literal::List(list) => {
            list.iter().map(field).collect::<Option<_>>().ok_or("its records cannot be understood")?
        }
        _ => return Err("its type cannot be understood".into()),
    };
    // An element that is not understood has a size nobody knows: nothing after it is where it should be.
    let sizes = fields.iter().map(|(_, element, width)| element.as_ref().map(|e| e.size().saturating_mul(*width)));
    let sizes: Vec<usize> = sizes.collect::<Result<_, _>>().map_err(Clone::clone)?;
    let each = sizes.iter().try_fold(0_usize, |all, n| all.checked_add(*n)).filter(|each| *each > 0);
    let each = each.ok_or("its elements have no size")?;
    let needed = count.checked_mul(each).ok_or("its shape is too large")?;
    let data = data
        .get(..needed)
        .ok_or_else(|| format!("it is truncated: {} bytes of data where its header declares {needed}", data.len()))?;
    // Small numbers take more memory than in the file.
    budget.spend(count.saturating_mul(8 * fields.iter().map(|(_, _, width)| width).sum::<usize>()))?;
    let mut from = 0;
    let mut all = Vec::new();
    for ((name, element, width), size) in fields.into_iter().zip(sizes) {
        let part = from..from + size;
        let cells = data.chunks_exact(each).map(|record| &record[part.clone()]);
        from += size;
        let element = element?;
        let values = element.read(cells.flat_map(|cell| cell.chunks_exact(element.size())));
        let mut shape = shape.clone();
        shape.extend((width > 1).then_some(width));
        all.push((name, Ok(Array { shape, values, columns_first, unit: element.unit().to_owned() })));
    }
    Ok(all)
}

/// The text of the header, and what follows it.
fn header(bytes: &[u8]) -> Result<(&str, &[u8]), String> {
    const CUT_OFF: &str = "it is truncated within its header";
    let version = *bytes.get(6).ok_or(CUT_OFF)?;
    let (size, begin) = match version {
        1 => (usize::from(u16::from_le_bytes(bytes.get(8..10).and_then(|b| b.try_into().ok()).ok_or(CUT_OFF)?)), 10),
        2 | 3 => (u32::from_le_bytes(bytes.get(8..12).and_then(|b| b.try_into().ok()).ok_or(CUT_OFF)?) as usize, 12),
        other => return Err(format!("its version is {other}; 1 to 3 are read")),
    };
    let end = begin + size;
    let text = std::str::from_utf8(bytes.get(begin..end).ok_or(CUT_OFF)?).map_err(|_| "its header is no text")?;
    Ok((text, &bytes[end..]))
}

/// A field of a record: its name, its type, how many of it there are.
fn field(field: &Literal) -> Option<(String, Result<Element, String>, usize)> {
    let Literal::List(parts) = field else { return None };
    let name = match parts.first()? {
        Literal::Text(name) => name,
        // A title before the name.
        Literal::List(both) => both.last()?.text()?,
        _ => return None,
    };
    let width = match parts.get(2) {
        None => 1,
        Some(shape) => shape.sizes()?.iter().try_fold(1_usize, |all, n| all.checked_mul(*n))?,
    };
    let element = match parts.get(1)? {
        Literal::Text(descr) => Element::of(descr),
        _ => Err("records within records are not read".into()),
    };
    Some((name.clone(), element, width))
}

/// The type of an element.
#[derive(Debug, Clone, PartialEq)]
enum Element {
    Number {
        number: Number,
        big: bool,
        unit: &'static str,
    },
    /// Of two bytes.
    Half {
        big: bool,
    },
    /// Letters of four bytes each, or of one.
    Text {
        letters: usize,
        size: usize,
        big: bool,
    },
}

impl Element {
    /// The type that `descr` names, such as `<f8`.
    fn of(descr: &str) -> Result<Self, String> {
        let unknown = || format!("its type is `{descr}`, which is not a number");
        let mut letters = descr.chars();
        let big = match letters.next().ok_or_else(unknown)? {
            '<' | '|' | '=' => false,
            '>' => true,
            _ => return Err(unknown()),
        };
        let kind = letters.next().ok_or_else(unknown)?;
        let rest = letters.as_str();
        let number = |number| Ok(Self::Number { number, big, unit: "" });
        match (kind, rest) {
            ('f', "8") => number(Number::F64),
            ('f', "4") => number(Number::F32),
            ('f', "2") => Ok(Self::Half { big }),
            ('i', "8") => number(Number::I64),
            ('i', "4") => number(Number::I32),
            ('i', "2") => number(Number::I16),
            ('i', "1") => number(Number::I8),
            ('u', "8") => number(Number::U64),
            ('u', "4") => number(Number::U32),
            ('u', "2") => number(Number::U16),
            ('u' | 'b', "1") => number(Number::U8),
            ('M' | 'm', time) => {
                let unit = match time {
                    "8[s]" => "s",
                    "8[ms]" => "ms",
                    "8[us]" => "us",
                    "8[ns]" => "ns",
                    _ => return Err(unknown()),
                };
                Ok(Self::Number { number: Number::I64, big, unit })
            }
            ('U' | 'S', count) => {
                let letters = count.parse().ok().filter(|letters| *letters > 0).ok_or_else(unknown)?;
                Ok(Self::Text { letters, size: if kind == 'U' { 4 } else { 1 }, big })
            }
            ('O', _) => {
                Err("it holds pickled objects, which may run code and are not read: save it as an array of numbers"
                    .into())
            }
            _ => Err(unknown()),
        }
    }

    fn size(&self) -> usize {
        match self {
            Self::Number { number, .. } => number.size(),
            Self::Half { .. } => 2,
            Self::Text { letters, size, .. } => letters.saturating_mul(*size),
        }
    }

    fn unit(&self) -> &str {
        if let Self::Number { unit, .. } = self { unit } else { "" }
    }

    fn read<'a>(&self, cells: impl Iterator<Item = &'a [u8]>) -> Values {
        match *self {
            Self::Number { number, big, .. } => number.read(big, cells),
            Self::Half { big } => {
                let half = |cell: &[u8]| {
                    let bytes = [cell[0], cell[1]];
                    half(if big { u16::from_be_bytes(bytes) } else { u16::from_le_bytes(bytes) })
                };
                Values::F32(cells.map(half).collect())
            }
            Self::Text { size, big, .. } => Values::Text(cells.map(|cell| text(cell, size, big)).collect()),
        }
    }
}

/// A number of two bytes.
fn half(bits: u16) -> f32 {
    let (exponent, fraction) = (bits >> 10 & 0x1f, f32::from(bits & 0x3ff));
    let size = match exponent {
        0 => fraction * 2_f32.powi(-24),
        0x1f => {
            if fraction > 0.0 {
                f32::NAN
            } else {
                f32::INFINITY
            }
        }
        e => (1024.0 + fraction) * 2_f32.powi(i32::from(e) - 25),
    };
    if bits >> 15 == 1 { -size } else { size }
}

/// The text in `cell`, whose letters have `size` bytes, up to the zeros that fill it up.
fn text(cell: &[u8], size: usize, big: bool) -> String {
    let letter = |bytes: &[u8]| match *bytes {
        [a, b, c, d] => {
            char::from_u32(if big { u32::from_be_bytes([a, b, c, d]) } else { u32::from_le_bytes([a, b, c, d]) })
                .unwrap_or(char::REPLACEMENT_CHARACTER)
        }
        [byte] => char::from(byte),
        _ => char::REPLACEMENT_CHARACTER,
    };
    cell.chunks_exact(size).map(letter).collect::<String>().trim_end_matches('\0').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As NumPy writes it.
    fn file(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
        let header = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}\n");
        let size = u16::try_from(header.len()).unwrap().to_le_bytes();
        [MAGIC, &[1, 0], &size, header.as_bytes(), data].concat()
    }

    #[test]
    fn numbers_times_texts_and_records_are_read() {
        let doubles: Vec<u8> = [1.5_f64, -2.0].iter().flat_map(|v| v.to_le_bytes()).collect();
        let [(name, Ok(array))] = &arrays(&file("'<f8'", "(2,)", &doubles), "x", &mut Budget::default()).unwrap()[..]
        else {
            panic!("one array")
        };
        assert_eq!((name.as_str(), &array.shape, &array.values), ("x", &vec![2], &Values::F64(vec![1.5, -2.0])));
        let halves: Vec<u8> = [0x3c00_u16, 0xc000, 0x0001, 0x7e00].iter().flat_map(|v| v.to_be_bytes()).collect();
        let [(_, Ok(array))] = &arrays(&file("'>f2'", "(4, 1)", &halves), "x", &mut Budget::default()).unwrap()[..]
        else {
            panic!("one array")
        };
        assert!(matches!(&array.values, Values::F32(v) if v[..3] == [1.0, -2.0, 2_f32.powi(-24)] && v[3].is_nan()));
        let letters: Vec<u8> = "ab\0θ\0\0".chars().flat_map(|c| u32::from(c).to_le_bytes()).collect();
        let [(_, Ok(array))] = &arrays(&file("'<U3'", "(2,)", &letters), "x", &mut Budget::default()).unwrap()[..]
        else {
            panic!("one array")
        };
        assert_eq!(array.values, Values::Text(vec!["ab".into(), "θ".into()]));
        let record = [&7_i64.to_le_bytes()[..], &0.5_f32.to_le_bytes(), &1.0_f32.to_le_bytes()].concat();
        let descr = "[('t', '<M8[ns]'), (('q [rad]', 'q'), '<f4', (2,))]";
        let [(t, Ok(time)), (q, Ok(both))] =
            &arrays(&file(descr, "(1,)", &record), "x", &mut Budget::default()).unwrap()[..]
        else {
            panic!("two")
        };
        assert_eq!((t.as_str(), time.unit.as_str(), &time.values), ("t", "ns", &Values::I64(vec![7])));
        assert_eq!((q.as_str(), &both.shape, &both.values), ("q", &vec![1, 2], &Values::F32(vec![0.5, 1.0])));
    }

    #[test]
    fn what_is_declared_and_not_there_is_refused() {
        let check = |bytes: &[u8], says: &str| {
            let failure = arrays(bytes, "x", &mut Budget::default()).unwrap_err();
            assert!(failure.contains(says), "{failure}");
        };
        check(&file("'<f8'", "(1000000000000,)", &[0; 16]), "16 bytes of data where its header declares 8000000000000");
        check(&file("'<f8'", "(18446744073709551615, 3)", &[]), "too large");
        check(&file("'<f8'", "(99999999999999999999,)", &[]), "shape is no tuple");
        check(&file("'|O'", "(2,)", b"\x80\x04cos\nsystem\n"), "pickled objects");
        check(&file("[('a', '|O'), ('t', '<f8')]", "(2,)", &[0; 32]), "pickled objects");
        check(&file("'<c16'", "(2,)", &[0; 32]), "`<c16`, which is not a number");
        check(&file("'<U0'", "(2,)", &[]), "not a number");
        check(&file("[]", "(2,)", &[]), "no size");
        check(&file(&"(".repeat(60_000), "(2,)", &[]), "nested");
        check(&file("'<f8'", "(2,)", &[0; 16])[..40], "truncated within its header");
        check(MAGIC, "truncated");
        check(b"\x93NUMPY\x09\x00\x00\x00", "its version is 9");
        check(b"\x93NUMPY\x02\x00\xff\xff\xff\xff", "truncated");
        check(&[MAGIC, &[1, 0, 2, 0], b"{}"].concat(), "has no `shape`");
    }
}
