//! A table of offsets and a library, compared.

use std::sync::Arc;

use crate::ffi::{Api, DataHandle, LoadError, ModelHandle, Part, take_warning};

/// A free body with a hinged one on it: nq = 8, nv = 7, nu = 2, and nothing else a state could hold has these lengths.
const MODEL: &str = r#"<mujoco>
  <option timestep="0.00390625" gravity="0 0 0"/>
  <worldbody>
    <body>
      <freejoint/>
      <geom size="0.1"/>
      <body pos="0 0 1">
        <joint name="hinge"/>
        <geom size="0.1"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <motor joint="hinge"/>
    <motor joint="hinge"/>
  </actuator>
</mujoco>"#;
const TIMESTEP: f64 = 0.00390625;
const SIZES: [usize; 3] = [8, 7, 2];

/// Says what the table has wrong about the library, if anything.
///
/// Sizes are compared before arrays are touched, and addresses before they are followed.
pub(crate) fn check(api: &Arc<Api>) -> Result<(), String> {
    let model = ModelHandle::from_xml(api, MODEL).map_err(|LoadError(message)| message)?;
    demand(model.sizes() == SIZES, "lengths of the state")?;
    demand(model.counts() == SIZES.map(|n| n as i64), "nq, nv and nu")?;
    demand(model.timestep().to_bits() == TIMESTEP.to_bits(), "the time step")?;

    let mut data = DataHandle::new(&Arc::new(model)).map_err(|raised| raised.0)?;
    let written: Vec<f64> = (1..=15).map(f64::from).collect();
    data.set(Part::State, &written).map_err(|raised| raised.0)?;
    demand(data.at_offsets().as_ref() == Some(&written), "qpos and qvel")?;

    for bad in [7, 10] {
        data.reset().map_err(|raised| raised.0)?;
        let mut state = vec![0.0; 15];
        data.get(Part::State, &mut state).map_err(|raised| raised.0)?;
        demand(matches!(data.step(), Ok(None)), "the statistics of warnings")?;
        state[bad] = f64::NAN;
        data.set(Part::State, &state).map_err(|raised| raised.0)?;
        demand(matches!(data.step(), Ok(Some(index)) if index == bad), "the statistics of warnings")?;
    }
    take_warning();
    Ok(())
}

fn demand(met: bool, what: &str) -> Result<(), String> {
    if met { Ok(()) } else { Err(format!("the table of offsets is wrong about {what}")) }
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use super::*;
    use crate::layout::Layout;
    use crate::search::Place;

    /// The library the tests use, or `None` after a line that says so, as in `tests/common`.
    fn api() -> Option<Api> {
        let named = std::env::var_os("SINDYNA_MUJOCO_VENV");
        let venv = named.clone().unwrap_or_else(|| concat!(env!("CARGO_MANIFEST_DIR"), "/../../.venv").into());
        match Place::VirtualEnvironment(venv.into()).libraries().remove(0) {
            (_, Ok(files)) => Some(Api::open(files.first()?).expect("it is a MuJoCo we know")),
            (place, Err(reason)) => {
                assert!(named.is_none(), "{place}: {reason}");
                let line = "not run, as there is no MuJoCo (scripts/mujoco_install): self_check::tests\n";
                std::io::stderr().write_all(line.as_bytes()).expect("stderr takes a line");
                None
            }
        }
    }

    #[test]
    fn a_table_that_is_wrong_in_one_place_is_refused() {
        type Tamper = fn(&mut Layout);
        let tampers: [(&str, Tamper); 10] = [
            ("lengths", |l| l.state_qpos = l.state_qvel),
            ("lengths", |l| l.state_ctrl = 1 << 3),
            ("invalid", |l| l.state_ctrl = 1 << 30),
            ("nq, nv and nu", |l| std::mem::swap(&mut l.nq, &mut l.nv)),
            ("nq, nv and nu", |l| l.nu.offset = l.timestep.offset),
            ("time step", |l| l.timestep.offset += 8),
            ("qpos and qvel", |l| std::mem::swap(&mut l.qpos, &mut l.qvel)),
            ("qpos and qvel", |l| l.qvel.offset = 0),
            ("warnings", |l| l.bad_qpos = l.bad_qacc),
            ("warnings", |l| l.warnings.offset -= 4),
        ];
        for (i, (words, tamper)) in tampers.into_iter().enumerate() {
            let Some(mut api) = api() else { return };
            tamper(&mut api.layout);
            let refused = check(&Arc::new(api)).expect_err(words);
            assert!(refused.to_lowercase().contains(words), "{i}: {refused}");
        }
        let Some(api) = api() else { return };
        check(&Arc::new(api)).expect("the table itself is right");
    }
}
