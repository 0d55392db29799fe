//! How many real steps it takes.

use crate::Comparison;
use crate::document::Block;
use crate::figure;
use crate::groups::Ratio;
use crate::numbers::{NONE, fixed, or_none, rough, with_interval};

pub(super) fn curves(comparison: &Comparison<'_>) -> Vec<Block> {
    let tasks = comparison.digest.tasks();
    let figures = tasks.into_iter().map(|task| figure::curves(comparison, task)).collect();
    vec![
        Block::Section("Learning curves".into()),
        Block::text(
            "At fixed numbers of real steps every seed's policy plays 100 episodes without exploration, from start states drawn anew for every check; \
             lines are the mean over the seeds that came to one, bands its 95\u{a0}% interval. The curves of sindy and of other models in its loop begin where their real steps end, because the policy \
             that is handed over is judged then. A run that has ended keeps its last score to the right. Dashed: methods whose \
             real steps say nothing (they know the equations, or learn nothing), with their return at the end. Dotted: the return that solves the task.",
        ),
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
            group.method.clone(),
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
        "over sindy",
        "over SINDy in the paper",
    ];
    vec![
        Block::table(2, head, rows.collect()),
        Block::text(
            "Solved: the mean return of 100 episodes from start states drawn anew reaches the task's threshold, for every method alike. Methods that learn on the system are judged so at \
             every check, and the first that reaches it counts; the others have one such check, at their end. First check: the real steps before which nothing can be solved, because the policy \
             has learned nothing or is not looked at. A run that never solves its task counts as infinitely long; \
             where that makes the ratio of a method with a budget infinite, “at least” says what it would be if all of those had solved it when that was spent. The paper does not say how many updates a \
             step its SAC makes, nor when it counts a task as solved; its one number for SAC stands beside both of ours.",
        ),
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
