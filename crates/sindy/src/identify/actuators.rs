//! What was identified of a system whose inputs act through first-order lags, with what actuators deliver as states.

use super::report::{EquationReport, Identified, Report};

impl Identified {
    /// The same with states called `names` (k) where inputs stand, which follow these with the time constant `tau` \[s\], v' = (u − v)/τ: what was identified from inputs behind a lag. `None` if it is
    /// not stepped by Runge–Kutta.
    #[must_use]
    pub fn with_actuators(self, tau: f64, names: &[String]) -> Option<Self> {
        let model = self.model.with_actuators(tau, names).ok()?;
        let report = of_actuators(self.report, self.model.controls(), (tau, names));
        Some(Self {
            models: self.models.map(|models| models.with_actuators((tau, names.to_vec()), &model)),
            model,
            report,
        })
    }
}

/// `report` with the equations of such actuators of `inputs`, which were not fitted.
fn of_actuators(mut report: Report, inputs: &[String], (tau, names): (f64, &[String])) -> Report {
    for text in &mut report.features {
        *text = inputs.iter().zip(names).fold(std::mem::take(text), |text, (input, name)| renamed(&text, input, name));
    }
    for (input, name) in inputs.iter().zip(names) {
        let first = report.features.len();
        report.features.extend([input.clone(), name.clone()]);
        report.equations.push(EquationReport {
            state: name.clone(),
            residual: 0.0,
            floor: 0.0,
            reached_floor: true,
            doubt: None,
            proved: true,
            support: vec![first, first + 1],
            coefficients: vec![1.0 / tau, -1.0 / tau],
            n_known: 2,
            standard_errors: vec![0.0; 2],
            parameters: Vec::new(),
            path: Vec::new(),
            equally_good: Vec::new(),
        });
        if !report.noise_deviations.is_empty() {
            report.noise_deviations.push(0.0);
            report.noise_growing.push(0.0);
            report.fit.push(1.0);
        }
    }
    report
}

/// `text` with the name `to` where the name `from` stands.
fn renamed(text: &str, from: &str, to: &str) -> String {
    let is_of_name = |c: char| c.is_alphabetic() || c.is_ascii_digit() || c == '_';
    let (mut told, mut rest) = (String::new(), text);
    while let Some(at) = rest.find(from) {
        let (before, after) = (&rest[..at], &rest[at + from.len()..]);
        let is_part = before.ends_with(is_of_name) || after.starts_with(is_of_name);
        told += before;
        told += if is_part { from } else { to };
        rest = after;
    }
    told + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_replaced_where_they_stand_alone() {
        for (text, expected) in [("F²·sin x", "F_d²·sin x"), ("exp F·F2·aF·F_", "exp F_d·F2·aF·F_"), ("x", "x")]
        {
            assert_eq!(renamed(text, "F", "F_d"), expected);
        }
    }
}
