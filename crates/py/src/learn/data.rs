//! Steps of a system, recorded.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use serde_json::json;
use sindyna::core::{Dataset, End};
use sindyna::logs::{Clock, Log, LogOptions, TRAJECTORY};

use super::system::{Declared, State, refused};

/// Observations (T + 1, m), actions (T, values), rewards (T) and the end of one episode: "terminated", "truncated" or "cut".
type Recorded<'py> = (PyReadonlyArray2<'py, f64>, PyReadonlyArray2<'py, f64>, PyReadonlyArray1<'py, f64>, String);

/// The same, to be given back.
type Shown<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>, &'static str);

/// Every step and reset of a system, recorded.
#[pyclass(frozen, module = "sindyna._sindyna")]
pub(crate) struct Data {
    pub(crate) inner: Dataset,
}

#[pymethods]
impl Data {
    /// Episodes of the system, one after the other.
    #[new]
    fn new(system: &str, episodes: Vec<Recorded<'_>>) -> PyResult<Self> {
        let spec = Declared::read(system)?.spec()?;
        let (m, k, values) = (spec.observation_dim(), spec.control_dim(), spec.action_space.action_dim());
        let mut data = Dataset::new(m, k, values, spec.dt);
        let mut control = vec![0.0; k];
        for (observations, actions, rewards, end) in &episodes {
            let (observations, actions, rewards) = (observations.as_array(), actions.as_array(), rewards.as_array());
            if observations.nrows() != actions.nrows() + 1 || rewards.len() != actions.nrows() {
                return Err(refused(format!(
                    "{} observations need one action and one reward less, got {} and {}",
                    observations.nrows(),
                    actions.nrows(),
                    rewards.len()
                )));
            }
            data.begin(&observations.row(0).to_vec()).map_err(refused)?;
            for (i, (action, reward)) in actions.rows().into_iter().zip(rewards).enumerate() {
                let action = action.to_vec();
                if !spec.action_space.control_into(&action, &mut control) {
                    return Err(refused(format!("{action:?} is no action of the system")));
                }
                data.push(&action, &control, *reward, &observations.row(i + 1).to_vec()).map_err(refused)?;
            }
            data.finish(match end.as_str() {
                "terminated" => End::Terminated,
                "truncated" => End::Truncated,
                _ => End::Cut,
            });
        }
        Ok(Self { inner: data })
    }

    /// Steps made.
    #[getter]
    fn n_steps(&self) -> usize {
        self.inner.n_steps()
    }

    /// Resets made.
    #[getter]
    fn n_resets(&self) -> usize {
        self.inner.n_rollouts()
    }

    /// Episode by episode.
    fn episodes<'py>(&self, py: Python<'py>) -> Vec<Shown<'py>> {
        let shown = |rollout: sindyna::core::Rollout<'_>| {
            let end = match rollout.end {
                End::Terminated => "terminated",
                End::Truncated => "truncated",
                End::Cut => "cut",
            };
            (
                rollout.observations.to_owned().into_pyarray(py),
                rollout.actions.to_owned().into_pyarray(py),
                rollout.rewards.to_owned().into_pyarray(py),
                end,
            )
        };
        self.inner.rollouts().map(shown).collect()
    }

    /// States that the observed values called `names` show, as JSON `{"states": […], "names": […], "notes": […]}`: `circles` are cosines and sines, `rates` states
    /// and those whose rates they are; recognised where none are given.
    fn recognise(
        &self,
        names: Vec<String>,
        dt: f64,
        angles: Vec<String>,
        circles: Option<Vec<(String, String)>>,
        rates: Option<Vec<(String, String)>>,
    ) -> PyResult<String> {
        let precision = Some(sindyna::core::Precision::F64);
        let inputs: Vec<String> =
            (0..self.inner.rollouts().next().map_or(0, |r| r.controls.ncols())).map(|i| format!("input {i}")).collect();
        let options = LogOptions {
            missing: Some(Vec::new()),
            angles: Some(angles),
            rates,
            circles,
            precision,
            clock: Clock::Given(dt),
            ..LogOptions::new(names.clone()).with_inputs(inputs.clone())
        };
        let log = Log::parse("data", self.text(&names, &inputs), &options).map_err(refused)?;
        let seen = |i: usize| -> Vec<usize> {
            use sindyna::core::Kind;
            let at = |kind| log.spec.observation.iter().position(|o| o.kind == kind);
            match (at(Kind::CosOf(i)), at(Kind::SinOf(i))) {
                (Some(cosine), Some(sine)) => vec![cosine, sine],
                _ => names.iter().position(|name| *name == log.spec.state[i].name).into_iter().collect(),
            }
        };
        let state = |(i, channel): (usize, &sindyna::core::Channel)| {
            use sindyna::core::Kind;
            let rate_of = if let Kind::RateOf(of) = channel.kind { Some(of) } else { None };
            State { seen: seen(i), angle: channel.kind == Kind::Angle, rate_of }
        };
        let states: Vec<State> = log.spec.state.iter().enumerate().map(state).collect();
        let told: Vec<&String> = log.spec.state.iter().map(|s| &s.name).collect();
        let notes: Vec<String> = log.notes.iter().map(ToString::to_string).collect();
        Ok(json!({ "states": states, "names": told, "notes": notes }).to_string())
    }
}

impl Data {
    /// The data as a log; inputs of the last sample of an episode are not known.
    fn text(&self, names: &[String], inputs: &[String]) -> String {
        let quoted = |name: &String| format!("\"{}\"", name.replace('"', "\"\""));
        let header: Vec<String> = names.iter().chain(inputs).map(quoted).collect();
        let mut text = format!("{TRAJECTORY},{}\n", header.join(","));
        for (number, rollout) in self.inner.rollouts().enumerate() {
            for (i, o) in rollout.observations.rows().into_iter().enumerate() {
                text += &number.to_string();
                let held = i.min(rollout.controls.nrows().saturating_sub(1));
                let control = rollout.controls.rows().into_iter().nth(held).map(|u| u.to_vec()).unwrap_or_default();
                for value in o.iter().chain(&control) {
                    text += &format!(",{value:?}");
                }
                text.push('\n');
            }
        }
        text
    }
}
