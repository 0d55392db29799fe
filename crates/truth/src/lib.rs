//! How far an identified model is from the true system.
//!
//! Nothing here knows a term or a coefficient of any system: what is true is asked of [`sindyna_envs::System::rates`].
//!
//! ```
//! use sindyna_sindy::Model;
//! use sindyna_truth::{Structure, Truth, structure};
//!
//! let model = Model::from_json(
//!     r#"{"format": 2, "form": "continuous", "scheme": "euler", "dt": 0.05, "states": ["θ", "ω"], "controls": ["u"],
//!         "terms": ["ω", "sin(θ)", "u"], "equations": [[{"term": 0, "coefficient": 1.0}],
//!         [{"term": 1, "coefficient": 14.9}, {"term": 2, "coefficient": 3.1}]], "kinematic": [true, false], "n_features": 3}"#,
//! )?;
//! let truth = Truth::of(&sindyna_envs::find("pendulum").expect("it is registered"), 100);
//! let Structure::True { coefficients } = structure(&truth, &model) else { panic!("these are its terms") };
//! assert!((coefficients[0] - 15.0).abs() < 1e-9 && (coefficients[1] - 3.0).abs() < 1e-9);
//! # Ok::<(), sindyna_sindy::ModelError>(())
//! ```

mod rates;
mod structure;

pub use rates::{Deviation, Truth};
pub use structure::{Structure, Terms, compare, structure};
