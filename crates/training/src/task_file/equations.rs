//! Equations of a task file as a ground-truth simulator.

use anyhow::{Context as _, ensure};
use sindyna_core::VectorField;
use sindyna_sindy::{Expr, parse};

use super::document::Document;

/// Variables of an equation held on the stack; larger systems fall back to the heap.
const STACK_VARIABLES: usize = 64;

/// The rates ẋ of all states.
#[derive(Debug, Clone)]
pub(super) struct Equations {
    /// One for each state, over z = (x; u; p).
    rates: Vec<Expr>,
    parameters: Vec<f64>,
    /// As they were written.
    lines: Vec<String>,
}

impl Equations {
    /// The equations of `document`; none if it has none. Those of states whose rate is another state may be left out.
    pub(super) fn of(document: &Document) -> anyhow::Result<Option<Self>> {
        let Some(written) = &document.equations else { return Ok(None) };
        let mut names: Vec<String> = document.names();
        names.truncate(document.state.len() + document.control.len());
        let definitions = document.defined()?;
        for (name, value) in &document.parameters {
            ensure!(value.is_finite(), "parameter `{name}` must be finite, got {value}");
            let symbol = parse(name, std::slice::from_ref(name)) == Ok(Expr::Variable(0));
            ensure!(
                symbol && !names.contains(name) && !document.definitions.contains_key(name),
                "`{name}` is no name for a parameter: it must be a name for formulas, not used yet"
            );
            names.push(name.clone());
        }
        let n = names.len();
        names.extend(document.definitions.keys().cloned());
        for name in written.keys() {
            document.state_named(name).context("[equations]")?;
        }
        let (mut rates, mut lines) = (Vec::new(), Vec::new());
        for state in &document.state {
            let rate = document.state.iter().find(|other| other.rate_of.as_ref() == Some(&state.name));
            let text = match (written.get(&state.name), rate) {
                (Some(text), _) => text.clone(),
                (None, Some(rate)) => rate.name.clone(),
                (None, None) => anyhow::bail!(
                    "[equations] have none for `{0}`, the rate of which no state is: {0} = \"…\"",
                    state.name
                ),
            };
            let rate = parse(&text, &names).with_context(|| format!("the equation of `{}`", state.name))?;
            rates.push(rate.replaced(&|i| Some(definitions.get(i.checked_sub(n)?)?.1.clone())));
            lines.push(format!("d{}/dt = {}", state.name, text.trim()));
        }
        let of_parameters = document.parameters.iter().map(|(name, value)| format!("{name} = {value}"));
        lines.extend(of_parameters);
        lines.extend(document.definitions.iter().map(|(name, text)| format!("{name} = {}", text.trim())));
        Ok(Some(Self { rates, parameters: document.parameters.values().copied().collect(), lines }))
    }

    /// As they were written, with the values of their parameters.
    pub(super) fn lines(&self) -> &[String] {
        &self.lines
    }
}

impl VectorField for Equations {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        let (n, k) = (x.len(), u.len());
        let width = n + k + self.parameters.len();
        let mut stack = [0.0; STACK_VARIABLES];
        let mut heap = Vec::new();
        let z = if width <= STACK_VARIABLES {
            &mut stack[..width]
        } else {
            heap.resize(width, 0.0);
            &mut heap[..]
        };
        z[..n].copy_from_slice(x);
        z[n..n + k].copy_from_slice(u);
        z[n + k..].copy_from_slice(&self.parameters);
        for (rate, expression) in x_dot.iter_mut().zip(&self.rates) {
            *rate = expression.eval(z);
        }
    }
}
