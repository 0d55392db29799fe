//! Inputs that act through first-order lags: what actuators deliver are states.

use sindyna_core::{Dataset, Spec};

/// Names (k) of what actuators of the controls of `spec` deliver, which no state or control has.
pub(super) fn names(spec: &Spec) -> Vec<String> {
    let is_taken = |name: &String| spec.state.iter().chain(&spec.control).any(|channel| channel.name == *name);
    let free = |control: &sindyna_core::Channel| {
        let mut name = format!("{}_delivered", control.name);
        while is_taken(&name) {
            name.push('_');
        }
        name
    };
    spec.control.iter().map(free).collect()
}

/// `data` of which the controls are what actuators with the time constant `tau` \[s\] deliver when each step begins, v, with these as last states (n + k) and the controls that they follow: over a step
/// v⁺ = u + (v − u) exp(−Δt/τ). The last step of each rollout is left out: what follows it is not known.
///
/// # Errors
/// Whatever is wrong with a value.
pub(super) fn commanded(data: &Dataset, tau: f64) -> Result<Dataset, sindyna_core::DatasetError> {
    let k = data.control_dim();
    let mut all = Dataset::new(data.observation_dim() + k, k, k, data.dt());
    let left = (-data.dt() / tau).exp();
    for rollout in data.rollouts() {
        let delivered: Vec<Vec<f64>> = rollout.controls.rows().into_iter().map(|v| v.to_vec()).collect();
        let seen = |t: usize| [&rollout.observations.row(t).to_vec()[..], &delivered[t]].concat();
        for t in 0..delivered.len() {
            let Some(before) = t.checked_sub(1) else {
                all.begin(&seen(t))?;
                continue;
            };
            let of = |(v, next): (&f64, &f64)| (next - v * left) / (1.0 - left);
            let u: Vec<f64> = delivered[before].iter().zip(&delivered[t]).map(of).collect();
            all.push(&u, &u, 0.0, &seen(t))?;
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_follow_from_what_was_delivered() {
        let (tau, dt) = (0.3, 0.1);
        let mut data = Dataset::new(1, 1, 1, dt);
        data.begin(&[7.0]).expect("begun");
        let (mut v, commands) = (0.2, [1.0, -1.0, 0.5, 0.5, 2.0]);
        for (t, u) in commands.into_iter().enumerate() {
            data.push(&[v], &[v], 0.0, &[t as f64]).expect("pushed");
            v = u + (v - u) * f64::exp(-dt / tau);
        }
        let told = commanded(&data, tau).expect("finite");
        let rollout = told.rollouts().next().expect("one");
        assert_eq!((rollout.observations.dim(), rollout.observations[[0, 1]]), ((5, 2), 0.2));
        assert!(rollout.controls.iter().zip(commands).all(|(u, truth)| (u - truth).abs() < 1e-12), "{told:?}");
    }
}
