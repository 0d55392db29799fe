//! Parameters of a robot whose joints' arrangement is known.

use sindyna_bodies::nalgebra::DMatrix;
use sindyna_bodies::{BodiesError, Calibration, Drive, Motion, Tree, calibrate};
use sindyna_core::{Kind, Spec};

use crate::logs::Log;

/// Why a log is none of a robot.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RobotError {
    /// Joints and positions are not as many.
    #[error(
        "the robot has {joints} joints, the log {positions} position{} with a rate",
        if *positions == 1 { "" } else { "s" }
    )]
    Positions {
        /// Joints of the robot.
        joints: usize,
        /// Positions in the log.
        positions: usize,
    },
    /// The names of inputs do not tell on which joints they act.
    #[error("{inputs} input{} for {drives} driven joint{}: which input acts on which joint is not known", if *inputs == 1 { "" } else { "s" }, if *drives == 1 { "" } else { "s" })]
    Inputs {
        /// Inputs of the log.
        inputs: usize,
        /// Joints of the robot that are driven.
        drives: usize,
    },
    /// Positions are shown by cosine and sine.
    #[error("angles that are shown by cosine and sine are not supported with a model of the robot")]
    Circles,
    /// The parameters cannot be identified.
    #[error(transparent)]
    Bodies(#[from] BodiesError),
}

/// A joint, and the columns that show it.
#[derive(Debug, Clone, PartialEq)]
pub struct Matched {
    /// The joint.
    pub joint: String,
    /// The column of its position.
    pub position: String,
    /// The column of its rate.
    pub rate: String,
    /// The columns of inputs that act on it.
    pub inputs: Vec<String>,
}

/// What a log tells of a robot.
#[derive(Debug, Clone)]
pub struct RobotFound {
    /// The parameters.
    pub calibration: Calibration,
    /// Which columns are those of which joint.
    pub joints: Vec<Matched>,
}

/// Identifies the parameters of the robot `tree` from a log of positions, rates and inputs of its joints. Columns are those of joints and `drives` with their names; where names do not tell, in
/// their order. `go_on` is asked now and then.
///
/// # Errors
/// [`RobotError`] if columns and joints do not fit each other, or the motions are too few.
pub fn robot(log: &Log, (tree, drives): (&Tree, &[Drive]), go_on: &dyn Fn() -> bool) -> Result<RobotFound, RobotError> {
    let (motions, joints) = motions(log, tree, drives)?;
    Ok(RobotFound { calibration: calibrate(tree, &motions, go_on)?, joints })
}

/// The motions of the robot `tree` in a log, and which columns are those of which joint.
///
/// # Errors
/// [`RobotError`] if columns and joints do not fit each other.
pub fn motions(log: &Log, tree: &Tree, drives: &[Drive]) -> Result<(Vec<Motion>, Vec<Matched>), RobotError> {
    let spec = &log.spec;
    if spec.observation.iter().any(|o| matches!(o.kind, Kind::CosOf(_) | Kind::SinOf(_))) {
        return Err(RobotError::Circles);
    }
    let names: Vec<&str> = tree.joints.iter().map(|j| j.name.as_str()).collect();
    let places = positions(spec, &names)?;
    let inputs: Vec<&str> = spec.control.iter().map(|c| c.name.as_str()).collect();
    let driven: Vec<&str> = drives.iter().map(|drive| drive.name.as_str()).collect();
    let of_joints: Vec<&str> = drives.iter().map(|drive| names[drive.joint]).collect();
    let is_named = [&driven, &of_joints].iter().any(|names| inputs.iter().any(|input| named(names, input).is_some()));
    let columns = match by_name(&driven, &inputs).or_else(|| by_name(&of_joints, &inputs)) {
        Some(columns) => columns,
        // The order counts where no name says otherwise.
        None if inputs.len() == drives.len() && !is_named => (0..inputs.len()).map(Some).collect(),
        None => return Err(RobotError::Inputs { inputs: inputs.len(), drives: drives.len() }),
    };
    let acting: Vec<(&Drive, usize)> = drives.iter().zip(columns).filter_map(|(drive, k)| Some((drive, k?))).collect();
    let force = |u: ndarray::ArrayView1<'_, f64>, i: usize| {
        acting.iter().filter(|(drive, _)| drive.joint == i).map(|(drive, k)| drive.gear * u[*k]).sum::<f64>()
    };
    let n = names.len();
    let motion = |(number, rollout): (usize, sindyna_core::Rollout<'_>)| {
        let (samples, steps) = (rollout.observations.nrows(), rollout.controls.nrows());
        let times = log.times.as_ref().and_then(|all| all.get(number)).cloned();
        let of_rate =
            |t: usize, i: usize| log.derivatives.as_ref().map_or(f64::NAN, |all| all[number][[t, places[i].1]]);
        Motion {
            times: times.unwrap_or_else(|| (0..samples).map(|t| t as f64 * spec.dt).collect()),
            positions: DMatrix::from_fn(samples, n, |t, i| rollout.observations[[t, places[i].0]]),
            rates: DMatrix::from_fn(samples, n, |t, i| rollout.observations[[t, places[i].1]]),
            forces: DMatrix::from_fn(steps, n, |t, i| force(rollout.controls.row(t), i)),
            accelerations: log.derivatives.is_some().then(|| DMatrix::from_fn(samples, n, of_rate)),
        }
    };
    let motions: Vec<Motion> = log.data.rollouts().enumerate().map(motion).collect();
    let matched = |(i, joint): (usize, &&str)| Matched {
        joint: (*joint).to_owned(),
        position: spec.state[places[i].0].name.clone(),
        rate: spec.state[places[i].1].name.clone(),
        inputs: acting.iter().filter(|(drive, _)| drive.joint == i).map(|(_, k)| inputs[*k].to_owned()).collect(),
    };
    Ok((motions, names.iter().enumerate().map(matched).collect()))
}

