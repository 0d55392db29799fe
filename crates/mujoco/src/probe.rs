//! What the header of a version would tell, found out by what its library does to a small model.
//!
//! MuJoCo's structs and constants change from version to version: `mjSTATE_CTRL` is bit 6 since 3.5 and was bit 5,
//! the sizes in `mjModel` grew from four bytes to eight in 3.5, and no function says where a field lies. So no
//! struct is looked into, and no constant is taken from a header. Everything goes through functions that have been the
//! same from 3.0.0 to 4.0.0, and the numbers and words they need are learned once, when the library is loaded:
//!
//! - Which bit of a signature means what: every bit that the library knows is tried on a model whose sizes and motion
//!   are known. Exactly one must behave as the time does, one as the positions, one as the velocities, one as the controls.
//! - How it says that a simulation diverged: positions, velocities and accelerations are made bad on purpose. The warning
//!   must begin with the same words for two indices, and go on with the index.
//!
//! What is not found, or found twice, is a reason not to use the library. Sizes are what `mj_stateSize` returns. The time
//! step is the time after the first step, for 0 + h = h without rounding.
//!
//! Not here: the counts of warnings in `mjData`, which tell the same as the warnings do. A simulation warns of each kind
//! once until it is reset, and an environment that diverged must be reset.

use std::sync::Arc;

use crate::compile::compile_text;
use crate::ffi::{Api, DataHandle, LoadError, ModelHandle, Raised, Signature, take_warnings};

/// Two bodies that nothing moves but their motors, the first the hinge (velocity 6), the second the free body along z
/// (velocity 2): nq = 8, nv = 7, nu = 2. All numbers are sums of few powers of two, so that results are exact.
const MODEL: &str = r#"<mujoco>
  <compiler angle="radian"/>
  <option timestep="0.00390625" gravity="0 0 0"/>
  <worldbody>
    <body pos="0.25 -0.5 2">
      <freejoint name="free"/>
      <geom size="0.5" mass="1" contype="0" conaffinity="0"/>
    </body>
    <body pos="8 0 0">
      <joint name="hinge" ref="0.125"/>
      <geom size="0.5" mass="1" contype="0" conaffinity="0"/>
    </body>
  </worldbody>
  <actuator>
    <motor joint="hinge" gear="1024"/>
    <motor joint="free" gear="0 0 1024 0 0 0"/>
  </actuator>
</mujoco>"#;
const TIMESTEP: f64 = 0.00390625;
const REST: [f64; 8] = [0.25, -0.5, 2.0, 1.0, 0.0, 0.0, 0.0, 0.125];
const NV: usize = 7;
/// What each motor moves.
const DRIVEN: [usize; 2] = [6, 2];
/// Large enough for an acceleration beyond MuJoCo's border of 1e10, and within that border itself.
const HUGE_CONTROL: f64 = 1e9;

/// Bits and words that differ between versions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Conventions {
    /// The time.
    pub(crate) time: Signature,
    /// qpos.
    pub(crate) positions: Signature,
    /// qvel.
    pub(crate) velocities: Signature,
    /// ctrl.
    pub(crate) controls: Signature,
    /// What stands before the index in a warning of bad positions, velocities and accelerations.
    diverged: [String; 3],
}

/// Why a library is not used.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Unexpected {
    /// The model could not be compiled.
    #[error("it cannot use a model of two bodies: {0}")]
    Model(String),
    /// A function failed.
    #[error("it fails on a model of two bodies: {0}")]
    Raised(String),
    /// No part of the state does what this one should, or several do.
    #[error("{found} parts of its state behave as {what} should")]
    Parts {
        /// Name of the part.
        what: &'static str,
        /// Number of parts that behave so.
        found: usize,
    },
    /// Positions and velocities do not come in this order.
    #[error("its state is not positions, then velocities")]
    Order,
    /// A step of a sound state warned.
    #[error("it warns of a sound state: {0}")]
    Warned(String),
    /// A warning has no index, other words for each index, or is missing.
    #[error("it does not say which {what} is bad; it says {said:?}")]
    Unclear {
        /// What was bad.
        what: &'static str,
        /// Its words for the two indices.
        said: [Vec<String>; 2],
    },
    /// The words for two kinds are the same.
    #[error("it says the same of bad positions, velocities and accelerations")]
    Alike,
}

