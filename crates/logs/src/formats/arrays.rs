//! Named arrays as the columns of one table.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use crate::LogError;
use crate::column::Column;
use crate::table::Table;
use crate::values::Values;

/// An array of a file.
#[derive(Debug, PartialEq)]
pub(super) struct Array {
    pub(super) shape: Vec<usize>,
    pub(super) values: Values,
    /// Whether the first index varies fastest.
    pub(super) columns_first: bool,
    pub(super) unit: String,
}

/// What a file has under a name: an array, or why there is none.
pub(super) type Named = (String, Result<Array, String>);

/// The columns of more than this many are not told apart by anybody.
const MOST_COLUMNS: usize = 100_000;

/// A table whose columns are those of `arrays` that have as many samples as most of their numbers. Samples go along either axis of a matrix,
/// whose columns are numbered from 1; an array that is one sample short lacks the last.
pub(super) fn table(path: &Path, arrays: Vec<Named>) -> Result<Table, LogError> {
    let arrays = with_short_names(arrays);
    let rows = samples(&arrays);
    let mut columns: Vec<(Column, Values)> = Vec::new();
    let mut left_out: Vec<(String, String)> = Vec::new();
    for (name, array) in arrays {
        match array.and_then(|array| parted(&name, &array, rows)) {
            Ok(several) => columns.extend(several),
            Err(why) => left_out.push((name, why)),
        }
    }
    let failed = |reason: String| Err(LogError::Malformed { path: path.to_owned(), format: "a table", reason });
    if columns.len() > MOST_COLUMNS {
        return failed(format!("{} columns are more than the maximum of {MOST_COLUMNS}", columns.len()));
    }
    if columns.is_empty() {
        return Err(LogError::NoArrays { path: path.to_owned(), arrays: left_out });
    }
    let mut seen = HashSet::new();
    if let Some((column, _)) = columns.iter().find(|(column, _)| !seen.insert(column.name.clone())) {
        return failed(format!("two columns are named `{}`", column.name));
    }
    Ok(Table::of_values(path, columns, rows, left_out))
}

/// The number of samples: that under which most numbers stand.
fn samples(arrays: &[Named]) -> usize {
    let mut numbers: HashMap<usize, usize> = HashMap::new();
    for array in arrays.iter().filter_map(|(_, array)| array.as_ref().ok()).filter(|array| array.shape.len() <= 2) {
        let mut sizes = array.shape.clone();
        sizes.dedup();
        sizes.into_iter().for_each(|size| *numbers.entry(size).or_default() += array.values.len());
    }
    let several = numbers.into_iter().filter(|(size, _)| *size > 1);
    several.max_by_key(|(size, numbers)| (*numbers, *size)).map_or(0, |(size, _)| size)
}

/// The columns of `array` if it has `rows` samples, or one less.
fn parted(name: &str, array: &Array, rows: usize) -> Result<Vec<(Column, Values)>, String> {
    let (first, second) = match array.shape[..] {
        [] => return Err("is one number".into()),
        [n] => (n, 1),
        [n, m] => (n, m),
        _ => return Err(format!("has {} dimensions", array.shape.len())),
    };
    if array.values.len() <= 1 {
        return Err(if array.values.len() == 1 { "is one number" } else { "is empty" }.into());
    }
    let fits = |size: usize| size == rows || size + 1 == rows;
    // Whole before one short, rows before columns.
    let along_first = match (first == rows, second == rows) {
        (true, _) => true,
        (false, true) => false,
        _ if fits(first) => true,
        _ if fits(second) => false,
        _ => {
            let sizes: Vec<String> = array.shape.iter().map(ToString::to_string).collect();
            return Err(format!("has the shape {} where most arrays have {rows} samples", sizes.join("×")));
        }
    };
    let (samples, width) = if along_first { (first, second) } else { (second, first) };
    let consecutive = along_first == array.columns_first;
    let told = Column::new(name);
    let unit = if array.unit.is_empty() { told.unit } else { array.unit.clone() };
    let column = |j: usize| {
        let number = if width == 1 { String::new() } else { (j + 1).to_string() };
        let place = |i: usize| if consecutive { j * samples + i } else { i * width + j };
        let values = array.values.at((0..samples).map(place));
        (Column { name: format!("{}{number}", told.name), unit: unit.clone() }, values)
    };
    Ok((0..width).map(column).collect())
}

/// `a.b` is called `b` where nothing else is.
fn with_short_names(arrays: Vec<Named>) -> Vec<Named> {
    let short = |name: &str| name.rsplit(['.', '/']).next().unwrap_or(name).to_owned();
    let mut count: HashMap<String, usize> = HashMap::new();
    arrays.iter().for_each(|(name, _)| *count.entry(short(name)).or_default() += 1);
    let renamed = |(name, array): Named| match short(&name) {
        own if !own.is_empty() && count[&own] == 1 => (own, array),
        _ => (name, array),
    };
    arrays.into_iter().map(renamed).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn array(shape: &[usize]) -> Array {
        let count: usize = shape.iter().product();
        let values = Values::F64((0..count).map(|i| i as f64).collect());
        Array { shape: shape.to_vec(), values, columns_first: false, unit: String::new() }
    }

    fn rows(table: &Table) -> Vec<Vec<String>> {
        table.rows().map(|(_, cells)| cells.iter().map(ToString::to_string).collect()).collect()
    }

    #[test]
    fn samples_go_along_either_axis_and_the_last_input_may_lack() {
        let named = |name: &str, shape: &[usize]| (name.to_owned(), Ok(array(shape)));
        let across = Array { columns_first: true, ..array(&[3, 2]) };
        let arrays = vec![
            named("t [ms]", &[1, 3]),
            named("log.q", &[3, 2]),
            named("v", &[2, 3]),
            ("w".to_owned(), Ok(across)),
            named("u", &[2]),
            named("fs", &[1, 1]),
            named("M", &[2, 2, 3]),
            named("gains", &[7]),
            ("name".to_owned(), Err("is text".into())),
        ];
        let table = table(Path::new("log.npz"), arrays).unwrap();
        let names: Vec<String> = table.columns().iter().map(|c| format!("{}|{}", c.name, c.unit)).collect();
        assert_eq!(names, ["t|ms", "q1|", "q2|", "v1|", "v2|", "w1|", "w2|", "u|"]);
        assert_eq!(
            rows(&table),
            [
                ["0", "0", "1", "0", "3", "0", "3", "0"],
                ["1", "2", "3", "1", "4", "1", "4", "1"],
                ["2", "4", "5", "2", "5", "2", "5", ""]
            ]
        );
        let why = |name: &str| table.column(name).unwrap_err().to_string();
        assert!(why("fs").contains("`fs` of log.npz is not a column: is one number"), "{}", why("fs"));
        assert!(
            why("M").contains("has 3 dimensions")
                && why("gains").contains("has the shape 7 where most arrays have 3 samples")
        );
        assert!(why("name").contains("is text") && why("x").contains("no column named `x`"));
    }

    #[test]
    fn what_cannot_be_a_table_is_refused() {
        let check = |arrays: Vec<Named>, says: &str| {
            let failure = table(Path::new("log.npz"), arrays).map(drop).unwrap_err().to_string();
            assert!(failure.contains(says), "{failure}");
        };
        check(vec![], "log.npz has no column of numbers");
        check(vec![("a".into(), Ok(array(&[1])))], "`a` is one number");
        check(vec![("a".into(), Ok(array(&[5, 0])))], "`a` is empty");
        check(vec![("q".into(), Ok(array(&[5, 2]))), ("q1".into(), Ok(array(&[5])))], "two columns are named `q1`");
    }
}
