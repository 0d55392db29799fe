//! Equations as people read them.

use std::fmt;

use super::{Entry, Form, Model};
use sindyna_core::number::coefficient as readable;

impl Model {
    /// The equations, one per state: `Δω/Δt = 15 sin θ + 3 u`.
    ///
    /// The left-hand side says what was fitted: `Δx/Δt` a difference over one interval, `x⁺` the next state, `ẋ` the
    /// derivative. Numbers have six significant digits; [`Self::to_json`] has all of them.
    #[must_use]
    pub fn equations(&self) -> Vec<String> {
        (0..self.parts.states.len()).map(|i| format!("{} = {}", self.left(i), self.right(i))).collect()
    }

    fn left(&self, i: usize) -> String {
        let name = &self.parts.states[i];
        let name = if name.contains(' ') { format!("({name})") } else { name.clone() };
        match self.parts.form {
            Form::Increment => format!("Δ{name}/Δt"),
            Form::Discrete => format!("{name}⁺"),
            Form::Continuous(_) | Form::SemiImplicit { .. } => rate(&name),
        }
    }

    fn right(&self, i: usize) -> String {
        let names: Vec<String> = self.parts.states.iter().chain(&self.parts.controls).cloned().collect();
        let mut text = String::new();
        let mut row = self.parts.equations[i].clone();
        // What the system does by itself is read first, what is done to it last.
        let controlled = |e: &Entry| self.terms[e.term].max_variable().is_some_and(|v| v >= self.parts.states.len());
        row.sort_by_key(controlled);
        for Entry { term, coefficient: c, rate: of } in row {
            let sign = match (text.is_empty(), c < 0.0) {
                (true, false) => "",
                (true, true) => "−",
                (false, false) => " + ",
                (false, true) => " − ",
            };
            let size = readable(c.abs());
            let term = self.terms[term].shifted(&self.parts.offsets);
            let factor = match of.map(|l| rate(&names[l])) {
                None => term.pretty(&names).as_factor(),
                Some(rate) if term.is_one() => rate,
                Some(rate) => format!("{}·{rate}", term.pretty(&names).as_factor()),
            };
            text.push_str(sign);
            text.push_str(&match (term.is_one() && of.is_none(), size.as_str()) {
                (true, _) => size,
                (false, "1") => factor,
                _ if factor.starts_with(|c: char| c.is_ascii_digit()) => format!("{size}·{factor}"),
                _ => format!("{size} {factor}"),
            });
        }
        if text.is_empty() { "0".into() } else { text }
    }
}

/// The derivative of `name`: a dot above a single letter.
fn rate(name: &str) -> String {
    if name.chars().count() == 1 { format!("{name}\u{307}") } else { format!("d{name}/dt") }
}

/// The equations, one per line.
impl fmt::Display for Model {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.equations().join("\n"))
    }
}
