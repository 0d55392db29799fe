//! What is known of tasks and methods besides the records of their runs.

use sindyna_envs::System;
use sindyna_record::comparison::Names;
use sindyna_report::{Catalog, Published};

use super::{Method, first_check, paper};

/// The methods and tasks that can be compared.
pub(crate) struct Known;

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
    /// Names of the tasks.
    pub(crate) fn tasks() -> Vec<&'static str> {
        sindyna_envs::systems().iter().map(System::name).collect()
    }

    /// The names that a comparison of these `tasks` may have.
    pub(crate) fn names<'a>(tasks: &'a [&'a str]) -> Names<'a> {
        Names { tasks, methods: &METHODS }
    }
}

impl Catalog for Known {
    fn methods(&self) -> &[&'static str] {
        &METHODS
    }

    fn system(&self, task: &str) -> Option<System> {
        sindyna_envs::find(task)
    }

    fn is_reference(&self, method: &str) -> bool {
        Method::named(method).is_ok_and(Method::is_reference)
    }

    fn is_online(&self, method: &str) -> bool {
        Method::named(method).is_ok_and(Method::is_online)
    }

    fn first_check(&self, method: &str, task: &str) -> Option<usize> {
        first_check(Method::named(method).ok()?, sindyna_envs::find(task)?.spec())
    }

    fn applies(&self, method: &str, task: &str) -> bool {
        Method::named(method).is_ok_and(|method| method.fits(task))
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
