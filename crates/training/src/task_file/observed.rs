//! What the sensors of a task file show: states, cosines and sines of them, formulas.

use anyhow::{Context as _, ensure};
use sindyna_core::{Channel, Kind};
use sindyna_sindy::{Expr, parse};

use super::document::Document;

/// Observed values.
pub(super) struct Observed {
    pub(super) channels: Vec<Channel>,
    /// Those that are formulas, by their names: the text itself.
    pub(super) formulas: Vec<(String, Expr)>,
}

impl Document {
    /// What the file lists, or every state, angles that go round as cosine and sine.
    pub(super) fn observed(&self, state: &[Channel]) -> anyhow::Result<Observed> {
        let cosine = |i: usize| waving("cos", Kind::CosOf(i), &state[i]);
        let sine = |i: usize| waving("sin", Kind::SinOf(i), &state[i]);
        let Some(listed) = &self.observation else {
            let shown = state.iter().enumerate().flat_map(|(i, channel)| match channel.kind {
                Kind::Angle if !channel.is_bounded() => vec![cosine(i), sine(i)],
                _ => vec![channel.clone()],
            });
            return Ok(Observed { channels: shown.collect(), formulas: Vec::new() });
        };
        let (mut shown, mut formulas) = (Vec::new(), Vec::new());
        for text in listed {
            let channel = match text.split_once(' ') {
                Some(("cos", name)) => Some(cosine(self.state_named(name).context("observation")?)),
                Some(("sin", name)) => Some(sine(self.state_named(name).context("observation")?)),
                _ => state.iter().find(|channel| channel.name == *text).cloned(),
            };
            match channel {
                Some(channel) => {
                    ensure!(formulas.is_empty(), "observation lists `{text}` after a formula: formulas come last");
                    shown.push(channel);
                }
                None => formulas.push((text.clone(), self.function_of_states(text)?)),
            }
        }
        for (i, channel) in state.iter().enumerate() {
            let shows = |what: &Channel| shown.iter().any(|o: &Channel| o.name == what.name);
            let (name, turned) = (&channel.name, shows(&cosine(i)) && shows(&sine(i)));
            ensure!(
                shows(channel) || turned,
                "observation does not show state `{name}`, which identification needs. List `{name}`, or \
                 both `cos {name}` and `sin {name}`"
            );
        }
        shown.extend(formulas.iter().map(|(text, _)| Channel::new(text, "", Kind::Plain, 1.0)));
        for (i, channel) in shown.iter().enumerate() {
            ensure!(!shown[..i].contains(channel), "observation lists `{}` twice", channel.name);
        }
        Ok(Observed { channels: shown, formulas })
    }

    /// A formula over states, definitions and parameters.
    fn function_of_states(&self, text: &str) -> anyhow::Result<Expr> {
        let (n, definitions) = (self.state.len(), self.defined()?);
        let states = self.state.iter().map(|s| s.name.clone());
        let defined = definitions.iter().map(|(name, _)| name.clone());
        let names: Vec<String> = states.chain(defined).chain(self.numbers().map(|(name, _)| name)).collect();
        let numbers: Vec<f64> = self.numbers().map(|(_, value)| value).collect();
        let formula =
            parse(text, &names).with_context(|| format!("observation `{text}`, a formula over the states"))?;
        Ok(formula.replaced(&|i| match i.checked_sub(n)? {
            i if i < definitions.len() => Some(definitions[i].1.clone()),
            i => Some(Expr::Constant(numbers[i - definitions.len()])),
        }))
    }
}

/// Cosine or sine of an angle as a channel.
fn waving(function: &str, kind: Kind, of: &Channel) -> Channel {
    Channel::new(&format!("{function} {}", of.name), "", kind, 1.0).within(-1.0, 1.0)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use sindyna_core::{Observe as _, Seed};

    use super::super::TaskFile;
    use crate::problem::Problem as _;

    /// The task file of two hinges with an observation.
    fn arm(observation: &str) -> anyhow::Result<TaskFile> {
        let text = format!(
            "name = \"arm\"\nmax_steps = 10\ndt = 0.1\nobservation = [{observation}]\n[let]\ntip = \"cos(a) + cos(a + b)\"\n\
             [parameters]\nfar = 1.5\n[equations]\na = \"u\"\nb = \"-b\"\n[[state]]\nname = \"a\"\nkind = \"angle\"\n[[state]]\nname = \"b\"\n\
             [[control]]\nname = \"u\"\nlow = -1.0\nhigh = 1.0\n[task]\nreward = \"-a^2\"\n"
        );
        TaskFile::read(Path::new("arm.toml"), text, None)
    }

    #[test]
    fn formulas_of_states_are_seen() {
        let listed = r#""cos a", "sin a", "b", "far - tip", "clip(10*b, -1, 1)", "cos(a)""#;
        let file = arm(listed).unwrap();
        let names: Vec<_> = file.spec().observation.iter().map(|o| o.name.as_str()).collect();
        assert_eq!(names, ["cos a", "sin a", "b", "far - tip", "clip(10*b, -1, 1)", "cos(a)"]);
        let mut o = [0.0; 6];
        file.sensors().observe(&[0.3, 0.4], &mut Seed::new(0).numpy(), &mut o);
        let (cosine, sine) = (0.3_f64.cos(), 0.3_f64.sin());
        assert_eq!(o, [cosine, sine, 0.4, 1.5 - (cosine + 0.7_f64.cos()), 1.0, cosine]);
        // Noise of the sensors leaves formulas what they are called.
        assert_eq!(file.with_noise(0.1).spec().observation_dim(), 6);
    }

    #[test]
    fn what_cannot_be_seen_is_refused() {
        for (listed, says) in [
            (r#""a", "b", "u*a""#, "no variable named `u`"),
            (r#""a", "b", "next_a""#, "no variable named `next_a`"),
            (r#""a", "a + b", "b""#, "observation lists `b` after a formula: formulas come last"),
            (r#""cos a", "b", "tip""#, "observation does not show state `a`"),
            (r#""a", "b", "tip", "tip""#, "observation lists `tip` twice"),
        ] {
            let refusal = format!("{:#}", arm(listed).err().unwrap());
            assert!(refusal.contains(says), "{listed}: {refusal}");
        }
    }
}
