//! A log, understood.

use std::io::Read;
use std::path::Path;

use ndarray::Array2;
use sindyna_core::{Dataset, Kind, Precision, Spec};

use crate::circles::{self, Circle, Reading};
use crate::column::Column;
use crate::columns::{named, refuse_unit, same_units, selected, unused};
use crate::formats;
use crate::positions::positions;
use crate::recording::{Cell, Digits, Recording, Source, codes, place, recordings};
use crate::resolution::Step;
use crate::table::Table;
use crate::{
    Clock, DeclarationError, Difference, Finding, LogError, LogOptions, Note, StateOption, angles, clock, declare,
    derivatives, differences, jumps, late_rates, moments, quality, rates, resolution, states, units,
};

/// A log, understood: what is declared about the system, and its trajectories.
#[derive(Debug, Clone)]
pub struct Log {
    /// Channels, their roles and units, the sampling interval; of samples that are not evenly spaced the median of their steps.
    pub spec: Spec,
    /// The trajectories.
    pub data: Dataset,
    /// When the samples of each trajectory were taken, since its first one \[s\]; `None` if they are evenly spaced.
    pub times: Option<Vec<Vec<f64>>>,
    /// Measured derivatives of all states at each sample of each trajectory (T + 1, n), those of a state whose rate is a state too by that; `None` if there are none.
    pub derivatives: Option<Vec<Array2<f64>>>,
    /// Rows of the files.
    pub rows: usize,
    /// What was decided without being asked for.
    pub notes: Vec<Note>,
    /// What makes the samples hard to identify anything in, as they were read.
    pub findings: Vec<Finding>,
    /// States that may be angles, as their names or units say, and have rates, but do not turn far enough to be taken as such.
    pub may_turn: Vec<String>,
    /// Other states without a unit, and whether they are called as angles are: what is found in the log may say that they turn.
    pub could_turn: Vec<(String, bool)>,
    /// States whose columns were computed of those of others: they tell nothing that these do not.
    pub differences: Vec<Difference>,
    /// What the columns are, decided and as they were named: options by which another log is read alike.
    pub decided: LogOptions,
}

impl Log {
    /// Reads the file at `path`: a text with a header line and a row per sample, or one of the formats that [`crate`] names.
    ///
    /// # Errors
    /// [`LogError`], with the line and column that is wrong.
    pub fn read(path: impl AsRef<Path>, options: &LogOptions) -> Result<Self, LogError> {
        Self::read_all(&[path], options)
    }

    /// Reads the files at `paths` as trajectories of one system: each begins a trajectory, and has the columns that are named.
    ///
    /// # Errors
    /// [`LogError`], with the file, line and column that is wrong.
    pub fn read_all<P: AsRef<Path>>(paths: &[P], options: &LogOptions) -> Result<Self, LogError> {
        let table = |path: &P| {
            let path = path.as_ref();
            let bytes = std::fs::read(path).map_err(|source| LogError::Unreadable { path: path.to_owned(), source })?;
            formats::read(path, bytes, formats::Reading::of(options))
        };
        Self::interpret(paths.iter().map(table).collect::<Result<_, _>>()?, options)
    }

    /// The same of what `source` gives, such as standard input; messages call it `name`.
    ///
    /// # Errors
    /// [`LogError`], with the line and column that is wrong.
    pub fn read_from(name: impl AsRef<Path>, mut source: impl Read, options: &LogOptions) -> Result<Self, LogError> {
        let (name, mut bytes) = (name.as_ref(), Vec::new());
        let failed = |source| LogError::Unreadable { path: name.to_owned(), source };
        source.read_to_end(&mut bytes).map_err(failed)?;
        Self::interpret(vec![formats::read(name, bytes, formats::Reading::of(options))?], options)
    }

    /// The same of a `text` that is at hand; messages call it `name`.
    ///
    /// # Errors
    /// [`LogError`], with the line and column that is wrong.
    pub fn parse(name: impl AsRef<Path>, text: String, options: &LogOptions) -> Result<Self, LogError> {
        Self::interpret(vec![Table::parse(name.as_ref(), text, options.delimiter)?], options)
    }

