//! Names and roles of states and inputs, for data that come without a task.

use sindyna_core::{Channel, Kind, Precision, Space, Spec};

use super::Identifier;

/// The states and inputs of a system by name, and what they stand for.
///
/// # Examples
/// The equations of a damped oscillator from arrays:
/// ```
/// use ndarray::Array2;
/// use sindyna_sindy::{Identifier, Recording, Signals};
///
/// let (dt, decay) = (0.05, |t: f64| (-0.1 * t).exp());
/// let states = Array2::from_shape_fn((200, 2), |(i, j)| {
///     let (t, (sin, cos)) = (dt * i as f64, (2.0 * dt * i as f64).sin_cos());
///     decay(t) * if j == 0 { cos } else { -0.1 * cos - 2.0 * sin }
/// });
/// let signals = Signals::new(&["x", "v"], &[]).rate("v", "x")?;
/// let found = Identifier::of_signals(&signals, dt)?.identify_recordings(&[Recording::even(dt, states, None)])?;
/// println!("{found}");
/// let ahead = found.model.simulate(&[1.0, 0.0], Array2::zeros((20, 0)).view())?;
/// let (a, _) = found.model.jacobians(&[0.0, 0.0], &[])?;
/// assert!((a[[1, 0]] + 4.01).abs() < 1e-6 && (a[[1, 1]] + 0.2).abs() < 1e-6, "{a}");
/// # assert_eq!(ahead.dim(), (21, 2));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Signals {
    states: Vec<Channel>,
    inputs: Vec<Channel>,
}

/// Why signals were refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SignalsError {
    /// There is no state of that name.
    #[error("no state named `{name}`; states: {known}")]
    NoSuchState {
        /// The name asked for.
        name: String,
        /// The names there are.
        known: String,
    },
    /// Two signals of one name, or one without.
    #[error("every state and input needs a name of its own; `{name}` is not")]
    Name {
        /// The name.
        name: String,
    },
    /// No state at all.
    #[error("a system has at least one state")]
    NoState,
    /// A sampling interval that is none.
    #[error("the sampling interval must be finite and > 0 s, got {dt}")]
    SamplingInterval {
        /// The value given.
        dt: f64,
    },
    /// A state that is the rate of itself, or of a state that has a rate already.
    #[error("`{rate}` cannot be the rate of `{of}`")]
    Rate {
        /// The state said to be a rate.
        rate: String,
        /// The state it should be the rate of.
        of: String,
    },
}

impl Signals {
    /// States and inputs by name; all are plain quantities until something else is said of them.
    #[must_use]
    pub fn new(states: &[&str], inputs: &[&str]) -> Self {
        let channels = |names: &[&str]| names.iter().map(|name| Channel::new(name, "", Kind::Plain, 1.0)).collect();
        Self { states: channels(states), inputs: channels(inputs) }
    }

    /// The same with an angle \[rad\]: terms are its sine and cosine.
    ///
    /// # Errors
    /// [`SignalsError::NoSuchState`].
    pub fn angle(mut self, state: &str) -> Result<Self, SignalsError> {
        let i = self.state(state)?;
        self.states[i].kind = Kind::Angle;
        Ok(self)
    }

    /// The same with the state `rate` the time derivative of the state `of`: that equation is believed, not fitted.
    ///
    /// # Errors
    /// [`SignalsError::NoSuchState`]; [`SignalsError::Rate`] if it cannot be.
    pub fn rate(mut self, rate: &str, of: &str) -> Result<Self, SignalsError> {
        let (v, x) = (self.state(rate)?, self.state(of)?);
        if v == x || self.states.iter().any(|s| s.kind == Kind::RateOf(x)) || self.states[v].kind != Kind::Plain {
            return Err(SignalsError::Rate { rate: rate.into(), of: of.into() });
        }
        self.states[v].kind = Kind::RateOf(x);
        Ok(self)
    }

    fn state(&self, name: &str) -> Result<usize, SignalsError> {
        let known = || self.states.iter().map(|s| s.name.as_str()).collect::<Vec<_>>().join(", ");
        let at = self.states.iter().position(|s| s.name == name);
        at.ok_or_else(|| SignalsError::NoSuchState { name: name.into(), known: known() })
    }

    fn spec(&self, dt: f64) -> Result<Spec, SignalsError> {
        if self.states.is_empty() {
            return Err(SignalsError::NoState);
        }
        if !(dt.is_finite() && dt > 0.0) {
            return Err(SignalsError::SamplingInterval { dt });
        }
        let names: Vec<&String> = self.states.iter().chain(&self.inputs).map(|c| &c.name).collect();
        if let Some((_, name)) = names.iter().enumerate().find(|(i, n)| n.is_empty() || names[..*i].contains(n)) {
            return Err(SignalsError::Name { name: (*name).clone() });
        }
        let bound = vec![f64::INFINITY; self.inputs.len()];
        Ok(Spec {
            name: "system".into(),
            observation: self.states.clone(),
            state: self.states.clone(),
            control: self.inputs.clone(),
            action_space: Space::Box { low: bound.iter().map(|v| -v).collect(), high: bound },
            precision: Precision::F64,
            noise: 0.0,
            dt,
        })
    }
}

impl Identifier {
    /// An identifier for recordings of these signals, sampled every `dt` \[s\] (or unevenly, about so often). The noise is estimated.
    ///
    /// # Errors
    /// [`SignalsError`] if names are not unique, or `dt` is no time.
    pub fn of_signals(signals: &Signals, dt: f64) -> Result<Self, SignalsError> {
        signals.spec(dt).map(|spec| Self::new(&spec))
    }
}
