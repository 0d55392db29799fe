//! `sindyna identify --urdf` and `--mjcf`: the parameters of a robot whose joints are known.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde::Serialize;
use sindyna_bodies::{BodiesError, Calibration, Drive, Mjcf, Motion, Prediction, Tree, Urdf, predict};
use sindyna_core::number::significant;
use sindyna_record::run::RunDir;
use sindyna_report::text::aligned;

use crate::cli::answer::{Answer, Verdict};
use crate::cli::console::width;
use crate::cli::failure::Failure;
use crate::cli::interrupt::Interrupt;
use crate::cli::reading::heading;
use crate::identify::{Matched, RobotError, RobotFound, motions, robot};
use crate::logs::Log;

/// The file of all results.
const RESULTS: &str = "parameters.json";

/// The version of its format.
const FORMAT: u32 = 1;

/// What `parameters.json` holds.
#[derive(Serialize)]
struct Results<'a> {
    format: u32,
    robot: &'a Path,
    joints: Vec<Joint<'a>>,
    method: &'a str,
    condition: f64,
    /// Rows by which inputs act later than they were recorded.
    delay: i32,
    undetermined: usize,
    warnings: Vec<String>,
    base_parameters: Vec<BaseParameter>,
    parameters: Vec<Parameter>,
    prediction: Option<Predicted<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    held_out: Option<Predicted<'a>>,
}

#[derive(Serialize)]
struct Joint<'a> {
    joint: &'a str,
    position: &'a str,
    rate: &'a str,
    inputs: &'a [String],
}

#[derive(Serialize)]
struct BaseParameter {
    combination: String,
    value: f64,
    /// None where the data do not determine it.
    standard_error: Option<f64>,
    /// None where the file has no inertial parameters.
    file: Option<f64>,
}

#[derive(Serialize)]
struct Parameter {
    name: String,
    value: f64,
    file: Option<f64>,
}

#[derive(Serialize)]
struct Predicted<'a> {
    seconds: f64,
    windows: usize,
    diverged: usize,
    rmse: &'a [f64],
    rmse_of_file: Option<&'a [f64]>,
}

impl<'a> Predicted<'a> {
    fn of(prediction: &'a Prediction) -> Self {
        Self {
            seconds: prediction.seconds,
            windows: prediction.windows,
            diverged: prediction.diverged,
            rmse: &prediction.errors,
            rmse_of_file: prediction.before.as_deref(),
        }
    }
}

/// What `--json` says.
#[derive(Serialize)]
struct Told<'a> {
    record: Option<&'a Path>,
    notes: Vec<String>,
    results: &'a Results<'a>,
}

/// A file that describes a robot.
#[derive(Debug, Clone, Copy)]
pub(super) enum File<'a> {
    Urdf(&'a Path),
    Mjcf(&'a Path),
}

/// What it describes.
enum Robot {
    Urdf(Urdf),
    Mjcf(Mjcf),
}

impl File<'_> {
    fn path(&self) -> &Path {
        let (Self::Urdf(path) | Self::Mjcf(path)) = self;
        path
    }

    fn read(&self) -> Result<Robot, Failure> {
        let path = self.path();
        let text = std::fs::read_to_string(path).map_err(|e| Failure::new(format!("{}: {e}", path.display())))?;
        let read = match self {
            Self::Urdf(_) => Urdf::parse(&text).map(Robot::Urdf),
            Self::Mjcf(_) => Mjcf::parse(&text).map(Robot::Mjcf),
        };
        read.map_err(|e| Failure::from(anyhow::Error::new(e).context(path.display().to_string())))
    }
}

impl Robot {
    fn tree(&self) -> &Tree {
        match self {
            Self::Urdf(urdf) => &urdf.tree,
            Self::Mjcf(mjcf) => &mjcf.tree,
        }
    }

    /// What inputs act on: motors, or where the file has none each joint.
    fn drives(&self) -> Vec<Drive> {
        match self {
            Self::Mjcf(mjcf) if !mjcf.drives.is_empty() => mjcf.drives.clone(),
            _ => self
                .tree()
                .joints
                .iter()
                .enumerate()
                .map(|(joint, j)| Drive { name: j.name.clone(), joint, gear: 1.0 })
                .collect(),
        }
    }

    fn with_parameters(&self, parameters: &[f64]) -> Result<String, BodiesError> {
        match self {
            Self::Urdf(urdf) => urdf.with_parameters(parameters),
            Self::Mjcf(mjcf) => mjcf.with_parameters(parameters),
        }
    }
}

