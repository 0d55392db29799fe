//! A log as a declared system.

use std::path::Path;

use ndarray::Array2;
use sindyna_core::{Channel, Kind, Precision, Prior, Space, Spec};

use crate::circles::Reading;
use crate::column::Column;
use crate::positions::positions;
use crate::recording::Recording;
use crate::resolution::Step;
use crate::{DeclarationError, LogError, StateOption};

/// The system as its columns show it, each of the `states` and `inputs` a channel of its own.
pub(crate) fn spec(path: &Path, (states, inputs): (&[Column], &[&Column]), recordings: &[Recording]) -> Spec {
    let channel = |c: &Column, reach: f64| Channel::new(&c.name, &c.unit, Kind::Plain, reach);
    let states = states.iter().enumerate();
    let inputs = inputs.iter().enumerate();
    let observation: Vec<Channel> = states.map(|(i, c)| channel(c, reach(recordings, |r| &r.states, i))).collect();
    let control: Vec<Channel> = inputs.map(|(i, c)| channel(c, reach(recordings, |r| &r.inputs, i))).collect();
    let high: Vec<f64> = control.iter().map(|c| c.prior.scale).collect();
    Spec {
        name: path.file_stem().map_or_else(|| "log".into(), |stem| stem.to_string_lossy().into_owned()),
        state: observation.clone(),
        observation,
        action_space: Space::Box { low: high.iter().map(|h| -h).collect(), high },
        control,
        precision: Precision::F64,
        noise: 0.0,
        dt: 1.0,
    }
}

/// Largest magnitude in a column; 1 where there is nothing but zeros.
fn reach(recordings: &[Recording], of: fn(&Recording) -> &Array2<f64>, column: usize) -> f64 {
    let values = recordings.iter().flat_map(|r| of(r).column(column).to_vec());
    let reach = values.fold(0.0, |largest: f64, v| largest.max(v.abs()));
    if reach > 0.0 { reach } else { 1.0 }
}

/// What each state is.
pub(crate) fn kinds(names: &[String], angles: &[usize], rates: &[(usize, usize)]) -> Result<Vec<Kind>, LogError> {
    let kind = |i: usize| {
        let rate_of = rates.iter().find(|(rate, _)| *rate == i).map(|(_, of)| *of);
        match rate_of {
            Some(of) if angles.contains(&i) => {
                Err(DeclarationError::AngleAndRate { state: names[i].clone(), of: names[of].clone() }.into())
            }
            Some(of) => Ok(Kind::RateOf(of)),
            None if angles.contains(&i) => Ok(Kind::Angle),
            None => Ok(Kind::Plain),
        }
    };
    (0..names.len()).map(kind).collect()
}

/// The states, of the `columns` they are read from; `values` are theirs.
pub(crate) fn declared(
    columns: &[Channel],
    readings: &[Reading],
    names: &[String],
    kinds: &[Kind],
    values: &[Recording],
) -> Vec<Channel> {
    let declared = |(i, reading): (usize, &Reading)| {
        let told = match reading {
            Reading::Column(column) => columns[*column].unit.as_str(),
            Reading::Circle { .. } => "",
        };
        let unit = match kinds[i] {
            _ if !told.is_empty() => told,
            Kind::Angle => "rad",
            Kind::RateOf(of) if kinds[of] == Kind::Angle => "rad/s",
            _ => "",
        };
        Channel::new(&names[i], unit, kinds[i], reach(values, |r| &r.states, i))
    };
    readings.iter().enumerate().map(declared).collect()
}

/// Says which state each column shows.
pub(crate) fn show(spec: &mut Spec, readings: &[Reading]) {
    for (i, reading) in readings.iter().enumerate() {
        match *reading {
            Reading::Column(column) => {
                let scale = spec.observation[column].prior.scale;
                spec.observation[column] =
                    Channel { prior: Prior { scale, ..spec.state[i].prior }, ..spec.state[i].clone() };
            }
            Reading::Circle { cosine, sine } => {
                spec.observation[cosine].kind = Kind::CosOf(i);
                spec.observation[sine].kind = Kind::SinOf(i);
            }
        }
    }
}

/// Declares the limits that were given.
pub(crate) fn limit(spec: &mut Spec, limits: &[(String, f64, f64)]) -> Result<(), LogError> {
    let names: Vec<String> = spec.state.iter().map(|s| s.name.clone()).collect();
    for (name, low, high) in limits {
        let at = positions(std::slice::from_ref(name), &names, StateOption::Limits)?[0];
        spec.state[at].prior.bounds = (*low, *high);
        for shown in spec.observation.iter_mut().filter(|o| o.name == *name) {
            shown.prior.bounds = (*low, *high);
        }
    }
    Ok(())
}

/// Declares what the columns called `columns` show wrongly: the noise that was given, and the `steps` to which they were rounded.
pub(crate) fn errors(
    spec: &mut Spec,
    columns: &[String],
    steps: &[Step],
    noise: &[(String, f64)],
) -> Result<(), LogError> {
    for (channel, step) in spec.observation.iter_mut().zip(steps) {
        channel.prior.resolution = step.printed();
    }
    let mut deviations: Vec<f64> =
        steps.iter().map(|step| step.size().map_or(0.0, |step| step / 12_f64.sqrt())).collect();
    for (name, sigma) in noise {
        let at = positions(std::slice::from_ref(name), columns, StateOption::Noise)?[0];
        deviations[at] = deviations[at].hypot(*sigma);
    }
    if deviations.iter().all(|d| *d == 0.0) {
        return Ok(());
    }
    // Noise is declared as a part of each channel's scale: here of one, so that the scales are the deviations.
    spec.noise = 1.0;
    for (channel, deviation) in spec.observation.iter_mut().zip(&deviations) {
        channel.prior.scale = *deviation;
    }
    Ok(())
}
