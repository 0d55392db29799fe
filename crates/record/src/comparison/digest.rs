//! A comparison in short: files small enough to be kept for ever, from which everything that is reported follows.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::{Names, Outcome, Request, mean};
use crate::{RecordError, from_csv, save, to_csv};

/// One run: a line of `runs.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Name of the task.
    pub task: String,
    /// Name of the method.
    pub method: String,
    /// Seed of everything random.
    pub seed: u64,
    /// Real steps at the first check that solved the task.
    pub solved_after: Option<usize>,
    /// Real steps in all.
    pub real_steps: usize,
    /// Episodes on the system.
    pub real_episodes: usize,
    /// Gradient updates.
    pub updates: u64,
    /// Simulated steps in the model.
    pub model_steps: u64,
    /// Numbers in the model.
    pub parameters: Option<usize>,
    /// Over the start states of the last evaluation.
    pub mean_return: Option<f64>,
    /// Why the run came to nothing.
    pub failure: Option<String>,
}

/// One look at a policy on the way: a line of `curves.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// Name of the task.
    pub task: String,
    /// Name of the method.
    pub method: String,
    /// Seed of everything random.
    pub seed: u64,
    /// Real steps so far.
    pub real_steps: usize,
    /// Gradient updates.
    pub updates: u64,
    /// Mean of the returns.
    pub mean_return: f64,
}

/// The equations of one run: a line of `models.jsonl`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FoundModel {
    /// Name of the task.
    pub task: String,
    /// Name of the method.
    pub method: String,
    /// Seed of everything random.
    pub seed: u64,
    /// The model ([`sindyna_sindy::Model::to_json`]).
    pub model: serde_json::Value,
}

/// How long one run took: a line of `timing.csv`, apart from the rest because no two are the same.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunTime {
    /// Name of the task.
    pub task: String,
    /// Name of the method.
    pub method: String,
    /// Seed of everything random.
    pub seed: u64,
    /// Seconds in all.
    pub wall_seconds: f64,
}

/// All of it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Digest {
    /// What the runs depend on besides task, method and seed.
    pub settings: String,
    /// What was asked for, which may be more than was done.
    pub asked: Vec<Request>,
    /// One for each run.
    pub runs: Vec<Run>,
    /// Evaluations on the way.
    pub checks: Vec<Check>,
    /// Models with equations.
    pub models: Vec<FoundModel>,
    /// Times that runs took.
    pub times: Vec<RunTime>,
}

const SETTINGS: &str = "settings.txt";
const ASKED: &str = "asked.csv";
const RUNS: &str = "runs.csv";
const CHECKS: &str = "curves.csv";
const MODELS: &str = "models.jsonl";
const TIMES: &str = "timing.csv";
const SUMS: &str = "checksums.csv";

/// What one file held when it was written: a line of `checksums.csv`, which has all files that are the same every time.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Sum {
    file: String,
    bytes: usize,
    crc32: String,
}

impl Sum {
    fn of(file: &str, contents: &[u8]) -> Self {
        Self { file: file.into(), bytes: contents.len(), crc32: format!("{:08x}", crc32fast::hash(contents)) }
    }
}

impl Digest {
    /// Adds a run, and the seconds it took where they are known.
    pub fn add(&mut self, outcome: &Outcome, wall_seconds: Option<f64>) {
        let (task, method, seed) = (|| outcome.task.clone(), || outcome.method.clone(), outcome.seed);
        self.runs.push(Run {
            task: task(),
            method: method(),
            seed,
            solved_after: outcome.solved_after,
            real_steps: outcome.real_steps,
            real_episodes: outcome.real_episodes,
            updates: outcome.updates,
            model_steps: outcome.model_steps,
            parameters: outcome.model_parameters,
            mean_return: outcome.mean_return(),
            failure: outcome.failure.clone(),
        });
        self.checks.extend(outcome.curve.iter().filter_map(|point| {
            let mean_return = mean(&point.returns)?;
            let (real_steps, updates) = (point.real_steps, point.updates);
            Some(Check { task: task(), method: method(), seed, real_steps, updates, mean_return })
        }));
        self.models.extend(outcome.model.iter().map(|model| FoundModel {
            task: task(),
            method: method(),
            seed,
            model: model.clone(),
        }));
        self.times.extend(wall_seconds.map(|wall_seconds| RunTime {
            task: task(),
            method: method(),
            seed,
            wall_seconds,
        }));
    }

    /// Whether `directory` holds one.
    #[must_use]
    pub fn is_in(directory: &Path) -> bool {
        directory.join(RUNS).is_file()
    }

