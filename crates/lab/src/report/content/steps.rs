//! How many real steps it takes.

use crate::report::digest::Digest;
use crate::report::document::Block;
use crate::report::figure;
use crate::report::groups::{Group, Ratio};
use crate::report::paper;
use crate::report::shown::{NONE, fixed, or_none, rough, with_interval};

pub(super) fn curves(digest: &Digest, groups: &[Group]) -> Vec<Block> {
    let figures = digest.tasks().into_iter().map(|task| figure::curves(digest, groups, task)).collect();
    vec![
        Block::Section("Learning curves".into()),
        Block::text(
            "The paper's protocol: at fixed numbers of real steps every seed's policy plays ten episodes without exploration; \
             lines are the mean over the seeds that came to one, bands its 95\u{a0}% interval. SINDy's curve begins where its real steps end, because they are \
             all spent before anything is learned. A run that has ended keeps its last score to the right. Dashed: methods whose \
             real steps say nothing (they know the equations, or learn nothing), with their return at the end. Dotted: the return that solves the task.",
        ),
        Block::Figures(figures),
    ]
}

/// The table of speed-ups, beside the paper's.
pub(in crate::report) fn speed_ups(groups: &[Group]) -> Vec<Block> {
    let rows = groups.iter().filter_map(|group| {
        let steps = group.steps.as_ref()?;
        let range = steps.range.map(|(least, most)| format!("{}–{}", fixed(least as f64, 0), fixed(most as f64, 0)));
        let theirs = paper::row(&group.task).and_then(|row| row.speed_up(&group.method));
        Some([
            group.task.clone(),
            group.method.clone(),
            format!("{} of {}", group.solved, group.runs),
            with_interval(steps.median, steps.interval, |v| fixed(v, 0)),
            or_none(range),
            steps.over_sindy.as_ref().map_or_else(|| NONE.into(), times),
            or_none(theirs.map(String::from)),
        ])
    });
    let head =
        ["task", "method", "solved", "real steps, median", "least–most", "over sindy", "over SINDy in the paper"];
    vec![
        Block::table(2, head, rows.collect()),
        Block::text(
            "Solved: for methods that learn on the real system, the first of three checks in a row that all reach the task's mark; for \
             the others, the mean return of 100 episodes at the end. A run that never solves its task counts as infinitely long; \
             where that makes the ratio infinite, “at least” says what it would be if all of those had solved it as soon as their last checks allow. The paper does not say how many updates a \
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
