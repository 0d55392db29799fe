//! Logged data: a CSV file, and what the user says about it, as rollouts of a declared system.

mod circles;
mod clock;
mod declare;
mod doubts;
mod held_out;
mod jumps;
mod rates;
mod recording;
mod resolution;
mod table;

use std::path::Path;

use sindyna_core::{Dataset, Precision, Spec};

use crate::failure::Failure;
use circles::Reading;
pub(crate) use held_out::held_out;
pub(crate) use rates::closes_circle;
use recording::{Recording, Selected, TIME, TRAJECTORY, recordings};
use table::Table;

/// What the user says about a log.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LogOptions {
    /// Columns that are states.
    pub(crate) states: Vec<String>,
    /// Columns that are inputs.
    pub(crate) inputs: Vec<String>,
    /// States that are angles \[rad\].
    pub(crate) angles: Vec<String>,
    /// States that are rates of others; none given: what the data show.
    pub(crate) rates: Option<Vec<(String, String)>>,
    /// Pairs of states that are cosine and sine of one angle; none given: what the data show.
    pub(crate) circles: Option<Vec<(String, String)>>,
    /// Standard deviations of the noise on states, in their units.
    pub(crate) noise: Vec<(String, f64)>,
    /// States with their lowest and highest value.
    pub(crate) limits: Vec<(String, f64, f64)>,
    pub(crate) clock: Clock,
    /// How finely the states were shown; none given: what the numbers show.
    pub(crate) precision: Option<Precision>,
}

/// Where the sampling interval comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Clock {
    /// Evenly spaced time stamps.
    Stamps,
    /// The user \[s\].
    Given(f64),
    /// Interpolation of whatever time stamps there are \[s\].
    Resampled(f64),
}

/// A log, understood.
#[derive(Debug)]
pub(crate) struct Log {
    pub(crate) spec: Spec,
    pub(crate) data: Dataset,
    /// Rows of the file.
    pub(crate) rows: usize,
    /// What was decided without being asked for, for the user to check.
    pub(crate) notes: Vec<String>,
}

