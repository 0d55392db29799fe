//! What is known of tasks and methods besides the records of their runs.

use sindyna_core::Policy;
use sindyna_envs::System;
use sindyna_record::comparison::{Digest, Names, base};
use sindyna_report::{Catalog, Published};

use super::{Method, first_check, paper};

/// The methods and tasks that can be compared, and the variants of a comparison.
pub struct Known {
    /// The methods in the order of [`Method::ALL`], by the names their runs have, then variants.
    methods: Vec<String>,
}

/// Names that runs may have: those of all methods, and old ones.
static NAMES: [&str; Method::ALL.len() + 2] = {
    let mut names = [""; Method::ALL.len() + 2];
    let mut i = 0;
    while i < Method::ALL.len() {
        names[i] = Method::ALL[i].name();
        i += 1;
    }
    (names[i], names[i + 1]) = ("truth", "hand");
    names
};

impl Known {
    /// What is known besides `digest`, which may have variants.
    pub fn of(digest: &Digest) -> Self {
        let there = digest.methods();
        let recorded =
            |method: Method| there.iter().find(|name| NAMES.contains(name) && Method::of_run(name) == Some(method));
        let mut methods: Vec<String> = Method::ALL
            .map(|method| recorded(method).map_or_else(|| method.name().into(), |name| (*name).into()))
            .into();
        let variants: Vec<String> =
            there.iter().filter(|name| methods.iter().all(|m| m != *name)).map(|name| (*name).into()).collect();
        methods.extend(variants);
        Self { methods }
    }

    /// Names of the tasks.
    pub fn tasks() -> Vec<&'static str> {
        sindyna_envs::systems().iter().map(System::name).collect()
    }

    /// The names that a comparison of these `tasks` may have.
    pub fn names<'a>(tasks: &'a [&'a str]) -> Names<'a> {
        Names { tasks, methods: &NAMES }
    }
}

impl Catalog for Known {
    fn methods(&self) -> Vec<&str> {
        self.methods.iter().map(String::as_str).collect()
    }

    fn system(&self, task: &str) -> Option<System> {
        sindyna_envs::find(base(task))
    }

    fn is_reference(&self, method: &str) -> bool {
        Method::of_run(method).is_some_and(Method::is_reference)
    }

    fn is_online(&self, method: &str) -> bool {
        Method::of_run(method).is_some_and(Method::is_online)
    }

    fn first_check(&self, method: &str, task: &str) -> Option<usize> {
        first_check(Method::of_run(method)?, sindyna_envs::find(base(task))?.spec())
    }

    fn applies(&self, method: &str, task: &str) -> bool {
        Method::of_run(method).is_some_and(|method| method.fits(base(task)))
    }

    fn expert(&self, task: &str) -> Option<Box<dyn Policy>> {
        sindyna_control::ByHand::new(base(task)).map(|expert| Box::new(expert) as Box<dyn Policy>)
    }

    fn published(&self, task: &str) -> Option<&Published> {
        paper::row(task)
    }

    fn published_network_parameters(&self) -> &str {
        paper::MBPO_PARAMETERS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_has_a_colour() {
        assert_eq!(Method::ALL.len(), sindyna_report::METHOD_COLOURS);
    }
}