impl From<Raised> for Unexpected {
    fn from(Raised(message): Raised) -> Self {
        Self::Raised(message)
    }
}

impl Conventions {
    /// Learns them from the library.
    pub(crate) fn of(api: &Arc<Api>) -> Result<Self, Unexpected> {
        let model = compile_text(api, MODEL).map_err(|LoadError(message)| Unexpected::Model(message))?;
        let probe = Probe::new(model);
        let [time, positions, velocities, controls] = probe.parts()?;
        let written: Vec<f64> = (1..=REST.len() + NV).map(|i| i as f64).collect();
        let mut data = probe.data()?;
        data.set(positions | velocities, &written)?;
        let apart = [(positions, REST.len()), (velocities, NV)].map(|(part, len)| read(&data, part, len));
        let [first, then] = apart;
        if [first?, then?].concat() != written {
            return Err(Unexpected::Order);
        }

        take_warnings();
        data.reset()?;
        data.step()?;
        if let Some(said) = take_warnings().pop() {
            return Err(Unexpected::Warned(said));
        }
        let bad = |part, len, i: usize, value| {
            let mut values = vec![0.0; len];
            data.reset()?;
            data.get(part, &mut values)?;
            values[i] = value;
            data.set(part, &values)?;
            take_warnings();
            data.step()?;
            Ok(take_warnings())
        };
        let diverged = words(bad, positions, velocities, controls)?;
        Ok(Self { time, positions, velocities, controls, diverged })
    }

    /// Positions, then velocities.
    pub(crate) fn state(&self) -> Signature {
        self.positions | self.velocities
    }

    /// Index into (qpos, qvel) of what `warning` calls bad, with `nq` positions: a state, or the acceleration of a velocity.
    pub(crate) fn diverged(&self, warning: &str, nq: usize) -> Option<usize> {
        self.diverged.iter().enumerate().find_map(|(kind, words)| {
            let index = number(warning.strip_prefix(words.as_str())?)?;
            Some(if kind == 0 { index } else { nq.saturating_add(index) })
        })
    }
}

/// What stands before the index in each of the three warnings; `bad` makes a step with one bad value and returns what is
/// warned of.
fn words(
    mut bad: impl FnMut(Signature, usize, usize, f64) -> Result<Vec<String>, Raised>,
    positions: Signature,
    velocities: Signature,
    controls: Signature,
) -> Result<[String; 3], Unexpected> {
    let nq = REST.len();
    let mut learn = |what, part, len, [(i, first), (j, then)]: [(usize, usize); 2], value| {
        let said = [bad(part, len, i, value)?, bad(part, len, j, value)?];
        let [a, b] = [(&said[0], first), (&said[1], then)].map(|(said, index)| before(said, index));
        match (a, b) {
            (Some(a), Some(b)) if a == b && !a.is_empty() => Ok(a.to_owned()),
            _ => Err(Unexpected::Unclear { what, said }),
        }
    };
    let same = |i| (i, i);
    let words = [
        learn("position", positions, nq, [3, 7].map(same), f64::NAN)?,
        learn("velocity", velocities, NV, [2, 6].map(same), f64::NAN)?,
        learn("acceleration", controls, DRIVEN.len(), [(0, DRIVEN[0]), (1, DRIVEN[1])], HUGE_CONTROL)?,
    ];
    let [a, b, c] = &words;
    if a == b || b == c || a == c { Err(Unexpected::Alike) } else { Ok(words) }
}

/// What stands before the first number of the first warning in which that is `index`.
fn before(said: &[String], index: usize) -> Option<&str> {
    said.iter().find_map(|text| {
        let words = &text[..text.find(|c: char| c.is_ascii_digit())?];
        (number(&text[words.len()..]) == Some(index)).then_some(words)
    })
}

/// The whole number `text` begins with.
fn number(text: &str) -> Option<usize> {
    text.split(|c: char| !c.is_ascii_digit()).next()?.parse().ok()
}

fn read(data: &DataHandle, part: Signature, len: usize) -> Result<Vec<f64>, Raised> {
    let mut values = vec![0.0; len];
    data.get(part, &mut values).map(|()| values)
}

/// The model and the parts of its state.
struct Probe {
    model: Arc<ModelHandle>,
    /// Each part and how many values it has.
    sizes: Vec<(Signature, usize)>,
}