    fn interpret(mut tables: Vec<Table>, options: &LogOptions) -> Result<Self, LogError> {
        for table in &mut tables {
            options.units.iter().try_for_each(|(column, unit)| table.set_unit(column, unit))?;
        }
        let first = tables.first().ok_or(LogError::NoLog)?;
        let (options, note) = named(first, options)?;
        let measured = derivatives::candidates(first.columns(), &options);
        let n_states = options.states.len();
        // Derivatives are read as states are.
        let columns = LogOptions { states: [&options.states[..], &measured].concat(), ..options.clone() };
        let options = &options;
        let mut notes: Vec<Note> = note.into_iter().collect();
        for note in tables.iter().flat_map(Table::notes) {
            notes.extend((!notes.contains(&note)).then_some(note));
        }
        let source = |table| Ok(Source { columns: selected(table, &columns)?, table });
        let sources = tables.iter().map(source).collect::<Result<Vec<_>, LogError>>()?;
        same_units(&sources)?;
        let declared = positions(options.angles.as_deref().unwrap_or_default(), &options.states, StateOption::Angles)?;
        let codes = codes(&sources, options.missing.as_deref());
        let coded = |(i, value)| {
            let columns = sources[0].columns.states.iter().chain(&sources[0].columns.inputs);
            let column = columns.clone().nth(i).map_or("", |&column| &first.columns()[column].name);
            Note::MissingCode { column: column.to_owned(), value }
        };
        notes.extend(codes.recognised().map(coded));
        let (recordings, digits) = recordings(&sources, &codes)?;
        notes.extend(unused(&sources[0]));
        let missing = |(rows, cell): &(usize, Cell)| Note::Missing {
            rows: *rows,
            column: cell.column.clone(),
            row: cell.row.clone(),
        };
        notes.extend(digits.missing.as_ref().map(missing));
        let rows = recordings.iter().map(|r| r.lines.len()).sum();
        let mut steps = resolution::steps(&recordings, &digits.written[..sources[0].columns.states.len()]);
        let moments::Moments { mut recordings, rounding, gaps } =
            moments::told(recordings, &sources, &digits, options, &declared, &mut notes)?;
        let columns = |numbers: &[usize]| numbers.iter().map(|&i| &first.columns()[i]).collect::<Vec<&Column>>();
        let of_states = units::in_radians(&mut recordings, &columns(&sources[0].columns.states), |r| &mut r.states);
        let of_inputs = units::in_radians(&mut recordings, &columns(&sources[0].columns.inputs), |r| &mut r.inputs);
        notes.extend([of_states.notes, of_inputs.notes].concat());
        let (mut recordings, mut derivatives) = derivatives::apart(recordings, n_states);
        let states_told = &of_states.columns[..n_states];
        steps.truncate(n_states);
        steps.iter_mut().zip(&of_states.factors).for_each(|(step, factor)| step.scale(*factor));
        let inputs_told: Vec<&Column> = of_inputs.columns.iter().collect();
        let mut folded = declared.clone();
        if options.angles.is_none() {
            for (i, note) in angles::recognised(&recordings, states_told, &inputs_told) {
                folded.push(i);
                notes.push(note);
            }
        }
        for &i in &folded {
            let column = &states_told[i];
            if !["", "rad"].contains(&column.unit.as_str()) {
                return Err(refuse_unit(first, column, "radians or degrees"));
            }
            notes.extend(angles::suspected(&recordings, i, column));
        }
        notes.extend(states::unwrap(&mut recordings, &folded, &options.states));
        notes.extend(jumps::note(&recordings, &options.states, |table, row| place(&sources, table, row)));
        notes.extend(states::still(&recordings, &options.states));
        let (dt, is_even) = match options.clock {
            Clock::Stamps => match clock::interval(&recordings, rounding)? {
                Some(dt) => (dt, true),
                None => {
                    let (dt, note) = clock::uneven(&recordings);
                    notes.push(note);
                    (dt, false)
                }
            },
            Clock::Given(dt) => (dt, true),
            Clock::Resampled(dt) => {
                clock::check_resampling(&recordings, dt)?;
                recordings = recordings.iter().map(|r| clock::resampled(r, dt)).collect();
                derivatives = derivatives.iter().map(|r| clock::resampled(r, dt)).collect();
                notes.push(Note::Resampled { dt });
                (dt, true)
            }
        };
        let starts = quality::starts(&recordings);
        if is_even {
            recordings = recordings.into_iter().map(|r| r.with_step(dt)).collect();
        }
        let circles = circles_of(&recordings, options, &mut notes)?;
        let readings = circles::readings(options.states.len(), &circles);
        let names: Vec<String> = readings.iter().map(|r| circles::name_of(*r, &circles, &options.states)).collect();
        let states = circles::read(&recordings, &readings);
        let turning: Vec<String> = folded.iter().map(|&i| options.states[i].clone()).collect();
        let mut angles = positions(&turning, &names, StateOption::Angles)?;
        angles.extend((0..readings.len()).filter(|&i| matches!(readings[i], Reading::Circle { .. })));
        let units: Vec<(&str, &str)> = states_told.iter().map(|c| (c.name.as_str(), c.unit.as_str())).collect();
        let rates = rates_of(&states, &names, (options, &units), &mut notes)?;
        if options.derivatives.as_ref().is_some_and(|given| !given.is_empty()) && !circles.is_empty() {
            return Err(DeclarationError::DerivativesOfCircles.into());
        }
        let columns = (&derivatives[..], if circles.is_empty() { &measured[..] } else { &[] });
        let derivatives = derivatives::of_states((&states, &names), &rates, columns, options, &mut notes)?;
        let kinds = declare::kinds(&names, &angles, &rates)?;
        let has_rate = |i: usize| rates.iter().any(|(_, of)| *of == i);
        let may_turn = |(name, column): (&String, &Column)| {
            let state = names.iter().position(|n| n == name).filter(|&i| kinds[i] == Kind::Plain)?;
            let moves = has_rate(state) || angles::may_be_without_rate(column, &inputs_told);
            (moves && angles::may_be(column, &inputs_told)).then(|| name.clone())
        };
        let may_turn = match &options.angles {
            Some(_) => Vec::new(),
            None => options.states.iter().zip(states_told).filter_map(may_turn).collect(),
        };
        let is_open = |name: &String| {
            let is_plain = names.iter().position(|n| n == name).is_some_and(|i| kinds[i] == Kind::Plain);
            is_plain && !may_turn.contains(name)
        };
        let unnamed = options.states.iter().zip(states_told).filter(|_| options.angles.is_none());
        let could_turn = unnamed.filter(|(name, column)| column.unit.is_empty() && is_open(name));
        let could_turn =
            could_turn.map(|(name, column)| (name.clone(), angles::may_be(column, &inputs_told))).collect();
        let precision = precision(&digits, options);
        let of_columns = |reading: &Reading| match *reading {
            Reading::Column(column) => Some(of_states.factors[column] * digits.written[column].step()),
            Reading::Circle { .. } => None,
        };
        let differences = if is_even && !matches!(options.clock, Clock::Resampled(_)) {
            let written: Vec<Option<f64>> = readings.iter().map(of_columns).collect();
            differences::seen((&states, &names), (&written, precision), dt)
        } else {
            Vec::new()
        };
        let mut spec = Spec { dt, precision, ..declare::spec(first.path(), (states_told, &inputs_told), &recordings) };
        spec.state = declare::declared(&spec.observation, &readings, &names, &kinds, &states);
        declare::show(&mut spec, &readings);
        declare::limit(&mut spec, &options.limits)?;
        let is_as_written = !matches!(options.clock, Clock::Resampled(_)) && options.precision.is_none();
        if !is_as_written {
            steps = vec![Step::None; options.states.len()];
        }
        declare::errors(&mut spec, &options.states, &steps, &options.noise)?;
        let written = digits.written.iter().skip(sources[0].columns.states.len()).zip(of_inputs.factors);
        if is_as_written {
            let inputs = spec.control.iter_mut().zip(written);
            inputs.for_each(|(input, (written, factor))| {
                input.prior.resolution = factor * written.fine();
                input.prior.written = factor * written.step();
            });
        }
        notes.extend(options.states.iter().zip(&steps).filter_map(|(state, step)| step.note(state)));
        notes.extend(resolution::printed(&steps, &digits.written));
        let findings = quality::findings((&recordings, &starts), &spec, &steps, &gaps, &sources);
        let (samples, skipped): (Vec<&Recording>, Vec<&Recording>) = recordings.iter().partition(|r| r.lines.len() > 1);
        notes.extend((!skipped.is_empty()).then_some(Note::Skipped { trajectories: skipped.len() }));
        let since_start = |r: &&Recording| r.times.iter().map(|t| t - r.times[0]).collect();
        let times = (!is_even).then(|| samples.iter().map(since_start).collect());
        let is_sample = |i: &usize| recordings[*i].lines.len() > 1;
        let (derivatives, derived) = match derivatives {
            Some(all) => {
                let values = (0..recordings.len()).filter(is_sample).map(|i| all.values[i].clone()).collect();
                (Some(values), all.pairs)
            }
            None => (None, Vec::new()),
        };
        let pairs = |pairs: Vec<(usize, usize)>, of: &[String]| -> Vec<(String, String)> {
            pairs.into_iter().map(|(a, b)| (of[a].clone(), of[b].clone())).collect()
        };
        let decided = LogOptions {
            angles: Some(turning),
            rates: Some(pairs(rates, &names)),
            circles: Some(pairs(circles.iter().map(|c| (c.cosine, c.sine)).collect(), &options.states)),
            derivatives: Some(derived),
            ..options.clone()
        };
        Ok(Self {
            data: dataset(&samples, &spec)?,
            spec,
            times,
            derivatives,
            rows,
            notes,
            findings,
            may_turn,
            could_turn,
            differences,
            decided,
        })
    }
}

