//! A model as parts, checked once, and as JSON.

use serde::{Deserialize, Serialize};
use sindyna_core::Scheme;

use super::friction::Friction;
use super::parts::{Entry, Form, ModelParts};
use super::right_side::RightSide;
use super::slopes::Shared;
use super::{Model, Reading};
use crate::chain::after_their_rates;
use crate::expr::{Expr, ParseError, Tape, parse};
use crate::names::symbols;

/// Why something is not a model.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// Not JSON, or JSON of something else.
    #[error("not a model: {reason}")]
    Json {
        /// What the reader said.
        reason: String,
    },
    /// A model of another format.
    #[error("the model has format version {got}, this program reads version {known}")]
    Version {
        /// Version found.
        got: u32,
        /// Version understood.
        known: u32,
    },
    /// Lists that do not fit each other.
    #[error("{what}: expected {expected}, got {got}")]
    Shape {
        /// What was counted.
        what: &'static str,
        /// Number wanted.
        expected: usize,
        /// Number found.
        got: usize,
    },
    /// The search for the equations was told to stop.
    #[error("interrupted before the equations were found")]
    Interrupted,
    /// A number that is NaN, infinite or otherwise impossible.
    #[error("{what} is {value}")]
    BadNumber {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A state that is, by way of others, the rate of itself.
    #[error("the rates of states form a circle at `{state}`")]
    CircularRates {
        /// Its name.
        state: String,
    },
    /// A term that cannot be read.
    #[error(transparent)]
    Term(#[from] ParseError),
    /// A reference to a term or a state there is not.
    #[error("{what} {index} is asked for, there are only {count}")]
    NoSuch {
        /// What is missing.
        what: &'static str,
        /// Number asked for.
        index: usize,
        /// How many there are.
        count: usize,
    },
}

fn expect(what: &'static str, expected: usize, got: usize) -> Result<(), ModelError> {
    if expected == got { Ok(()) } else { Err(ModelError::Shape { what, expected, got }) }
}

impl Model {
    /// Checks and compiles a model.
    ///
    /// # Errors
    /// [`ModelError`] for lists that do not fit, terms that cannot be read, numbers that are not finite.
    pub fn new(parts: ModelParts) -> Result<Self, ModelError> {
        let n = parts.states.len();
        expect("equations", n, parts.equations.len())?;
        expect("kinematic flags", n, parts.kinematic.len())?;
        expect("offsets", n, parts.offsets.len())?;
        if let Some(value) = parts.offsets.iter().copied().find(|v| !v.is_finite()) {
            return Err(ModelError::BadNumber { what: "an offset", value });
        }
        if !(parts.dt.is_finite() && parts.dt > 0.0) {
            return Err(ModelError::BadNumber { what: "the control interval", value: parts.dt });
        }
        if let Form::Continuous(Scheme::Rk4 { substeps: 0 }) = parts.form {
            return Err(ModelError::BadNumber { what: "the number of substeps", value: 0.0 });
        }
        if let Some(readings) = &parts.readings {
            expect("readings", n, readings.len())?;
            // Every task state must be read somewhere, so none can be numbered higher than the readings reach.
            if let Some(reading) = readings.iter().find(|r| r.index() >= n) {
                return Err(ModelError::NoSuch { what: "state", index: reading.index(), count: n });
            }
        }
        for &Entry { term, coefficient, rate } in parts.equations.iter().flatten() {
            if term >= parts.terms.len() {
                return Err(ModelError::NoSuch { what: "term", index: term, count: parts.terms.len() });
            }
            if let Some(index) = rate.filter(|&l| l >= n) {
                return Err(ModelError::NoSuch { what: "state", index, count: n });
            }
            if !coefficient.is_finite() {
                return Err(ModelError::BadNumber { what: "a coefficient", value: coefficient });
            }
        }
        let kinematic = |row: &Vec<Entry>| matches!(row[..], [Entry { rate: None, .. }]);
        if matches!(parts.form, Form::SemiImplicit { .. }) {
            // Which state is the rate is read from the row: it must be that state and nothing else.
            let mut rows = parts.equations.iter().zip(&parts.kinematic).filter(|(_, k)| **k);
            if let Some((row, _)) = rows.find(|(row, _)| !kinematic(row)) {
                return Err(ModelError::Shape { what: "terms of a kinematic equation", expected: 1, got: row.len() });
            }
        }
        let names: Vec<String> = parts.states.iter().chain(&parts.controls).cloned().collect();
        let names = symbols(&names);
        let terms: Vec<Expr> = parts.terms.iter().map(|t| parse(t, &names)).collect::<Result<_, _>>()?;
        let mut tape = Tape::new(names.len(), &terms);
        let right = RightSide::new(&parts.equations, tape.outputs());
        let is_stepped_by_time = matches!(parts.form, Form::Continuous(Scheme::Rk4 { .. }));
        let friction = if is_stepped_by_time { Friction::among(&parts.equations, &terms, &mut tape) } else { None };
        let smooth = match &friction {
            Some(_) => RightSide::new(&Friction::without(&parts.equations, &terms), tape.outputs()),
            None => right.clone(),
        };
        let is_semi_implicit = matches!(parts.form, Form::SemiImplicit { .. });
        let positions = if is_semi_implicit { positions(&parts, &terms)? } else { Vec::new() };
        Ok(Self { parts, terms, tape, right, friction, smooth, positions, slopes: Shared::default() })
    }

    /// The model as JSON, with every digit of every number.
    #[must_use]
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("a model holds only finite numbers and text")
    }

    /// Reads a model from JSON.
    ///
    /// # Errors
    /// [`ModelError`] if the text is not a model of this format, or not a valid one.
    pub fn from_json(text: &str) -> Result<Self, ModelError> {
        let json = |e: serde_json::Error| ModelError::Json { reason: e.to_string() };
        let version: Version = serde_json::from_str(text).map_err(json)?;
        version.check()?;
        let document: Document = serde_json::from_str(text).map_err(json)?;
        document.try_into()
    }
}

