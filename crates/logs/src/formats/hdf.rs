//! HDF5, and so `.mat` of MATLAB 7.3: data sets of numbers, also in groups.

use hdf5_pure::{DType, Dataset, File, Group};

use super::arrays::{Array, Named};
use super::budget::Budget;
use crate::values::Values;

/// How a file of MATLAB's begins.
const MATLAB: &[u8] = b"MATLAB 7.3";

/// Groups within groups that are followed.
const DEEPEST: usize = 8;

/// The data sets in `bytes`.
pub(super) fn arrays(bytes: Vec<u8>) -> Result<Vec<Named>, String> {
    // MATLAB counts the columns first, and turns the sizes round.
    let turned = bytes.starts_with(MATLAB);
    let file = File::from_bytes(bytes).map_err(|e| e.to_string())?;
    let mut all = Vec::new();
    of_group(&file.root(), "", turned, &mut Reader { budget: Budget::default(), depth: DEEPEST }, &mut all)?;
    Ok(all)
}

struct Reader {
    budget: Budget,
    depth: usize,
}

fn of_group(group: &Group, path: &str, turned: bool, reader: &mut Reader, all: &mut Vec<Named>) -> Result<(), String> {
    for name in group.datasets().map_err(|e| e.to_string())? {
        let array = match group.dataset(&name) {
            Ok(set) => array(&set, turned, &mut reader.budget),
            Err(e) => Err(e.to_string()),
        };
        all.push((format!("{path}{name}"), array));
    }
    let Some(depth) = reader.depth.checked_sub(1) else { return Err("its groups are nested too deeply".into()) };
    reader.depth = depth;
    for name in group.groups().map_err(|e| e.to_string())? {
        // What begins so is MATLAB's own.
        if name.starts_with('#') {
            continue;
        }
        let inner = group.group(&name).map_err(|e| e.to_string())?;
        of_group(&inner, &format!("{path}{name}/"), turned, reader, all)?;
    }
    reader.depth += 1;
    Ok(())
}

fn array(set: &Dataset, turned: bool, budget: &mut Budget) -> Result<Array, String> {
    let told = |e: hdf5_pure::Error| e.to_string();
    let mut shape: Vec<usize> = Vec::new();
    for size in set.shape().map_err(told)? {
        shape.push(usize::try_from(size).map_err(|_| "is too large")?);
    }
    let count = shape.iter().try_fold(1_usize, |all, n| all.checked_mul(*n)).ok_or("is too large")?;
    budget.spend(count.saturating_mul(8))?;
    let values = match set.dtype().map_err(told)? {
        DType::F64 => Values::F64(set.read_f64().map_err(told)?),
        DType::F32 => Values::F32(set.read_f32().map_err(told)?),
        DType::U64 => Values::U64(set.read_u64().map_err(told)?),
        DType::I64 | DType::I32 | DType::I16 | DType::I8 | DType::U32 | DType::U16 | DType::U8 => {
            Values::I64(set.read_i64().map_err(told)?)
        }
        _ => return Err("is no array of numbers".into()),
    };
    if values.len() != count {
        return Err(format!("should have {count} numbers and has {}", values.len()));
    }
    if turned {
        shape.reverse();
    }
    Ok(Array { shape, values, columns_first: turned, unit: String::new() })
}