/// Identifies the parameters of the robot in `file` from `log`.
pub(super) fn run(
    file: File<'_>,
    (log, logs): (&Log, &[&Path]),
    other: Option<&Log>,
    out: Option<&Path>,
) -> Result<Answer, Failure> {
    let interrupt = Interrupt::listen()?;
    let path = file.path();
    let read = file.read()?;
    let (tree, drives) = (read.tree(), read.drives());
    let found = match robot(log, (tree, &drives), &|| !interrupt.pressed()) {
        Err(RobotError::Bodies(BodiesError::Interrupted)) => return Ok(Answer::silent(Verdict::Interrupted)),
        Err(error) => return Err(failed(error, tree, &drives)),
        Ok(found) => found,
    };
    let RobotFound { calibration, joints } = &found;
    let go_on = || !interrupt.pressed();
    let held_out = match other {
        Some(other) => {
            let (motions, _) = motions(other, tree, &drives).map_err(|e| failed(e, tree, &drives))?;
            let before = predict(tree, &tree.parameters(), &motions, &go_on).filter(|p| p.diverged == 0);
            let motions: Vec<Motion> = motions.iter().map(|m| m.delayed(calibration.delay)).collect();
            let found = predict(tree, &calibration.parameters, &motions, &go_on);
            found.map(|p| Prediction { before: before.map(|b| b.errors), ..p })
        }
        None => None,
    };
    let (names, before) = (tree.names(), tree.parameters());
    let base_before = calibration.base.values(&before);
    let has_all = tree.joints.iter().all(|j| j.is_massless || j.inertia.mass() > 0.0);
    let base = (0..calibration.base.len()).map(|i| BaseParameter {
        combination: calibration.base.told(i, &names),
        value: calibration.values[i],
        standard_error: Some(calibration.errors[i]).filter(|e| e.is_finite()),
        file: has_all.then_some(base_before[i]),
    });
    let all = names.iter().zip(&calibration.parameters).zip(&before);
    let results = Results {
        format: FORMAT,
        robot: path,
        joints: joints
            .iter()
            .map(|j| Joint { joint: &j.joint, position: &j.position, rate: &j.rate, inputs: &j.inputs })
            .collect(),
        method: &calibration.form,
        condition: calibration.condition,
        delay: calibration.delay,
        warnings: warnings(calibration, joints),
        undetermined: calibration.undetermined,
        base_parameters: base.collect(),
        parameters: all
            .map(|((name, value), file)| Parameter {
                name: name.clone(),
                value: *value,
                file: has_all.then_some(*file),
            })
            .collect(),
        prediction: calibration.prediction.as_ref().map(Predicted::of),
        held_out: held_out.as_ref().map(Predicted::of),
    };
    let updated = read.with_parameters(&calibration.parameters).map_err(anyhow::Error::new)?;
    let name = path.file_name().map_or_else(|| "robot.urdf".into(), |name| name.to_string_lossy().into_owned());
    let mut json = serde_json::to_vec_pretty(&results)?;
    json.push(b'\n');
    let files = [(RESULTS, json), (name.as_str(), updated.into_bytes())];
    let written = match out {
        Some(out) => RunDir::create(out, &files),
        None => RunDir::create_numbered(&Path::new("models").join(stem(path)), &files),
    };
    let mut text = heading(logs, log) + "\n" + &told(path, &results);
    if let Ok(dir) = &written {
        let dir = dir.path().display();
        let _ = writeln!(text, "record: {dir} ({RESULTS}, {name} with these parameters)");
    }
    let answer = Told {
        record: written.as_ref().ok().map(RunDir::path),
        notes: log.notes.iter().map(ToString::to_string).collect(),
        results: &results,
    };
    Ok(Answer::new(Verdict::Done, text, &answer)?.and(written.map_err(Failure::from)))
}

fn stem(path: &Path) -> PathBuf {
    path.file_stem().map_or_else(|| "robot".into(), PathBuf::from)
}

/// Part of a motion that a prediction may miss.
const MISSED: f64 = 0.2;

/// What speaks against the parameters.
fn warnings(calibration: &Calibration, joints: &[Matched]) -> Vec<String> {
    let mut all = Vec::new();
    let silent: Vec<&str> = joints.iter().filter(|j| j.inputs.is_empty()).map(|j| j.joint.as_str()).collect();
    if !silent.is_empty() {
        all.push(format!("no input acts on {}: it is taken as free of forces", silent.join(", ")));
    }
    let Some(prediction) = &calibration.prediction else { return all };
    if prediction.diverged > 0 {
        all.push(format!(
            "the prediction diverges in {} of {} windows: the parameters are wrong; look at units, signs and the order of the columns",
            prediction.diverged, prediction.windows
        ));
    }
    for ((joint, error), still) in joints.iter().zip(&prediction.errors).zip(&prediction.still) {
        if *still > 0.0 && error.is_finite() && *error > MISSED * still {
            let percent = significant(100.0 * error / still, 2);
            all.push(format!(
                "the motion of {} is not explained: the prediction misses {percent} % of it (other friction, contacts, a spring, a wrong column or unit)",
                joint.joint
            ));
        }
    }
    all
}

