//! How long the rest of a comparison will take.

use std::collections::BTreeMap;

use super::{Job, Method};

/// Runs that are to come, and how long those took that are over.
pub(crate) struct Pace {
    threads: usize,
    left: BTreeMap<(String, &'static str), usize>,
    /// Seconds of all runs of a method on a task, and how many.
    taken: BTreeMap<(String, &'static str), (f64, usize)>,
}

impl Pace {
    /// For `jobs` that `threads` work on.
    pub(crate) fn new<'a>(jobs: impl Iterator<Item = &'a Job>, threads: usize) -> Self {
        let mut left = BTreeMap::new();
        for job in jobs {
            *left.entry(key(job)).or_insert(0) += 1;
        }
        Self { threads: threads.max(1), left, taken: BTreeMap::new() }
    }

    /// Remembers that such a run took so long.
    pub(crate) fn know(&mut self, job: &Job, seconds: f64) {
        let (sum, count) = self.taken.entry(key(job)).or_insert((0.0, 0));
        (*sum, *count) = (*sum + seconds, *count + 1);
    }

    /// The same of a run that was still to come.
    pub(crate) fn done(&mut self, job: &Job, seconds: f64) {
        self.know(job, seconds);
        if let Some(left) = self.left.get_mut(&key(job)) {
            *left = left.saturating_sub(1);
        }
    }

    /// Seconds until the last run is over, as far as can be told: a run takes as long as others of its method on its task, or
    /// else of its method, or else any. `None` before the first.
    pub(crate) fn seconds_left(&self) -> Option<f64> {
        let mean = |of: &dyn Fn(&str, &'static str) -> bool| {
            let found = self.taken.iter().filter(|((task, method), _)| of(task, method)).map(|(_, taken)| *taken);
            let (sum, count) = found.fold((0.0, 0), |(sum, count), (s, c)| (sum + s, count + c));
            (count > 0).then(|| sum / count as f64)
        };
        let of_one = |task: &str, method: &'static str| {
            mean(&|t, m| t == task && m == method).or_else(|| mean(&|_, m| m == method)).or_else(|| mean(&|_, _| true))
        };
        let each = self.left.iter().map(|((task, method), count)| Some(*count as f64 * of_one(task, method)?));
        Some(each.sum::<Option<f64>>()? / self.threads as f64)
    }
}

fn key(job: &Job) -> (String, &'static str) {
    (job.system.name().to_owned(), Method::name(job.method))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem;

    fn job(task: &str, method: Method, seed: u64) -> Job {
        Job { system: problem::system(task).unwrap(), method, seed, budget: None, whole_budget: false }
    }

    #[test]
    fn runs_take_as_long_as_those_most_like_them() {
        let jobs = [
            job("pendulum", Method::Sindy, 0),
            job("pendulum", Method::Sindy, 1),
            job("pendulum", Method::Sac, 0),
            job("cart-pole", Method::Sac, 0),
        ];
        let mut pace = Pace::new(jobs.iter(), 2);
        assert_eq!(pace.seconds_left(), None);
        pace.done(&jobs[0], 1.0);
        assert_eq!(pace.seconds_left(), Some(1.5), "three more, of which nothing else is known");
        pace.done(&jobs[2], 20.0);
        assert_eq!(pace.seconds_left(), Some(10.5), "the one of sac is like the other");
        pace.done(&jobs[1], 1.0);
        pace.done(&jobs[3], 20.0);
        assert_eq!(pace.seconds_left(), Some(0.0));
    }
}
