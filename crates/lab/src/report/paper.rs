//! What the paper reports, to stand beside what is found here.
//!
//! Arora, da Silva, Moss (2022), *Model-Based Reinforcement Learning with SINDy*: Table 1, and the speed-ups of Figure 1.

/// A row of Table 1, with the speed-ups of the task.
pub(crate) struct Row {
    pub(crate) task: &'static str,
    /// Rollouts for identification.
    pub(crate) rollouts: usize,
    /// Their length.
    pub(crate) rollout_len: usize,
    /// Dynamics learned.
    pub(crate) dynamics: &'static str,
    /// Whether the policy generalises to the real system.
    pub(crate) generalises: &'static str,
    /// Size of Ξ.
    pub(crate) parameters: usize,
    /// Those that are not zero.
    pub(crate) nonzero: &'static str,
    /// Real steps of MBPO over those of SINDy.
    pub(crate) over_mbpo: Option<&'static str>,
    /// Real steps of SAC over those of SINDy.
    pub(crate) over_sac: Option<&'static str>,
}

/// Numbers in the model of the paper's MBPO.
pub(crate) const MBPO_PARAMETERS: &str = "613,036";

/// What the paper says of the task called `task`.
pub(crate) fn row(task: &str) -> Option<&'static Row> {
    ROWS.iter().find(|row| row.task == task)
}

const ROWS: [Row; 4] = [
    Row {
        task: "cart-pole",
        rollouts: 1,
        rollout_len: 30,
        dynamics: "approximate",
        generalises: "yes",
        parameters: 164,
        nonzero: "~70",
        over_mbpo: None,
        over_sac: Some("5"),
    },
    Row {
        task: "mountain-car",
        rollouts: 1,
        rollout_len: 50,
        dynamics: "exact",
        generalises: "yes",
        parameters: 50,
        nonzero: "7",
        over_mbpo: Some("200"),
        over_sac: Some("500"),
    },
    Row {
        task: "pendulum",
        rollouts: 1,
        rollout_len: 20,
        dynamics: "exact",
        generalises: "yes",
        parameters: 99,
        nonzero: "10",
        over_mbpo: Some("40"),
        over_sac: Some("60"),
    },
    Row {
        task: "inverted-pendulum",
        rollouts: 1,
        rollout_len: 30,
        dynamics: "approximate",
        generalises: "yes",
        parameters: 164,
        nonzero: "50",
        over_mbpo: Some("4–100"),
        over_sac: Some("15–375"),
    },
];

impl Row {
    /// The speed-up that a method of ours is to be compared with.
    pub(crate) fn speed_up(&self, method: &str) -> Option<&'static str> {
        match method {
            "mbpo" | "mbpo-paper" => self.over_mbpo,
            "sac" | "sac20" => self.over_sac,
            _ => None,
        }
    }
}