/// A parameter of the file.
fn in_file(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), |value| significant(value, 6))
}

/// The results as text.
fn told(path: &Path, results: &Results<'_>) -> String {
    let mut text = format!("robot: {}, {} joints\n", path.display(), results.joints.len());
    for joint in &results.joints {
        let input = if joint.inputs.is_empty() { "no input".to_owned() } else { joint.inputs.join(", ") };
        let _ = writeln!(text, "  {}: {}, {}, {input}", joint.joint, joint.position, joint.rate);
    }
    let _ = writeln!(
        text,
        "\n{} base parameters by {}; condition number {}",
        results.base_parameters.len(),
        results.method,
        significant(results.condition, 2)
    );
    if results.delay != 0 {
        let rows = results.delay.unsigned_abs();
        let when = if results.delay > 0 { "later" } else { "earlier" };
        let _ =
            writeln!(text, "inputs act {rows} row{} {when} than they were recorded", if rows == 1 { "" } else { "s" });
    }
    for warning in &results.warnings {
        let _ = writeln!(text, "warning: {warning}");
    }
    if results.undetermined > 0 {
        let _ = writeln!(
            text,
            "the motions in the data do not determine {} of them: move more joints together, and in both directions",
            results.undetermined
        );
    }
    let mut rows = vec![["combination", "value", "standard error", "file"].map(str::to_owned)];
    rows.extend(results.base_parameters.iter().map(|base| {
        let error = base.standard_error.map_or_else(|| "not determined".to_owned(), |e| significant(e, 2));
        [base.combination.clone(), significant(base.value, 6), error, in_file(base.file)]
    }));
    text += &aligned(&rows, width());
    let mut rows = vec![["parameter", "value", "file"].map(str::to_owned)];
    rows.extend(results.parameters.iter().map(|p| [p.name.clone(), significant(p.value, 6), in_file(p.file)]));
    text += "\n\nall parameters: physically consistent, with nearly these base parameters, and else near those of the file\n";
    text += &aligned(&rows, width());
    text += "\n";
    if let Some(prediction) = &results.prediction {
        text += &predicted("the last 30 %, not fitted", prediction, results);
    }
    if let Some(prediction) = &results.held_out {
        text += &predicted("the logs held out", prediction, results);
    }
    text
}

/// A prediction as text.
fn predicted(what: &str, prediction: &Predicted<'_>, results: &Results<'_>) -> String {
    let (seconds, windows) = (significant(prediction.seconds, 3), prediction.windows);
    let mut text =
        format!("\nprediction of {what}, over {seconds} s ({windows} windows, {} diverged)\n", prediction.diverged);
    let mut rows = vec![["joint", "median RMSE", "with the file's parameters"].map(str::to_owned)];
    rows.extend(results.joints.iter().enumerate().map(|(i, joint)| {
        let of_file = prediction.rmse_of_file.map_or_else(|| "–".to_owned(), |e| significant(e[i], 3));
        [joint.joint.to_owned(), significant(prediction.rmse[i], 3), of_file]
    }));
    text += &aligned(&rows, width());
    text + "\n"
}

/// What can be done where columns and joints do not fit each other.
fn failed(error: RobotError, tree: &Tree, drives: &[Drive]) -> Failure {
    let listed = |names: Vec<&str>| names.join(", ");
    let hint = match &error {
        RobotError::Positions { .. } => Some(format!(
            "--states names positions and rates of the joints, --rates which is the rate of which; joints: {}",
            listed(tree.joints.iter().map(|j| j.name.as_str()).collect())
        )),
        RobotError::Inputs { .. } => Some(format!(
            "name the columns of inputs after the joints on which they act, or --inputs in their order: {}",
            listed(drives.iter().map(|d| d.name.as_str()).collect())
        )),
        RobotError::Bodies(BodiesError::TooFew { .. } | BodiesError::Short { .. }) => Some("use a longer log".into()),
        _ => None,
    };
    let failure = Failure::from(anyhow::Error::new(error));
    match hint {
        Some(hint) => failure.hint(hint),
        None => failure,
    }
}
