//! `sindyna export`: equations as a program in another language.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context as _;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use serde_json::{Value, json};
use sindyna_core::number::significant;
use sindyna_core::{Channel, Task};
use sindyna_export::{Contents, Interface, Language, PRODUCER, Program};
use sindyna_record::Own;
use sindyna_record::identification::{Stepping, read_model};
use sindyna_rl::SavedPolicy;
use sindyna_sindy::{Expr, Model, export};
use sindyna_training::problem::{RECORDED_LOG, Source};
use sindyna_training::settings::{ControllerName, TrainConfig};

use super::answer::{Answer, Verdict};
use crate::cli::failure::Failure;

/// Write equations, and the policy of a run, as a program in another language
///
/// `rhs(x, u)` returns the rates of the states (not for a map), `step(x, u)` the state one control interval later, and, for a run, `act(o)` the
/// action of its policy for an observation, scaling and limits included. In C, JavaScript, Python and Rust, `observe(x)`, `control(action)` and
/// `clip(x)` close the loop: x = clip(step(x, control(act(observe(x))))). Numbers are double precision; actions differ from those of sindyna by at
/// most 1e-6 of their range. docs/export.md describes each file and what it needs.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    /// Output directory of `sindyna identify` or `sindyna train`, or a model.json
    #[arg(value_name = "DIR")]
    from: PathBuf,
    /// Language to write
    #[arg(long, value_name = "LANGUAGE", value_parser = languages())]
    to: Language,
    /// File to write, `-` for standard output; an existing file is overwritten only if an export wrote it [default: model.py, .c, .mjs, .rs, .tex, .html, .onnx, .fmu or model_casadi.py next to model.json]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

const EXAMPLE: &str = "\
Example:  sindyna export models/pendulum --to python
          python3 -c 'import sys; sys.path.append(\"models/pendulum\"); import model; print(model.step([0.1, 0.0], [0.5]))'";

/// The languages by name, with what is written in them.
fn languages() -> impl TypedValueParser<Value = Language> {
    let value = |language: Language| PossibleValue::new(language.name()).help(language.about());
    PossibleValuesParser::new(Language::ALL.map(value))
        .try_map(|name| Language::ALL.into_iter().find(|language| language.name() == name).ok_or("unknown language"))
}

pub(crate) fn run(args: &Args) -> Result<Answer, Failure> {
    let file = if args.from.is_dir() { args.from.join("model.json") } else { args.from.clone() };
    let text =
        std::fs::read_to_string(&file).with_context(|| format!("cannot read {}", file.display())).map_err(|e| {
            Failure::from(e)
                .hint("DIR is an output directory of `sindyna identify` or `sindyna train`, or a model.json")
        })?;
    let model = read_model(&text).with_context(|| format!("{} is not a model", file.display()))?;
    let directory = file.parent().unwrap_or(Path::new(""));
    let (system, notes) = (export::System::from(&model), notes(directory, &model));
    let program = Program::new(system, notes);
    let task = task(directory);
    let (task, formulas) = task.map_or((None, Vec::new()), |(task, formulas)| (Some(task), formulas));
    let program = match policy(directory, task.as_deref())? {
        Some((policy, observed)) => program.with_policy(&policy, observed),
        None => program,
    };
    let program = program.with_interface(interface(directory, &model, task.as_deref().zip(Some(&formulas[..]))));
    if args.to == Language::Html && program.interface.is_none() {
        return Err(Failure::new(format!(
            "{} cannot be exported as a page: the start state is not known",
            file.display()
        ))
        .hint("name the directory of a run or of an identification, with config.toml or data.csv in it"));
    }
    let written = args.to.write(&program)?;
    let (text, bytes) = match &written.contents {
        Contents::Text(text) => (Some(text), text.as_bytes()),
        Contents::Bytes(bytes) => (None, &bytes[..]),
    };
    // To rename a file over what standard output leads to would replace it.
    if args.out.as_deref().is_some_and(is_stdout) {
        let Some(text) = text else {
            return Err(Failure::new(format!("{} is binary and not written to standard output", args.to.name()))
                .hint("name a file with --out"));
        };
        let result = json!({"language": args.to.name(), "written": null, "policy_written": null, "program": text});
        return Answer::raw(text.clone(), &result);
    }
    let stem = file.file_stem().unwrap_or(OsStr::new("model")).to_string_lossy();
    let out = args.out.clone().unwrap_or_else(|| file.with_file_name(args.to.file_name(&stem)));
    let save = |path: &Path, contents: &[u8]| {
        let own = Own { path, what: "an export of sindyna" };
        let saved = if text.is_some() { own.save(contents) } else { own.save_marked(contents, PRODUCER.as_bytes()) };
        saved.map_err(|e| Failure::of_own(e, "--out"))
    };
    save(&out, bytes)?;
    let policy = written.policy.as_ref().map(|_| beside(&out));
    if let (Some(contents), Some(path)) = (&written.policy, &policy) {
        save(path, contents)?;
    }
    let result = json!({"language": args.to.name(), "written": out, "policy_written": policy, "program": text});
    let paths: Vec<String> = std::iter::once(&out).chain(&policy).map(|path| path.display().to_string()).collect();
    let note = written.note.as_ref().map_or_else(String::new, |note| format!(", {note}"));
    let planner = planner(directory).map_or_else(String::new, |name| {
        format!("no policy was written: the planner of --controller {name} is not exported\n")
    });
    let is_late = config(directory).and_then(|config| config.data).is_some_and(|data| data.delay > 0.0);
    let late = if is_late && program.policy.is_some() {
        "the inputs act late: the policy takes the observation predicted for when they act, and the written program predicts none\n"
    } else {
        ""
    };
    let told = format!("{model}\n{}\n\nwritten: {}{note}\n{planner}{late}", Stepping::of(&model), paths.join(", "));
    Answer::new(Verdict::Done, told, &result)
}