impl Probe {
    fn new(model: ModelHandle) -> Self {
        // MuJoCo raises an error at the first bit it does not know.
        let part = |bit: u32| model.state_size(1 << bit).ok().map(|size| (1 << bit, size));
        let sizes = (0..Signature::BITS - 1).map_while(part).collect();
        Self { model: Arc::new(model), sizes }
    }

    fn data(&self) -> Result<DataHandle, Raised> {
        DataHandle::new(&self.model)
    }

    /// Time, positions, velocities and controls.
    fn parts(&self) -> Result<[Signature; 4], Unexpected> {
        let time = self.only("the time", 1, Self::is_time)?;
        let positions = self.only("the positions", REST.len(), Self::is_positions)?;
        let velocities = self.only("the velocities", NV, |p, part| p.is_velocities(part, positions))?;
        let controls = self.only("the controls", DRIVEN.len(), |p, part| p.is_controls(part, velocities))?;
        Ok([time, positions, velocities, controls])
    }

    /// The one part that has `len` values and `behaves`.
    fn only(
        &self,
        what: &'static str,
        len: usize,
        behaves: impl Fn(&Self, Signature) -> Result<bool, Raised>,
    ) -> Result<Signature, Unexpected> {
        let mut found = Vec::new();
        for &(part, _) in self.sizes.iter().filter(|(_, size)| *size == len) {
            if behaves(self, part)? {
                found.push(part);
            }
        }
        match found[..] {
            [part] => Ok(part),
            _ => Err(Unexpected::Parts { what, found: found.len() }),
        }
    }

    /// It is 0 after a reset and grows by the time step.
    fn is_time(&self, part: Signature) -> Result<bool, Raised> {
        let mut data = self.data()?;
        for steps in 0..3 {
            if read(&data, part, 1)? != [f64::from(steps) * TIMESTEP] {
                return Ok(false);
            }
            data.step()?;
        }
        Ok(true)
    }

    /// It is what the model says, and stays where it is put.
    fn is_positions(&self, part: Signature) -> Result<bool, Raised> {
        let mut data = self.data()?;
        let mut there = read(&data, part, REST.len())?;
        if there != REST {
            return Ok(false);
        }
        there[0] = -4.0;
        there[7] = 0.5;
        data.set(part, &there)?;
        data.step()?;
        Ok(read(&data, part, REST.len())? == there)
    }

    /// Positions move by it.
    fn is_velocities(&self, part: Signature, positions: Signature) -> Result<bool, Raised> {
        let mut data = self.data()?;
        data.set(part, &[1.0, 2.0, -4.0, 0.0, 0.0, 0.0, 0.5])?;
        data.step()?;
        let mut expected = REST;
        for (i, v) in [(0, 1.0), (1, 2.0), (2, -4.0), (7, 0.5)] {
            expected[i] += TIMESTEP * v;
        }
        Ok(read(&data, positions, REST.len())? == expected)
    }

