//! What in a log is likely to be why no equations were found in it.

use ndarray::ArrayView1;
use sindyna_core::number::significant;
use sindyna_core::{Channel, Rollout};

use crate::Log;

/// Magnitudes and seconds a step whose products still are numbers.
const SANE: std::ops::RangeInclusive<f64> = 1e-30..=1e30;

impl Log {
    /// What is likely to be wrong with the data, and what to do about it.
    #[must_use]
    pub fn doubts(&self) -> Option<String> {
        let found = self.of(&self.spec.observation, |rollout, i| rollout.observations.column(i).to_owned());
        let done = self.of(&self.spec.control, |rollout, i| rollout.controls.column(i).to_owned());
        let mut doubts: Vec<String> = found.chain(done).flatten().collect();
        if !SANE.contains(&self.spec.dt) {
            doubts
                .push(format!("the sampling interval is {} s: use another unit of time", significant(self.spec.dt, 3)));
        }
        (!doubts.is_empty()).then(|| doubts.join("; "))
    }

    /// The doubt about each of `channels`, whose values in a rollout are `values`.
    fn of<'a>(
        &'a self,
        channels: &'a [Channel],
        values: impl Fn(&Rollout<'_>, usize) -> ndarray::Array1<f64> + 'a,
    ) -> impl Iterator<Item = Option<String>> + 'a {
        channels.iter().enumerate().map(move |(i, channel)| {
            let all: Vec<f64> = self.data.rollouts().flat_map(|rollout| values(&rollout, i).to_vec()).collect();
            doubt(&channel.name, ArrayView1::from(&all))
        })
    }
}

fn doubt(name: &str, values: ArrayView1<'_, f64>) -> Option<String> {
    let first = *values.first()?;
    if values.iter().all(|value| value.to_bits() == first.to_bits()) {
        return Some(format!("`{name}` is {} in every row: leave this column out", significant(first, 3)));
    }
    let reach = values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    (!SANE.contains(&reach)).then(|| format!("`{name}` reaches {}: use another unit", significant(reach, 3)))
}
