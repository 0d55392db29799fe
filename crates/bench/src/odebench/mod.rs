//! ODEBench: 63 equations with two trajectories each, one to identify from and one to predict.
//!
//! # References
//! d'Ascoli, Becker, Mathis, Schwaller, Kilbertus (2024), *ODEFormer*, ICLR, arXiv:2310.05573, §4 and appendix A.

mod integrate;
mod score;

use anyhow::Context as _;
use ndarray::{Array2, Axis};
use rand::Rng as _;
use rand_distr::{Distribution as _, StandardNormal};
use serde::Deserialize;
use sindyna_core::Rng;

pub use integrate::integrate;
pub use score::{compared, r_squared, simulate};

use crate::equations::{Equations, Term};
use crate::log::{Log, Role, Trajectory};

/// The benchmark as it was published.
const DATA: &str = include_str!("../../data/odebench.json");

#[derive(Deserialize)]
struct Entry {
    id: u32,
    eq_description: String,
    substituted: Vec<Vec<String>>,
    init: Vec<Vec<f64>>,
    t_end: f64,
    n: usize,
}

/// One of the equations.
pub struct Problem {
    /// Its number.
    pub id: u32,
    /// What it describes.
    pub description: String,
    /// The true right-hand sides.
    pub equations: Equations,
    /// The two start states.
    pub starts: Vec<Vec<f64>>,
    /// Times of the samples \[s\].
    pub times: Vec<f64>,
}

/// How data are spoilt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spoilt {
    /// x becomes x (1 + noise ε) with Gaussian ε.
    pub noise: f64,
    /// Share of the samples that are dropped at random.
    pub dropped: f64,
}

/// All problems.
///
/// # Errors
/// If the data cannot be read.
pub fn problems() -> anyhow::Result<Vec<Problem>> {
    let entries: Vec<Entry> = serde_json::from_str(DATA)?;
    entries.into_iter().map(problem).collect()
}

fn problem(entry: Entry) -> anyhow::Result<Problem> {
    let of = || format!("ODEBench {}", entry.id);
    let sides = entry.substituted.first().with_context(of)?;
    let term = |side: &String| vec![Term { text: readable(side), rate: None, coefficient: 1.0, error: None }];
    let rows: Vec<Vec<Term>> = sides.iter().map(term).collect();
    let equations = Equations::new(&rows, &names(sides.len())).with_context(of)?;
    let times = (0..entry.n).map(|i| entry.t_end * i as f64 / (entry.n - 1) as f64).collect();
    Ok(Problem { id: entry.id, description: entry.eq_description, equations, starts: entry.init, times })
}

/// Python's text in the words of our parser.
fn readable(side: &str) -> String {
    // The only power that is not whole: the two summands of equation 10.
    side.replace("(1 - x_0)**1.2", "exp(1.2*log(1 - x_0))")
        .replace("x_0**1.2", "exp(1.2*log(x_0))")
        .replace("**", "^")
        .replace("Abs(", "abs(")
        .replace("cot(", "1/tan(")
}

fn names(n: usize) -> Vec<String> {
    (0..n).map(|i| format!("x_{i}")).collect()
}

impl Problem {
    /// The trajectory from start number `which`; none if it does not stay finite.
    #[must_use]
    pub fn trajectory(&self, which: usize) -> Option<Array2<f64>> {
        integrate(&self.equations, self.starts.get(which)?, &self.times)
    }

    /// Sampling interval \[s\].
    #[must_use]
    pub fn dt(&self) -> f64 {
        self.times[1] - self.times[0]
    }

    /// The log a method is given: `states` (T, n) spoilt.
    #[must_use]
    pub fn log(&self, states: &Array2<f64>, spoilt: Spoilt, rng: &mut Rng) -> Log {
        let mut states = states.clone();
        for value in states.iter_mut().filter(|_| spoilt.noise > 0.0) {
            let normal: f64 = StandardNormal.sample(rng);
            *value *= 1.0 + spoilt.noise * normal;
        }
        let mut times = None;
        if spoilt.dropped > 0.0 {
            let kept = kept(states.nrows(), spoilt.dropped, rng);
            times = Some(kept.iter().map(|&i| self.times[i]).collect());
            states = states.select(Axis(0), &kept);
        }
        let n = states.ncols();
        let controls = Array2::zeros((states.nrows() - 1, 0));
        let trajectories = vec![Trajectory { states, controls, times }];
        Log { states: names(n), roles: vec![Role::Plain; n], controls: Vec::new(), dt: self.dt(), trajectories }
    }
}

/// Which of `count` samples are kept when the share `dropped` is not: as many as possible at random, in order.
fn kept(count: usize, dropped: f64, rng: &mut Rng) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    for i in (1..count).rev() {
        order.swap(i, (rng.next_u64() % (i as u64 + 1)) as usize);
    }
    order.truncate(count - (dropped * count as f64) as usize);
    order.sort_unstable();
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use sindyna_core::{Seed, VectorField as _};

    #[test]
    fn all_problems_are_read_and_integrated() -> anyhow::Result<()> {
        let problems = problems()?;
        assert_eq!(problems.len(), 63);
        let away: Vec<u32> =
            problems.iter().filter(|p| (0..2).any(|which| p.trajectory(which).is_none())).map(|p| p.id).collect();
        assert!(away.is_empty(), "{away:?} do not stay finite");
        Ok(())
    }

    #[test]
    fn powers_that_are_not_whole_are_read() -> anyhow::Result<()> {
        let (problems, mut x_dot) = (problems()?, [0.0]);
        problems[9].equations.eval(&[0.3], &[], &mut x_dot);
        let expected = -0.8 * 0.3 * 0.7_f64.powf(1.2) + 0.2 * 0.3_f64.powf(1.2) * 0.7;
        assert!((x_dot[0] - expected).abs() < 1e-15, "{x_dot:?}");
        Ok(())
    }

    #[test]
    fn half_of_the_samples_are_dropped_in_order() {
        let kept = kept(512, 0.5, &mut Seed::new(0).numpy());
        assert_eq!(kept.len(), 256);
        assert!(kept.windows(2).all(|w| w[0] < w[1]) && kept[255] < 512);
    }
}