    /// Each value moves what its motor drives and nothing else.
    fn is_controls(&self, part: Signature, velocities: Signature) -> Result<bool, Raised> {
        for (motor, driven) in DRIVEN.into_iter().enumerate() {
            let mut data = self.data()?;
            let mut control = [0.0; DRIVEN.len()];
            control[motor] = 1.0 / 1024.0;
            data.set(part, &control)?;
            data.step()?;
            let moved = read(&data, velocities, NV)?;
            if !moved.iter().enumerate().all(|(i, v)| (i == driven) == (*v > 0.0) && (i == driven || *v == 0.0)) {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::io::Write as _;

    use super::*;
    use crate::search::Place;

    #[test]
    fn words_are_learned_from_warnings_that_go_on_with_the_index() {
        let said = |texts: &[&str]| texts.iter().map(ToString::to_string).collect::<Vec<_>>();
        for (texts, index, expected) in [
            (&["Nan in QPOS at DOF 3. Time = 0.0000."][..], 3, Some("Nan in QPOS at DOF ")),
            (&["something else", "7 contacts", "QACC 13"], 13, Some("QACC ")),
            (&["QACC 13"], 1, None),
            (&["Time = 3.3, DOF 5"], 5, None),
            (&["no number"], 0, None),
            (&["99999999999999999999999"], 9, None),
            (&[], 0, None),
        ] {
            assert_eq!(before(&said(texts), index), expected, "{texts:?}");
        }
    }

    #[test]
    fn a_warning_is_read_as_it_was_learned() {
        let diverged = ["q at ", "v at ", "a at "].map(String::from);
        let learned = Conventions { time: 1, positions: 2, velocities: 4, controls: 32, diverged };
        let read = |text| learned.diverged(text, 8);
        assert_eq!(["q at 3!", "v at 3. Time 1", "a at 0"].map(read), [Some(3), Some(11), Some(8)]);
        assert_eq!(["q at ", "q at x", " q at 3", "contacts 3", ""].map(read), [None; 5]);
        assert_eq!(read(&format!("a at {}", usize::MAX)), Some(usize::MAX));
    }

    /// What is learned where `say` is warned of bad values: 0, 1, 2 for positions, velocities, accelerations; the index; how
    /// many were bad before.
    fn learned(say: impl Fn(usize, usize, usize) -> Vec<String>) -> Result<[String; 3], Unexpected> {
        let before = Cell::new(0);
        let bad = |part: Signature, _, i: usize, _| {
            let (kind, index) = (part as usize, if part == 2 { DRIVEN[i] } else { i });
            Ok(say(kind, index, before.replace(before.get() + 1)))
        };
        words(bad, 0, 1, 2)
    }

    #[test]
    fn warnings_that_do_not_tell_what_is_bad_are_refused() {
        type Say = fn(usize, usize, usize) -> Vec<String>;
        let kinds = ["QPOS", "QVEL", "QACC"];
        let good = learned(|kind, i, _| vec![format!("bad {} at {i}, at 0.0", kinds[kind])]);
        assert_eq!(good, Ok(kinds.map(|kind| format!("bad {kind} at "))));
        let texts: [Say; 5] = [
            |_, _, _| vec![],
            |kind, _, _| vec![format!("kind {kind}x")],
            |kind, i, _| vec![format!("{} {}", ["p", "v", "a"][kind], i + 1)],
            |kind, i, n| vec![format!("{} of run {}: {i}", ["p", "v", "a"][kind], ["a", "b"][n % 2])],
            |_, i, _| vec![i.to_string()],
        ];
        for text in texts {
            assert!(matches!(learned(text), Err(Unexpected::Unclear { .. })));
        }
        assert_eq!(learned(|_, i, _| vec![format!("bad at {i}")]), Err(Unexpected::Alike));
    }

    /// The library the tests use, or `None` after a line that says so, as in `tests/common`.
    fn api() -> Option<Arc<Api>> {
        let named = std::env::var_os("SINDYNA_MUJOCO_VENV");
        let venv = named.clone().unwrap_or_else(|| concat!(env!("CARGO_MANIFEST_DIR"), "/../../.venv").into());
        match Place::VirtualEnvironment(venv.into()).libraries().remove(0) {
            (_, Ok(files)) => Some(Arc::new(Api::open(files.first()?).expect("it is a MuJoCo"))),
            (place, Err(reason)) => {
                assert!(named.is_none(), "{place}: {reason}");
                let line = "not run, as there is no MuJoCo (scripts/mujoco_install): probe::tests::parts\n";
                std::io::stderr().write_all(line.as_bytes()).expect("stderr takes a line");
                None
            }
        }
    }

    #[test]
    fn parts_that_are_missing_or_behave_alike_are_refused() {
        let Some(api) = api() else { return };
        let learned = Conventions::of(&api).expect("it behaves as expected");
        let probe = || {
            let model = compile_text(&api, MODEL).unwrap_or_else(|LoadError(e)| panic!("{e}"));
            Probe::new(model)
        };
        let Conventions { time, positions, velocities, controls, .. } = learned;
        for part in [time, positions, velocities, controls] {
            for found in [0, 2] {
                let mut probe = probe();
                let (of_part, others): (Vec<_>, Vec<_>) = probe.sizes.iter().copied().partition(|(p, _)| *p == part);
                probe.sizes = others.into_iter().chain(of_part.repeat(found)).collect();
                let refused = probe.parts().expect_err("not one part for each");
                assert!(matches!(refused, Unexpected::Parts { found: f, .. } if f == found), "{refused}");
            }
        }
        assert_eq!(probe().parts(), Ok([time, positions, velocities, controls]));
    }
}
