//! What models and training cost.

use sindyna_record::comparison::Digest;

use crate::Comparison;
use crate::document::Block;
use crate::groups::Group;
use crate::numbers::{fixed, or_none, rough};
use crate::stats::median;

pub(super) fn costs(comparison: &Comparison<'_>) -> Vec<Block> {
    let Comparison { digest, groups, .. } = comparison;
    let row = |group: &Group| {
        let of_group = |task: &str, method: &str| task == group.task && method == group.method;
        let seconds: Vec<f64> =
            digest.times.iter().filter(|t| of_group(&t.task, &t.method)).map(|t| t.wall_seconds).collect();
        let count = |value: Option<f64>| or_none(value.map(|v| fixed(v, 0)));
        [
            group.task.clone(),
            group.method.clone(),
            count(group.parameters_median),
            count(group.updates_median),
            count(group.model_steps_median),
            or_none(median(&seconds).map(rough)),
        ]
    };
    let head = ["task", "method", "parameters of the model", "updates", "steps of the model", "wall time [s]"];
    vec![
        Block::Section("Models and costs".into()),
        Block::text(format!(
            "Medians over seeds. Parameters: coefficients that were fitted and are not zero, or weights of networks. Wall time is that of \
             a whole run with all its checks on one core, which it may have had to share, so it tells orders of magnitude. Added up: {}.",
            totals(digest)
        )),
        Block::table(2, head, groups.iter().map(row).collect()),
    ]
}

/// The time that all runs of each method took together.
fn totals(digest: &Digest) -> String {
    let hours = |method: &str| {
        let seconds: f64 = digest.times.iter().filter(|t| t.method == method).map(|t| t.wall_seconds).sum();
        format!(
            "{method} {}",
            if seconds < 3600.0 { format!("{seconds:.0} s") } else { format!("{:.1} h", seconds / 3600.0) }
        )
    };
    digest.methods().into_iter().map(hours).collect::<Vec<_>>().join(", ")
}
