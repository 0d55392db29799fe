//! What was identified, in lines people read.

use std::fmt;

use sindyna_core::number::{coefficient, decimals, significant};

use super::report::Identified;

impl fmt::Display for Identified {
    /// The equations, then per equation its coefficients with their standard errors and what speaks against it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for equation in self.model.equations() {
            writeln!(f, "{equation}")?;
        }
        for warning in &self.report.warnings {
            writeln!(f, "warning: {warning}")?;
        }
        for equation in &self.report.equations {
            if equation.standard_errors.is_empty() {
                continue;
            }
            writeln!(f, "\n{}", equation.state)?;
            let rows = equation.support.iter().zip(&equation.coefficients).zip(&equation.standard_errors);
            for (at, ((&term, &value), error)) in rows.enumerate() {
                let name = &self.report.features[term];
                match at + equation.n_known < equation.support.len() {
                    true => writeln!(f, "  {name:<24} {:>12} ± {}", coefficient(value), significant(*error, 2))?,
                    false => writeln!(f, "  {name:<24} {:>12}, as given", coefficient(value))?,
                }
            }
            for parameter in &equation.parameters {
                let name = format!("in {}", self.report.features[parameter.term]);
                writeln!(
                    f,
                    "  {name:<24} {:>12} ± {}",
                    coefficient(parameter.value),
                    significant(parameter.standard_error, 2)
                )?;
            }
            match equation.doubt {
                None if equation.reached_floor => writeln!(f, "  adequate")?,
                None => writeln!(f, "  an approximation")?,
                Some(doubt) => writeln!(f, "  not adequate: {doubt}")?,
            }
            for other in &equation.equally_good {
                let terms: Vec<&str> = other.iter().map(|&j| self.report.features[j].as_str()).collect();
                writeln!(f, "  equally good set of terms: {}", terms.join(", "))?;
            }
        }
        let noise = self.report.noise_deviations.iter().zip(&self.report.fit);
        for (i, (name, (sigma, fit))) in self.model.states().iter().zip(noise).enumerate() {
            match self.report.unmeasured.contains(&i) {
                true => writeln!(f, "{name}: not measured")?,
                false => writeln!(f, "{name}: noise {}, fit {} %", significant(*sigma, 3), decimals(100.0 * fit, 1))?,
            }
        }
        Ok(())
    }
}
