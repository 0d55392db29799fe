//! What a method of identification is given: a log, and nothing about its noise.

use ndarray::Array2;
use serde::Serialize;

/// What is known of a state besides its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// A quantity on the real line.
    Plain,
    /// An angle \[rad\] that may enter the equations by itself, as with a torsion spring.
    Angle,
    /// An angle \[rad\] that goes round; unwrapped in the log.
    Turning,
    /// The time derivative of another state.
    RateOf(usize),
}

/// One uninterrupted recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    /// States (T, n) as the sensors show them.
    pub states: Array2<f64>,
    /// Inputs (T − 1, k); row i is held from sample i to sample i + 1.
    pub controls: Array2<f64>,
    /// Times of the samples \[s\] where they are not evenly spaced.
    pub times: Option<Vec<f64>>,
}

/// Recordings of one system, with what a user can say about the columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Log {
    /// Names of the states.
    pub states: Vec<String>,
    /// What each state is.
    pub roles: Vec<Role>,
    /// Names of the inputs.
    pub controls: Vec<String>,
    /// Sampling interval \[s\].
    pub dt: f64,
    /// The recordings.
    pub trajectories: Vec<Trajectory>,
}

impl Log {
    /// Names of z = (x; u), the variables of all terms.
    #[must_use]
    pub fn variables(&self) -> Vec<String> {
        self.states.iter().chain(&self.controls).cloned().collect()
    }

    /// The same without the samples of states that are rates of others: NaN, as what was not measured is.
    #[must_use]
    pub fn without_rates(mut self) -> Self {
        let rates = (0..self.roles.len()).filter(|&i| matches!(self.roles[i], Role::RateOf(_)));
        for i in rates {
            self.trajectories.iter_mut().for_each(|t| t.states.column_mut(i).fill(f64::NAN));
        }
        self
    }
}
