//! What a comparison comes to, in numbers.

use serde::Serialize;

use super::Outcome;
use super::method::is_anchor;
use super::outcome::mean;

/// All seeds of one method on one task.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Group {
    pub(crate) task: String,
    pub(crate) method: String,
    pub(crate) runs: usize,
    pub(crate) solved: usize,
    /// Median of the real steps until solved; those that never solve it count as infinite. None for methods of which real steps
    /// say nothing.
    pub(crate) steps_median: Option<f64>,
    /// Least and most of those that solved it.
    pub(crate) steps_range: Option<(usize, usize)>,
    /// Mean over seeds of the mean return at the end; of those that came to an evaluation.
    pub(crate) mean_return: Option<f64>,
    /// Interquartile mean of the returns of all episodes of all seeds.
    pub(crate) interquartile_mean: Option<f64>,
    /// Lowest mean return of a seed.
    pub(crate) lowest_return: Option<f64>,
    pub(crate) model_parameters: Option<usize>,
    pub(crate) failures: usize,
}

/// One group for each task and method, in the order in which they come first.
pub(crate) fn groups(outcomes: &[Outcome]) -> Vec<Group> {
    let mut keys: Vec<(&str, &str)> = Vec::new();
    for outcome in outcomes {
        let key = (outcome.task.as_str(), outcome.method.as_str());
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    let of = |(task, method): (&str, &str)| {
        let runs: Vec<&Outcome> = outcomes.iter().filter(|o| o.task == task && o.method == method).collect();
        group(task, method, &runs)
    };
    keys.into_iter().map(of).collect()
}

fn group(task: &str, method: &str, runs: &[&Outcome]) -> Group {
    let steps: Vec<usize> = runs.iter().filter_map(|o| o.solved_after).collect();
    let means: Vec<f64> = runs.iter().filter_map(|o| o.mean_return()).collect();
    let all: Vec<f64> = runs.iter().flat_map(|o| o.returns.iter().copied()).collect();
    let with_infinite = runs.iter().map(|o| o.solved_after.map_or(f64::INFINITY, |s| s as f64)).collect();
    Group {
        task: task.into(),
        method: method.into(),
        runs: runs.len(),
        solved: steps.len(),
        steps_median: median(with_infinite).filter(|m| m.is_finite() && !is_anchor(method)),
        steps_range: steps.iter().min().copied().zip(steps.iter().max().copied()).filter(|_| !is_anchor(method)),
        mean_return: (!means.is_empty()).then(|| mean(&means)),
        interquartile_mean: interquartile_mean(all),
        lowest_return: means.iter().copied().min_by(f64::total_cmp),
        model_parameters: runs.iter().find_map(|o| o.model_parameters),
        failures: runs.iter().filter(|o| o.failure.is_some()).count(),
    }
}

/// The middle value, or the mean of the two in the middle.
fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    let middle = |i: usize| values.get(i).copied();
    if n.is_multiple_of(2) { Some(0.5 * (middle((n / 2).checked_sub(1)?)? + middle(n / 2)?)) } else { middle(n / 2) }
}

/// The mean of the middle half of the values (Agarwal et al. 2021).
fn interquartile_mean(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let cut = values.len() / 4;
    let middle = values.get(cut..values.len() - cut).filter(|m| !m.is_empty())?;
    Some(mean(middle))
}

/// The groups as a table, with the factor by which each method needs more real steps than `sindy`.
pub(crate) fn markdown(groups: &[Group]) -> String {
    let mut text = String::from(
        "| task | method | solved | real steps until solved, median (least–most) | times those of sindy | return, mean of seeds (lowest) | interquartile mean |\n\
         |---|---|---|---|---|---|---|\n",
    );
    for group in groups {
        let ours = groups.iter().find(|g| g.task == group.task && g.method == "sindy").and_then(|g| g.steps_median);
        let ratio = group.steps_median.zip(ours).filter(|(_, ours)| *ours > 0.0).map(|(steps, ours)| steps / ours);
        let steps = match (group.steps_median, group.steps_range) {
            (Some(median), Some((least, most))) => format!("{median:.0} ({least}–{most})"),
            (None, Some((least, most))) => format!("never for half of them ({least}–{most})"),
            _ if is_anchor(&group.method) => "–".into(),
            _ => "never".into(),
        };
        text += &format!(
            "| {} | {} | {} of {} | {steps} | {} | {} ({}) | {} |\n",
            group.task,
            group.method,
            group.solved,
            group.runs,
            ratio.map_or_else(|| "–".into(), |r| format!("{r:.0}")),
            shown(group.mean_return),
            shown(group.lowest_return),
            shown(group.interquartile_mean),
        );
    }
    text
}

fn shown(value: Option<f64>) -> String {
    value.map_or_else(|| "–".into(), |v| format!("{v:.1}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_count_those_that_never_solve_it() {
        let run = |seed: u64, solved_after| Outcome {
            solved_after,
            returns: vec![seed as f64; 4],
            ..Outcome::new("any", "sac", seed)
        };
        let runs = [run(0, Some(100)), run(1, None), run(2, Some(300))];
        let groups = groups(&runs);
        assert_eq!(groups.len(), 1);
        assert_eq!(
            (groups[0].solved, groups[0].steps_median, groups[0].steps_range),
            (2, Some(300.0), Some((100, 300)))
        );
        assert_eq!((groups[0].mean_return, groups[0].lowest_return), (Some(1.0), Some(0.0)));
        let worse = [run(0, None), run(1, None), run(2, Some(300))];
        assert_eq!(super::groups(&worse)[0].steps_median, None);
    }

    #[test]
    fn the_interquartile_mean_leaves_out_both_ends() {
        assert_eq!(interquartile_mean(vec![-1e9, 1.0, 3.0, 1e9]), Some(2.0));
        assert_eq!(interquartile_mean(vec![5.0]), Some(5.0));
        assert_eq!(interquartile_mean(vec![]), None);
        assert_eq!(median(vec![]), None);
        assert_eq!(median(vec![4.0, 1.0]), Some(2.5));
    }
}
