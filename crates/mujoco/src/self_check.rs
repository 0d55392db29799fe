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
