//! Names that a task file gives to terms.

use std::collections::BTreeMap;

use anyhow::{Context as _, bail, ensure};
use sindyna_sindy::{Expr, parse};

use super::document::{Document, Parameter};

/// Characters of a definition once it is written out.
const LONGEST: usize = 20_000;

/// Definitions that are written out, and those that wait for others.
struct Progress<'a> {
    found: BTreeMap<&'a str, Expr>,
    begun: Vec<&'a str>,
}

impl Document {
    /// The definitions, in the order of their names, as terms of the states.
    pub(super) fn defined(&self) -> anyhow::Result<Vec<(String, Expr)>> {
        let numbers = self.parameters.iter().filter_map(|(name, parameter)| match parameter {
            Parameter::Number(value) => Some((name.as_str(), Expr::Constant(*value))),
            Parameter::Drawn(_) => None,
        });
        let mut progress = Progress { found: numbers.collect(), begun: Vec::new() };
        for name in self.definitions.keys() {
            self.definition(name, &mut progress)?;
        }
        let definitions = progress.found.into_iter().filter(|(name, _)| self.definitions.contains_key(*name));
        Ok(definitions.map(|(name, term)| (name.to_owned(), term)).collect())
    }

    /// What `name` stands for.
    fn definition<'a>(&'a self, name: &'a str, progress: &mut Progress<'a>) -> anyhow::Result<Expr> {
        if let Some(term) = progress.found.get(name) {
            return Ok(term.clone());
        }
        if progress.begun.contains(&name) {
            bail!("[let] `{name}` is defined in terms of itself: {} → {name}", progress.begun.join(" → "));
        }
        progress.begun.push(name);
        let (n, others) = (self.state.len(), self.definitions.keys().chain(self.parameters.keys()));
        let names: Vec<String> = self.state.iter().map(|s| &s.name).chain(others.clone()).cloned().collect();
        let term = parse(&self.definitions[name], &names).with_context(|| format!("[let] `{name}`"))?;
        let mut parts = BTreeMap::new();
        for (i, other) in (n..).zip(others) {
            if term.has(i) {
                parts.insert(i, self.definition(other, progress)?);
            }
        }
        let term = term.replaced(&|i| parts.get(&i).cloned());
        let length = term.display(&names).to_string().len();
        ensure!(length <= LONGEST, "[let] `{name}` is longer than {LONGEST} characters once it is written out");
        progress.begun.pop();
        progress.found.insert(name, term.clone());
        Ok(term)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::TaskFile;
    use crate::problem::Problem as _;

    /// The task file of a point with definitions, equation, reward and end.
    fn point(definitions: &str, equation: &str, reward: &str, terminated: &str) -> anyhow::Result<TaskFile> {
        let text = format!(
            "name = \"point\"\nmax_steps = 10\ndt = 0.1\n[let]\n{definitions}\n[equations]\nx = \"{equation}\"\n[parameters]\nk = 2.0\n\
             [[state]]\nname = \"x\"\nstart = [1.0, 2.0]\n[[control]]\nname = \"u\"\nlow = -1.0\nhigh = 1.0\n\
             [task]\nreward = \"{reward}\"\nterminated = \"{terminated}\"\n"
        );
        TaskFile::read(Path::new("point.toml"), text, None)
    }

    #[test]
    fn definitions_stand_for_terms_before_and_after_the_step() {
        let definitions = "square = \"x^2\"\nmore = \"square + sine\"\nsine = \"0.5*k*sin(x)\"";
        let file = point(definitions, "u - k*square", "more - 5*k*next_square + u", "next_more > 2*k").unwrap();
        let task = file.task();
        let reward = task.reward(&[1.5], &[0.25], &[0.25], &[2.0]);
        assert!((reward - (1.5_f64.powi(2) + 1.5_f64.sin() - 40.0 + 0.25)).abs() < 1e-12, "{reward}");
        assert!(task.terminated(&[2.0]) && !task.terminated(&[1.5]));
        // ẋ = −2 x², so 1/x grows by 2 t.
        let (mut rng, mut next) = (sindyna_core::Seed::new(0).numpy(), [0.0]);
        file.dynamics().unwrap().step(&[1.0], &[0.0], &mut rng, &mut next).unwrap();
        assert!((next[0] - 1.0 / 1.2).abs() < 1e-9, "{next:?}");
    }

    #[test]
    fn what_defines_nothing_is_refused_by_name() {
        let long: Vec<String> = (1..60).map(|i| format!("a{i} = \"a{0} + a{0} + a{0}\"", i - 1)).collect();
        let long = format!("a0 = \"x\"\n{}", long.join("\n"));
        for (definitions, says) in [
            ("a = \"b\"\nb = \"2*a\"", "[let] `a` is defined in terms of itself: a → b → a"),
            ("a = \"u\"", "no variable named `u`"),
            ("a = \"x +\"", "[let] `a`"),
            ("x = \"1\"", "the name `x` is used twice"),
            ("next_x = \"1\"", "the name `next_x` is used twice"),
            ("k = \"x\"", "the name `k` is used twice"),
            ("\"a b\" = \"x\"", "`a b` is not a valid name"),
            (&long, "is longer than 20000 characters"),
            ("a = 'site(\"tip\").x'", "site() and body() are places of a `model`, and there is none"),
        ] {
            let refusal = format!("{:#}", point(definitions, "u", "-x^2", "next_x > 9").err().unwrap());
            assert!(refusal.contains(says), "{definitions}: {refusal}");
        }
    }

    #[test]
    fn places_stand_in_definitions_alone() {
        let refusal = format!(
            "{:#}",
            point("", "u", "site('tip').x".replace('\'', "\\\"").as_str(), "next_x > 9").err().unwrap()
        );
        assert!(refusal.contains("site() and body() are allowed in [let] only"), "{refusal}");
    }
}
