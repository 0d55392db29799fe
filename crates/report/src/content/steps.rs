//! How many real steps it takes.

use super::settings::check_episodes;
use crate::Comparison;
use crate::document::Block;
use crate::figure;
use crate::groups::Ratio;
use crate::names::method_name;
use crate::numbers::{NONE, fixed, or_none, rough, with_interval};

/// What a check is, as far as the records say.
fn check(comparison: &Comparison<'_>) -> String {
    let episodes = check_episodes(&comparison.digest.settings).unwrap_or_else(|| "its episodes".into());
    format!("{episodes} without exploration, from start states drawn anew")
}

pub(super) fn curves(comparison: &Comparison<'_>) -> Vec<Block> {
    let tasks = comparison.digest.tasks();
    let figures = tasks.into_iter().flat_map(|task| figure::curves(comparison, task)).collect();
    vec![
        Block::Section("Learning curves".into()),
        Block::text(format!(
            "At fixed numbers of real steps the policy of each seed is checked: {}. \
             Lines: mean over seeds; bands: its 95\u{a0}% interval. The first figure of a task has all returns, the second the returns from the threshold up, \
             on an axis of its own, where methods that solve the task can be told apart. The curves of sindy, least-squares and ensemble begin where their real steps end: \
             their policy is evaluated once. A run that has ended keeps its last return to the right. Dashed: methods without real steps of their own (oracle, expert, random), \
             with their return at the end. Dotted: the threshold.",
            check(comparison)
        )),
        Block::Figures(figures),
    ]
}

/// The table of speed-ups, beside the paper's.
pub(crate) fn speed_ups(comparison: &Comparison<'_>) -> Vec<Block> {
    let rows = comparison.groups.iter().filter_map(|group| {
        let steps = group.steps.as_ref()?;
        let range = steps.range.map(|(least, most)| format!("{}–{}", fixed(least as f64, 0), fixed(most as f64, 0)));
        let theirs = comparison.catalog.published(&group.task).and_then(|row| row.speed_up(&group.method));
        Some([
            group.task.clone(),
            method_name(&group.method),
            format!("{} of {}", group.solved, group.runs),
            with_interval(steps.median, steps.interval, |v| fixed(v, 0)),
            or_none(range),
            or_none(steps.first_check.map(|steps| fixed(steps as f64, 0))),
            steps.over_sindy.as_ref().map_or_else(|| NONE.into(), times),
            or_none(theirs.map(String::from)),
        ])
    });
    let head = [
        "task",
        "method",
        "solved",
        "real steps, median",
        "least–most",
        "first check",
        "ratio to sindy",
        "ratio to SINDy in the paper",
    ];
    vec![
        Block::table(2, head, rows.collect()),
        Block::text(format!(
            "Solved: the mean return of a check ({}) reaches the threshold of the task. Methods that learn on the system are checked at intervals, \
             and the first check that reaches the threshold counts; the others are checked once, at their end. First check: the real steps before which a method cannot solve a task, \
             because its policy has learned nothing or is not checked. A run that never solves its task counts as infinitely long. \
             “At least” is the ratio if all of these had solved it when their budget was spent. The paper does not say how many updates a \
             step its SAC makes, nor when it counts a task as solved; its one number for SAC stands beside both of ours.",
            check(comparison)
        )),
    ]
}

/// A ratio with its interval.
fn times(ratio: &Ratio) -> String {
    let text = with_interval(ratio.value, ratio.interval, rough);
    match ratio.at_least {
        Some(least) => format!("{text}, at least {}", rough(least)),
        None => text,
    }
}
