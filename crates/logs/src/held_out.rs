//! The end of a log, kept apart to judge by.

use ndarray::{Array2, s};
use sindyna_core::{Dataset, DatasetError, Rollout};

use crate::Log;

/// Trajectories of a log, and when their samples were taken.
#[derive(Debug, Clone, PartialEq)]
pub struct Samples {
    /// The trajectories.
    pub data: Dataset,
    /// As [`Log::times`].
    pub times: Option<Vec<Vec<f64>>>,
    /// As [`Log::derivatives`].
    pub derivatives: Option<Vec<Array2<f64>>>,
}

impl Samples {
    /// None of them.
    fn empty(&self) -> Self {
        let data = &self.data;
        let (m, k) = (data.observation_dim(), data.control_dim());
        Self {
            data: Dataset::new(m, k, k, data.dt()).with_intersample(data.intersample()),
            times: self.times.is_some().then(Vec::new),
            derivatives: self.derivatives.is_some().then(Vec::new),
        }
    }

    /// The first `steps` of them, and the rest.
    ///
    /// # Errors
    /// [`DatasetError`] if a row is not finite.
    pub fn split(&self, steps: usize) -> Result<(Self, Self), DatasetError> {
        let (mut first, mut last, mut begun) = (self.empty(), self.empty(), 0);
        for (number, rollout) in self.data.rollouts().enumerate() {
            let times = self.times.as_ref().and_then(|all| all.get(number)).map(Vec::as_slice);
            let derivatives = self.derivatives.as_ref().and_then(|all| all.get(number));
            let length = rollout.controls.nrows();
            let cut = steps.saturating_sub(begun).min(length);
            first.copy(&rollout, (times, derivatives), 0, cut)?;
            last.copy(&rollout, (times, derivatives), cut, length)?;
            begun += length;
        }
        Ok((first, last))
    }

    /// The first `steps` of them.
    #[must_use]
    pub fn first(&self, steps: usize) -> Self {
        let data = self.data.first(steps);
        let cut = |all: &Vec<Vec<f64>>| {
            data.rollouts().zip(all).map(|(rollout, times)| times[..=rollout.controls.nrows()].to_vec()).collect()
        };
        let rows = |all: &Vec<Array2<f64>>| {
            data.rollouts()
                .zip(all)
                .map(|(rollout, of)| of.slice(s![..=rollout.controls.nrows(), ..]).to_owned())
                .collect()
        };
        Self { times: self.times.as_ref().map(cut), derivatives: self.derivatives.as_ref().map(rows), data }
    }

    /// Appends the steps `from` to `to` of a rollout, that one excluded.
    fn copy(
        &mut self,
        rollout: &Rollout<'_>,
        (times, derivatives): (Option<&[f64]>, Option<&Array2<f64>>),
        from: usize,
        to: usize,
    ) -> Result<(), DatasetError> {
        if from == to {
            return Ok(());
        }
        self.data.begin(&rollout.observations.row(from).to_vec())?;
        for t in from..to {
            let (u, next) = (rollout.controls.row(t).to_vec(), rollout.observations.row(t + 1).to_vec());
            self.data.push(&u, &u, 0.0, &next)?;
        }
        if let Some((all, times)) = self.times.as_mut().zip(times) {
            all.push(times[from..=to].iter().map(|t| t - times[from]).collect());
        }
        if let Some((all, of)) = self.derivatives.as_mut().zip(derivatives) {
            all.push(of.slice(s![from..=to, ..]).to_owned());
        }
        Ok(())
    }
}

impl Log {
    /// All its samples.
    #[must_use]
    pub fn samples(&self) -> Samples {
        Samples { data: self.data.clone(), times: self.times.clone(), derivatives: self.derivatives.clone() }
    }
}

/// Splits `log` in time: all but the last `share` (0 to 1) of its steps, and these.
///
/// # Errors
/// [`DatasetError`] if a row is not finite.
pub fn held_out(log: &Log, share: f64) -> Result<(Samples, Samples), DatasetError> {
    let total = log.data.n_steps();
    log.samples().split(total - (share * total as f64).round() as usize)
}
