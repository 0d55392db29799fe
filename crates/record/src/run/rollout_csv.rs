//! `rollout.csv`: the real data.

use std::fmt::Write as _;

use sindyna_core::{Dataset, Spec};

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
