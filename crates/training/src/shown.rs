//! What identification is given of a system: observed values that show a state, and none that was computed from several.

use std::borrow::Cow;

use ndarray::s;
use sindyna_core::{Channel, Dataset, FitError, Kind, Spec};

/// `spec` without observed values that were computed; these stand after all others.
pub(crate) fn shown(spec: &Spec) -> Spec {
    let shows = |o: &&Channel| {
        matches!(o.kind, Kind::CosOf(_) | Kind::SinOf(_)) || spec.state.iter().any(|state| state.name == o.name)
    };
    Spec { observation: spec.observation.iter().filter(shows).cloned().collect(), ..spec.clone() }
}

/// `data` with the first `m` observed values.
pub(crate) fn shown_in(data: &Dataset, m: usize) -> Result<Cow<'_, Dataset>, FitError> {
    if data.observation_dim() <= m {
        return Ok(Cow::Borrowed(data));
    }
    let broken = |e: sindyna_core::DatasetError| FitError::Regression { reason: e.to_string() };
    let actions = data.rollouts().next().map_or(data.control_dim(), |rollout| rollout.actions.ncols());
    let mut kept = Dataset::new(m, data.control_dim(), actions, data.dt()).with_intersample(data.intersample());
    for rollout in data.rollouts() {
        let observations = rollout.observations.slice(s![.., ..m]);
        for (i, o) in observations.rows().into_iter().enumerate() {
            let Some(before) = i.checked_sub(1) else {
                kept.begin(&o.to_vec()).map_err(broken)?;
                continue;
            };
            let (u, action) = (rollout.controls.row(before).to_vec(), rollout.actions.row(before).to_vec());
            kept.push(&action, &u, rollout.rewards[before], &o.to_vec()).map_err(broken)?;
        }
        kept.finish(rollout.end);
    }
    Ok(Cow::Owned(kept))
}
