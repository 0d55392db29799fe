//! Equations and policies as programs in other languages.
//!
//! A `Program` is all that a language has to know. Names stand in comments alone, without what could end one: states and controls are
//! numbers in arrays, so no name can become code. Not here: where equations come from, and where files go.

mod c;
mod casadi;
mod code;
mod fmu;
mod friction;
mod interface;
mod javascript;
mod latex;
mod network;
mod numpy;
mod onnx;
mod page;
mod program;
mod rust;

use sindyna_rl::SavedPolicy;
use sindyna_sindy::export::{System, python};
use sindyna_sindy::{Model, ModelError};

pub use interface::Interface;
pub use program::{PRODUCER, Program};

/// What stands in the comments of a program.
#[derive(Debug, Clone, Default)]
pub struct Names {
    /// Names of the states (n), of the inputs (k), and of what the policy observes (m); none for those of the model.
    pub states: Vec<String>,
    /// Names of the inputs.
    pub controls: Vec<String>,
    /// Names of the observed values.
    pub observed: Vec<String>,
}

/// `model`, and the `policy` trained in it, as a program in the language called `language`: `python`, `c`, `javascript`, `rust`, `latex`, `casadi`, `onnx` or `fmu`.
///
/// Equations differ from the model by at most 1e-12 of their size, actions by at most 1e-6 of their range. Names stand in comments alone, so that none can become code.
///
/// # Errors
/// [`ExportError::UnknownLanguage`], [`ExportError::Model`] if the parts of the model do not fit each other.
pub fn program(
    model: &Model,
    policy: Option<&SavedPolicy>,
    names: Names,
    language: &str,
) -> Result<Written, ExportError> {
    // A page has to know where episodes begin, which a model does not.
    let languages = || Language::ALL.into_iter().filter(|l| *l != Language::Html);
    let Some(language) = languages().find(|l| l.name() == language) else {
        let known = languages().map(|l| l.name().to_owned()).collect();
        return Err(ExportError::UnknownLanguage { name: language.to_owned(), known });
    };
    let mut system = System::from(model);
    let renamed = |old: Vec<String>, new: Vec<String>| if new.len() == old.len() { new } else { old };
    system.states = renamed(system.states, names.states);
    system.controls = renamed(system.controls, names.controls);
    let program = Program::new(system, Vec::new());
    let program = match policy {
        Some(policy) => program.with_policy(policy, names.observed),
        None => program,
    };
    language.write(&program)
}

/// Why there is no program.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// A language that nothing is written in.
    #[error("no language named `{name}`; known: {}", known.iter().map(|k| format!("`{k}`")).collect::<Vec<_>>().join(", "))]
    UnknownLanguage {
        /// The name.
        name: String,
        /// Those there are.
        known: Vec<String>,
    },
    /// A model whose parts do not fit each other.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// An archive that could not be written.
    #[error("the archive cannot be written: {0}")]
    Archive(#[from] zip::result::ZipError),
}

/// What a program comes to in a language.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Written {
    /// The file.
    pub contents: Contents,
    /// A file of its own for the policy, in languages that need one.
    pub policy: Option<Vec<u8>>,
    /// What is to be said of it.
    pub note: Option<String>,
}

/// What is in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Contents {
    /// A program that people can read.
    Text(String),
    /// Anything else.
    Bytes(Vec<u8>),
}

impl From<String> for Written {
    fn from(text: String) -> Self {
        Self { contents: Contents::Text(text), policy: None, note: None }
    }
}

/// A language to write.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Language {
    /// A module that needs NumPy only
    Python,
    /// A C99 file without dynamic memory that needs <math.h> only
    C,
    /// A module for Node.js and browsers
    Javascript,
    /// A module that needs std only
    Rust,
    /// Formulas for a LaTeX document
    Latex,
    /// An interactive page: a running simulation, a slider for every coefficient, inputs by mouse or touch
    Html,
    /// A Python module of CasADi functions, which can be differentiated
    Casadi,
    /// Graphs for ONNX Runtime: the equations, and in a file beside it the policy
    Onnx,
    /// An FMU (FMI 2.0, co-simulation) of the equations, with C sources
    Fmu,
}

impl Language {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Python,
        Self::C,
        Self::Javascript,
        Self::Rust,
        Self::Latex,
        Self::Html,
        Self::Casadi,
        Self::Onnx,
        Self::Fmu,
    ];

    /// What the user calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Python => "python",
            Self::C => "c",
            Self::Javascript => "javascript",
            Self::Rust => "rust",
            Self::Latex => "latex",
            Self::Html => "html",
            Self::Casadi => "casadi",
            Self::Onnx => "onnx",
            Self::Fmu => "fmu",
        }
    }

    /// What is written in it.
    pub fn about(self) -> &'static str {
        match self {
            Self::Python => "A module that needs NumPy only",
            Self::C => "A C99 file without dynamic memory that needs <math.h> only",
            Self::Javascript => "A module for Node.js and browsers",
            Self::Rust => "A module that needs std only",
            Self::Latex => "Formulas for a LaTeX document",
            Self::Html => {
                "An interactive page: a running simulation, a slider for every coefficient, inputs by mouse or touch"
            }
            Self::Casadi => "A Python module of CasADi functions, which can be differentiated",
            Self::Onnx => "Graphs for ONNX Runtime: the equations, and the policy in a second file (model.policy.onnx)",
            Self::Fmu => {
                "An FMU (FMI 2.0, co-simulation) of the equations, with C sources, compiled if there is a C compiler"
            }
        }
    }

    /// What a file of it is called beside a `model` of this name.
    pub fn file_name(self, model: &str) -> String {
        let ending = match self {
            Self::Python => ".py",
            Self::C => ".c",
            Self::Javascript => ".mjs",
            Self::Rust => ".rs",
            Self::Latex => ".tex",
            Self::Html => ".html",
            // Python imports no file with two dots.
            Self::Casadi => "_casadi.py",
            Self::Onnx => ".onnx",
            Self::Fmu => ".fmu",
        };
        format!("{model}{ending}")
    }

    /// `program` in this language.
    ///
    /// # Errors
    /// [`ExportError::Model`], [`ExportError::Archive`].
    pub fn write(self, program: &Program) -> Result<Written, ExportError> {
        // The check of the lists is that of the first exporter.
        let module = python(&program.system, &numpy::notes(program))?;
        Ok(match self {
            Self::Python => (module + &numpy::policy(program) + &numpy::closed(program)).into(),
            Self::C => c::write(program).into(),
            Self::Javascript => javascript::write(program).into(),
            Self::Rust => rust::write(program).into(),
            Self::Latex => latex::write(program).into(),
            Self::Html => program.interface.as_ref().map_or_else(String::new, |i| page::write(program, i)).into(),
            Self::Casadi => casadi::write(program).into(),
            Self::Onnx => Written {
                contents: Contents::Bytes(onnx::equations(&program.system, &program.comments())),
                policy: program.policy.as_ref().map(|network| onnx::policy(network, &program.comments())),
                note: None,
            },
            Self::Fmu => {
                let (archive, note) = fmu::write(program)?;
                Written { contents: Contents::Bytes(archive), policy: None, note: Some(note) }
            }
        })
    }
}
