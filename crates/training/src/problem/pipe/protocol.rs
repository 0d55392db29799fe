//! What is said through a pipe: one JSON object on a line each way (`docs/pipe.md`).

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sindyna_core::{Channel, Spec};

use crate::settings::PrecisionName;

/// Version of what is said.
const PROTOCOL: u32 = 1;

/// What the program is asked.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename_all = "lowercase")]
pub(super) enum Request<'a> {
    /// What it is: answered by [`Told`].
    Spec { protocol: u32, states: Vec<State<'a>>, controls: Vec<Control<'a>>, dt: f64 },
    /// To begin an episode near the state `start` (n): answered by [`Reached`].
    Reset { start: &'a [f64] },
    /// To apply `control` (k) for one control interval: answered by [`Reached`].
    Step { control: &'a [f64] },
    /// To come to rest and end: not answered.
    Close,
}

/// A state as the task declares it.
#[derive(Debug, Serialize)]
pub(super) struct State<'a> {
    name: &'a str,
    unit: &'a str,
}

/// A control as the task declares it.
#[derive(Debug, Serialize)]
pub(super) struct Control<'a> {
    name: &'a str,
    unit: &'a str,
    low: f64,
    high: f64,
}

/// What the program is.
#[derive(Debug, Deserialize)]
pub(super) struct Told {
    states: Vec<String>,
    controls: Vec<String>,
    dt: f64,
    /// How finely states are told; as doubles if it does not say.
    pub(super) precision: Option<PrecisionName>,
}

/// The state (n) that it is in.
#[derive(Debug, Deserialize)]
pub(super) struct Reached {
    pub(super) state: Vec<f64>,
}

/// Why it cannot do what it was asked.
#[derive(Debug, Deserialize)]
struct Refused {
    error: String,
}

impl<'a> Request<'a> {
    /// The first question, about a system as `spec` declares it.
    pub(super) fn spec(spec: &'a Spec) -> Self {
        let state = |c: &'a Channel| State { name: &c.name, unit: &c.unit };
        let control = |c: &'a Channel| {
            let (low, high) = c.prior.bounds;
            Control { name: &c.name, unit: &c.unit, low, high }
        };
        Self::Spec {
            protocol: PROTOCOL,
            states: spec.state.iter().map(state).collect(),
            controls: spec.control.iter().map(control).collect(),
            dt: spec.dt,
        }
    }

    /// What it is called in messages.
    pub(super) fn name(&self) -> &'static str {
        match self {
            Self::Spec { .. } => "spec",
            Self::Reset { .. } => "reset",
            Self::Step { .. } => "step",
            Self::Close => "close",
        }
    }

    /// What an answer to it looks like.
    fn answered_by(&self) -> &'static str {
        match self {
            Self::Spec { .. } => r#"{"states": ["x"], "controls": ["u"], "dt": 0.05}"#,
            _ => r#"{"state": [0.0]}"#,
        }
    }
}

/// Reads the line that answers `request`.
pub(super) fn answer<T: DeserializeOwned>(line: &str, request: &Request<'_>) -> Result<T, String> {
    if let Ok(Refused { error }) = serde_json::from_str(line) {
        return Err(format!("it rejects `{}`: {error}", request.name()));
    }
    serde_json::from_str(line).map_err(|error| {
        format!(
            "it answered `{}` by `{}` where a line such as {} was expected ({error})",
            request.name(),
            shortened(line),
            request.answered_by(),
        )
    })
}

/// Characters of a line that are shown.
const SHOWN: usize = 80;

/// The beginning of `line`.
fn shortened(line: &str) -> String {
    let mut shown: String = line.trim_end().chars().take(SHOWN).collect();
    if shown.len() < line.trim_end().len() {
        shown.push('…');
    }
    shown
}

impl Told {
    /// Refuses a program that is not what `spec` declares.
    pub(super) fn check(&self, spec: &Spec) -> Result<(), String> {
        let names = |channels: &[Channel]| channels.iter().map(|c| c.name.clone()).collect::<Vec<_>>();
        for (what, declared, told) in
            [("states", names(&spec.state), &self.states), ("controls", names(&spec.control), &self.controls)]
        {
            if declared != *told {
                return Err(format!("its {what} are {told:?}, the task file has {declared:?}"));
            }
        }
        if (self.dt - spec.dt).abs() > 1e-9 * spec.dt {
            return Err(format!("its control interval is {} s, that of the task file is {} s", self.dt, spec.dt));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_lines_as_the_manual_has_them() {
        let line = |request: &Request<'_>| serde_json::to_string(request).unwrap();
        assert_eq!(line(&Request::Reset { start: &[0.5, -1.0] }), r#"{"type":"reset","start":[0.5,-1.0]}"#);
        assert_eq!(line(&Request::Step { control: &[0.1] }), r#"{"type":"step","control":[0.1]}"#);
        assert_eq!(line(&Request::Close), r#"{"type":"close"}"#);
        let spec = sindyna_envs::find("pendulum").unwrap();
        assert_eq!(
            line(&Request::spec(spec.spec())),
            r#"{"type":"spec","protocol":1,"states":[{"name":"θ","unit":"rad"},{"name":"ω","unit":"rad/s"}],"controls":[{"name":"u","unit":"N·m","low":-2.0,"high":2.0}],"dt":0.05}"#
        );
    }

    #[test]
    fn answers_are_read_and_what_is_none_is_shown() {
        let step = Request::Step { control: &[0.0] };
        assert_eq!(answer::<Reached>("{\"state\": [1, 2.5]}\n", &step).unwrap().state, [1.0, 2.5]);
        for (line, says) in [
            ("{\"error\": \"the motor is hot\"}", "it rejects `step`: the motor is hot"),
            ("ready", "it answered `step` by `ready`"),
            ("{\"state\": [NaN]}", "expected value"),
            ("{\"state\": [null]}", "invalid type: null"),
            ("{\"states\": [1.0]}", "missing field `state`"),
            ("", "a line such as {\"state\": [0.0]} was expected"),
        ] {
            let refusal = answer::<Reached>(line, &step).unwrap_err();
            assert!(refusal.contains(says), "{refusal}");
        }
        assert!(answer::<Reached>(&"x".repeat(1_000), &step).unwrap_err().contains("xxx…`"));
    }

    #[test]
    fn another_system_than_the_declared_one_is_refused() {
        let system = sindyna_envs::find("pendulum").unwrap();
        let told = |text: &str| serde_json::from_str::<Told>(text).unwrap().check(system.spec());
        assert_eq!(told(r#"{"states": ["θ", "ω"], "controls": ["u"], "dt": 0.05, "precision": "f32"}"#), Ok(()));
        for (text, says) in [
            (r#"{"states": ["ω", "θ"], "controls": ["u"], "dt": 0.05}"#, "its states are"),
            (r#"{"states": ["θ", "ω"], "controls": [], "dt": 0.05}"#, "its controls are []"),
            (r#"{"states": ["θ", "ω"], "controls": ["u"], "dt": 0.02}"#, "its control interval is 0.02 s"),
        ] {
            let refusal = told(text).unwrap_err();
            assert!(refusal.contains(says), "{refusal}");
        }
    }
}