/// Where the policy goes that cannot be in the file `out`: `a.policy.onnx` beside `a.onnx`.
fn beside(out: &Path) -> PathBuf {
    let ending = out.extension().map_or_else(String::new, |ending| format!(".{}", ending.to_string_lossy()));
    out.with_extension(format!("policy{ending}"))
}

/// The configuration of a run, where it is one.
fn config(directory: &Path) -> Option<TrainConfig> {
    TrainConfig::parse(&std::fs::read_to_string(directory.join("config.toml")).ok()?).ok()
}

/// The planner that is the policy of a run, where it is one.
fn planner(directory: &Path) -> Option<ControllerName> {
    config(directory).map(|config| config.controller).filter(|controller| !controller.trains())
}

/// A task, and the observed values of it that are formulas of its states, by their names.
type Declared<'a> = (&'a dyn Task, &'a [(String, Expr)]);

/// Name and formula of an observed value.
type Formula = (String, Expr);

/// The task of a run, where it is one and what it needs is there.
fn task(directory: &Path) -> Option<(Arc<dyn Task>, Vec<Formula>)> {
    let source = Source::of(&config(directory)?, directory, None);
    Some((source.task().ok()?.0, source.formulas().ok()?))
}

/// Rows of a log that a page begins in, at most.
const STARTS: usize = 12;

/// What a page to play with has to know besides `model`: of a run its task, of an identification its data.
fn interface(directory: &Path, model: &Model, task: Option<Declared<'_>>) -> Option<Interface> {
    if model.readings().is_some() {
        return None;
    }
    if let Some((task, formulas)) = task {
        let same = task.spec().state.iter().map(|channel| &channel.name).eq(model.states());
        return Interface::of(task, formulas, 0).filter(|_| same);
    }
    let data = std::fs::read_to_string(directory.join(RECORDED_LOG)).ok()?;
    let mut reader = csv::Reader::from_reader(data.as_bytes());
    let names = reader.headers().ok()?.clone();
    let rows: Vec<csv::StringRecord> = reader.records().map_while(Result::ok).collect();
    let values = |row: &csv::StringRecord, wanted: &[String]| {
        let value = |name: &String| {
            row.get(names.iter().position(|n| n == name)?)?.parse::<f64>().ok().filter(|v| v.is_finite())
        };
        wanted.iter().map(value).collect::<Option<Vec<f64>>>()
    };
    // Rows whose states were all measured, some of them.
    let measured = rows.iter().step_by(rows.len().div_ceil(STARTS).max(1));
    let starts: Vec<Vec<f64>> = measured.filter_map(|row| values(row, model.states())).collect();
    let inputs: Vec<Vec<f64>> = rows.iter().filter_map(|row| values(row, model.controls())).collect();
    let held = inputs.first().cloned().unwrap_or_else(|| vec![0.0; model.controls().len()]);
    let range = |i: usize| {
        let column = || inputs.iter().map(|row| row[i]);
        (column().fold(f64::INFINITY, f64::min), column().fold(f64::NEG_INFINITY, f64::max))
    };
    let controls = if inputs.is_empty() { Vec::new() } else { (0..model.controls().len()).map(range).collect() };
    if starts.is_empty() {
        return None;
    }
    let name = directory.file_name().map_or_else(|| "model".to_owned(), |name| name.to_string_lossy().into_owned());
    Some(Interface::without_policy(name, model.states().to_vec(), starts, (controls, held)))
}

