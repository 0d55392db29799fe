//! A log, understood.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use sindyna_core::{Dataset, Precision, Spec};

use crate::circles::{self, Circle, Reading};
use crate::columns::{in_unit, positions, selected, similar_to_time, unused};
use crate::recording::{Recording, recordings};
use crate::table::Table;
use crate::{Clock, LogError, LogOptions, Note, StateOption, clock, declare, jumps, rates, states};

/// A log, understood: what is declared about the system, and its trajectories.
#[derive(Debug)]
pub struct Log {
    /// Channels, their roles and units, the sampling interval.
    pub spec: Spec,
    /// The trajectories.
    pub data: Dataset,
    /// Rows of the file.
    pub rows: usize,
    /// What was decided without being asked for.
    pub notes: Vec<Note>,
}

impl Log {
    /// Reads the CSV file at `path`: a header line, then a row per sample. See [`crate`] for an example.
    ///
    /// # Errors
    /// [`LogError`], with the line and column that is wrong.
    pub fn read(path: impl AsRef<Path>, options: &LogOptions) -> Result<Self, LogError> {
        let path = path.as_ref();
        let file = File::open(path).map_err(|source| LogError::Unreadable { path: path.to_owned(), source })?;
        Self::interpret(path, &Table::read(path, file, options.delimiter)?, options)
    }

    /// The same of what `source` gives, such as standard input; messages call it `name`.
    ///
    /// # Errors
    /// [`LogError`], with the line and column that is wrong.
    pub fn read_from(name: impl AsRef<Path>, source: impl Read, options: &LogOptions) -> Result<Self, LogError> {
        let path = name.as_ref();
        Self::interpret(path, &Table::read(path, source, options.delimiter)?, options)
    }

    /// The same of a `text` that is at hand; messages call it `name`.
    ///
    /// # Errors
    /// [`LogError`], with the line and column that is wrong.
    pub fn parse(name: impl AsRef<Path>, text: String, options: &LogOptions) -> Result<Self, LogError> {
        let path = name.as_ref();
        Self::interpret(path, &Table::parse(path, text, options.delimiter)?, options)
    }

    fn interpret(path: &Path, table: &Table, options: &LogOptions) -> Result<Self, LogError> {
        let columns = selected(table, path, options)?;
        let folded = positions(&options.angles, &options.states, StateOption::Angles)?;
        options.angles.iter().try_for_each(|angle| in_unit(table, angle, "rad", "radians"))?;
        let (mut recordings, digits) = recordings(table, &columns)?;
        let mut notes: Vec<Note> = unused(table, &columns).into_iter().collect();
        if table.ends_abruptly() {
            notes.push(Note::EndsAbruptly);
        }
        let rows = recordings.iter().map(|r| r.lines.len()).sum();
        notes.extend(states::unwrap(&mut recordings, &folded, &options.states));
        notes.extend(jumps::note(&recordings, &options.states));
        notes.extend(states::still(&recordings, &options.states));
        let dt = match options.clock {
            Clock::Stamps if columns.time.is_none() => {
                return Err(LogError::NoTime { path: path.to_owned(), similar: similar_to_time(table) });
            }
            Clock::Stamps => clock::interval(table, &recordings, digits.time_decimals)?,
            Clock::Given(dt) => {
                notes.extend(columns.time.map(|_| Note::TimeIgnored { dt }));
                dt
            }
            Clock::Resampled(_) if columns.time.is_none() => return Err(LogError::NoTimeToResample),
            Clock::Resampled(dt) => {
                clock::check_resampling(table, &recordings, dt)?;
                recordings = recordings.iter().map(|r| clock::resampled(r, dt)).collect();
                notes.push(Note::Resampled { dt });
                dt
            }
        };
        let circles = circles_of(&recordings, options, &mut notes)?;
        let readings = circles::readings(options.states.len(), &circles);
        let names: Vec<String> = readings.iter().map(|r| circles::name_of(*r, &circles, &options.states)).collect();
        let states = circles::read(&recordings, &readings);
        let mut angles = positions(&options.angles, &names, StateOption::Angles)?;
        angles.extend((0..readings.len()).filter(|&i| matches!(readings[i], Reading::Circle { .. })));
        let rates = rates_of(&states, dt, &names, options, &mut notes)?;
        let precision = options.precision.unwrap_or(match (digits.float32, options.clock) {
            (true, Clock::Stamps | Clock::Given(_)) => Precision::F32,
            _ => Precision::F64,
        });
        let kinds = declare::kinds(&names, &angles, &rates)?;
        let mut spec = Spec { dt, precision, ..declare::spec(path, table, &columns, &recordings) };
        spec.state = declare::declared(&spec.observation, &readings, &names, &kinds, &states);
        declare::show(&mut spec, &readings);
        declare::limit(&mut spec, &options.limits)?;
        let steps = if matches!(options.clock, Clock::Resampled(_)) || options.precision.is_some() {
            vec![None; options.states.len()]
        } else {
            digits.steps.clone()
        };
        notes.extend(declare::errors(&mut spec, &options.states, &steps, &options.noise)?);
        let (data, skipped) = dataset(&recordings, &spec)?;
        notes.extend((skipped > 0).then_some(Note::Skipped { trajectories: skipped }));
        Ok(Self { spec, data, rows, notes })
    }
}

