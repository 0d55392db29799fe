//! The end of a log, kept apart to judge by.

use sindyna_core::{Dataset, DatasetError, Rollout};

/// Splits `data` in time: all but the last `share` (0 to 1) of its steps, and these.
///
/// # Errors
/// [`DatasetError`] if a row is not finite.
pub fn held_out(data: &Dataset, share: f64) -> Result<(Dataset, Dataset), DatasetError> {
    let total = data.n_steps();
    let kept = total - (share * total as f64).round() as usize;
    let empty = || Dataset::new(data.observation_dim(), data.control_dim(), data.control_dim(), data.dt());
    let (mut first, mut last, mut begun) = (empty(), empty(), 0);
    for rollout in data.rollouts() {
        let steps = rollout.controls.nrows();
        let cut = kept.saturating_sub(begun).min(steps);
        copy(&rollout, 0, cut, &mut first)?;
        copy(&rollout, cut, steps, &mut last)?;
        begun += steps;
    }
    Ok((first, last))
}

/// Appends the steps `from` to `to` of a rollout, that one excluded.
fn copy(rollout: &Rollout<'_>, from: usize, to: usize, data: &mut Dataset) -> Result<(), DatasetError> {
    if from == to {
        return Ok(());
    }
    data.begin(&rollout.observations.row(from).to_vec())?;
    for t in from..to {
        let (u, next) = (rollout.controls.row(t).to_vec(), rollout.observations.row(t + 1).to_vec());
        data.push(&u, &u, 0.0, &next)?;
    }
    Ok(())
}