    /// Reads what [`Self::write`] wrote, of tasks and methods that `names` has.
    ///
    /// # Errors
    /// [`RecordError::Io`], [`RecordError::Malformed`], [`RecordError::Inconsistent`].
    pub fn read(directory: &Path, names: &Names<'_>) -> Result<Self, RecordError> {
        let text = |name: &str| {
            let path = directory.join(name);
            fs::read_to_string(&path).map_err(RecordError::io("read", path))
        };
        let models = text(MODELS)?;
        // A line of JSON counts its own lines: the number that helps is that in the file.
        let model = |(number, line): (usize, &str)| {
            serde_json::from_str(line).map_err(|e| {
                let why = e.to_string().split(" at line ").next().unwrap_or_default().to_owned();
                RecordError::MalformedLine { path: directory.join(MODELS), line: number + 1, why }
            })
        };
        let models = models.lines().enumerate().map(model).collect::<Result<_, _>>()?;
        let digest = Self {
            settings: text(SETTINGS)?,
            asked: rows(directory, ASKED)?,
            runs: rows(directory, RUNS)?,
            checks: rows(directory, CHECKS)?,
            models,
            times: rows(directory, TIMES)?,
        };
        let inconsistent = |what| RecordError::Inconsistent { path: directory.to_owned(), what, is_digest: true };
        let sums: Vec<Sum> = rows(directory, SUMS)?;
        for name in [SETTINGS, ASKED, RUNS, CHECKS, MODELS] {
            if !sums.contains(&Sum::of(name, text(name)?.as_bytes())) {
                return Err(inconsistent(format!("{name} was changed after it was written")));
            }
        }
        digest.check(names).map_err(inconsistent)?;
        Ok(digest)
    }

    /// Whether the files can belong together: lines that were lost or changed mostly show in those that were not.
    ///
    /// # Errors
    /// What does not fit.
    pub fn check(&self, known: &Names<'_>) -> Result<(), String> {
        // Names become those of files, and stand in pages: none but ours.
        let named = self.asked.iter().map(|a| (ASKED, &a.task, &a.method));
        for (name, task, method) in named.chain(self.runs.iter().map(|run| (RUNS, &run.task, &run.method))) {
            if !known.has_task(task) {
                return Err(format!("{name} names an unknown task, `{task}`"));
            }
            if !known.has_method(method) {
                return Err(format!("{name} names an unknown method, `{method}`"));
            }
        }
        let mut keys = BTreeSet::new();
        for run in &self.runs {
            let key = (run.task.as_str(), run.method.as_str(), run.seed);
            if !keys.insert(key) {
                return Err(format!("{RUNS} has {} {} seed {} twice", key.0, key.1, key.2));
            }
            if run.mean_return.is_some_and(|value| !value.is_finite()) {
                return Err(format!("a return in {RUNS} is not a number: {} {} seed {}", key.0, key.1, key.2));
            }
        }
        let checks = self.checks.iter().map(|c| (CHECKS, (c.task.as_str(), c.method.as_str(), c.seed), c.mean_return));
        let models = self.models.iter().map(|m| (MODELS, (m.task.as_str(), m.method.as_str(), m.seed), 0.0));
        let times = self.times.iter().map(|t| (TIMES, (t.task.as_str(), t.method.as_str(), t.seed), t.wall_seconds));
        for (name, key, value) in checks.chain(models).chain(times) {
            if !keys.contains(&key) {
                return Err(format!("{name} has {} {} seed {}, {RUNS} has not", key.0, key.1, key.2));
            }
            if !value.is_finite() {
                return Err(format!("a value in {name} is not a number: {} {} seed {}", key.0, key.1, key.2));
            }
        }
        Ok(())
    }

    /// Writes a file of each kind into `directory`, which is made if it is not there.
    ///
    /// # Errors
    /// [`RecordError::Io`] if there is no room or no right to write.
    pub fn write(&self, directory: &Path) -> Result<(), RecordError> {
        fs::create_dir_all(directory).map_err(RecordError::io("make the directory", directory))?;
        let mut models = String::new();
        for found in &self.models {
            models += &(serde_json::to_string(found)? + "\n");
        }
        let files = [
            (SETTINGS, self.settings.clone().into_bytes()),
            (ASKED, to_csv(&self.asked)?),
            (RUNS, to_csv(&self.runs)?),
            (CHECKS, to_csv(&self.checks)?),
            (MODELS, models.into_bytes()),
        ];
        let sums: Vec<Sum> = files.iter().map(|(name, contents)| Sum::of(name, contents)).collect();
        for (name, contents) in files.into_iter().chain([(TIMES, to_csv(&self.times)?), (SUMS, to_csv(&sums)?)]) {
            save(&directory.join(name), &contents)?;
        }
        Ok(())
    }

    /// Names of the tasks there are runs of.
    #[must_use]
    pub fn tasks(&self) -> Vec<&str> {
        distinct(self.runs.iter().map(|run| run.task.as_str()))
    }

    /// Names of the methods there are runs of.
    #[must_use]
    pub fn methods(&self) -> Vec<&str> {
        distinct(self.runs.iter().map(|run| run.method.as_str()))
    }

    /// The runs of one method on one task.
    pub fn of<'a>(&'a self, task: &'a str, method: &'a str) -> impl Iterator<Item = &'a Run> + Clone {
        self.runs.iter().filter(move |run| run.task == task && run.method == method)
    }
}

