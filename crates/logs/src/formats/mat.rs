//! `.mat` of MATLAB 5 to 7: matrices of numbers, also in structs.
//!
//! Read here, not by a crate: `matfile` 0.5 reads no structs, prints to standard output what it does not know, and unpacks without a limit.

use super::arrays::{Array, Named};
use super::budget::Budget;
use crate::values::Number;

/// Structs within structs that are followed.
const DEEPEST: usize = 8;

/// Bytes of the header.
const HEADER: usize = 128;

/// Whether `bytes` begin as such a file does.
pub(super) fn is(bytes: &[u8]) -> bool {
    matches!(bytes.get(124..HEADER), Some([0, 1, b'I', b'M'] | [1, 0, b'M', b'I']))
}

/// The variables in `bytes`.
pub(super) fn arrays(bytes: &[u8]) -> Result<Vec<Named>, String> {
    let big = bytes.get(126) == Some(&b'M');
    let mut rest = Reader { bytes: bytes.get(HEADER..).unwrap_or_default(), big };
    let (mut all, mut budget) = (Found::default(), Budget::default());
    while !rest.bytes.is_empty() {
        let element = rest.element()?;
        match element.kind {
            COMPRESSED => {
                let unpacked = budget.read(flate2::read::ZlibDecoder::new(element.data))?;
                let inner = Reader { bytes: &unpacked, big }.element()?;
                if inner.kind == MATRIX {
                    matrix(inner.data, big, None, DEEPEST, &mut all)?;
                }
            }
            MATRIX => matrix(element.data, big, None, DEEPEST, &mut all)?,
            _ => {}
        }
    }
    Ok(all.arrays)
}

/// What was found so far.
#[derive(Default)]
struct Found {
    arrays: Vec<Named>,
    numbers: Budget,
}

const INT32: u32 = 5;
const UINT32: u32 = 6;
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;

/// How the numbers of an element of that kind are stored.
fn number(kind: u32) -> Option<Number> {
    Some(match kind {
        1 => Number::I8,
        2 => Number::U8,
        3 => Number::I16,
        4 => Number::U16,
        INT32 => Number::I32,
        UINT32 => Number::U32,
        7 => Number::F32,
        9 => Number::F64,
        12 => Number::I64,
        13 => Number::U64,
        _ => return None,
    })
}

/// Bytes that are left, and their order.
#[derive(Clone, Copy)]
struct Reader<'a> {
    bytes: &'a [u8],
    big: bool,
}

struct Element<'a> {
    kind: u32,
    data: &'a [u8],
}

impl<'a> Reader<'a> {
    fn word(&self, at: usize) -> Result<u32, String> {
        let bytes = self.bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).ok_or("it is truncated")?;
        Ok(if self.big { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }

    /// Takes the next element off, with what fills it up to eight bytes.
    fn element(&mut self) -> Result<Element<'a>, String> {
        let first = self.word(0)?;
        let (kind, size, begin) = if first >> 16 == 0 {
            (first, self.word(4)? as usize, 8)
        } else {
            (first & 0xffff, (first >> 16) as usize, 4)
        };
        if begin == 4 && size > 4 {
            return Err("it has an element of an impossible size".into());
        }
        let data = self.bytes.get(begin..).and_then(|rest| rest.get(..size)).ok_or_else(|| {
            format!(
                "it is truncated: {} bytes where an element declares {size}",
                self.bytes.len().saturating_sub(begin)
            )
        })?;
        // Packed elements are not filled up.
        let end = if kind == COMPRESSED { begin + size } else { (begin + size).next_multiple_of(8) };
        self.bytes = self.bytes.get(end..).unwrap_or_default();
        Ok(Element { kind, data })
    }
}