/// How finely the states were recorded.
fn precision(digits: &Digits, options: &LogOptions) -> Precision {
    options.precision.unwrap_or(match (digits.float32, options.clock) {
        (true, Clock::Stamps | Clock::Given(_)) => Precision::F32,
        _ => Precision::F64,
    })
}

/// The pairs of columns that show an angle: those given, which are checked, or those recognised, which are noted.
fn circles_of(recordings: &[Recording], options: &LogOptions, notes: &mut Vec<Note>) -> Result<Vec<Circle>, LogError> {
    let names = |c: &Circle| (options.states[c.cosine].clone(), options.states[c.sine].clone());
    if let Some(given) = &options.circles {
        let circles = circles::given(given, &options.states)?;
        return match circles.iter().find(|c| !circles::on_circle(recordings, c.cosine, c.sine)) {
            Some(c) => {
                let (cosine, sine) = names(c);
                Err(DeclarationError::NotACircle { cosine, sine }.into())
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
    names: &[String],
    (options, units): (&LogOptions, &[(&str, &str)]),
    notes: &mut Vec<Note>,
) -> Result<Vec<(usize, usize)>, LogError> {
    if let Some(given) = &options.rates {
        let rates = rates::given(given, names)?;
        notes.extend(rates.iter().filter_map(|&(rate, of)| rates::doubted(states, names, rate, of)));
        return Ok(rates);
    }
    let seen = rates::recognised(states);
    notes.extend(seen.iter().map(|seen| {
        let (rate, of) = (names[seen.rate].clone(), names[seen.of].clone());
        Note::Rate { rate, of, percent: (100.0 * seen.off_by).max(0.1) }
    }));
    notes.extend(rates::in_other_units(states, names, &seen));
    notes.extend(late_rates::late(states, names, &seen));
    let unit = |state: usize| units.iter().find(|(name, _)| *name == names[state]).map_or("", |(_, unit)| unit);
    notes.extend(
        seen.iter()
            .filter(|seen| units::are_reversed(unit(seen.rate), unit(seen.of)))
            .map(|seen| Note::RateUnits { rate: names[seen.rate].clone(), of: names[seen.of].clone() }),
    );
    Ok(seen.into_iter().map(|seen| (seen.rate, seen.of)).collect())
}

/// The recordings, each of two rows or more, as a data set.
fn dataset(recordings: &[&Recording], spec: &Spec) -> Result<Dataset, LogError> {
    let (m, k) = (spec.observation_dim(), spec.control_dim());
    let mut data = Dataset::new(m, k, k, spec.dt);
    for recording in recordings {
        data.begin(&recording.states.row(0).to_vec())?;
        for i in 1..recording.lines.len() {
            let input = recording.inputs.row(i - 1).to_vec();
            data.push(&input, &input, 0.0, &recording.states.row(i).to_vec())?;
        }
    }
    Ok(data)
}
