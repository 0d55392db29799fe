//! Your own tasks, declared channel by channel.

use rand::RngExt as _;
use sindyna_core::{Channel, Kind, Precision, Rng, Space, Spec, Task};

use crate::Error;

/// Reward of the step from x (n) under u (k) to the next state (n).
type Reward = Box<dyn Fn(&[f64], &[f64], &[f64]) -> f64 + Send + Sync>;

/// Whether arriving in a state (n) ends the episode.
type Ends = Box<dyn Fn(&[f64]) -> bool + Send + Sync>;

/// Declares a system and its task: states, inputs, start states, reward, termination.
///
/// States are declared in the order of the dynamics; an angle is observed as its cosine and sine.
pub struct TaskBuilder {
    name: String,
    dt: f64,
    states: Vec<State>,
    inputs: Vec<(Channel, f64, f64)>,
    starts: Vec<(f64, f64)>,
    reward: Option<Reward>,
    ends: Option<Ends>,
    max_steps: usize,
}

struct State {
    name: String,
    unit: String,
    angle: bool,
    rate_of: Option<String>,
}

/// A task made by [`TaskBuilder`].
pub struct OwnTask {
    spec: Spec,
    starts: Vec<(f64, f64)>,
    reward: Reward,
    ends: Option<Ends>,
    max_steps: usize,
}

impl TaskBuilder {
    /// A task called `name`, in which the agent acts every `dt` \[s\]. Episodes have 200 steps.
    #[must_use]
    pub fn new(name: &str, dt: f64) -> Self {
        Self {
            name: name.to_owned(),
            dt,
            states: Vec::new(),
            inputs: Vec::new(),
            starts: Vec::new(),
            reward: None,
            ends: None,
            max_steps: 200,
        }
    }

    /// With one more state, a quantity on the real line, that begins uniformly in `start`.
    #[must_use]
    pub fn state(self, name: &str, unit: &str, start: (f64, f64)) -> Self {
        self.with(State { name: name.into(), unit: unit.into(), angle: false, rate_of: None }, start)
    }

    /// With one more state, an angle \[rad\], that begins uniformly in `start`.
    #[must_use]
    pub fn angle(self, name: &str, start: (f64, f64)) -> Self {
        self.with(State { name: name.into(), unit: "rad".into(), angle: true, rate_of: None }, start)
    }

    /// With one more state, the time derivative of the state `of`, that begins uniformly in `start`.
    #[must_use]
    pub fn rate(self, name: &str, unit: &str, of: &str, start: (f64, f64)) -> Self {
        self.with(State { name: name.into(), unit: unit.into(), angle: false, rate_of: Some(of.into()) }, start)
    }

    fn with(mut self, state: State, start: (f64, f64)) -> Self {
        self.states.push(state);
        self.starts.push(start);
        self
    }

    /// With one more input, from `low` to `high`.
    #[must_use]
    pub fn input(mut self, name: &str, unit: &str, low: f64, high: f64) -> Self {
        let scale = low.abs().max(high.abs());
        self.inputs.push((Channel::new(name, unit, Kind::Plain, scale).within(low, high), low, high));
        self
    }

    /// With the reward `reward(x, u, next)` of the step from x (n) under the control u (k) to the next state (n).
    #[must_use]
    pub fn reward(mut self, reward: impl Fn(&[f64], &[f64], &[f64]) -> f64 + Send + Sync + 'static) -> Self {
        self.reward = Some(Box::new(reward));
        self
    }

    /// With episodes that terminate in states for which `ends` is true.
    #[must_use]
    pub fn terminated(mut self, ends: impl Fn(&[f64]) -> bool + Send + Sync + 'static) -> Self {
        self.ends = Some(Box::new(ends));
        self
    }

    /// With episodes of at most this many steps.
    #[must_use]
    pub fn max_steps(self, max_steps: usize) -> Self {
        Self { max_steps, ..self }
    }

