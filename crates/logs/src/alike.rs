//! Another log of the same system, read as this one was.

use std::path::Path;

use sindyna_core::{Channel, Dataset};

use crate::{Log, LogError, LogOptions};

/// Part of a sampling interval by which that of another log may differ and still be the same.
const SAME: f64 = 2e-3;

impl Log {
    /// The logs at `paths` as trajectories of the system of this one: their columns are what was decided of its columns. Where they were sampled
    /// at another interval, each sample has its time.
    ///
    /// # Errors
    /// [`LogError`] if they cannot be read, or a column is missing or in another unit.
    pub fn another<P: AsRef<Path>>(&self, paths: &[P]) -> Result<Self, LogError> {
        // What is believed of errors was told by this log.
        let options = LogOptions { noise: Vec::new(), ..self.decided.clone() };
        let other = Self::read_all(paths, &options)?;
        let channels =
            |log: &Self| log.spec.observation.iter().chain(&log.spec.control).cloned().collect::<Vec<Channel>>();
        for (own, read) in channels(self).into_iter().zip(channels(&other)) {
            if own.unit != read.unit {
                let path = paths.first().map_or_else(Default::default, |path| path.as_ref().to_owned());
                return Err(LogError::OtherUnit {
                    path,
                    column: own.name,
                    unit: read.unit,
                    first: self.spec.name.clone().into(),
                    expected: own.unit,
                });
            }
        }
        let same = (other.spec.dt - self.spec.dt).abs() <= SAME * self.spec.dt;
        let even = |rows: usize| (0..rows).map(|i| i as f64 * other.spec.dt).collect::<Vec<f64>>();
        let times = match &other.times {
            None if self.times.is_none() && same => None,
            None => Some(other.data.rollouts().map(|r| even(r.observations.nrows())).collect()),
            Some(times) => Some(times.clone()),
        };
        Ok(Self { spec: self.spec.clone(), data: every(&other.data, self.spec.dt)?, times, ..other })
    }
}

/// `data` with a step every `dt` \[s\].
fn every(data: &Dataset, dt: f64) -> Result<Dataset, LogError> {
    let mut all = Dataset::new(data.observation_dim(), data.control_dim(), data.control_dim(), dt);
    for rollout in data.rollouts() {
        all.begin(&rollout.observations.row(0).to_vec())?;
        for (t, u) in rollout.controls.rows().into_iter().enumerate() {
            all.push(&u.to_vec(), &u.to_vec(), 0.0, &rollout.observations.row(t + 1).to_vec())?;
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use crate::{Log, LogOptions, Note};
    use sindyna_core::Kind;

    #[test]
    fn another_log_is_read_as_the_first_and_at_its_own_times() {
        let text = |header: &str, dt: f64, rows: usize| {
            let row = |i: usize| {
                let t = dt * i as f64;
                format!("{t},{},{},1\n", 30.0 * t.sin(), 30.0 * t.cos())
            };
            header.to_owned() + "\n" + &(0..rows).map(row).collect::<String>()
        };
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("a.csv"), text("t,th [deg],w [deg/s],u", 0.1, 80)).unwrap();
        std::fs::write(path("b.csv"), text("time,th [deg],w [deg/s],u", 0.05, 4)).unwrap();
        std::fs::write(path("c.csv"), text("t,th [rad],w,u", 0.05, 40)).unwrap();
        let log = Log::read(path("a.csv"), &LogOptions::default()).unwrap();
        let other = log.another(&[path("b.csv")]).unwrap();
        // Four rows alone would not show that one is the rate of the other.
        assert_eq!(other.spec.state[1].kind, Kind::RateOf(0));
        assert!(other.notes.iter().any(|n| matches!(n, Note::Radians { .. })));
        assert_eq!((other.data.dt(), other.times.as_ref().unwrap()[0][2]), (0.1, 0.1));
        assert!(log.another(&[path("a.csv")]).unwrap().times.is_none());
        let failure = log.another(&[path("c.csv")]).unwrap_err().to_string();
        assert!(failure.contains("c.csv: column `w` is in ``, in ") || failure.contains("`w`"), "{failure}");
    }
}