/// The kinematic states of `parts`, each after the state that is its rate.
///
/// # Errors
/// [`ModelError::CircularRates`] if a state is, by way of others, its own rate.
fn positions(parts: &ModelParts, terms: &[Expr]) -> Result<Vec<usize>, ModelError> {
    let rate = |i: usize| {
        let term = parts.equations[i].iter().find_map(|e| terms[e.term].max_variable());
        term.filter(|_| parts.kinematic[i])
    };
    let circle = |i: usize| ModelError::CircularRates { state: parts.states[i].clone() };
    after_their_rates(parts.states.len(), rate).map_err(circle)
}

/// Version of the JSON form.
const FORMAT: u32 = 2;

#[derive(Deserialize)]
struct Version {
    format: u32,
}

impl Version {
    fn check(&self) -> Result<(), ModelError> {
        if self.format == FORMAT { Ok(()) } else { Err(ModelError::Version { got: self.format, known: FORMAT }) }
    }
}

/// The JSON form.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    format: u32,
    form: FormName,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    scheme: Option<SchemeName>,
    dt: f64,
    states: Vec<String>,
    controls: Vec<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    readings: Option<Vec<Reading>>,
    terms: Vec<String>,
    equations: Vec<Vec<Entry>>,
    kinematic: Vec<bool>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    offsets: Option<Vec<f64>>,
    n_features: usize,
}

#[derive(Serialize, Deserialize, Clone, Copy)]
#[serde(rename_all = "snake_case")]
enum FormName {
    Increment,
    Discrete,
    Continuous,
    SemiImplicit,
}

#[derive(Serialize, Deserialize, Clone, Copy)]
#[serde(rename_all = "snake_case")]
enum SchemeName {
    Euler,
    Rk4 { substeps: usize },
    SemiImplicitEuler { substeps: usize },
}

impl From<&Model> for Document {
    fn from(model: &Model) -> Self {
        let parts = model.parts.clone();
        let (form, scheme) = match parts.form {
            Form::Increment => (FormName::Increment, None),
            Form::Discrete => (FormName::Discrete, None),
            Form::SemiImplicit { substeps: 0 | 1 } => (FormName::SemiImplicit, None),
            Form::SemiImplicit { substeps } => {
                (FormName::SemiImplicit, Some(SchemeName::SemiImplicitEuler { substeps }))
            }
            Form::Continuous(Scheme::Euler) => (FormName::Continuous, Some(SchemeName::Euler)),
            Form::Continuous(Scheme::Rk4 { substeps }) => (FormName::Continuous, Some(SchemeName::Rk4 { substeps })),
        };
        Self {
            format: FORMAT,
            form,
            scheme,
            dt: parts.dt,
            states: parts.states,
            controls: parts.controls,
            readings: parts.readings,
            terms: parts.terms,
            equations: parts.equations,
            kinematic: parts.kinematic,
            offsets: Some(parts.offsets).filter(|offsets| offsets.iter().any(|v| *v != 0.0)),
            n_features: parts.n_features,
        }
    }
}

impl TryFrom<Document> for Model {
    type Error = ModelError;

    fn try_from(document: Document) -> Result<Self, ModelError> {
        Version { format: document.format }.check()?;
        let form = match (document.form, document.scheme) {
            (FormName::Increment, _) => Form::Increment,
            (FormName::Discrete, _) => Form::Discrete,
            (FormName::SemiImplicit, Some(SchemeName::SemiImplicitEuler { substeps })) => {
                Form::SemiImplicit { substeps }
            }
            (FormName::SemiImplicit, _) => Form::SemiImplicit { substeps: 1 },
            (FormName::Continuous, Some(SchemeName::Euler)) => Form::Continuous(Scheme::Euler),
            (FormName::Continuous, Some(SchemeName::Rk4 { substeps })) => Form::Continuous(Scheme::Rk4 { substeps }),
            (FormName::Continuous, None | Some(SchemeName::SemiImplicitEuler { .. })) => {
                return Err(ModelError::Shape { what: "schemes of a continuous model", expected: 1, got: 0 });
            }
        };
        Self::new(ModelParts {
            offsets: document.offsets.unwrap_or_else(|| vec![0.0; document.states.len()]),
            states: document.states,
            controls: document.controls,
            form,
            dt: document.dt,
            readings: document.readings,
            terms: document.terms,
            equations: document.equations,
            kinematic: document.kinematic,
            n_features: document.n_features,
        })
    }
}

impl Serialize for Model {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Document::from(self).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Model {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let document = Document::deserialize(deserializer)?;
        document.try_into().map_err(serde::de::Error::custom)
    }
}

/// A model inside of something that may be written in a format that does not describe itself: as its JSON form.
pub(crate) mod as_text {
    use serde::{Deserialize as _, Deserializer, Serializer, de::Error as _};

    use super::Model;

    pub(crate) fn serialize<S: Serializer>(model: &Model, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&model.to_json())
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Model, D::Error> {
        Model::from_json(&String::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}