impl Log {
    /// Reads the log at `path`.
    pub(crate) fn read(path: &Path, options: &LogOptions) -> Result<Self, Failure> {
        let table = Table::read(path)?;
        let columns = selected(&table, path, options)?;
        let folded = positions(&options.angles, &options.states, "--angles")?;
        options.angles.iter().try_for_each(|angle| in_unit(&table, angle, "rad", "radians"))?;
        let (mut recordings, digits) = recordings(&table, &columns)?;
        let mut notes = unused(&table, &columns);
        if table.ends_abruptly() {
            notes.push(
                "the last line has no line break; if the log was cut off there, its last number may be short".into(),
            );
        }
        let rows = recordings.iter().map(|r| r.lines.len()).sum();
        notes.extend(unwrap(&mut recordings, &folded, &options.states));
        notes.extend(jumps::note(&recordings, &options.states));
        notes.extend(still(&recordings, &options.states));
        let dt = match options.clock {
            Clock::Stamps if columns.time.is_none() => {
                let failure = Failure::new(format!("{} has no column `{TIME}` and --dt was not given", path.display()));
                let stamps = table.columns().iter().find(|c| is_time(&c.name));
                return Err(match stamps {
                    Some(column) => failure.hint(format!(
                        "if `{}` holds the time in seconds, name it `{TIME}` in the header; else give the time between two rows with --dt",
                        column.name
                    )),
                    None => failure
                        .hint("give the time between two rows in seconds with --dt; for a map without seconds, --dt 1"),
                });
            }
            Clock::Stamps => clock::interval(&table, &recordings, digits.time_decimals)?,
            Clock::Given(dt) => {
                notes.extend(columns.time.map(|_| format!("--dt {dt} is taken, the column `{TIME}` is not looked at")));
                dt
            }
            Clock::Resampled(dt) => {
                if columns.time.is_none() {
                    return Err(Failure::new(format!("--resample needs time stamps: a column `{TIME}` in seconds")));
                }
                clock::check_resampling(&table, &recordings, dt)?;
                recordings = recordings.iter().map(|r| clock::resampled(r, dt)).collect();
                notes.push(format!("resampled every {dt} s: straight lines between rows, inputs held"));
                dt
            }
        };
        let circles = match &options.circles {
            Some(given) => {
                let circles = given_circles(given, &options.states)?;
                if let Some(c) = circles.iter().find(|c| !circles::on_circle(&recordings, c.cosine, c.sine)) {
                    let (cosine, sine) = (&options.states[c.cosine], &options.states[c.sine]);
                    return Err(Failure::new(format!("--circles {cosine}={sine}: their squares do not add up to 1")));
                }
                circles
            }
            None => {
                let circles = circles::recognised(&recordings, &options.states);
                notes.extend(circles.iter().map(|c| {
                    let (cosine, sine) = (&options.states[c.cosine], &options.states[c.sine]);
                    format!("{cosine} and {sine} are taken as cosine and sine of one angle, {}; say --circles none to stop this", c.name)
                }));
                circles
            }
        };
        let readings = circles::readings(options.states.len(), &circles);
        let names: Vec<String> = readings.iter().map(|r| name_of(*r, &circles, &options.states)).collect();
        let states = circles::read(&recordings, &readings);
        let mut angles = positions(&options.angles, &names, "--angles")?;
        angles.extend((0..readings.len()).filter(|&i| matches!(readings[i], Reading::Circle { .. })));
        let rates = match &options.rates {
            Some(given) => {
                let rates = given_rates(given, &names)?;
                notes.extend(rates.iter().filter_map(|&(rate, of)| doubted(&states, dt, &names, rate, of)));
                rates
            }
            None => rates::recognised(&states, dt)
                .into_iter()
                .map(|seen| {
                    let (rate, of) = (&names[seen.rate], &names[seen.of]);
                    let percent = (100.0 * seen.off_by).max(0.1);
                    notes.push(format!(
                        "{rate} is taken as the rate of {of}, which changes by it to within {percent:.1} %; say --rates \
                         none to stop this"
                    ));
                    (seen.rate, seen.of)
                })
                .collect(),
        };
        let precision = options.precision.unwrap_or(match (digits.float32, options.clock) {
            (true, Clock::Stamps | Clock::Given(_)) => Precision::F32,
            _ => Precision::F64,
        });
        let kinds = declare::kinds(&names, &angles, &rates)?;
        let mut spec = Spec { dt, precision, ..declare::spec(path, &table, &columns, &recordings) };
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
        notes.extend((skipped > 0).then(|| format!("{skipped} trajectories of one row have no step and are left out")));
        Ok(Self { spec, data, rows, notes })
    }
}

/// The columns the user names.
fn selected(table: &Table, path: &Path, options: &LogOptions) -> Result<Selected, Failure> {
    if options.states.is_empty() {
        return Err(which_columns(table, path));
    }
    let named: Vec<&String> = options.states.iter().chain(&options.inputs).collect();
    for (i, name) in named.iter().enumerate() {
        if [TIME, TRAJECTORY].contains(&name.as_str()) {
            let is = if *name == TIME { "the time" } else { "what tells rollouts apart" };
            return Err(Failure::new(format!("`{name}` is {is}, not a state or an input")));
        }
        if named[..i].contains(name) {
            return Err(Failure::new(format!("the column `{name}` is named twice among states and inputs")));
        }
    }
    in_unit(table, TIME, "s", "seconds")?;
    let columns = |names: &[String]| names.iter().map(|n| table.column(n)).collect::<Result<Vec<_>, _>>();
    Ok(Selected {
        states: columns(&options.states)?,
        inputs: columns(&options.inputs)?,
        time: table.find(TIME),
        trajectory: table.find(TRAJECTORY),
    })
}

