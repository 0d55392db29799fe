//! Equations and policies as programs in other languages.
//!
//! A [`Program`] is all that a language has to know. Names stand in comments alone, without what could end one: states and controls are
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

use sindyna_sindy::ModelError;
use sindyna_sindy::export::python;

pub(crate) use interface::Interface;
pub(crate) use program::Program;

/// A language to write.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Language {
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
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Python => "python",
            Self::C => "c",
            Self::Javascript => "javascript",
            Self::Rust => "rust",
            Self::Latex => "latex",
            Self::Html => "html",
        }
    }

    /// How the names of its files end.
    pub(crate) fn extension(self) -> &'static str {
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
    pub(crate) fn write(self, program: &Program) -> Result<String, ModelError> {
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
