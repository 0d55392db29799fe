//! A comparison in short: files small enough to be kept for ever, from which everything that is reported follows.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use anyhow::Context as _;
use serde::{Deserialize, Serialize};

use crate::compare::{Asked, Method, Outcome};
use crate::failure::Failure;
use crate::record::{from_csv, save, to_csv};
use crate::registry;

/// One run: a line of `runs.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Run {
    pub(crate) task: String,
    pub(crate) method: String,
    pub(crate) seed: u64,
    pub(crate) solved_after: Option<usize>,
    pub(crate) real_steps: usize,
    pub(crate) real_episodes: usize,
    pub(crate) updates: u64,
    pub(crate) model_steps: u64,
    pub(crate) parameters: Option<usize>,
    /// Over the start states of the last evaluation.
    pub(crate) mean_return: Option<f64>,
    pub(crate) failure: Option<String>,
}

/// One look at a policy on the way: a line of `curves.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Check {
    pub(crate) task: String,
    pub(crate) method: String,
    pub(crate) seed: u64,
    pub(crate) real_steps: usize,
    pub(crate) updates: u64,
    pub(crate) mean_return: f64,
}

/// The equations of one run: a line of `models.jsonl`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Found {
    pub(crate) task: String,
    pub(crate) method: String,
    pub(crate) seed: u64,
    pub(crate) model: serde_json::Value,
}

/// How long one run took: a line of `timing.csv`, apart from the rest because no two are the same.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Taken {
    pub(crate) task: String,
    pub(crate) method: String,
    pub(crate) seed: u64,
    pub(crate) wall_seconds: f64,
}

