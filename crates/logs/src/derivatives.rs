//! Derivatives of states that were measured, such as accelerations.

use ndarray::{Array2, Axis, concatenate, s};

use crate::column::Column;
use crate::recording::Recording;
use crate::{DeclarationError, LogError, LogOptions, Note, roles};

/// The columns that may hold derivatives: those that were named, or else those that are no states and no inputs and have the name of one.
pub(crate) fn candidates(columns: &[Column], options: &LogOptions) -> Vec<String> {
    if let Some(given) = &options.derivatives {
        return given.iter().map(|(column, _)| column.clone()).collect();
    }
    let is_taken = |name: &String| options.states.contains(name) || options.inputs.contains(name);
    columns.iter().map(|c| c.name.clone()).filter(|name| roles::is_derivative(name) && !is_taken(name)).collect()
}

/// `recordings` without the columns from `n_states` on, and these as recordings of their own.
pub(crate) fn apart(recordings: Vec<Recording>, n_states: usize) -> (Vec<Recording>, Vec<Recording>) {
    let cut = |recording: Recording| {
        let states = recording.states.slice(s![.., ..n_states]).to_owned();
        let others = recording.states.slice(s![.., n_states..]).to_owned();
        let inputs = Array2::zeros((others.nrows(), 0));
        (Recording { states, ..recording.clone() }, Recording { states: others, inputs, ..recording })
    };
    recordings.into_iter().map(cut).unzip()
}

/// Derivatives of all states.
pub(crate) struct Derivatives {
    /// Per recording and sample (T), those of the states (n).
    pub(crate) values: Vec<Array2<f64>>,
    /// Which column is that of which state.
    pub(crate) pairs: Vec<(String, String)>,
}

/// The derivatives of all states `names`, of which some are the `rates` (rate, state) of others, by `columns` of measured ones, called `called`. `None` if there are no
/// columns, or they are not what they are called and nobody said so.
pub(crate) fn of_states(
    (states, names): (&[Recording], &[String]),
    rates: &[(usize, usize)],
    (columns, called): (&[Recording], &[String]),
    options: &LogOptions,
    notes: &mut Vec<Note>,
) -> Result<Option<Derivatives>, LogError> {
    if called.is_empty() {
        return Ok(None);
    }
    let rate_of = |i: usize| rates.iter().find(|(_, of)| *of == i).map(|(rate, _)| *rate);
    let own: Vec<(usize, usize)> = match &options.derivatives {
        Some(given) => given_of(given, names, &rate_of)?,
        None => {
            let seen = seen((states, columns), |i| rate_of(i).is_none());
            notes.extend(seen.iter().map(|&(column, of, off_by)| Note::Derivative {
                column: called[column].clone(),
                of: names[of].clone(),
                percent: (100.0 * off_by).max(0.1),
            }));
            seen.into_iter().map(|(column, of, _)| (column, of)).collect()
        }
    };
    let column_of = |i: usize| own.iter().find(|(_, of)| *of == i).map(|(column, _)| *column);
    if let Some(unknown) = (0..names.len()).find(|&i| rate_of(i).is_none() && column_of(i).is_none()) {
        if options.derivatives.is_some() {
            return Err(DeclarationError::NoDerivative { state: names[unknown].clone() }.into());
        }
        notes.retain(|note| !matches!(note, Note::Derivative { .. }));
        notes.push(Note::Unused { columns: called.to_vec() });
        return Ok(None);
    }
    let of = |(x, columns): (&Recording, &Recording)| {
        Array2::from_shape_fn(x.states.dim(), |(t, i)| match (rate_of(i), column_of(i)) {
            (Some(rate), _) => x.states[[t, rate]],
            (None, column) => column.map_or(f64::NAN, |column| columns.states[[t, column]]),
        })
    };
    let pairs = own.iter().map(|&(column, of)| (called[column].clone(), names[of].clone())).collect();
    Ok(Some(Derivatives { values: states.iter().zip(columns).map(of).collect(), pairs }))
}

/// The columns that were named, by number, with their states.
fn given_of(
    given: &[(String, String)],
    names: &[String],
    rate_of: &dyn Fn(usize) -> Option<usize>,
) -> Result<Vec<(usize, usize)>, LogError> {
    let mut own: Vec<(usize, usize)> = Vec::new();
    for (number, (column, state)) in given.iter().enumerate() {
        let of = crate::positions::positions(std::slice::from_ref(state), names, crate::StateOption::Derivatives)?[0];
        let (column, state) = (column.clone(), state.clone());
        if let Some(rate) = rate_of(of) {
            return Err(DeclarationError::RateIsState { column, state, rate: names[rate].clone() }.into());
        }
        if let Some(&(other, _)) = own.iter().find(|(_, taken)| *taken == of) {
            let (other_rate, other_of) = given[other].clone();
            return Err(DeclarationError::RateTaken { rate: column, of: state, other_rate, other_of }.into());
        }
        own.push((number, of));
    }
    Ok(own)
}

/// The columns whose integral a state for which `is_free` says so follows, best match first, each of another state: (column, state, deviation).
fn seen((states, columns): (&[Recording], &[Recording]), is_free: impl Fn(usize) -> bool) -> Vec<(usize, usize, f64)> {
    let joined = |(x, columns): (&Recording, &Recording)| Recording {
        states: concatenate![Axis(1), x.states, columns.states],
        ..x.clone()
    };
    let both: Vec<Recording> = states.iter().zip(columns).map(joined).collect();
    let n = states.first().map_or(0, |r| r.states.ncols());
    let all = both.first().map_or(0, |r| r.states.ncols());
    let pairs = (n..all).flat_map(|column| (0..n).filter(|i| is_free(*i)).map(move |of| (column, of)));
    let close = |(column, of): (usize, usize)| {
        let off_by = crate::rates::off_by(&both, column, of).filter(|off| *off <= crate::rates::CLOSE)?;
        Some((column - n, of, off_by))
    };
    let mut found: Vec<(usize, usize, f64)> = pairs.filter_map(close).collect();
    found.sort_by(|a, b| a.2.total_cmp(&b.2));
    let mut kept: Vec<(usize, usize, f64)> = Vec::new();
    for one in found {
        if kept.iter().all(|other| other.0 != one.0 && other.1 != one.1) {
            kept.push(one);
        }
    }
    kept
}
