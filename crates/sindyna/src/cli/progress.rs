//! How a run is going, on stderr: a bar on a terminal, plain lines elsewhere.

use std::cell::Cell;
use std::io::{IsTerminal as _, Write as _};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use sindyna_core::Event;
use sindyna_core::number::plural;
use sindyna_sindy::Stage;

use crate::cli::plain::message;

/// Tells the user how far a run is.
pub(crate) enum Progress {
    Quiet,
    Lines,
    Bar(ProgressBar),
}

impl Progress {
    pub(crate) fn new(quiet: bool) -> Self {
        if quiet {
            Self::Quiet
        } else if std::io::stderr().is_terminal() {
            let style = ProgressStyle::with_template("training {bar:30} {pos}/{len} updates at most, {msg}");
            let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
            Self::Bar(ProgressBar::new(0).with_style(style))
        } else {
            Self::Lines
        }
    }

    /// A line above whatever else is shown.
    pub(crate) fn say(&self, line: &str) {
        let line = message(line);
        match self {
            Self::Quiet => {}
            // Progress that nobody can read any more is no reason to stop.
            Self::Lines => drop(writeln!(std::io::stderr(), "{line}")),
            Self::Bar(bar) => bar.println(&line),
        }
    }

    pub(crate) fn show(&self, event: &Event<'_>) {
        match (self, event) {
            (Self::Bar(bar), Event::Updated { updates, max_updates, .. }) => {
                bar.set_length(*max_updates);
                bar.set_position(*updates);
            }
            (Self::Bar(bar), Event::Imagined { mean_return, best_return, .. }) => {
                bar.set_message(format!("return in the model {mean_return:.1}, best {best_return:.1}"));
            }
            (_, Event::Imagined { updates, mean_return, best_return }) => self.say(&format!(
                "training: {updates} updates, return in the model {mean_return:.1}, best {best_return:.1}"
            )),
            (_, Event::Confirmed { real, promised }) => {
                self.say(&format!("real episode of the policy: return {real:.1}, {promised:.1} expected by the model"))
            }
            (_, Event::Collected { data }) => self.say(&format!(
                "collected: {} real steps in {}",
                data.n_steps(),
                plural(data.n_rollouts(), "episode")
            )),
            _ => {}
        }
    }

    pub(crate) fn finish(&self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}

/// How the search for equations is going: a line every other second, or what a bar shows.
pub(crate) struct Looking<'a> {
    progress: &'a Progress,
    begun: Instant,
    told: Cell<Instant>,
}

/// Time between two lines, and between two changes of a bar.
const EVERY: (Duration, Duration) = (Duration::from_secs(2), Duration::from_millis(100));

impl<'a> Looking<'a> {
    pub(crate) fn new(progress: &'a Progress) -> Self {
        let now = Instant::now();
        Self { progress, begun: now, told: Cell::new(now) }
    }

    pub(crate) fn tell(&self, stage: Stage) {
        let (now, bar) = (Instant::now(), matches!(self.progress, Progress::Bar(_)));
        if now - self.told.get() < if bar { EVERY.1 } else { EVERY.0 } {
            return;
        }
        self.told.set(now);
        let seconds = (now - self.begun).as_secs();
        let line = match stage {
            Stage::Search { spent } => {
                format!("looking for equations: {seconds} s, {:.0} % of the operations allowed", 100.0 * spent)
            }
            _ => format!("looking for equations: {seconds} s"),
        };
        match self.progress {
            Progress::Bar(bar) => {
                bar.set_style(ProgressStyle::with_template("{msg}").unwrap_or_else(|_| ProgressStyle::default_bar()));
                bar.set_message(line);
            }
            progress => progress.say(&line),
        }
    }
}
