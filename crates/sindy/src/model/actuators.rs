//! Models whose inputs act through first-order lags: what actuators deliver are states.

use sindyna_core::Scheme;

use super::parts::{Entry, Form, ModelParts};
use super::{Model, ModelError};
use crate::expr::Expr;
use crate::names::symbols;

/// Runge–Kutta steps of fourth order per time constant: their error is 1e-6 of what is left of the lag.
const STEPS: f64 = 8.0;

impl Model {
    /// The same model behind actuators: states called `names` (k) stand where its inputs do and follow these with the time constant `tau` \[s\], v' = (u − v)/τ.
    ///
    /// # Errors
    /// [`ModelError::Shape`] if it is not stepped by Runge–Kutta, or there are not as many names as inputs.
    pub fn with_actuators(&self, tau: f64, names: &[String]) -> Result<Self, ModelError> {
        let parts = self.parts().clone();
        let (n, k) = (parts.states.len(), parts.controls.len());
        let shape = |what: &'static str, expected: usize, got: usize| ModelError::Shape { what, expected, got };
        let Form::Continuous(Scheme::Rk4 { substeps }) = parts.form else {
            return Err(shape("schemes of a model with actuators", 1, 0));
        };
        if names.len() != k || parts.readings.is_some() {
            return Err(shape("names of actuators", k, names.len()));
        }
        let fine = (STEPS * parts.dt / tau).ceil() as usize;
        let states: Vec<String> = parts.states.iter().chain(names).cloned().collect();
        let all: Vec<String> = states.iter().chain(&parts.controls).cloned().collect();
        // Variables are states, then inputs: those of the inputs are the actuators' now.
        let written = |expr: &Expr| expr.display(&symbols(&all)).to_string();
        let mut terms: Vec<String> = self.terms().iter().map(written).collect();
        let mut equations = parts.equations;
        for actuator in 0..k {
            let mut entry = |variable: usize, coefficient: f64| {
                terms.push(written(&Expr::Variable(variable)));
                Entry::new(terms.len() - 1, coefficient)
            };
            equations.push(vec![entry(n + k + actuator, 1.0 / tau), entry(n + actuator, -1.0 / tau)]);
        }
        Self::new(ModelParts {
            form: Form::Continuous(Scheme::Rk4 { substeps: substeps.max(fine) }),
            states,
            terms,
            equations,
            kinematic: [parts.kinematic, vec![false; k]].concat(),
            offsets: [parts.offsets, vec![0.0; k]].concat(),
            n_features: parts.n_features + 2 * k,
            ..parts
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Inputs;
    use ndarray::Array2;

    /// x' = −x + 2 F behind an actuator under a step of F: v = 1 − e^(−t/τ), x follows from both.
    #[test]
    fn what_is_delivered_follows_what_is_told() {
        let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        let model = Model::new(ModelParts {
            states: names(&["x"]),
            controls: names(&["F"]),
            form: Form::Continuous(Scheme::Rk4 { substeps: 1 }),
            dt: 0.1,
            readings: None,
            terms: names(&["x", "F"]),
            equations: vec![vec![Entry::new(0, -1.0), Entry::new(1, 2.0)]],
            kinematic: vec![false],
            offsets: vec![0.0],
            n_features: 2,
        })
        .expect("a model");
        let tau = 0.25;
        let behind = model.with_actuators(tau, &names(&["F_delivered"])).expect("continuous");
        assert_eq!(behind.equations(), ["x\u{307} = −x + 2 F_delivered", "dF_delivered/dt = −4 F_delivered + 4 F"]);
        let u = Array2::ones((20, 1));
        let states = behind.simulate(&[0.0, 0.0], Inputs::from(u.view())).expect("simulated");
        for (t, row) in states.rows().into_iter().enumerate() {
            let t = 0.1 * t as f64;
            let (slow, fast) = ((-t).exp(), (-t / tau).exp());
            let x = 2.0 * (1.0 - slow) - 2.0 / (1.0 - 1.0 / tau) * (fast - slow);
            assert!((row[1] - (1.0 - fast)).abs() < 1e-6 && (row[0] - x).abs() < 1e-6, "{row} {x}");
        }
        assert!(model.with_actuators(tau, &[]).is_err());
    }
}
