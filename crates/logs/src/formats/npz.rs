//! `.npz`: an archive of NumPy's arrays.

use std::io::Cursor;

use super::arrays::Named;
use super::budget::Budget;
use super::npy;

/// How the file begins; the second is an archive of nothing.
pub(super) const MAGIC: [&[u8]; 2] = [b"PK\x03\x04", b"PK\x05\x06"];

/// The arrays in `bytes`.
pub(super) fn arrays(bytes: &[u8]) -> Result<Vec<Named>, String> {
    let mut archive =
        zip::ZipArchive::new(Cursor::new(bytes)).map_err(|e| format!("it is not a complete archive: {e}"))?;
    let (mut budget, mut numbers) = (Budget::default(), Budget::default());
    let (mut all, mut members) = (Vec::new(), 0_usize);
    for i in 0..archive.len() {
        let member = archive.by_index(i).map_err(|e| format!("its part {}: {e}", i + 1))?;
        let Some(name) = member.name().strip_suffix(".npy").map(str::to_owned) else { continue };
        members += 1;
        let read = budget.read(member).map_err(|e| format!("`{name}`: {e}"))?;
        match npy::arrays(&read, &name, &mut numbers) {
            Ok(arrays) => all.extend(arrays),
            Err(why) => all.push((name, Err(format!("cannot be read: {why}")))),
        }
    }
    if members == 0 { Err("it is an archive without arrays of NumPy (`.npy`)".into()) } else { Ok(all) }
}
