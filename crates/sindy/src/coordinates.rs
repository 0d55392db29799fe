//! The learned side's map from what sensors show back to the state.

use std::f64::consts::PI;

use ndarray::{Array2, ArrayView1, ArrayView2};
use sindyna_core::turning::unwrapped;
use sindyna_core::{Kind, Precision, Spec};

use crate::library::{Input, Role};

/// In which space a model lives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CoordinateMode {
    /// The task's state: a cosine and a sine are put together to their angle.
    Recognised,
    /// The observation as it is: cosine and sine are two states (the paper's reading).
    Raw,
}

/// How one state is read from an observation.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Source {
    Shown(usize),
    Turned { cosine: usize, sine: usize },
}

/// The map o → z for a spec and a mode.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Coordinates {
    sources: Vec<Source>,
    precision: Precision,
    /// Distance of two neighbouring values of each observation, 0 where the precision alone rounds.
    resolution: Vec<f64>,
    /// Standard deviation of the declared noise of each observation.
    noise: Vec<f64>,
    dt: f64,
}

impl Coordinates {
    /// The coordinates of `mode`.
    ///
    /// # Errors
    /// The name of the first state that no observation shows.
    pub(crate) fn new(spec: &Spec, mode: CoordinateMode) -> Result<Self, String> {
        let sources = match mode {
            CoordinateMode::Raw => (0..spec.observation_dim()).map(Source::Shown).collect(),
            CoordinateMode::Recognised => {
                let source = |i: usize| source(spec, i).ok_or_else(|| spec.state[i].name.clone());
                (0..spec.state_dim()).map(source).collect::<Result<_, _>>()?
            }
        };
        let resolution = spec.observation.iter().map(|o| o.prior.resolution).collect();
        let noise = spec.noise_deviations().collect();
        Ok(Self { sources, precision: spec.precision, resolution, noise, dt: spec.dt })
    }

    /// The states z (T, n) of a rollout's observations (T, m); angles are unwrapped from row to row.
    pub(crate) fn states(&self, observations: ArrayView2<'_, f64>) -> Array2<f64> {
        let mut states = Array2::zeros((observations.nrows(), self.sources.len()));
        for (i, source) in self.sources.iter().enumerate() {
            let mut last = 0.0;
            for (o, mut z) in observations.rows().into_iter().zip(states.rows_mut()) {
                z[i] = match *source {
                    Source::Shown(at) => o[at],
                    Source::Turned { cosine, sine } => unwrapped(o[sine].atan2(o[cosine]), last),
                };
                last = z[i];
            }
        }
        states
    }

    /// The error \[unit of z\] that rounding the observation `o` leaves on state `i`, as a standard deviation.
    pub(crate) fn rounding(&self, i: usize, o: ArrayView1<'_, f64>) -> f64 {
        // A rounding error is uniform over one unit in the last place. A system seen as finely as it computes has rounded
        // a few times on its way.
        let times = match self.precision {
            Precision::F32 => 1.0,
            Precision::F64 => 4.0,
        };
        let spread = |at: usize| (times * ulp(o[at], self.precision)).max(self.resolution[at]) / 12_f64.sqrt();
        match self.sources[i] {
            Source::Shown(at) => spread(at),
            Source::Turned { cosine, sine } => {
                let (c, s) = (o[cosine], o[sine]);
                // The angle is computed, here and in the system, with rounding of its own.
                let own = 4.0 * ulp(PI, Precision::F64) / 12_f64.sqrt();
                (s * spread(cosine)).hypot(c * spread(sine)).hypot(own)
            }
        }
    }

    /// The standard deviation \[unit of z\] of the error with which the observation `o` shows state `i`: declared noise
    /// and rounding.
    pub(crate) fn error(&self, i: usize, o: ArrayView1<'_, f64>) -> f64 {
        let noise = match self.sources[i] {
            Source::Shown(at) => self.noise[at],
            Source::Turned { cosine, sine } => (o[sine] * self.noise[cosine]).hypot(o[cosine] * self.noise[sine]),
        };
        noise.hypot(self.rounding(i, o))
    }

    /// Number of states.
    pub(crate) fn n_states(&self) -> usize {
        self.sources.len()
    }

    /// Control interval \[s\].
    pub(crate) fn dt(&self) -> f64 {
        self.dt
    }
}

/// The unit in the last place of `v`.
fn ulp(v: f64, precision: Precision) -> f64 {
    match precision {
        Precision::F32 => {
            let v = (v as f32).abs();
            f64::from(f32::from_bits(v.to_bits() + 1) - v)
        }
        Precision::F64 => {
            let v = v.abs();
            f64::from_bits(v.to_bits() + 1) - v
        }
    }
}

fn source(spec: &Spec, i: usize) -> Option<Source> {
    let shown = spec.observation.iter().position(|o| o.name == spec.state[i].name);
    let of = |kind| spec.observation.iter().position(|o| o.kind == kind);
    match (shown, of(Kind::CosOf(i)), of(Kind::SinOf(i))) {
        (Some(at), _, _) => Some(Source::Shown(at)),
        (None, Some(cosine), Some(sine)) => Some(Source::Turned { cosine, sine }),
        _ => None,
    }
}

/// The variables z = (x; u) of a library and what they stand for.
pub(crate) fn inputs(spec: &Spec, mode: CoordinateMode) -> Vec<Input> {
    let channels = match mode {
        CoordinateMode::Recognised => &spec.state,
        CoordinateMode::Raw => &spec.observation,
    };
    let states = channels.iter().map(|channel| {
        let role = match channel.kind {
            Kind::Angle if mode == CoordinateMode::Recognised && goes_round(spec, &channel.name) => Role::Turning,
            Kind::Angle => Role::Angle,
            Kind::RateOf(_) => Role::Rate,
            Kind::Plain | Kind::CosOf(_) | Kind::SinOf(_) => Role::Plain,
        };
        Input::new(&channel.name, role)
    });
    states
        .chain(spec.control.iter().map(|c| Input { in_radians: c.unit == "rad", ..Input::new(&c.name, Role::Control) }))
        .collect()
}

/// Whether the angle `name` is unbounded and seen only through its cosine and sine.
fn goes_round(spec: &Spec, name: &str) -> bool {
    let bounded = spec.state.iter().any(|s| s.name == name && s.is_bounded());
    !bounded && !spec.observation.iter().any(|o| o.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_unit_in_the_last_place() {
        let is = |got: f64, expected: f64| assert!((got / expected - 1.0).abs() < 1e-12, "{got} is not {expected}");
        is(ulp(-1.0, Precision::F64), f64::EPSILON);
        is(ulp(0.75, Precision::F32), f64::from(f32::EPSILON) / 2.0);
        assert!(ulp(0.0, Precision::F32) > 0.0);
    }
}
