//! What is written in a language: equations and a policy, with the names that stand in comments.

use sindyna_rl::SavedPolicy;
use sindyna_sindy::Expr;
use sindyna_sindy::export::System;

use super::interface::Interface;
use super::network::{Head, Network};

/// Who wrote a file, as it stands in files that are no text.
pub const PRODUCER: &str = "sindyna export";

/// Equations, and a policy where there is one.
pub struct Program {
    /// The equations.
    pub system: System,
    /// The policy trained in them.
    pub policy: Option<Network>,
    /// Names of what the policy observes; empty where they are not known.
    pub observed: Vec<String>,
    /// What stands between equations and policy, where it is known.
    pub interface: Option<Interface>,
    /// Where the equations come from.
    pub notes: Vec<String>,
}

impl Program {
    /// A program of `system` alone; `notes` tell where the equations come from.
    pub fn new(system: System, notes: Vec<String>) -> Self {
        Self { system, policy: None, observed: Vec::new(), interface: None, notes }
    }

    /// The same with what stands between equations and policy.
    pub fn with_interface(self, interface: Option<Interface>) -> Self {
        Self { interface, ..self }
    }

    /// The same with a policy, and the names of what it observes.
    pub fn with_policy(self, policy: &SavedPolicy, observed: Vec<String>) -> Self {
        Self { policy: Some(Network::of(policy)), observed, ..self }
    }

    /// What stands between equations and policy, where there are both and all three fit each other.
    pub(super) fn closed(&self) -> Option<&Interface> {
        let (network, interface) = (self.policy.as_ref()?, self.interface.as_ref()?);
        let (n, k) = (self.system.states.len(), self.system.controls.len());
        let below = |reading: &Expr| reading.max_variable().is_none_or(|i| i < n);
        let acts = match network.head {
            Head::Squashed { .. } => interface.numbered.is_empty() && network.actions() == k,
            Head::Largest => {
                interface.numbered.len() == network.outputs() && interface.numbered.iter().all(|u| u.len() == k)
            }
        };
        let sizes = interface.readings.len() == network.observed()
            && interface.bounds.len() == n
            && interface.controls.len() == k;
        (acts && sizes && interface.readings.iter().all(below)).then_some(interface)
    }

    /// What the policy observes as functions of the states; nothing where that is not known.
    pub(super) fn readings(&self) -> &[Expr] {
        self.closed().map_or(&[], |interface| &interface.readings)
    }

    /// What stands in the head of a file: the equations, what is which number in which array, where it comes from.
    pub(super) fn comments(&self) -> Vec<String> {
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
pub(super) fn harmless(text: &str) -> String {
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