/// Of each joint the states that are its position and its rate.
fn positions(spec: &Spec, joints: &[&str]) -> Result<Vec<(usize, usize)>, RobotError> {
    let rate_of = |i: usize| (0..spec.state.len()).find(|&r| spec.state[r].kind == Kind::RateOf(i));
    let is_position = |i: &usize| !matches!(spec.state[*i].kind, Kind::RateOf(_));
    let all: Vec<(usize, usize)> =
        (0..spec.state.len()).filter(is_position).filter_map(|i| Some((i, rate_of(i)?))).collect();
    let names: Vec<&str> = all.iter().map(|(i, _)| spec.state[*i].name.as_str()).collect();
    if let Some(order) = by_name(joints, &names).and_then(|o| o.into_iter().collect::<Option<Vec<usize>>>()) {
        return Ok(order.into_iter().map(|at| all[at]).collect());
    }
    let is_named = names.iter().any(|name| named(joints, name).is_some());
    if all.len() == joints.len() && !is_named {
        Ok(all)
    } else {
        Err(RobotError::Positions { joints: joints.len(), positions: all.len() })
    }
}

/// Of each joint the column that has its name, if every column has that of a joint and no two of the same.
fn by_name(joints: &[&str], columns: &[&str]) -> Option<Vec<Option<usize>>> {
    if columns.is_empty() {
        return None;
    }
    let mut found = vec![None; joints.len()];
    for (at, column) in columns.iter().enumerate() {
        if found[named(joints, column)?].replace(at).is_some() {
            return None;
        }
    }
    Some(found)
}

/// The joint whose name `column` has, alone or among other words; of several that with the longest name, `None` if these are several.
fn named(joints: &[&str], column: &str) -> Option<usize> {
    let words = |name: &str| -> Vec<String> {
        let all = name.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
        all.map(str::to_lowercase).collect()
    };
    let column = words(column);
    let length = |joint: &str| {
        let joint = words(joint);
        (!joint.is_empty() && column.windows(joint.len()).any(|part| part == joint)).then_some(joint.len())
    };
    let lengths: Vec<Option<usize>> = joints.iter().map(|joint| length(joint)).collect();
    let longest = lengths.iter().flatten().max()?;
    let mut of = (0..joints.len()).filter(|&j| lengths[j] == Some(*longest));
    of.next().filter(|_| of.next().is_none())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_those_of_joints_by_their_names() {
        let joints = ["shoulder", "elbow", "wrist_1"];
        assert_eq!(by_name(&joints, &["elbow_torque", "tau.shoulder"]), Some(vec![Some(1), Some(0), None]));
        assert_eq!(by_name(&joints, &["wrist_1_effort"]), Some(vec![None, None, Some(0)]));
        assert_eq!(by_name(&joints, &["elbow_torque", "elbow_current"]), None);
        assert_eq!(by_name(&joints, &["tau1"]), None);
        assert_eq!(by_name(&["j1", "j2"], &["j1", "j2"]), Some(vec![Some(0), Some(1)]));
        let nested = ["base", "base_2", "base_2_x"];
        assert_eq!(by_name(&nested, &["q_base_2_x", "q_base", "q_base_2"]), Some(vec![Some(1), Some(2), Some(0)]));
    }
}
