//! What the paper reports, to stand beside what is found here.
//!
//! Arora, da Silva, Moss (2022), *Model-Based Reinforcement Learning with SINDy*: Table 1, and the speed-ups of Figure 1.

use sindyna_report::Published;

const MBPO: &[&str] = &["mbpo", "mbpo-paper"];
const SAC: &[&str] = &["sac", "sac20"];

/// Numbers in the model of the paper's MBPO.
pub(crate) const MBPO_PARAMETERS: &str = "613,036";

/// What the paper says of the task called `task`.
pub(crate) fn row(task: &str) -> Option<&'static Published> {
    ROWS.iter().find(|row| row.task == task)
}

static ROWS: [Published; 4] = [
    Published {
        task: "cart-pole",
        rollouts: 1,
        rollout_len: 30,
        dynamics: "approximate",
        generalises: "yes",
        parameters: 164,
        nonzero: "~70",
        speed_ups: &[(SAC, "5")],
    },
    Published {
        task: "mountain-car",
        rollouts: 1,
        rollout_len: 50,
        dynamics: "exact",
        generalises: "yes",
        parameters: 50,
        nonzero: "7",
        speed_ups: &[(MBPO, "200"), (SAC, "500")],
    },
    Published {
        task: "pendulum",
        rollouts: 1,
        rollout_len: 20,
        dynamics: "exact",
        generalises: "yes",
        parameters: 99,
        nonzero: "10",
        speed_ups: &[(MBPO, "40"), (SAC, "60")],
    },
    Published {
        task: "inverted-pendulum",
        rollouts: 1,
        rollout_len: 30,
        dynamics: "approximate",
        generalises: "yes",
        parameters: 164,
        nonzero: "50",
        speed_ups: &[(MBPO, "4–100"), (SAC, "15–375")],
    },
];
