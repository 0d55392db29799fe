//! Which columns of a table are what.

use std::path::Path;

use crate::recording::Selected;
use crate::table::Table;
use crate::{LogError, LogOptions, Note, StateOption, Suggestion, TIME, TRAJECTORY};

/// The columns that `options` name.
pub(crate) fn selected(table: &Table, path: &Path, options: &LogOptions) -> Result<Selected, LogError> {
    if options.states.is_empty() {
        return Err(which_columns(table, path, &options.time));
    }
    let named: Vec<&String> = options.states.iter().chain(&options.inputs).collect();
    for (i, name) in named.iter().enumerate() {
        let column = || (*name).clone();
        if [options.time.as_str(), TRAJECTORY].contains(&name.as_str()) {
            return Err(LogError::Reserved { column: column() });
        }
        if named[..i].contains(name) {
            return Err(LogError::NamedTwice { column: column() });
        }
    }
    in_unit(table, &options.time, "s", "seconds")?;
    let columns = |names: &[String]| names.iter().map(|n| table.column(n)).collect::<Result<Vec<_>, _>>();
    Ok(Selected {
        states: columns(&options.states)?,
        inputs: columns(&options.inputs)?,
        time: time(table, options)?,
        trajectory: table.find(TRAJECTORY),
    })
}

/// The column of the time stamps; one that was named must be there.
fn time(table: &Table, options: &LogOptions) -> Result<Option<usize>, LogError> {
    if options.time == TIME { Ok(table.find(TIME)) } else { table.column(&options.time).map(Some) }
}

/// Refuses the column `name` if its header tells another unit than `wanted`.
pub(crate) fn in_unit(table: &Table, name: &str, wanted: &str, expected: &'static str) -> Result<(), LogError> {
    match table.find(name).map(|column| &table.columns()[column].unit) {
        Some(unit) if !unit.is_empty() && unit != wanted => {
            Err(LogError::Unit { path: table.path().to_owned(), column: name.into(), unit: unit.clone(), expected })
        }
        _ => Ok(()),
    }
}

/// Asks which columns are what, with a guess.
fn which_columns(table: &Table, path: &Path, time: &str) -> LogError {
    let names = table.columns().iter().map(|c| c.name.as_str());
    let columns: Vec<&str> = names.filter(|n| !n.is_empty() && ![time, TRAJECTORY].contains(n)).collect();
    if columns.is_empty() {
        return LogError::NoColumns { path: path.to_owned() };
    }
    let looks_like_input = |name: &str| {
        let letters: String = name.to_lowercase().chars().take_while(char::is_ascii_alphabetic).collect();
        ["u", "f", "a", "action", "control", "force", "input", "torque"].contains(&letters.as_str())
    };
    let (inputs, states): (Vec<&str>, Vec<&str>) =
        columns.iter().filter(|n| **n != "reward").partition(|name| looks_like_input(name));
    let owned = |list: Vec<&str>| list.into_iter().map(String::from).collect();
    let suggestion = Suggestion { states: owned(states), inputs: owned(inputs), has_time: table.find(time).is_some() };
    LogError::ColumnsNotNamed { path: path.to_owned(), columns: owned(columns), suggestion }
}

/// A column whose name says that it is likely to hold time stamps.
pub(crate) fn similar_to_time(table: &Table) -> Option<String> {
    let is_time =
        |name: &str| ["time", "timestamp", "time_s", "seconds", "sec"].contains(&name.to_lowercase().as_str());
    table.columns().iter().find(|c| is_time(&c.name)).map(|c| c.name.clone())
}

/// The columns that nobody asked for.
pub(crate) fn unused(table: &Table, columns: &Selected) -> Option<Note> {
    let used = |i: &usize| {
        columns.states.contains(i)
            || columns.inputs.contains(i)
            || [columns.time, columns.trajectory].contains(&Some(*i))
    };
    let left: Vec<String> =
        (0..table.columns().len()).filter(|i| !used(i)).map(|i| table.columns()[i].name.clone()).collect();
    (!left.is_empty()).then_some(Note::Unused { columns: left })
}

/// Where each of `names`, which `option` gives, stands among the `states`.
pub(crate) fn positions(names: &[String], states: &[String], option: StateOption) -> Result<Vec<usize>, LogError> {
    let position = |name: &String| {
        states.iter().position(|s| s == name).ok_or_else(|| LogError::UnknownState {
            option,
            state: name.clone(),
            known: states.to_vec(),
        })
    };
    names.iter().map(position).collect()
}
