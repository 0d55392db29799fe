//! Who watches a run: writes down, shows, times.

use std::io;
use std::time::Instant;

use sindyna_core::{Event, Observer, Spec};
use sindyna_record::run::{EventLog, RunDir, rollout_csv};

use crate::cli::progress::Progress;

/// Seconds since the start, and what they went into.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Clock {
    /// Seconds that the run had taken when it was killed.
    pub(super) before: f64,
    /// When real data came in last.
    pub(super) collected: f64,
    /// Seconds spent on identification, over all fits.
    pub(super) identified: f64,
}

/// Watches a run: writes down, shows, times.
pub(super) struct Recorder<'a> {
    pub(super) spec: &'a Spec,
    pub(super) run_dir: &'a RunDir,
    pub(super) progress: &'a Progress,
    /// Real data that were there when the run began: of the same run, cut off.
    pub(super) kept: String,
    pub(super) log: EventLog,
    pub(super) clock: Clock,
    pub(super) start: Instant,
}

impl Recorder<'_> {
    /// Seconds that the run has taken, those before it was killed among them.
    pub(super) fn elapsed(&self) -> f64 {
        self.clock.before + self.start.elapsed().as_secs_f64()
    }

    /// Where the data that were kept and `text` begin to differ.
    fn otherwise(&self, text: &str) -> String {
        let mut lines = self.kept.lines().zip(text.lines()).enumerate();
        let (number, (before, now)) = lines.find(|(_, (before, now))| before != now).unwrap_or_default();
        let path = self.run_dir.path().join("rollout.csv");
        format!(
            "the system responds differently than before: {}, line {} has `{before}`, the system now gives `{now}`; the file is kept",
            path.display(),
            number + 1
        )
    }
}

impl Observer for Recorder<'_> {
    fn on(&mut self, event: &Event<'_>) -> io::Result<()> {
        self.log.note(event);
        self.progress.show(event);
        let now = self.elapsed();
        match event {
            Event::Collected { data } => {
                // Real data are what cannot be had again: on the disk before anything else happens.
                let text = rollout_csv(self.spec, data);
                if !text.starts_with(&self.kept) && !self.kept.starts_with(&text) {
                    return Err(io::Error::other(self.otherwise(&text)));
                }
                if text.len() > self.kept.len() {
                    self.run_dir.write("rollout.csv", text.as_bytes()).map_err(io::Error::other)?;
                }
                self.clock.collected = now;
            }
            Event::Fitted { .. } | Event::NotFitted { .. } => self.clock.identified += now - self.clock.collected,
            _ => {}
        }
        Ok(())
    }
}