/// The rows of the file `name`.
fn rows<T: DeserializeOwned>(directory: &Path, name: &str) -> Result<Vec<T>, RecordError> {
    let path = directory.join(name);
    let text = fs::read_to_string(&path).map_err(RecordError::io("read", &path))?;
    from_csv(&text).map_err(|e| RecordError::Malformed { path, source: e.into() })
}

/// The names, each once, in the order in which they come first.
fn distinct<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    names.fold(Vec::new(), |mut seen, name| {
        if !seen.contains(&name) {
            seen.push(name);
        }
        seen
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::comparison::Seeds;

    const NAMES: Names<'static> = Names { tasks: &["pendulum"], methods: &["sindy", "sac"] };

    #[test]
    fn what_is_written_is_read_again_with_every_digit() {
        let outcome = Outcome {
            returns: vec![0.1, 0.2, 0.30000000000000004],
            failure: Some("a \"quoted\", long\nstory".into()),
            model: Some(serde_json::json!({"version": 1, "dt": 0.05})),
            model_parameters: Some(2),
            ..Outcome::new("pendulum", "sindy", 3)
        };
        let asked = vec![Request { task: "pendulum".into(), method: "sac".into(), seeds: Seeds::first(3) }];
        let mut digest = Digest { settings: "version = \"0\"\n".into(), asked, ..Digest::default() };
        digest.add(&outcome, Some(1.25));
        digest.add(&Outcome::new("pendulum", "sac", 0), None);
        let temp = tempfile::tempdir().expect("a directory");
        assert!(!Digest::is_in(temp.path()));
        digest.write(temp.path()).expect("it can be written");
        assert!(Digest::is_in(temp.path()));
        assert_eq!(Digest::read(temp.path(), &NAMES).expect("it can be read"), digest);
        assert_eq!((digest.tasks(), digest.methods()), (vec!["pendulum"], vec!["sindy", "sac"]));
        for name in [SETTINGS, ASKED, MODELS] {
            let whole = fs::read_to_string(temp.path().join(name)).expect("it is there");
            fs::write(temp.path().join(name), "").expect("it can be written");
            let refusal = Digest::read(temp.path(), &NAMES).expect_err("a file was emptied").to_string();
            assert!(refusal.contains(&format!("{name} was changed after it was written")), "{refusal}");
            fs::write(temp.path().join(name), whole).expect("it can be written");
        }
        assert!(Digest::read(temp.path(), &NAMES).is_ok());
        let models = fs::read_to_string(temp.path().join(MODELS)).expect("it is there");
        fs::write(temp.path().join(MODELS), format!("{models}{{\n")).expect("it can be written");
        let refusal = Digest::read(temp.path(), &NAMES).expect_err("its second line is no JSON").to_string();
        assert!(refusal.contains("models.jsonl, line 2: ") && !refusal.contains("line 1"), "{refusal}");
    }

    #[test]
    fn files_that_do_not_belong_together_are_refused() {
        let outcome = |seed| Outcome { returns: vec![1.0; 2], ..Outcome::new("pendulum", "sac", seed) };
        let mut digest = Digest::default();
        digest.add(&outcome(0), Some(1.0));
        digest.add(&outcome(1), Some(1.0));
        assert_eq!(digest.check(&NAMES), Ok(()));
        let lost = Digest { runs: digest.runs[..1].to_vec(), ..digest.clone() };
        assert!(lost.check(&NAMES).unwrap_err().contains("timing.csv has pendulum sac seed 1"));
        let twice = Digest { runs: [&digest.runs[..], &digest.runs[1..]].concat(), ..digest.clone() };
        assert!(twice.check(&NAMES).unwrap_err().contains("seed 1 twice"));
        for (task, method, says) in [
            ("x/../../evil", "sac", "runs.csv names an unknown task, `x/../../evil`"),
            ("pendulum", "<script>", "runs.csv names an unknown method, `<script>`"),
        ] {
            let mut strange = Digest::default();
            strange.add(&Outcome::new(task, method, 0), None);
            assert!(strange.check(&NAMES).unwrap_err().contains(says));
        }
        let asked = vec![Request { task: "pendulum".into(), method: "\u{7}".into(), seeds: Seeds::first(1) }];
        assert!(
            Digest { asked, ..Digest::default() }
                .check(&NAMES)
                .unwrap_err()
                .contains("asked.csv names an unknown method")
        );
        digest.runs[0].mean_return = Some(f64::NAN);
        assert!(digest.check(&NAMES).unwrap_err().contains("is not a number"));
    }

    #[test]
    fn a_comparison_of_nothing_is_written_and_read_too() {
        let temp = tempfile::tempdir().expect("a directory");
        Digest::default().write(temp.path()).expect("it can be written");
        assert_eq!(Digest::read(temp.path(), &NAMES).expect("it can be read"), Digest::default());
    }
}
