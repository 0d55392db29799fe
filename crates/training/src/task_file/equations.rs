//! Equations of a task file as a ground-truth simulator.

use anyhow::Context as _;
use sindyna_core::VectorField;
use sindyna_sindy::{Expr, parse};

use super::document::Document;

/// Variables of an equation held on the stack; larger systems fall back to the heap.
const STACK_VARIABLES: usize = 64;

/// The rates ẋ of all states.
#[derive(Debug, Clone)]
pub(super) struct Equations {
    /// One for each state, over z = (x; u).
    rates: Vec<Expr>,
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
        let n = names.len();
        names.extend(definitions.iter().map(|(name, _)| name.clone()));
        names.extend(document.parameters.keys().cloned());
        let parameters: Vec<f64> = document.numbers().map(|(_, value)| value).collect();
        for name in written.keys() {
            document.state_named(name).context("[equations]")?;
        }
        let (mut rates, mut lines) = (Vec::new(), Vec::new());
        for state in &document.state {
            let rate = document.state.iter().find(|other| other.rate_of.as_ref() == Some(&state.name));
            let text = match (written.get(&state.name), rate) {
                (Some(text), _) => text.clone(),
                (None, Some(rate)) => rate.name.clone(),
                (None, None) => anyhow::bail!("[equations] lack one for `{0}`: {0} = \"…\"", state.name),
            };
            let rate = parse(&text, &names).with_context(|| format!("the equation of `{}`", state.name))?;
            rates.push(rate.replaced(&|i| match i.checked_sub(n)? {
                i if i < definitions.len() => Some(definitions[i].1.clone()),
                i => Some(Expr::Constant(parameters[i - definitions.len()])),
            }));
            lines.push(format!("d{}/dt = {}", state.name, text.trim()));
        }
        let of_parameters = document.numbers().map(|(name, value)| format!("{name} = {value}"));
        lines.extend(of_parameters);
        lines.extend(document.definitions.iter().map(|(name, text)| format!("{name} = {}", text.trim())));
        Ok(Some(Self { rates, lines }))
    }

    /// As they were written, with the values of their parameters.
    pub(super) fn lines(&self) -> &[String] {
        &self.lines
    }
}

impl VectorField for Equations {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        let (n, k) = (x.len(), u.len());
        let width = n + k;
        let mut stack = [0.0; STACK_VARIABLES];
        let mut heap = Vec::new();
        let z = if width <= STACK_VARIABLES {
            &mut stack[..width]
        } else {
            heap.resize(width, 0.0);
            &mut heap[..]
        };
        z[..n].copy_from_slice(x);
        z[n..].copy_from_slice(u);
        for (rate, expression) in x_dot.iter_mut().zip(&self.rates) {
            *rate = expression.eval(z);
        }
    }
}
