//! Names that a comparison may have.

/// The names that a comparison may have, in their usual order: others become neither names of files nor text in pages.
#[derive(Debug, Clone, Copy)]
pub struct Names<'a> {
    /// Tasks that come along. Others may be called with letters, digits, `-` and `_`. Each may have noise, `TASK+noise-FRACTION`.
    pub tasks: &'a [&'a str],
    /// Methods. Each may have variants, `METHOD+NAME`.
    pub methods: &'a [&'a str],
}

/// What stands between a method and the name of its variant, and between a task and its noise.
const JOINT: char = '+';

/// What stands before the noise of a task.
const NOISE: &str = "noise-";

/// Characters of the name of a variant; a task has four times as many bytes.
const LONGEST: usize = 40;

impl Names<'_> {
    /// Whether a comparison may have the task `name`, or the task with noise.
    #[must_use]
    pub fn has_task(&self, name: &str) -> bool {
        let plain = |c: char| c.is_alphanumeric() || c == '-' || c == '_';
        let Some((task, noise)) = name.split_once(JOINT) else {
            return self.tasks.contains(&name) || ((1..=4 * LONGEST).contains(&name.len()) && name.chars().all(plain));
        };
        let noise = noise.strip_prefix(NOISE).and_then(|noise| noise.parse::<f64>().ok());
        // As it is written here and nowhere else, so that a task has one name.
        self.has_task(task) && noise.is_some_and(|noise| noise.is_finite() && noisy(task, noise) == name && noise > 0.0)
    }

    /// Whether a comparison may have the method `name`, or the variant.
    #[must_use]
    pub fn has_method(&self, name: &str) -> bool {
        let variant = name.split_once(JOINT).map(|(_, variant)| variant);
        self.methods.contains(&base(name)) && variant.is_none_or(is_variant)
    }
}

/// The method that the method or variant `name` is, or is a variant of; the task of which `name` is the one with noise.
#[must_use]
pub fn base(name: &str) -> &str {
    name.split_once(JOINT).map_or(name, |(base, _)| base)
}

/// The name of the variant `name` of `method`.
#[must_use]
pub fn variant(method: &str, name: &str) -> String {
    format!("{method}{JOINT}{name}")
}

/// What a comparison calls `task` where its sensors have noise whose standard deviation is the fraction `noise` of their scales.
#[must_use]
pub fn noisy(task: &str, noise: f64) -> String {
    if noise == 0.0 { task.to_owned() } else { format!("{task}{JOINT}{NOISE}{noise}") }
}

/// Whether `name` can be that of a variant: letters, digits, `-` and `_`.
#[must_use]
pub fn is_variant(name: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    (1..=LONGEST).contains(&name.len()) && name.chars().all(plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_task_with_noise_has_one_name() {
        let names = Names { tasks: &["pendulum"], methods: &["sac"] };
        assert_eq!(
            (noisy("pendulum", 0.0), noisy("pendulum", 0.01)),
            ("pendulum".into(), "pendulum+noise-0.01".into())
        );
        for name in ["pendulum", "pendulum+noise-0.01", "mine+noise-1", "my-own_task"] {
            assert!(names.has_task(name), "{name}");
        }
        for name in [
            "pendulum+",
            "pendulum+noise-",
            "pendulum+noise-0",
            "pendulum+noise--1",
            "pendulum+noise-0.010",
            "pendulum+noise-inf",
            "pendulum+0.01",
            "+noise-1",
            "a+noise-1+noise-1",
        ] {
            assert!(!names.has_task(name), "{name}");
        }
        assert_eq!(base("pendulum+noise-0.01"), "pendulum");
    }
}