    /// The task.
    ///
    /// # Errors
    /// [`Error::System`] if a declaration is missing or contradicts another one.
    pub fn build(self) -> Result<OwnTask, Error> {
        let refused = |why: String| Err(Error::System { name: self.name.clone(), why });
        if self.states.is_empty() || self.inputs.is_empty() {
            return refused("it needs a state and an input".into());
        }
        if !(self.dt.is_finite() && self.dt > 0.0) {
            return refused(format!("its control interval must be finite and above 0, got {}", self.dt));
        }
        if self.max_steps == 0 {
            return refused("its episodes must have a step".into());
        }
        let names: Vec<&str> =
            self.states.iter().map(|s| &*s.name).chain(self.inputs.iter().map(|i| &*i.0.name)).collect();
        if let Some((_, name)) = names.iter().enumerate().find(|(i, name)| names[..*i].contains(name)) {
            return refused(format!("the name `{name}` is used twice"));
        }
        let ordered = |low: f64, high: f64| low <= high && low.is_finite() && high.is_finite();
        if let Some((i, (low, high))) = self.starts.iter().enumerate().find(|(_, s)| !ordered(s.0, s.1)) {
            return refused(format!("`{}` must begin within (low, high), got ({low}, {high})", self.states[i].name));
        }
        if let Some((input, low, high)) =
            self.inputs.iter().find(|(_, low, high)| !(low < high && ordered(*low, *high)))
        {
            return refused(format!("`{}` must go from low to high, both finite; got {low} and {high}", input.name));
        }
        let Some(reward) = self.reward else { return refused("it has no reward".into()) };
        let mut state = Vec::new();
        for State { name, unit, angle, rate_of } in &self.states {
            let kind = match rate_of {
                None if *angle => Kind::Angle,
                None => Kind::Plain,
                Some(of) => match self.states.iter().position(|s| s.name == *of && s.name != *name) {
                    Some(of) => Kind::RateOf(of),
                    None => return refused(format!("`{name}` is the rate of `{of}`, which is not another state")),
                },
            };
            state.push(Channel::new(name, unit, kind, 1.0));
        }
        let seen = |(i, channel): (usize, &Channel)| match channel.kind {
            Kind::Angle => {
                let waving = |function: &str, kind| {
                    Channel::new(&format!("{function} {}", channel.name), "", kind, 1.0).within(-1.0, 1.0)
                };
                vec![waving("cos", Kind::CosOf(i)), waving("sin", Kind::SinOf(i))]
            }
            _ => vec![channel.clone()],
        };
        let (low, high) = self.inputs.iter().map(|(_, low, high)| (*low, *high)).unzip();
        let spec = Spec {
            name: self.name,
            observation: state.iter().enumerate().flat_map(seen).collect(),
            state,
            control: self.inputs.into_iter().map(|(channel, ..)| channel).collect(),
            action_space: Space::Box { low, high },
            precision: Precision::F64,
            noise: 0.0,
            dt: self.dt,
        };
        Ok(OwnTask { spec, starts: self.starts, reward, ends: self.ends, max_steps: self.max_steps })
    }
}

impl Task for OwnTask {
    fn spec(&self) -> &Spec {
        &self.spec
    }

    fn max_steps(&self) -> usize {
        self.max_steps
    }

    fn initial(&self, rng: &mut Rng, x: &mut [f64]) {
        for (value, &(low, high)) in x.iter_mut().zip(&self.starts) {
            *value = rng.random_range(low..=high);
        }
    }

    fn reward(&self, x: &[f64], _action: &[f64], u: &[f64], next: &[f64]) -> f64 {
        (self.reward)(x, u, next)
    }

    fn terminated(&self, next: &[f64]) -> bool {
        self.ends.as_ref().is_some_and(|ends| ends(next))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_or_contradicts_itself_is_told() {
        let whole =
            || TaskBuilder::new("a", 0.1).state("x", "m", (0.0, 1.0)).input("u", "N", -1.0, 1.0).reward(|_, _, _| 0.0);
        assert!(whole().build().is_ok());
        for (builder, says) in [
            (TaskBuilder::new("a", 0.1), "needs a state and an input"),
            (TaskBuilder { dt: f64::NAN, ..whole() }, "control interval"),
            (whole().state("x", "m", (0.0, 0.0)), "`x` is used twice"),
            (whole().state("y", "m", (1.0, 0.0)), "`y` must begin within"),
            (whole().input("v", "N", 1.0, 1.0), "`v` must go from low to high"),
            (whole().rate("w", "m/s", "w", (0.0, 0.0)), "`w` is the rate of `w`"),
            (whole().max_steps(0), "must have a step"),
        ] {
            let refusal = builder.build().map(drop).unwrap_err().to_string();
            assert!(refusal.contains(says), "{refusal}");
        }
    }

    #[test]
    fn angles_are_seen_as_cosine_and_sine() {
        let task = TaskBuilder::new("a", 0.1).angle("θ", (0.0, 0.0)).rate("ω", "rad/s", "θ", (0.0, 0.0));
        let task = task.input("u", "N", -1.0, 1.0).reward(|_, _, _| 0.0).build().unwrap();
        let seen: Vec<_> = task.spec().observation.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(seen, ["cos θ", "sin θ", "ω"]);
    }
}