/// All of it.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Digest {
    /// What the runs depend on besides task, method and seed.
    pub(crate) settings: String,
    /// What was asked for, which may be more than was done.
    pub(crate) asked: Vec<Asked>,
    pub(crate) runs: Vec<Run>,
    pub(crate) checks: Vec<Check>,
    pub(crate) models: Vec<Found>,
    pub(crate) times: Vec<Taken>,
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
    pub(crate) fn add(&mut self, outcome: &Outcome, wall_seconds: Option<f64>) {
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
        self.checks.extend(outcome.curve.iter().map(|point| Check {
            task: task(),
            method: method(),
            seed,
            real_steps: point.real_steps,
            updates: point.updates,
            mean_return: crate::compare::mean(&point.returns),
        }));
        self.models.extend(outcome.model.iter().map(|model| Found {
            task: task(),
            method: method(),
            seed,
            model: model.clone(),
        }));
        self.times.extend(wall_seconds.map(|wall_seconds| Taken {
            task: task(),
            method: method(),
            seed,
            wall_seconds,
        }));
    }

    /// Whether `directory` holds one.
    pub(crate) fn is_in(directory: &Path) -> bool {
        directory.join(RUNS).is_file()
    }

    /// Reads what [`Self::write`] wrote.
    pub(crate) fn read(directory: &Path) -> Result<Self, Failure> {
        let text = |name: &str| {
            let path = directory.join(name);
            fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))
        };
        let models = text(MODELS)?;
        // A line of JSON counts its own lines: the number that helps is that in the file.
        let model = |(number, line): (usize, &str)| {
            serde_json::from_str(line).map_err(|e| {
                let (why, path) = (e.to_string(), directory.join(MODELS));
                let why = why.split(" at line ").next().unwrap_or_default();
                Failure::new(format!("cannot understand {}, line {}: {why}", path.display(), number + 1))
            })
        };
        let models = models.lines().enumerate().map(model).collect::<Result<_, _>>()?;
        let unread = |name: &str| format!("cannot understand {}", directory.join(name).display());
        let digest = Self {
            settings: text(SETTINGS)?,
            asked: from_csv(&text(ASKED)?).with_context(|| unread(ASKED))?,
            runs: from_csv(&text(RUNS)?).with_context(|| unread(RUNS))?,
            checks: from_csv(&text(CHECKS)?).with_context(|| unread(CHECKS))?,
            models,
            times: from_csv(&text(TIMES)?).with_context(|| unread(TIMES))?,
        };
        let damage = || {
            let sums: Vec<Sum> = from_csv(&text(SUMS)?).with_context(|| unread(SUMS))?;
            for name in [SETTINGS, ASKED, RUNS, CHECKS, MODELS] {
                if !sums.contains(&Sum::of(name, text(name)?.as_bytes())) {
                    return Ok::<_, Failure>(Err(format!("{name} was changed since")));
                }
            }
            Ok(Ok(()))
        };
        damage()?.and_then(|()| digest.check()).map_err(|what| {
            Failure::new(format!("{} is not what a comparison wrote: {what}", directory.display()))
                .hint("`sindyna report` makes it again from the directory of the comparison")
        })?;
        Ok(digest)
    }

    /// Whether the files can belong together: lines that were lost or changed mostly show in those that were not.
    pub(super) fn check(&self) -> Result<(), String> {
        // Names become those of files, and stand in pages: none but ours.
        let named = self.asked.iter().map(|a| (ASKED, &a.task, &a.method));
        for (name, task, method) in named.chain(self.runs.iter().map(|run| (RUNS, &run.task, &run.method))) {
            if registry::system(task).is_err() {
                return Err(format!("{name} names the task `{task}`, which there is not"));
            }
            if Method::named(method).is_err() {
                return Err(format!("{name} names the method `{method}`, which there is not"));
            }
        }
        let mut known = BTreeSet::new();
        for run in &self.runs {
            let key = (run.task.as_str(), run.method.as_str(), run.seed);
            if !known.insert(key) {
                return Err(format!("{RUNS} has {} {} seed {} twice", key.0, key.1, key.2));
            }
            if run.mean_return.is_some_and(|value| !value.is_finite()) {
                return Err(format!("a return in {RUNS} is no number: {} {} seed {}", key.0, key.1, key.2));
            }
        }
        let checks = self.checks.iter().map(|c| (CHECKS, (c.task.as_str(), c.method.as_str(), c.seed), c.mean_return));
        let models = self.models.iter().map(|m| (MODELS, (m.task.as_str(), m.method.as_str(), m.seed), 0.0));
        let times = self.times.iter().map(|t| (TIMES, (t.task.as_str(), t.method.as_str(), t.seed), t.wall_seconds));
        for (name, key, value) in checks.chain(models).chain(times) {
            if !known.contains(&key) {
                return Err(format!("{name} has {} {} seed {}, {RUNS} has not", key.0, key.1, key.2));
            }
            if !value.is_finite() {
                return Err(format!("a value in {name} is no number: {} {} seed {}", key.0, key.1, key.2));
            }
        }
        Ok(())
    }

    /// Writes a file of each kind into `directory`, which is made if it is not there.
    pub(crate) fn write(&self, directory: &Path) -> Result<(), Failure> {
        fs::create_dir_all(directory).with_context(|| format!("cannot make the directory {}", directory.display()))?;
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
    pub(crate) fn tasks(&self) -> Vec<&str> {
        distinct(self.runs.iter().map(|run| run.task.as_str()))
    }

    /// Names of the methods there are runs of.
    pub(crate) fn methods(&self) -> Vec<&str> {
        distinct(self.runs.iter().map(|run| run.method.as_str()))
    }

    /// The runs of one method on one task.
    pub(crate) fn of<'a>(&'a self, task: &'a str, method: &'a str) -> impl Iterator<Item = &'a Run> + Clone {
        self.runs.iter().filter(move |run| run.task == task && run.method == method)
    }
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

    #[test]
    fn what_is_written_is_read_again_with_every_digit() {
        let outcome = Outcome {
            returns: vec![0.1, 0.2, 0.30000000000000004],
            failure: Some("a \"quoted\", long\nstory".into()),
            model: Some(serde_json::json!({"version": 1, "dt": 0.05})),
            model_parameters: Some(2),
            ..Outcome::new("pendulum", "sindy", 3)
        };
        let asked = vec![Asked { task: "pendulum".into(), method: "sac".into(), seeds: 3 }];
        let mut digest = Digest { settings: "version = \"0\"\n".into(), asked, ..Digest::default() };
        digest.add(&outcome, Some(1.25));
        digest.add(&Outcome::new("pendulum", "sac", 0), None);
        let temp = tempfile::tempdir().expect("a directory");
        assert!(!Digest::is_in(temp.path()));
        digest.write(temp.path()).expect("it can be written");
        assert!(Digest::is_in(temp.path()));
        assert_eq!(Digest::read(temp.path()).expect("it can be read"), digest);
        assert_eq!((digest.tasks(), digest.methods()), (vec!["pendulum"], vec!["sindy", "sac"]));
        for name in [SETTINGS, ASKED, MODELS] {
            let whole = fs::read_to_string(temp.path().join(name)).expect("it is there");
            fs::write(temp.path().join(name), "").expect("it can be written");
            let refusal = Digest::read(temp.path()).expect_err("a file was emptied").to_string();
            assert!(refusal.contains(&format!("{name} was changed since")), "{refusal}");
            fs::write(temp.path().join(name), whole).expect("it can be written");
        }
        assert!(Digest::read(temp.path()).is_ok());
        let models = fs::read_to_string(temp.path().join(MODELS)).expect("it is there");
        fs::write(temp.path().join(MODELS), format!("{models}{{\n")).expect("it can be written");
        let refusal = Digest::read(temp.path()).expect_err("its second line is no JSON").to_string();
        assert!(refusal.contains("models.jsonl, line 2: ") && !refusal.contains("line 1"), "{refusal}");
    }

    #[test]
    fn files_that_do_not_belong_together_are_refused() {
        let outcome = |seed| Outcome { returns: vec![1.0; 2], ..Outcome::new("pendulum", "sac", seed) };
        let mut digest = Digest::default();
        digest.add(&outcome(0), Some(1.0));
        digest.add(&outcome(1), Some(1.0));
        assert_eq!(digest.check(), Ok(()));
        let lost = Digest { runs: digest.runs[..1].to_vec(), ..digest.clone() };
        assert!(lost.check().unwrap_err().contains("timing.csv has pendulum sac seed 1"));
        let twice = Digest { runs: [&digest.runs[..], &digest.runs[1..]].concat(), ..digest.clone() };
        assert!(twice.check().unwrap_err().contains("seed 1 twice"));
        for (task, method, says) in [
            ("x/../../evil", "sac", "runs.csv names the task `x/../../evil`"),
            ("pendulum", "<script>", "runs.csv names the method `<script>`"),
        ] {
            let mut strange = Digest::default();
            strange.add(&Outcome::new(task, method, 0), None);
            assert!(strange.check().unwrap_err().contains(says));
        }
        let asked = vec![Asked { task: "pendulum".into(), method: "\u{7}".into(), seeds: 1 }];
        assert!(Digest { asked, ..Digest::default() }.check().unwrap_err().contains("asked.csv names the method"));
        digest.runs[0].mean_return = Some(f64::NAN);
        assert!(digest.check().unwrap_err().contains("no number"));
    }

    #[test]
    fn a_comparison_of_nothing_is_written_and_read_too() {
        let temp = tempfile::tempdir().expect("a directory");
        Digest::default().write(temp.path()).expect("it can be written");
        assert_eq!(Digest::read(temp.path()).expect("it can be read"), Digest::default());
    }
}