/// The policy beside a model and the names of what it observes, where there is one.
fn policy(directory: &Path, task: Option<&dyn Task>) -> Result<Option<(SavedPolicy, Vec<String>)>, Failure> {
    let path = directory.join("policy.safetensors");
    let bytes = match std::fs::read(&path) {
        Ok(bytes) => bytes,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(anyhow::Error::new(e).context(format!("cannot read {}", path.display())).into()),
    };
    let policy =
        SavedPolicy::from_safetensors(&bytes).with_context(|| format!("{} is not a policy", path.display()))?;
    // Names are for comments; a system that is not there has none.
    let names: Vec<String> =
        task.map_or_else(Vec::new, |task| task.spec().observation.iter().map(|c| c.name.clone()).collect());
    let observed = if names.len() == policy.observation_dim() { names } else { Vec::new() };
    Ok(Some((policy, observed)))
}

/// Whether `out` is a name of standard output.
fn is_stdout(out: &Path) -> bool {
    ["-", "/dev/stdout"].map(Path::new).contains(&out)
}

/// What is known besides the model: where it comes from, units, in which space it lives.
fn notes(directory: &Path, model: &Model) -> Vec<String> {
    let (source, units) = identified(directory).or_else(|| trained(directory)).unwrap_or_default();
    let list = |names: &[String]| {
        let one = |name: &String| match units.iter().find(|(n, unit)| n == name && !unit.is_empty()) {
            Some((_, unit)) => format!("{name} [{unit}]"),
            None => name.clone(),
        };
        if names.is_empty() { "none".to_owned() } else { names.iter().map(one).collect::<Vec<_>>().join(", ") }
    };
    let mut notes = vec![format!("States: {}; inputs: {}.", list(model.states()), list(model.controls()))];
    notes.extend(Some(source).filter(|s| !s.is_empty()));
    if model.readings().is_some() {
        notes.push("The states are the observations; cosine and sine of an angle are not normalised.".into());
    }
    notes
}

/// A sentence about where a model comes from, and units by name.
type Origin = (String, Vec<(String, String)>);

/// From the account that `sindyna identify` left.
fn identified(directory: &Path) -> Option<Origin> {
    let text = std::fs::read_to_string(directory.join("identify.json")).ok()?;
    let document: Value = serde_json::from_str(&text).ok()?;
    let channels = ["states", "inputs"].iter().filter_map(|key| document[key].as_array()).flatten();
    let unit = |c: &Value| Some((c["name"].as_str()?.to_owned(), c["unit"].as_str()?.to_owned()));
    let mut source = format!("Found in {}.", document["log"].as_str()?);
    if let Some(rows) = document["input_delay"].as_f64() {
        source +=
            &format!(" Delay of the inputs in control intervals (negative: earlier): {rows}; u must be shifted by it.");
    }
    if let Some(tau) = document["input_lag"].as_f64() {
        source += &format!(" Lag of the inputs: first order, time constant {tau} s; u is what the actuator delivers.");
    }
    Some((source, channels.filter_map(unit).collect()))
}

/// From the configuration that `sindyna train` left.
fn trained(directory: &Path) -> Option<Origin> {
    let config = config(directory)?;
    let mut source = format!("Found in {} (seed {}).", config.task, config.seed);
    if let Some(delay) = config.data.as_ref().map(|data| data.delay).filter(|delay| *delay > 0.0) {
        source += &format!(" Inputs act {} s late.", significant(delay, 6));
        if config.controller.trains() {
            source += " The policy takes the observation that the equations predict for that time, from the state now and the inputs that have not acted yet; no function here does that.";
        }
    }
    if let Some(lag) = config.data.as_ref().map(|data| data.lag).filter(|lag| *lag > 0.0) {
        source += &format!(
            " Inputs act through a lag of first order, {} s: what actuators deliver are the last states; no sensor shows them, `step` computes them from the inputs.",
            significant(lag, 6)
        );
    }
    let Some(system) = sindyna_envs::find(&config.task).filter(|_| config.task_file.is_none()) else {
        return Some((source, Vec::new()));
    };
    let spec = system.spec();
    let unit = |c: &Channel| (c.name.clone(), c.unit.clone());
    Some((source, spec.state.iter().chain(&spec.observation).chain(&spec.control).map(unit).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn standard_output_has_two_names() {
        let is = ["-", "/dev/stdout", "./-", "stdout", "/dev/null"].map(|out| is_stdout(Path::new(out)));
        assert_eq!(is, [true, true, false, false, false]);
    }
}
