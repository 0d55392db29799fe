//! Models as files hold them, which anybody may have written.

use sindyna_core::Scheme;
use sindyna_sindy::{Expr, Form, Model, ModelError};

/// Steps in a control interval; what is identified here takes twenty-two at most.
const MOST_SUBSTEPS: usize = 1_000;

/// Why a `model.json` holds no model that can be stepped.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelFileError {
    /// It is no model.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A step would take too long.
    #[error("{substeps} steps in a control interval are more than {MOST_SUBSTEPS}")]
    Substeps {
        /// Steps of the scheme in one control interval.
        substeps: usize,
    },
    /// A state that follows another has an equation that names none.
    #[error("the equation of `{state}` names no state as its rate")]
    NoRate {
        /// The state.
        state: String,
    },
}

/// The model that the JSON `text` of a `model.json` holds, if it is one that can be stepped.
///
/// # Errors
/// [`ModelFileError`] for anything else.
pub fn read_model(text: &str) -> Result<Model, ModelFileError> {
    let model = Model::from_json(text)?;
    let n = model.states().len();
    match model.form() {
        Form::Continuous(Scheme::Rk4 { substeps }) | Form::SemiImplicit { substeps } if substeps > MOST_SUBSTEPS => {
            return Err(ModelFileError::Substeps { substeps });
        }
        Form::SemiImplicit { .. } => {
            // Such a row is followed with the new states alone.
            let is_state = |i: usize| {
                let mut terms = model.coefficients(i).iter().map(|entry| &model.terms()[entry.term]);
                terms.all(|term| matches!(term, Expr::Variable(j) if *j < n))
            };
            if let Some(i) = (0..n).find(|&i| model.kinematic()[i] && !is_state(i)) {
                return Err(ModelFileError::NoRate { state: model.states()[i].clone() });
            }
        }
        _ => {}
    }
    Ok(model)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A model whose position is followed by the term number `rate` of (v, u, v²).
    fn text(form: &str, rate: usize) -> String {
        format!(
            r#"{{"format": 2, {form}, "dt": 0.1, "states": ["x", "v"], "controls": ["u"], "terms": ["v", "u", "v^2"],
                "equations": [[{{"term": {rate}, "coefficient": 1}}], [{{"term": 1, "coefficient": 2}}]],
                "kinematic": [true, false], "n_features": 10}}"#
        )
    }

    #[test]
    fn models_that_cannot_be_stepped_are_refused_with_the_reason() {
        let semi = r#""form": "semi_implicit""#;
        let rk4 = |n: u64| format!(r#""form": "continuous", "scheme": {{"rk4": {{"substeps": {n}}}}}"#);
        let says = |text: String| read_model(&text).map(drop).map_err(|e| e.to_string());
        assert_eq!(says(text(semi, 0)), Ok(()));
        assert_eq!(says(text(&rk4(8), 0)), Ok(()));
        for rate in [1, 2] {
            assert!(says(text(semi, rate)).unwrap_err().contains("the equation of `x` names no state as its rate"));
        }
        for substeps in [1_001, 1_000_000_000_000_000_000] {
            assert!(says(text(&rk4(substeps), 0)).unwrap_err().contains(&format!("{substeps} steps")));
        }
        assert!(says("{}".into()).unwrap_err().contains("not a model"));
    }
}
