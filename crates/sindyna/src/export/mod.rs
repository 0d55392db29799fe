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
mod rust;

use sindyna_rl::SavedPolicy;
use sindyna_sindy::ModelError;
use sindyna_sindy::export::{System, python};

pub(crate) use interface::Interface;
pub(crate) use network::Network;

/// Equations, and a policy where there is one.
pub(crate) struct Program {
    pub(crate) system: System,
    pub(crate) policy: Option<Network>,
    /// Names of what the policy observes; empty where they are not known.
    pub(crate) observed: Vec<String>,
    /// What stands between equations and policy, where it is known.
    pub(crate) interface: Option<Interface>,
    /// Where the equations come from.
    pub(crate) notes: Vec<String>,
}

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

impl Program {
    pub(crate) fn new(system: System, notes: Vec<String>) -> Self {
        Self { system, policy: None, observed: Vec::new(), interface: None, notes }
    }

    pub(crate) fn with_interface(self, interface: Option<Interface>) -> Self {
        Self { interface, ..self }
    }

    pub(crate) fn with_policy(self, policy: &SavedPolicy, observed: Vec<String>) -> Self {
        Self { policy: Some(Network::of(policy)), observed, ..self }
    }

    /// What stands in the head of a file: the equations, what is which number in which array, where it comes from.
    fn comments(&self) -> Vec<String> {
        let numbered = |array: &str, names: &[String]| {
            let each = names.iter().enumerate().map(|(i, name)| format!("{array}[{i}] {name}"));
            (!names.is_empty()).then(|| each.collect::<Vec<_>>().join(", "))
        };
        let mut lines = self.system.text.clone();
        lines.extend(numbered("x", &self.system.states));
        lines.extend(numbered("u", &self.system.controls));
        lines.extend(numbered("o", &self.observed));
        lines.extend(self.notes.iter().cloned());
        lines.iter().map(|line| harmless(line)).collect()
    }
}

/// `text` for a comment of one line in any language: nothing that ends it, goes on after it, or changes the direction of writing.
fn harmless(text: &str) -> String {
    let allowed = |c: char| {
        let turns = matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        !c.is_control() && !turns && !matches!(c, '\\' | '/' | '*' | '?' | '`' | '$')
    };
    let kept = text.replace(" / ", " over ");
    kept.chars().map(|c| if allowed(c) { c } else { '_' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_comment_cannot_be_left() {
        assert_eq!(harmless("a */ b\n\\ // ??/ `$x` é θ"), "a __ b__ __ ___ __x_ é θ");
        assert_eq!(harmless("x\u{2028}y\u{202e}"), "x_y_");
    }
}
