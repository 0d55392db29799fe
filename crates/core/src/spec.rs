//! What is declared about a system before anything is learned: names, units, bounds, time step.

use ndarray::Array2;

/// The actions an agent may choose, and the control u each of them puts on the system.
#[derive(Debug, Clone, PartialEq)]
pub enum Space {
    /// Real actions; the control is the action clipped to `low..=high`, element by element.
    Box {
        /// Smallest control, one value per input.
        low: Vec<f64>,
        /// Largest control, one value per input.
        high: Vec<f64>,
    },
    /// Numbered actions; row i of `controls` (actions, k) is the control of action i.
    Discrete {
        /// The control of each action, shape (actions, k).
        controls: Array2<f64>,
    },
}

impl Space {
    /// Number of values in one action: k for a box, 1 (the index) for numbered actions.
    #[must_use]
    pub fn action_dim(&self) -> usize {
        match self {
            Self::Box { low, .. } => low.len(),
            Self::Discrete { .. } => 1,
        }
    }

    /// Number of inputs k of the system.
    #[must_use]
    pub fn control_dim(&self) -> usize {
        match self {
            Self::Box { low, .. } => low.len(),
            Self::Discrete { controls } => controls.ncols(),
        }
    }

    /// The control u that `action` puts on the system; `false` if the action names none.
    ///
    /// `action` has [`Self::action_dim`] values, `control` [`Self::control_dim`].
    pub fn control_into(&self, action: &[f64], control: &mut [f64]) -> bool {
        match self {
            Self::Box { low, high } => {
                for (((u, a), lo), hi) in control.iter_mut().zip(action).zip(low).zip(high) {
                    *u = a.clamp(*lo, *hi);
                }
                action.len() == low.len() && action.iter().all(|a| a.is_finite())
            }
            Self::Discrete { controls } => {
                let Some(row) = action_index(action).filter(|&i| i < controls.nrows()) else { return false };
                for (u, c) in control.iter_mut().zip(controls.row(row)) {
                    *u = *c;
                }
                true
            }
        }
    }
}

/// A whole, non-negative action number; `None` for anything else.
fn action_index(action: &[f64]) -> Option<usize> {
    match action {
        [a] if *a >= 0.0 && a.fract() == 0.0 && *a < 1e9 => Some(*a as usize),
        _ => None,
    }
}

/// What a channel measures, as far as it is declared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A quantity on the real line.
    Plain,
    /// An angle \[rad\]; values 2π apart are the same place.
    Angle,
    /// The cosine of state channel `.0` (observations only).
    CosOf(usize),
    /// The sine of state channel `.0` (observations only).
    SinOf(usize),
    /// The time derivative of state channel `.0`.
    RateOf(usize),
}

/// One scalar signal: a state, an observation or a control.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Short name as printed in equations, such as `θ`.
    pub name: String,
    /// SI unit, such as `rad/s`; empty for a pure number.
    pub unit: String,
    /// What the channel measures.
    pub kind: Kind,
    /// What is known of its values.
    pub prior: Prior,
}

/// What is known of the values of a channel before any of them is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prior {
    /// Range of the signal, infinite where none is declared.
    pub bounds: (f64, f64),
    /// Typical magnitude, in the channel's unit; positive. Sensors' noise is declared in parts of it, and models are compared with their systems
    /// within it; learners do not use it, but for the target `increment`, which tells equally good equations apart over it.
    pub scale: f64,
    /// Distance of two neighbouring values, in the channel's unit: the error of rounding is uniform over it. 0 where the precision of the numbers
    /// alone rounds.
    pub resolution: f64,
    /// Distance of two neighbouring values as they are written, in the channel's unit: they may have been rounded to it, or be exact. 0 where they are written
    /// in full. Asked of controls.
    pub written: f64,
}

impl Prior {
    /// A typical magnitude and no bounds.
    #[must_use]
    pub fn of_scale(scale: f64) -> Self {
        Self { bounds: (f64::NEG_INFINITY, f64::INFINITY), scale, resolution: 0.0, written: 0.0 }
    }
}

impl Channel {
    /// A channel without declared bounds.
    #[must_use]
    pub fn new(name: &str, unit: &str, kind: Kind, scale: f64) -> Self {
        Self { name: name.into(), unit: unit.into(), kind, prior: Prior::of_scale(scale) }
    }

    /// The same channel with a declared range.
    #[must_use]
    pub fn within(mut self, low: f64, high: f64) -> Self {
        self.prior.bounds = (low, high);
        self
    }

    /// Whether both ends of the range are finite.
    #[must_use]
    pub fn is_bounded(&self) -> bool {
        self.prior.bounds.0.is_finite() && self.prior.bounds.1.is_finite()
    }
}

/// How finely observations are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// Observations are rounded to the nearest float32.
    F32,
    /// Observations are float64.
    F64,
}

/// What connects a learner to a system, and what is known of each [`Channel`] beforehand: all that identification may use. How long episodes are and
/// from which return a task is solved is the [`Protocol`] of its evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct Spec {
    /// Name of the task, such as `pendulum`.
    pub name: String,
    /// State channels (n).
    pub state: Vec<Channel>,
    /// Observation channels. `CosOf(i)` and `SinOf(i)` show state i so; any other shows the state of the same name, or a function of
    /// states where there is none.
    pub observation: Vec<Channel>,
    /// Input channels (k).
    pub control: Vec<Channel>,
    /// What an agent may choose.
    pub action_space: Space,
    /// How finely observations are shown.
    pub precision: Precision,
    /// Standard deviation of the sensors' noise as a fraction of each observation channel's scale: what stands on a
    /// sensor's data sheet, so that whoever learns may know it. 0 for sensors without noise.
    pub noise: f64,
    /// Control interval \[s\]; 1 for a map without seconds.
    pub dt: f64,
}

/// How a policy is evaluated: what its task counts for, which no learner sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Protocol {
    /// Steps after which an episode is truncated.
    pub max_steps: usize,
    /// Mean return from which the task counts as solved.
    pub solved_at: Option<f64>,
}

impl Spec {
    /// Number of states n.
    #[must_use]
    pub fn state_dim(&self) -> usize {
        self.state.len()
    }

    /// Number of observed values.
    #[must_use]
    pub fn observation_dim(&self) -> usize {
        self.observation.len()
    }

    /// Number of inputs k.
    #[must_use]
    pub fn control_dim(&self) -> usize {
        self.control.len()
    }

    /// Standard deviation of the noise on each observation channel, in its unit: [`Self::noise`] times its scale.
    pub fn noise_deviations(&self) -> impl ExactSizeIterator<Item = f64> {
        self.observation.iter().map(|channel| self.noise * channel.prior.scale)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;

    #[test]
    fn box_actions_are_clipped_to_the_control_range() {
        let space = Space::Box { low: vec![-2.0], high: vec![2.0] };
        let mut u = [0.0];
        for (action, control) in [(-3.0, -2.0), (0.5, 0.5), (7.0, 2.0)] {
            assert!(space.control_into(&[action], &mut u));
            assert_eq!(u, [control]);
        }
        assert!(!space.control_into(&[f64::NAN], &mut u));
    }

    #[test]
    fn numbered_actions_look_up_their_control() {
        let space = Space::Discrete { controls: array![[-10.0], [10.0]] };
        let mut u = [0.0];
        assert!(space.control_into(&[1.0], &mut u));
        assert_eq!(u, [10.0]);
        for bad in [2.0, -1.0, 0.5, f64::NAN] {
            assert!(!space.control_into(&[bad], &mut u), "{bad} names no action");
        }
    }
}
