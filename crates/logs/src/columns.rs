//! Which columns of a table are what.

use crate::column::Column;
use crate::recording::{Selected, Source, is_missing};
use crate::table::Table;
use crate::{DeclarationError, LogError, LogOptions, Note, Suggestion, TRAJECTORY, TimeUnit, roles, time};

/// `options` with states and inputs by the names of the columns of `table`, where none were named, and a note on that. Without inputs all columns are states.
///
/// # Errors
/// [`LogError::ColumnsNotNamed`] if their names do not tell.
pub(crate) fn named(table: &Table, options: &LogOptions) -> Result<(LogOptions, Option<Note>), LogError> {
    let is_autonomous = options.inputs == [crate::NO_INPUTS] && table.find(crate::NO_INPUTS).is_none();
    let inputs = if is_autonomous { Vec::new() } else { options.inputs.clone() };
    let options = &LogOptions { inputs, ..options.clone() };
    if !options.states.is_empty() {
        return Ok((options.clone(), None));
    }
    let time = time_of(table, options)?;
    // A second column of times is neither a state nor an input.
    let also_time = |i: usize| time.is_some() && time::is_time(&table.columns()[i]);
    let derived = |i: usize| roles::is_derivative(&table.columns()[i].name);
    let words = of_words(table);
    let reserved = |i: usize| {
        Some(i) == time || table.find(TRAJECTORY) == Some(i) || also_time(i) || derived(i) || words.contains(&i)
    };
    let columns: Vec<String> =
        (0..table.columns().len()).filter(|i| !reserved(*i)).map(|i| table.columns()[i].name.clone()).collect();
    if columns.iter().all(String::is_empty) {
        return Err(LogError::NoColumns { path: table.path().to_owned() });
    }
    if is_autonomous {
        let states = columns.into_iter().filter(|name| !name.is_empty()).collect();
        return Ok((LogOptions { states, ..options.clone() }, None));
    }
    if let Some((states, inputs)) = roles::told(&columns, &options.inputs) {
        let note = Note::Roles { states: states.clone(), inputs: inputs.clone() };
        return Ok((LogOptions { states, inputs, ..options.clone() }, Some(note)));
    }
    let columns: Vec<String> = columns.into_iter().filter(|name| !name.is_empty()).collect();
    // The unit, or the values, tell what no name does.
    let in_seconds = |c: &&Column| TimeUnit::named(&c.unit).is_some();
    let by_values = || time::running(table).map(|i| &table.columns()[i]);
    let found = if time.is_some() { None } else { table.columns().iter().find(in_seconds).or_else(by_values) };
    let time_column = found.map(|c| c.name.clone());
    let others: Vec<String> = columns.iter().filter(|name| Some(*name) != time_column.as_ref()).cloned().collect();
    let suggestion = Suggestion { has_time: time.is_some(), time_column, ..roles::suggested(&others) };
    Err(LogError::ColumnsNotNamed { path: table.path().to_owned(), columns, suggestion: Box::new(suggestion) })
}

/// Numbers of the columns of `table` whose first rows have words and no numbers.
fn of_words(table: &Table) -> Vec<usize> {
    let first: Vec<_> = table.rows().take(LOOKED_AT).map(|(_, cells)| cells).collect();
    let is_word = |cell: &str| cell.parse::<f64>().is_err() && !is_missing(cell);
    let has_words = |i: usize| !first.is_empty() && first.iter().all(|cells| cells.get(i).is_some_and(|c| is_word(c)));
    (0..table.columns().len()).filter(|&i| has_words(i)).collect()
}

/// Rows that tell whether a column has numbers.
const LOOKED_AT: usize = 20;

/// The columns of `table` that `options` name.
pub(crate) fn selected(table: &Table, options: &LogOptions) -> Result<Selected, LogError> {
    let named: Vec<&String> = options.states.iter().chain(&options.inputs).collect();
    let time = time_of(table, options)?;
    for (i, name) in named.iter().enumerate() {
        let column = || (*name).clone();
        if name.as_str() == TRAJECTORY || (time.is_some() && table.find(name) == time) {
            return Err(DeclarationError::Reserved { column: column() }.into());
        }
        if named[..i].contains(name) {
            return Err(DeclarationError::NamedTwice { column: column() }.into());
        }
    }
    let columns = |names: &[String]| names.iter().map(|n| table.column(n)).collect::<Result<Vec<_>, _>>();
    Ok(Selected {
        states: columns(&options.states)?,
        inputs: columns(&options.inputs)?,
        time,
        trajectory: table.find(TRAJECTORY),
    })
}

/// The column of the time stamps; one that was named must be there.
fn time_of(table: &Table, options: &LogOptions) -> Result<Option<usize>, LogError> {
    match &options.time {
        Some(name) if name == crate::NO_TIME && table.find(name).is_none() => Ok(None),
        Some(name) => table.column(name).map(Some),
        None => {
            // `t` is the time, whatever was said; another name could be anything.
            let taken: Vec<&str> = options.states.iter().chain(&options.inputs).map(String::as_str).collect();
            Ok(table.find(crate::TIME).or_else(|| time::column(table, &taken)))
        }
    }
}

/// Refuses columns whose unit is not the one of the first source.
pub(crate) fn same_units(sources: &[Source<'_>]) -> Result<(), LogError> {
    let Some((first, others)) = sources.split_first() else { return Ok(()) };
    for other in others {
        let both = |s: &Source<'_>| [&s.columns.states[..], &s.columns.inputs[..]].concat();
        for (a, b) in both(first).into_iter().zip(both(other)) {
            let (a, b) = (&first.table.columns()[a], &other.table.columns()[b]);
            if a.unit != b.unit {
                return Err(LogError::OtherUnit {
                    path: other.path().to_owned(),
                    column: b.name.clone(),
                    unit: b.unit.clone(),
                    first: first.path().to_owned(),
                    expected: a.unit.clone(),
                });
            }
        }
    }
    Ok(())
}

/// That `column` is in another unit than `expected`.
pub(crate) fn refuse_unit(table: &Table, column: &Column, expected: &'static str) -> LogError {
    let (column, unit) = (column.name.clone(), column.unit.clone());
    LogError::Unit { path: table.path().to_owned(), column, unit, expected }
}

/// The columns that nobody asked for.
pub(crate) fn unused(source: &Source<'_>) -> Option<Note> {
    let Source { table, columns } = source;
    let used = |i: &usize| {
        columns.states.contains(i)
            || columns.inputs.contains(i)
            || [columns.time, columns.trajectory].contains(&Some(*i))
    };
    let left: Vec<String> =
        (0..table.columns().len()).filter(|i| !used(i)).map(|i| table.columns()[i].name.clone()).collect();
    (!left.is_empty()).then_some(Note::Unused { columns: left })
}
