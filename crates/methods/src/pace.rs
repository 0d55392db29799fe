//! How long the rest of a comparison will take.

use std::collections::BTreeMap;
use std::fmt;
use std::time::Duration;

use sindyna_core::number::plural;

use super::Job;

/// Runs that are to come, and how long those took that are over.
pub struct Pace {
    threads: usize,
    /// Runs at work count as to come.
    left: BTreeMap<Kind, usize>,
    /// Seconds of all runs of a kind, and how many.
    taken: BTreeMap<Kind, (f64, usize)>,
}

/// Task and method: runs of one kind take about as long as each other, and nobody knows how long those of another take.
type Kind = (String, String);

/// How long the rest will take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Left {
    /// Of the runs whose kind has been timed.
    seconds: f64,
    /// Runs whose kind has not.
    unknown: usize,
}

impl Pace {
    /// For `jobs` that `threads` work on.
    pub fn new<'a>(jobs: impl Iterator<Item = &'a Job>, threads: usize) -> Self {
        let mut left = BTreeMap::new();
        for job in jobs {
            *left.entry(kind(job)).or_insert(0) += 1;
        }
        Self { threads: threads.max(1), left, taken: BTreeMap::new() }
    }

    /// Remembers that such a run took so long.
    pub fn know(&mut self, job: &Job, seconds: f64) {
        let (sum, count) = self.taken.entry(kind(job)).or_insert((0.0, 0));
        (*sum, *count) = (*sum + seconds, *count + 1);
    }

    /// The same of a run that was still to come.
    pub fn done(&mut self, job: &Job, seconds: f64) {
        self.know(job, seconds);
        if let Some(left) = self.left.get_mut(&kind(job)) {
            *left = left.saturating_sub(1);
        }
    }

    /// How long it is until the last run is over, as far as can be told: the work shared by the threads, but no shorter than
    /// the longest run.
    pub fn left(&self) -> Left {
        let (mut work, mut longest, mut unknown) = (0.0, 0.0_f64, 0);
        for (kind, count) in self.left.iter().filter(|(_, count)| **count > 0) {
            match self.taken.get(kind) {
                Some((sum, timed)) => {
                    let each = sum / *timed as f64;
                    work += *count as f64 * each;
                    longest = longest.max(each);
                }
                None => unknown += count,
            }
        }
        Left { seconds: longest.max(work / self.threads as f64), unknown }
    }
}

impl fmt::Display for Left {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let time = shown(Duration::from_secs_f64(self.seconds.clamp(0.0, 1e9)));
        match self.unknown {
            0 => write!(f, "{time} left"),
            unknown if self.seconds == 0.0 => {
                write!(f, "time left unknown: {} of methods not timed yet", plural(unknown, "run"))
            }
            unknown => write!(f, "at least {time} left: {} of methods not timed yet", plural(unknown, "run")),
        }
    }
}

fn shown(time: Duration) -> String {
    let seconds = time.as_secs_f64();
    match seconds {
        _ if seconds < 90.0 => format!("{seconds:.0} s"),
        _ if seconds < 5_400.0 => format!("{:.0} min", seconds / 60.0),
        _ => format!("{:.1} h", seconds / 3_600.0),
    }
}

fn kind(job: &Job) -> Kind {
    (job.task(), job.contender.name())
}

#[cfg(test)]
mod tests {
    use sindyna_training::problem;

    use super::*;
    use crate::Method;

    fn job(task: &str, method: Method, seed: u64) -> Job {
        let system = problem::named(task).unwrap();
        Job { system, noise: 0.0, contender: method.into(), seed, budget: None, whole_budget: false }
    }

    #[test]
    fn only_what_was_timed_is_told() {
        let jobs = [
            job("pendulum", Method::Sindy, 0),
            job("pendulum", Method::Sindy, 1),
            job("pendulum", Method::Sac, 0),
            job("cart-pole", Method::Sac, 0),
            job("pendulum", Method::Sac, 1),
        ];
        let mut pace = Pace::new(jobs.iter(), 2);
        assert_eq!(pace.left().to_string(), "time left unknown: 5 runs of methods not timed yet");
        pace.done(&jobs[0], 1.0);
        assert_eq!(pace.left(), Left { seconds: 1.0, unknown: 3 });
        assert_eq!(pace.left().to_string(), "at least 1 s left: 3 runs of methods not timed yet");
        pace.done(&jobs[2], 200.0);
        assert_eq!(pace.left(), Left { seconds: 200.0, unknown: 1 }, "no shorter than the longest run");
        pace.done(&jobs[3], 20.0);
        assert_eq!(pace.left().to_string(), "3 min left");
        pace.done(&jobs[1], 1.0);
        pace.done(&jobs[4], 200.0);
        assert_eq!(pace.left().to_string(), "0 s left");
    }
}
