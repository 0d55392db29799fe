//! Where a run is, written now and then, so that it can go on after it was killed.

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use sindyna_core::{decode, encode};
use sindyna_record::run::{EventLog, RunDir};

use super::recorder::Clock;
use crate::cli::progress::Progress;

/// The file in the run directory; it is taken away when the run is over.
const FILE: &str = "checkpoint.bin";

/// Part of a run's time that goes into its checkpoints.
const SHARE: f64 = 0.04;

/// Time between two checkpoints, at least. Runs that are shorter have none.
const LEAST: Duration = Duration::from_secs(1);

/// What is in the file besides its checksum.
#[derive(Serialize, Deserialize)]
struct Contents {
    /// The build and the instructions that wrote it: others compute other numbers.
    made_by: (String, String),
    /// The configuration of the run.
    config: String,
    events: String,
    /// Seconds of the run so far, and those of them that went into identification.
    seconds: (f64, f64),
    run: Vec<u8>,
}

/// Where a run was when it was killed.
pub(super) struct Saved {
    pub(super) log: EventLog,
    pub(super) clock: Clock,
    /// What the loop is restored from.
    pub(super) run: Vec<u8>,
}

/// Writes checkpoints of one run.
pub(super) struct Checkpoints<'a> {
    run_dir: &'a RunDir,
    progress: &'a Progress,
    isa: &'static str,
    config: String,
    written: Instant,
    /// Time that the last one took.
    cost: Duration,
}

impl<'a> Checkpoints<'a> {
    /// For the run in `run_dir` with the instructions `isa`, that begins now.
    pub(super) fn new(run_dir: &'a RunDir, progress: &'a Progress, isa: &'static str) -> Self {
        let config = run_dir.read("config.toml").unwrap_or_default();
        Self { run_dir, progress, isa, config, written: Instant::now(), cost: Duration::ZERO }
    }

    /// Where the run was when it was killed, if that is known. What cannot be gone on from is told, and left.
    pub(super) fn read(&self) -> Option<Saved> {
        let bytes = std::fs::read(self.run_dir.path().join(FILE)).ok()?;
        let contents = bytes.split_at_checked(4).filter(|(sum, rest)| *sum == crc32fast::hash(rest).to_le_bytes());
        let Some(Ok(contents)) = contents.map(|(_, rest)| decode::<Contents>(rest)) else {
            self.progress.say(&format!("note: {FILE} is damaged, so the run restarts"));
            return None;
        };
        if contents.made_by != self.made_by() {
            let (commit, isa) = contents.made_by;
            self.progress.say(&format!("note: {FILE} is of another build ({commit}, {isa}), so the run restarts"));
            return None;
        }
        if contents.config != self.config {
            self.progress.say(&format!("note: config.toml was changed since {FILE} was written, so the run restarts"));
            return None;
        }
        let (elapsed, identified) = contents.seconds;
        let clock = Clock { before: elapsed, collected: elapsed, identified };
        Some(Saved { log: EventLog::of(contents.events), clock, run: contents.run })
    }

    fn made_by(&self) -> (String, String) {
        (sindyna_training::COMMIT.to_owned(), self.isa.to_owned())
    }

    /// Writes what `state` gives, if it is time.
    pub(super) fn offer(
        &mut self,
        log: &EventLog,
        clock: &Clock,
        elapsed: f64,
        state: impl FnOnce() -> Option<Vec<u8>>,
    ) {
        if self.written.elapsed() < LEAST.max(self.cost.div_f64(SHARE)) {
            return;
        }
        let begun = Instant::now();
        if let Some(run) = state() {
            let events = String::from_utf8_lossy(log.as_bytes()).into_owned();
            let seconds = (elapsed, clock.identified);
            let contents =
                encode(&Contents { made_by: self.made_by(), config: self.config.clone(), events, seconds, run });
            let file = [&crc32fast::hash(&contents).to_le_bytes()[..], &contents].concat();
            // A run that cannot be gone on with is better than none.
            if let Err(error) = self.run_dir.write(FILE, &file) {
                self.progress.say(&format!(
                    "note: {}; the run continues without a new checkpoint",
                    std::error::Error::source(&error)
                        .map_or_else(|| error.to_string(), |cause| format!("{error}: {cause}"))
                ));
            }
        }
        self.written = Instant::now();
        self.cost = begun.elapsed();
    }
}

/// Takes the checkpoint of a run away that is over.
pub(super) fn remove(run_dir: &RunDir) {
    // Whoever leaves it behind loses nothing.
    drop(std::fs::remove_file(run_dir.path().join(FILE)));
}
