//! What inputs do between samples.

use serde::{Deserialize, Serialize};

/// Behaviour of the inputs between two samples, as `InterSample` of MATLAB's `iddata`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InterSample {
    /// Zero-order hold: constant from each sample to the next.
    #[default]
    Zoh,
    /// First-order hold: linear from each sample to the next.
    Foh,
    /// Band-limited: smooth. Values are those whose straight lines have the mean over every step of the cubic through the four samples about it.
    Bl,
    /// Constant, and from a part of each step on (0 to 1) that of the next sample: zero-order hold with a delay of a part of a step.
    Late(f64),
    /// Those of a first-order lag with this time constant \[s\]: from each sample on they approach a constant by which they become those of the next one.
    Lag(f64),
}

impl InterSample {
    /// Whether inputs stay the same over each step.
    #[must_use]
    pub fn is_held(self) -> bool {
        self == Self::Zoh
    }

    /// The part of each step after which inputs become those of the next sample at once; `None` if they do not.
    #[must_use]
    pub fn switch(self) -> Option<f64> {
        if let Self::Late(part) = self { Some(part) } else { None }
    }

    /// The part of their change over a step of `dt` \[s\] that inputs have after the part `over` of it: (1 − exp(−over·dt/τ)) / (1 − exp(−dt/τ)) for a lag τ.
    #[must_use]
    pub fn share(self, over: f64, dt: f64) -> f64 {
        match self {
            Self::Zoh => 0.0,
            Self::Foh | Self::Bl => over,
            Self::Late(part) => f64::from(over >= part),
            Self::Lag(tau) => (-over * dt / tau).exp_m1() / (-dt / tau).exp_m1(),
        }
    }

    /// The same, averaged over the step.
    #[must_use]
    pub fn mean_share(self, dt: f64) -> f64 {
        match self {
            Self::Zoh => 0.0,
            Self::Foh | Self::Bl => 0.5,
            Self::Late(part) => 1.0 - part,
            Self::Lag(tau) => -1.0 / (-dt / tau).exp_m1() - tau / dt,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_of_a_lag_follow_its_solution() {
        // v' = (1 - v)/tau from v(0) = 0.3, sampled at 0 and dt.
        let (tau, dt): (f64, f64) = (0.2, 0.05);
        let v = |t: f64| 1.0 - 0.7 * (-t / tau).exp();
        let (lag, mean) =
            (InterSample::Lag(tau), (0..1000).map(|i| v((f64::from(i) + 0.5) * dt / 1e3) / 1e3).sum::<f64>());
        for over in [0.0, 0.3, 1.0] {
            let between = v(0.0) + lag.share(over, dt) * (v(dt) - v(0.0));
            assert!((between - v(over * dt)).abs() < 1e-15, "{between}");
        }
        assert!((v(0.0) + lag.mean_share(dt) * (v(dt) - v(0.0)) - mean).abs() < 1e-8);
        assert!(
            (InterSample::Lag(1e6).share(0.3, dt) - InterSample::Foh.share(0.3, dt)).abs() < 1e-7,
            "a slow one is linear"
        );
    }
}
