//! One identification, held against the truth.

use cpu_time::ThreadTime;
use serde::{Deserialize, Serialize};
use sindyna_core::Dataset;
use sindyna_sindy::{Identified, Identifier, Model};

use sindyna_truth::{Deviation, Structure, Truth, compare, structure};

/// Relative accuracy to which true coefficients are computed from true rates: about 1e-13, and some room.
const KNOWN: f64 = 1e-11;

/// How far rates are from the truth; none where that is not finite, or where there is no model.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Off {
    /// Largest difference on any point.
    pub worst: Option<f64>,
    /// Root of the mean of squared differences.
    pub rms: Option<f64>,
}

impl From<Deviation> for Off {
    fn from(deviation: Deviation) -> Self {
        let finite = |value: f64| Some(value).filter(|v| v.is_finite());
        Self { worst: finite(deviation.worst), rms: finite(deviation.rms) }
    }
}

/// What an identification with the defaults is worth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Processor time of the fit, which uses one thread \[s\].
    pub seconds: f64,
    /// How far the rates are from the truth over the box.
    pub deviation: Off,
    /// Whether the report says of every equation that nothing is left to explain.
    pub explained: bool,
    /// Whether every equation has the true terms and no other.
    pub true_terms: bool,
    /// Whether true terms are among the sets the report shows for every equation.
    pub true_terms_shown: bool,
    /// |estimate/truth − 1| of every coefficient; empty without the true terms.
    pub relative_errors: Vec<f64>,
    /// (estimate − truth)/(reported standard error) of the coefficients; empty without the true terms, and without those
    /// whose standard error is below what is known of the truth.
    pub standardised_errors: Vec<f64>,
    /// The equations as people read them.
    pub equations: Vec<String>,
}

/// Identifies `data` with `identifier` and measures what was found; the model comes too.
///
/// # Errors
/// Why nothing was identified.
pub fn measure(truth: &Truth, identifier: &Identifier, data: &Dataset) -> anyhow::Result<(Measured, Model)> {
    let start = ThreadTime::now();
    let found = identifier.identify(data)?;
    let seconds = start.elapsed().as_secs_f64();
    let (mut relative_errors, mut standardised_errors) = (Vec::new(), Vec::new());
    let structure = structure(truth, &found.model);
    if let Structure::True { coefficients } = &structure {
        let mut coefficients = coefficients.iter();
        for (i, _) in truth.judged() {
            let report = &found.report.equations[i];
            let errors = report.standard_errors.iter().copied().chain(std::iter::repeat(f64::INFINITY));
            for ((estimate, standard), truth) in report.coefficients.iter().zip(errors).zip(&mut coefficients) {
                relative_errors.push((estimate / truth - 1.0).abs());
                if standard.is_finite() && standard > KNOWN * truth.abs() {
                    standardised_errors.push((estimate - truth) / standard);
                }
            }
        }
    }
    let true_terms = matches!(structure, Structure::True { .. });
    let measured = Measured {
        seconds,
        deviation: truth.deviation(&found.model).into(),
        explained: truth.judged().all(|(i, _)| found.report.equations[i].reached_floor),
        true_terms,
        true_terms_shown: true_terms || shown(truth, identifier, &found),
        relative_errors,
        standardised_errors,
        equations: found.model.equations(),
    };
    Ok((measured, found.model))
}

/// Whether every equation is true with some of the sets of terms that the report shows, of whatever size.
fn shown(truth: &Truth, identifier: &Identifier, found: &Identified) -> bool {
    let Ok(terms) = identifier.terms() else { return false };
    truth.judged().all(|(i, _)| {
        let report = &found.report.equations[i];
        report.path.iter().map(|size| &size.support).chain(&report.equally_good).any(|support| {
            let chosen: Option<Vec<_>> = support.iter().map(|&j| terms.get(j).map(|t| (&t.expr, t.rate))).collect();
            let is_true = |terms| compare(truth, &[(i, terms)], found.model.offsets());
            chosen.is_some_and(|terms| matches!(is_true(terms), Structure::True { .. }))
        })
    })
}