/// The pairs of columns that show an angle: those given, which are checked, or those recognised, which are noted.
fn circles_of(recordings: &[Recording], options: &LogOptions, notes: &mut Vec<Note>) -> Result<Vec<Circle>, LogError> {
    let names = |c: &Circle| (options.states[c.cosine].clone(), options.states[c.sine].clone());
    if let Some(given) = &options.circles {
        let circles = circles::given(given, &options.states)?;
        return match circles.iter().find(|c| !circles::on_circle(recordings, c.cosine, c.sine)) {
            Some(c) => {
                let (cosine, sine) = names(c);
                Err(LogError::NotACircle { cosine, sine })
            }
            None => Ok(circles),
        };
    }
    let circles = circles::recognised(recordings, &options.states);
    notes.extend(circles.iter().map(|c| {
        let (cosine, sine) = names(c);
        Note::Circle { cosine, sine, angle: c.name.clone() }
    }));
    Ok(circles)
}

/// Which state (first) is the rate of which: as given, with doubts noted, or as recognised and noted.
fn rates_of(
    states: &[Recording],
    dt: f64,
    names: &[String],
    options: &LogOptions,
    notes: &mut Vec<Note>,
) -> Result<Vec<(usize, usize)>, LogError> {
    if let Some(given) = &options.rates {
        let rates = rates::given(given, names)?;
        notes.extend(rates.iter().filter_map(|&(rate, of)| rates::doubted(states, dt, names, rate, of)));
        return Ok(rates);
    }
    let seen = rates::recognised(states, dt);
    notes.extend(seen.iter().map(|seen| {
        let (rate, of) = (names[seen.rate].clone(), names[seen.of].clone());
        Note::Rate { rate, of, percent: (100.0 * seen.off_by).max(0.1) }
    }));
    Ok(seen.into_iter().map(|seen| (seen.rate, seen.of)).collect())
}

/// The recordings as a data set, and how many of them have no step.
fn dataset(recordings: &[Recording], spec: &Spec) -> Result<(Dataset, usize), LogError> {
    let (m, k) = (spec.observation_dim(), spec.control_dim());
    let mut data = Dataset::new(m, k, k, spec.dt);
    let mut skipped = 0;
    for recording in recordings {
        let rows = recording.states.nrows();
        if rows < 2 {
            skipped += 1;
            continue;
        }
        data.begin(&recording.states.row(0).to_vec())?;
        for i in 1..rows {
            let input = recording.inputs.row(i - 1).to_vec();
            data.push(&input, &input, 0.0, &recording.states.row(i).to_vec())?;
        }
    }
    Ok((data, skipped))
}
