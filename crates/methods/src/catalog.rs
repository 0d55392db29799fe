//! What is known of tasks and methods besides the records of their runs.

use sindyna_core::Policy;
use sindyna_envs::System;
use sindyna_record::comparison::{Digest, Names, base};
use sindyna_report::{Catalog, Published};

use super::{Method, first_check, paper};

/// The methods and tasks that can be compared, and the variants of a comparison.
pub struct Known {
    variants: Vec<String>,
}

/// Names of all methods, in the order of [`Method::ALL`].
static METHODS: [&str; Method::ALL.len()] = {
    let mut names = [""; Method::ALL.len()];
    let mut i = 0;
    while i < names.len() {
        names[i] = Method::ALL[i].name();
        i += 1;
    }
    names
};

impl Known {
    /// What is known besides `digest`, which may have variants.
    pub fn of(digest: &Digest) -> Self {
        let variants = digest.methods().into_iter().filter(|method| !METHODS.contains(method));
        Self { variants: variants.map(String::from).collect() }
    }

    /// Names of the tasks.
    pub fn tasks() -> Vec<&'static str> {
        sindyna_envs::systems().iter().map(System::name).collect()
    }

    /// The names that a comparison of these `tasks` may have.
    pub fn names<'a>(tasks: &'a [&'a str]) -> Names<'a> {
        Names { tasks, methods: &METHODS }
    }
}

impl Catalog for Known {
    fn methods(&self) -> Vec<&str> {
        METHODS.into_iter().chain(self.variants.iter().map(String::as_str)).collect()
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
        assert_eq!(METHODS.len(), sindyna_report::METHOD_COLOURS);
    }
}
