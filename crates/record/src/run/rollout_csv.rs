//! `rollout.csv`: the real data; `data.csv`: a log.

use std::fmt::Write as _;

use sindyna_core::{Channel, Dataset, Inverse, Spec};

use crate::RecordError;

/// A row per sample: trajectory, time t \[s\], observation, action, control held until the next row, reward of that
/// step. The last row of a rollout has no action; its fields are empty.
#[must_use]
pub fn rollout_csv(spec: &Spec, data: &Dataset) -> String {
    let mut text = String::from("trajectory,t");
    for channel in &spec.observation {
        let _ = write!(text, ",{}", channel.name);
    }
    let actions = spec.action_space.action_dim();
    for i in 0..actions {
        let _ = write!(text, ",action{}", if actions > 1 { i.to_string() } else { String::new() });
    }
    for channel in &spec.control {
        let _ = write!(text, ",{}", channel.name);
    }
    text.push_str(",reward\n");

    for (trajectory, rollout) in data.rollouts().enumerate() {
        let steps = rollout.rewards.len();
        for i in 0..=steps {
            let _ = write!(text, "{trajectory},{}", i as f64 * data.dt());
            // Rust prints the shortest decimal that reads back as the same float64.
            for value in rollout.observations.row(i) {
                let _ = write!(text, ",{value}");
            }
            if i < steps {
                for value in rollout.actions.row(i).iter().chain(rollout.controls.row(i)) {
                    let _ = write!(text, ",{value}");
                }
                let _ = write!(text, ",{}", rollout.rewards[i]);
            } else {
                text.extend(std::iter::repeat_n(',', actions + spec.control_dim() + 1));
            }
            text.push('\n');
        }
    }
    text
}

/// A log as it was understood: a row per sample with trajectory, time t \[s\] since its start (one of `times` for each trajectory, if its samples
/// are not evenly spaced), states, and control held until the next row; the last row
/// of a trajectory repeats the control before.
///
/// # Errors
/// [`RecordError::Unseen`] if a state follows from no observation, [`RecordError::Csv`] for what has no CSV.
pub fn log_csv(spec: &Spec, data: &Dataset, times: Option<&[Vec<f64>]>) -> Result<Vec<u8>, RecordError> {
    let inverse = Inverse::of(spec)?;
    let mut writer = csv::Writer::from_writer(Vec::new());
    let named = |channels: &[Channel]| channels.iter().map(|c| c.name.clone()).collect::<Vec<_>>();
    writer.write_record([vec!["trajectory".into(), "t".into()], named(&spec.state), named(&spec.control)].concat())?;
    for (trajectory, rollout) in data.rollouts().enumerate() {
        // A trajectory without a step has no control.
        let Some(last) = rollout.rewards.len().checked_sub(1) else { continue };
        let mut state = vec![0.0; spec.state_dim()];
        for (i, observation) in rollout.observations.rows().into_iter().enumerate() {
            let near = state.clone();
            inverse.state(&observation.to_vec(), &near, &mut state);
            let numbers = state.iter().chain(rollout.controls.row(i.min(last))).map(ToString::to_string);
            let own = times.and_then(|all| all.get(trajectory)?.get(i));
            let t = own.copied().unwrap_or(i as f64 * data.dt());
            writer.write_record([trajectory.to_string(), t.to_string()].into_iter().chain(numbers))?;
        }
    }
    Ok(writer.into_inner().map_err(|e| csv::Error::from(e.into_error()))?)
}