/// Refuses the column `name` if its header tells another unit than `wanted`.
fn in_unit(table: &Table, name: &str, wanted: &str, words: &str) -> Result<(), Failure> {
    match table.find(name).map(|column| &table.columns()[column].unit) {
        Some(unit) if !unit.is_empty() && unit != wanted => {
            Err(table.failure(1, &format!("the column `{name}` is in `{unit}`; it must be in {words}")))
        }
        _ => Ok(()),
    }
}

/// Asks which columns are what, and shows the call.
fn which_columns(table: &Table, path: &Path) -> Failure {
    let names = table.columns().iter().map(|c| c.name.as_str());
    let open: Vec<&str> = names.filter(|n| !n.is_empty() && ![TIME, TRAJECTORY].contains(n)).collect();
    if open.is_empty() {
        return Failure::new(format!("{} has no column but `{TIME}` and `{TRAJECTORY}`", path.display()));
    }
    let looks_like_input = |name: &str| {
        let letters: String = name.to_lowercase().chars().take_while(char::is_ascii_alphabetic).collect();
        ["u", "f", "a", "action", "control", "force", "input", "torque"].contains(&letters.as_str())
    };
    let (inputs, states): (Vec<&str>, Vec<&str>) =
        open.iter().filter(|n| **n != "reward").partition(|name| looks_like_input(name));
    let quote = |list: &[&str]| match list.join(",") {
        list if list.contains([' ', '(', '*']) => format!("'{list}'"),
        list => list,
    };
    let inputs = if inputs.is_empty() { String::new() } else { format!(" --inputs {}", quote(&inputs)) };
    let dt = if table.find(TIME).is_some() { "" } else { " --dt SECONDS" };
    let list = open.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ");
    Failure::new(format!("which of the columns {list} are states, and which are inputs?")).hint(format!(
        "for example: sindyna identify {} --states {}{inputs}{dt}",
        path.display(),
        quote(&states)
    ))
}

/// Whether a column of this name is likely to hold time stamps.
fn is_time(name: &str) -> bool {
    ["time", "timestamp", "time_s", "seconds", "sec"].contains(&name.to_lowercase().as_str())
}

fn unused(table: &Table, columns: &Selected) -> Vec<String> {
    let used = |i: &usize| {
        columns.states.contains(i)
            || columns.inputs.contains(i)
            || [columns.time, columns.trajectory].contains(&Some(*i))
    };
    let left: Vec<String> =
        (0..table.columns().len()).filter(|i| !used(i)).map(|i| format!("`{}`", table.columns()[i].name)).collect();
    match &left[..] {
        [] => vec![],
        [one] => vec![format!("the column {one} is not used")],
        several => vec![format!("the columns {} are not used", several.join(", "))],
    }
}

/// Where each of `names` stands among the states.
fn positions(names: &[String], states: &[String], option: &str) -> Result<Vec<usize>, Failure> {
    let position = |name: &String| {
        states.iter().position(|s| s == name).ok_or_else(|| {
            let known: Vec<&str> = states.iter().map(String::as_str).collect();
            crate::registry::unknown(&format!("state for {option}"), name, &known)
        })
    };
    names.iter().map(position).collect()
}

fn given_rates(pairs: &[(String, String)], states: &[String]) -> Result<Vec<(usize, usize)>, Failure> {
    let mut rates: Vec<(usize, usize)> = Vec::new();
    for (rate, of) in pairs {
        let both = positions(&[rate.clone(), of.clone()], states, "--rates")?;
        let (rate_idx, of_idx) = (both[0], both[1]);
        if rate_idx == of_idx {
            return Err(Failure::new(format!("--rates {rate}={of}: a state cannot be its own rate")));
        }
        if let Some(&(r, o)) = rates.iter().find(|(r, o)| *r == rate_idx || *o == of_idx) {
            let (r, o) = (&states[r], &states[o]);
            return Err(Failure::new(format!("--rates {rate}={of} does not go with {r}={o}: one rate for one state")));
        }
        if closes_circle(&rates, (rate_idx, of_idx)) {
            let message = format!("--rates {rate}={of} closes a circle: {rate} would be its own rate by way of others");
            return Err(Failure::new(message).hint("leave one of the pairs out: its equation is then looked for"));
        }
        rates.push((rate_idx, of_idx));
    }
    Ok(rates)
}

