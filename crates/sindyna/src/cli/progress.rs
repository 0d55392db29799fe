//! How a command is going, on stderr: a bar or a line on a terminal, plain lines elsewhere.

use std::cell::Cell;
use std::io::{IsTerminal as _, Write as _};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use sindyna_core::Event;
use sindyna_core::number::{fixed, plural};
use sindyna_sindy::Stage;

use super::console::Console;
use crate::cli::plain::message;

/// Tells the user how far a command is.
pub(crate) struct Progress {
    sink: Sink,
    console: Console,
}

enum Sink {
    Nowhere,
    Lines,
    /// A terminal; nothing is shown before something is known.
    Bar(ProgressBar),
}

/// What a bar counts.
const TRAINING: &str = "training {bar:30} {pos}/{len} updates at most, {msg}";
const RUNS: &str = "{bar:30} {pos}/{len} runs, {msg}";
const SEARCH: &str = "{msg}";

/// Time between two lines, and between two changes of a bar.
const EVERY: (Duration, Duration) = (Duration::from_secs(2), Duration::from_millis(100));

impl Progress {
    pub(crate) fn new(console: Console) -> Self {
        let sink = match console.quiet {
            true => Sink::Nowhere,
            false if std::io::stderr().is_terminal() => Sink::Bar(ProgressBar::hidden()),
            false => Sink::Lines,
        };
        Self { sink, console }
    }

    /// A line above whatever else is shown.
    pub(crate) fn say(&self, line: &str) {
        let line = message(line);
        match &self.sink {
            Sink::Nowhere => {}
            // Progress that nobody can read any more is no reason to stop.
            Sink::Lines => drop(writeln!(self.console.stderr(), "{line}")),
            Sink::Bar(bar) if bar.is_hidden() => drop(writeln!(self.console.stderr(), "{line}")),
            Sink::Bar(bar) => bar.println(&line),
        }
    }

    /// The same for those who want to know more.
    pub(crate) fn detail(&self, line: impl FnOnce() -> String) {
        if self.console.verbose {
            self.say(&line());
        }
    }

    pub(crate) fn show(&self, event: &Event<'_>) {
        match event {
            Event::Updated { updates, max_updates, .. } => {
                if let Some(bar) = self.bar(TRAINING) {
                    bar.set_length(*max_updates);
                    bar.set_position(*updates);
                }
            }
            Event::Imagined { updates, mean_return, best_return } => {
                let returns =
                    format!("return in the model {}, best {}", fixed(*mean_return, 1), fixed(*best_return, 1));
                match self.bar(TRAINING) {
                    Some(bar) => bar.set_message(returns),
                    // Planners are not trained.
                    None if *updates == 0 => self.say(&format!("planning: {returns}")),
                    None => self.say(&format!("training: {updates} updates, {returns}")),
                }
            }
            Event::Confirmed { real, predicted } => self.say(&format!(
                "confirmation episode: return {}, predicted {}",
                fixed(*real, 1),
                fixed(*predicted, 1)
            )),
            Event::Collected { data } => self.say(&format!(
                "collected: {} real steps in {}",
                data.n_steps(),
                plural(data.n_rollouts(), "episode")
            )),
            Event::Fitted { rows, description } => {
                self.detail(|| format!("fitted to {rows} steps:\n  {}", description.join("\n  ")))
            }
            Event::NotFitted { rows, reason } => {
                self.say(&format!("no model fits all {rows} real steps ({reason}); the previous one is kept"));
            }
            _ => {}
        }
    }

    /// So many of `total` runs are done; `left` tells how long the others take, `running` which are at work.
    pub(crate) fn runs(&self, done: usize, total: usize, left: &str, running: &[String]) {
        if let Some(bar) = self.bar(RUNS) {
            bar.set_length(total as u64);
            bar.set_position(done as u64);
            let at_work = if running.is_empty() { String::new() } else { format!("; running: {}", running.join(", ")) };
            bar.set_message(message(&format!("{left}{at_work}")));
        }
    }

    pub(crate) fn finish(&self) {
        if let Sink::Bar(bar) = &self.sink {
            bar.finish_and_clear();
        }
    }

    /// The bar, where there is one, in the style `template`; a hidden one comes to light.
    fn bar(&self, template: &str) -> Option<&ProgressBar> {
        let Sink::Bar(bar) = &self.sink else { return None };
        let again = bar.is_finished();
        if bar.is_hidden() || again {
            bar.set_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()));
            if again {
                bar.reset();
            }
            bar.set_draw_target(indicatif::ProgressDrawTarget::stderr());
        }
        Some(bar)
    }
}

/// How the search for equations is going: a line every other second, or what a bar shows.
pub(crate) struct Looking<'a> {
    progress: &'a Progress,
    begun: Instant,
    told: Cell<Instant>,
}

impl<'a> Looking<'a> {
    pub(crate) fn new(progress: &'a Progress) -> Self {
        let now = Instant::now();
        Self { progress, begun: now, told: Cell::new(now) }
    }

    pub(crate) fn tell(&self, stage: Stage) {
        let (now, bar) = (Instant::now(), matches!(self.progress.sink, Sink::Bar(_)));
        if now - self.told.get() < if bar { EVERY.1 } else { EVERY.0 } {
            return;
        }
        self.told.set(now);
        let line = searched(stage, (now - self.begun).as_secs());
        match self.progress.bar(SEARCH) {
            Some(bar) => bar.set_message(line),
            None => self.progress.say(&line),
        }
    }
}

/// How episodes are going, those of an evaluation or others: a line every other second, or what a bar shows.
pub(crate) struct Evaluating<'a> {
    progress: &'a Progress,
    what: &'static str,
    told: Mutex<Instant>,
}

impl<'a> Evaluating<'a> {
    pub(crate) fn new(progress: &'a Progress, what: &'static str) -> Self {
        Self { progress, what, told: Mutex::new(Instant::now()) }
    }

    /// Episode `number` of so many begins.
    pub(crate) fn begun(&self, number: usize, episodes: usize) {
        let (now, mut told) = (Instant::now(), self.told.lock().unwrap_or_else(PoisonError::into_inner));
        let bar = matches!(self.progress.sink, Sink::Bar(_));
        if now - *told < if bar { EVERY.1 } else { EVERY.0 } {
            return;
        }
        *told = now;
        let line = format!("{}: episode {number} of {episodes}", self.what);
        match self.progress.bar(SEARCH) {
            Some(bar) => bar.set_message(line),
            None => self.progress.say(&line),
        }
    }
}

fn searched(stage: Stage, seconds: u64) -> String {
    match stage {
        Stage::Search { spent } => {
            format!("searching for equations: {seconds} s, {:.0} % of this search", 100.0 * spent)
        }
        Stage::Rounding => format!("searching for equations at the level of rounding: {seconds} s"),
        _ => format!("searching for equations: {seconds} s"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_search_tells_how_much_of_what_is_allowed_it_has_spent() {
        assert_eq!(searched(Stage::Search { spent: 0.254 }, 12), "searching for equations: 12 s, 25 % of this search");
        assert_eq!(searched(Stage::Rounding, 0), "searching for equations at the level of rounding: 0 s");
    }
}
