//! What is known of tasks and methods besides their records.

use sindyna_core::Policy;
use sindyna_envs::System;

/// Facts about the tasks and methods of a comparison that no record holds. Whoever runs methods knows them.
pub trait Catalog {
    /// Names of the methods in their usual order, which is that of their colours; variants come last.
    fn methods(&self) -> Vec<&str>;

    /// The system of `task`, with its true equations; noise changes none of them.
    fn system(&self, task: &str) -> Option<System>;

    /// Whether `method` is a reference whose real steps say nothing: it knows what others have to learn, or learns nothing.
    fn is_reference(&self, method: &str) -> bool;

    /// Whether `method` goes on acting on the system until its budget is spent.
    fn is_online(&self, method: &str) -> bool;

    /// Real steps at the first check of a policy of `method` that has learned something; `None` where there are no checks.
    fn first_check(&self, method: &str, task: &str) -> Option<usize>;

    /// Whether `method` can be used on `task`.
    fn applies(&self, method: &str, task: &str) -> bool;

    /// A controller for `task`, written by hand, whose closed loops are drawn; `None` where there is none.
    fn expert(&self, _task: &str) -> Option<Box<dyn Policy>> {
        None
    }

    /// What a publication reports of `task`, to stand beside what is found here.
    fn published(&self, task: &str) -> Option<&Published>;

    /// Parameters of the publication's learned networks, as text.
    fn published_network_parameters(&self) -> &str;
}

/// What a publication reports of one task.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Published {
    /// Name of the task.
    pub task: &'static str,
    /// Rollouts for identification.
    pub rollouts: usize,
    /// Their length.
    pub rollout_len: usize,
    /// Dynamics learned, such as `exact`.
    pub dynamics: &'static str,
    /// Whether the policy generalises to the system.
    pub generalises: &'static str,
    /// Size of Ξ.
    pub parameters: usize,
    /// Coefficients that are not zero.
    pub nonzero: &'static str,
    /// Real steps of other methods over those of SINDy: names of methods here, and the factor.
    pub speed_ups: &'static [(&'static [&'static str], &'static str)],
}

impl Published {
    /// The factor that `method` is to be compared with.
    #[must_use]
    pub fn speed_up(&self, method: &str) -> Option<&'static str> {
        self.speed_ups.iter().find(|(methods, _)| methods.contains(&method)).map(|(_, factor)| *factor)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Some methods on the systems there are; networks are checked every 250 real steps.
    pub(crate) struct Some7;

    impl Catalog for Some7 {
        fn methods(&self) -> Vec<&str> {
            vec!["sindy", "mbpo", "sac", "truth", "lqr", "hand", "random"]
        }
        fn system(&self, task: &str) -> Option<System> {
            sindyna_envs::find(task)
        }
        fn is_reference(&self, method: &str) -> bool {
            ["truth", "hand", "random"].contains(&method)
        }
        fn is_online(&self, method: &str) -> bool {
            ["mbpo", "sac"].contains(&method)
        }
        fn first_check(&self, method: &str, _task: &str) -> Option<usize> {
            self.is_online(method).then_some(if method == "mbpo" { 500 } else { 250 })
        }
        fn applies(&self, method: &str, task: &str) -> bool {
            method != "lqr" || task == "cart-pole"
        }
        fn published(&self, _task: &str) -> Option<&Published> {
            None
        }
        fn published_network_parameters(&self) -> &str {
            "1"
        }
    }
}