/// Adds the matrix in `data` to `all`, or the fields of a struct; called `given`, if not by a name of its own.
fn matrix(data: &[u8], big: bool, given: Option<&str>, depth: usize, all: &mut Found) -> Result<(), String> {
    let mut rest = Reader { bytes: data, big };
    if data.is_empty() {
        all.arrays.push((given.unwrap_or_default().to_owned(), Err("is empty".into())));
        return Ok(());
    }
    let flags = rest.element()?;
    let flags = Reader { bytes: flags.data, big }.word(0)?;
    let (class, complex) = (flags & 0xff, flags & 0x800 != 0);
    // Classes of MATLAB's own, tables among them, have no sizes here.
    let opaque = |what: &str| Err(format!("is {what}, which is not read: save matrices of numbers or structs of them"));
    if class == 17 {
        let name = rest.element()?;
        let name = given.map_or_else(|| String::from_utf8_lossy(name.data).into_owned(), str::to_owned);
        all.arrays.push((name, opaque("an object, such as a table or a timetable")));
        return Ok(());
    }
    let sizes = rest.element()?;
    let sizes: Vec<i64> = sizes
        .data
        .chunks_exact(4)
        .map(|b| {
            let bytes = [b[0], b[1], b[2], b[3]];
            i64::from(if big { i32::from_be_bytes(bytes) } else { i32::from_le_bytes(bytes) })
        })
        .collect();
    let shape: Option<Vec<usize>> = sizes.iter().map(|n| usize::try_from(*n).ok()).collect();
    let name = rest.element()?;
    let name = given.map_or_else(|| String::from_utf8_lossy(name.data).into_owned(), str::to_owned);
    let shape = shape.ok_or_else(|| format!("`{name}` has a size below zero"))?;
    let count = shape.iter().try_fold(1_usize, |all, n| all.checked_mul(*n));
    let count = count.ok_or_else(|| format!("`{name}` is too large"))?;
    let array = match class {
        2 => return fields((rest, count), &name, depth, all),
        1 => opaque("a cell array"),
        3 => opaque("an object"),
        4 => Err("is text".into()),
        5 => opaque("a sparse matrix"),
        6..=15 if complex => Err("has complex numbers".into()),
        6..=15 => {
            let real = rest.element()?;
            let number =
                number(real.kind).ok_or_else(|| format!("`{name}` has numbers of an unknown kind, {}", real.kind))?;
            if count.checked_mul(number.size()) != Some(real.data.len()) {
                return Err(format!(
                    "`{name}` should have {count} numbers and has {}",
                    real.data.len() / number.size()
                ));
            }
            // Small numbers take more memory than in the file.
            all.numbers.spend(count.saturating_mul(8))?;
            let values = number.read(big, real.data.chunks_exact(number.size()));
            Ok(Array { shape, values, columns_first: true, unit: String::new() })
        }
        other => Err(format!("is of an unknown class, {other}")),
    };
    // What has no name is MATLAB's own.
    all.arrays.extend((!name.is_empty()).then_some((name, array)));
    Ok(())
}

/// Adds the fields of the struct called `name`.
fn fields((mut rest, count): (Reader<'_>, usize), name: &str, depth: usize, all: &mut Found) -> Result<(), String> {
    let Some(depth) = depth.checked_sub(1) else { return Err(format!("`{name}` is nested too deeply")) };
    if count != 1 {
        all.arrays.push((name.to_owned(), Err(format!("is an array of {count} structs: only single ones are read"))));
        return Ok(());
    }
    let width = rest.element()?;
    let width = Reader { bytes: width.data, big: rest.big }.word(0)? as usize;
    if width == 0 {
        return Err(format!("`{name}` has fields without names"));
    }
    let names = rest.element()?;
    for field in names.data.chunks_exact(width) {
        let field: Vec<u8> = field.iter().copied().take_while(|b| *b != 0).collect();
        let field = format!("{name}.{}", String::from_utf8_lossy(&field));
        let element = rest.element()?;
        if element.kind != MATRIX {
            return Err(format!("`{field}` is no matrix"));
        }
        matrix(element.data, rest.big, Some(&field), depth, all)?;
    }
    Ok(())
}
