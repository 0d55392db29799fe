//! Equations and policies as programs in other languages.
//!
//! A `Program` is all that a language has to know. Names stand in comments alone, without what could end one: states and controls are
//! numbers in arrays, so no name can become code.

mod c;
mod code;
mod interface;
mod javascript;
mod latex;
mod network;
mod numpy;
mod page;
mod program;
mod rust;

use sindyna_rl::SavedPolicy;
use sindyna_sindy::export::{System, python};
use sindyna_sindy::{Model, ModelError};

pub use interface::Interface;
pub use program::Program;

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

/// `model`, and the `policy` trained in it, as a program in the language called `language`: `python`, `c`, `javascript`, `rust` or `latex`.
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
) -> Result<String, ExportError> {
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
    Ok(language.write(&program)?)
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
}

/// A language to write.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Language {
    /// A module that needs NumPy alone
    Python,
    /// A C99 file without allocation that needs <math.h> alone
    C,
    /// A module for Node.js and browsers
    Javascript,
    /// A module that needs std alone
    Rust,
    /// Formulas
    Latex,
    /// A page to play with: it moves, every coefficient has a slider, the pointer pushes
    Html,
}

impl Language {
    /// All of them.
    pub const ALL: [Self; 6] = [Self::Python, Self::C, Self::Javascript, Self::Rust, Self::Latex, Self::Html];

    /// What the user calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Python => "python",
            Self::C => "c",
            Self::Javascript => "javascript",
            Self::Rust => "rust",
            Self::Latex => "latex",
            Self::Html => "html",
        }
    }

    /// What is written in it.
    pub fn about(self) -> &'static str {
        match self {
            Self::Python => "A module that needs NumPy alone",
            Self::C => "A C99 file without allocation that needs <math.h> alone",
            Self::Javascript => "A module for Node.js and browsers",
            Self::Rust => "A module that needs std alone",
            Self::Latex => "Formulas",
            Self::Html => "A page to play with: it moves, every coefficient has a slider, the pointer pushes",
        }
    }

    /// How the names of its files end.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Python => "py",
            Self::C => "c",
            Self::Javascript => "mjs",
            Self::Rust => "rs",
            Self::Latex => "tex",
            Self::Html => "html",
        }
    }

    /// `program` in this language.
    pub fn write(self, program: &Program) -> Result<String, ModelError> {
        // The check of the lists is that of the first exporter.
        let module = python(&program.system, &program.notes)?;
        Ok(match self {
            Self::Python => module + &numpy::policy(program),
            Self::C => c::write(program),
            Self::Javascript => javascript::write(program),
            Self::Rust => rust::write(program),
            Self::Latex => latex::write(program),
            Self::Html => program.interface.as_ref().map_or_else(String::new, |i| page::write(program, i)),
        })
    }
}