/// A note where a state hardly changes by what was declared to be its rate.
fn doubted(states: &[Recording], dt: f64, names: &[String], rate: usize, of: usize) -> Option<String> {
    /// Difference, as a share of the change, from which nothing speaks for it.
    const DOUBTFUL: f64 = 0.5;
    let off_by = rates::off_by(states, dt, rate, of).filter(|off| *off > DOUBTFUL)?;
    let (rate, of) = (&names[rate], &names[of]);
    Some(format!(
        "{rate} is taken as the rate of {of} because --rates says so; {of} changes otherwise, by {:.0} %",
        100.0 * off_by
    ))
}

/// Joins angles that were folded into one turn.
fn unwrap(recordings: &mut [Recording], angles: &[usize], names: &[String]) -> Vec<String> {
    use std::f64::consts::{PI, TAU};
    let mut notes = Vec::new();
    for &angle in angles {
        let values = || recordings.iter().flat_map(|r| r.states.column(angle).to_vec());
        let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        // What spans more than a turn was never folded.
        if high - low > TAU * (1.0 + 1e-6) {
            continue;
        }
        let mut joined = 0;
        for recording in &mut *recordings {
            let (mut turns, mut last) = (0.0, None);
            for value in recording.states.column_mut(angle) {
                let step: f64 = last.map_or(0.0, |last| *value - last);
                last = Some(*value);
                if step.abs() > PI {
                    turns -= step.signum();
                    joined += 1;
                }
                *value += turns * TAU;
            }
        }
        if joined > 0 {
            let s = if joined == 1 { "" } else { "s" };
            notes.push(format!("{} is joined where it jumps by a whole turn: {joined} jump{s}", names[angle]));
        }
    }
    notes
}

/// What a state is called.
fn name_of(reading: Reading, circles: &[circles::Circle], columns: &[String]) -> String {
    match reading {
        Reading::Column(column) => columns[column].clone(),
        Reading::Circle { cosine, .. } => {
            circles.iter().find(|c| c.cosine == cosine).map_or_else(|| "angle".into(), |c| c.name.clone())
        }
    }
}

fn given_circles(pairs: &[(String, String)], states: &[String]) -> Result<Vec<circles::Circle>, Failure> {
    let mut circles: Vec<circles::Circle> = Vec::new();
    for (cosine, sine) in pairs {
        let both = positions(&[cosine.clone(), sine.clone()], states, "--circles")?;
        let taken = circles.iter().any(|c| [c.cosine, c.sine].iter().any(|k| both.contains(k)));
        if taken || both[0] == both[1] {
            return Err(Failure::new(format!(
                "--circles {cosine}={sine}: a state shows one angle, with one other state"
            )));
        }
        let named = circles::circle(states, both[0], both[1]);
        circles.push(circles::Circle { cosine: both[0], sine: both[1], ..named });
    }
    Ok(circles)
}

/// The recordings as a data set, and how many of them have no step.
fn dataset(recordings: &[Recording], spec: &Spec) -> Result<(Dataset, usize), Failure> {
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

/// States that never change: no term of another equation can be told from the same with them in it.
fn still(recordings: &[Recording], names: &[String]) -> Vec<String> {
    let stays = |i: &usize| {
        let mut values = recordings.iter().flat_map(|r| r.states.column(*i).to_vec());
        let first = values.next();
        values.all(|v| Some(v) == first)
    };
    let note =
        |i: usize| format!("{} never changes, so what it does cannot be seen; no candidate term has it", names[i]);
    (0..names.len()).filter(stays).map(note).collect()
}
