//! What a run came to, for people.

use std::path::Path;

use sindyna_core::number::{fixed, plural, significant};
use sindyna_record::identification::Account;
use sindyna_record::run::{
    ChannelRange, Collect, Confirmation, Coverage, Improvable, PlannerReturn, Prediction, Span, Summary, Timing,
};
use sindyna_report::text;

use super::console::width;
use super::evaluate::report;
use super::pages;

/// What a run came to.
pub(super) struct Conclusion<'a> {
    pub(super) summary: &'a Summary,
    pub(super) timing: Option<&'a Timing>,
    pub(super) account: Option<&'a Account>,
    /// The equations of the ground-truth simulator, where there is one.
    pub(super) truth: &'a [String],
    /// Whether the model was one that a real episode should have confirmed.
    pub(super) unconfirmed: bool,
    pub(super) record: &'a Path,
    /// Whether there is a page.
    pub(super) page: bool,
}

impl Conclusion<'_> {
    pub(super) fn text(&self) -> String {
        let Summary { identification, training, evaluation, threshold, .. } = self.summary;
        let found = identification.as_ref().map_or(&[][..], |i| &i.equations);
        let mut text = match found {
            [] => "no equations were identified\n".into(),
            found => text::beside(("identified", found), ("ground truth", self.truth), width()),
        };
        if let Some(account) = self.account {
            text += &text::verdict(account);
        }
        let Summary { real_steps, real_episodes, .. } = self.summary;
        let steps = if self.summary.from_log { "steps in the log" } else { "real steps" };
        let of = if self.summary.from_log { "rollout" } else { "episode" };
        text += &format!("\n{steps}: {real_steps} in {}", plural(*real_episodes, of));
        text += &match identification.as_ref().map(|i| i.rows + i.rows_at_limit + i.rows_astray) {
            Some(rows) if rows < *real_steps => format!("; the equations were fitted to {rows} of them\n"),
            _ => "\n".into(),
        };
        if let Some(failure) = &training.refit_failure {
            text += &format!(
                "warning: all {real_steps} real steps do not fit one model ({failure}): these equations may be wrong\n"
            );
        }
        if let Some(model_return) = training.model_return {
            if training.planners.is_empty() {
                let converged = if training.converged { "converged" } else { "not converged" };
                text += &format!(
                    "training: {} updates, {converged}; mean return of its trials in the model {} (penalties for leaving the data included)\n",
                    training.updates,
                    fixed(model_return, 1)
                );
            } else {
                text += &planned(&training.planners, &training.algorithm);
            }
        }
        if let Some(improvable) = training.improvable.as_ref().filter(|improvable| improvable.is_large()) {
            text += &far(improvable);
        }
        if let Some(confirmation) = &training.confirmation {
            text += &confirmed(confirmation);
        }
        if let Some(prediction) = &training.prediction {
            let delayed = self.summary.input_delay_seconds.is_some();
            let approximate = identification.as_ref().is_some_and(|i| i.explained == Some(false));
            text += &predicted(
                prediction,
                evaluation.as_ref().map(|evaluation| evaluation.episodes),
                (approximate, delayed),
            );
            if training.confirmation.is_none() && !self.summary.from_log && self.unconfirmed {
                text += "not confirmed by a real episode; --imagined-rollouts auto and a larger --max-real-steps allow one\n";
            }
        }
        if let Some(delay) = self.summary.input_delay_seconds {
            text += &format!(
                "delay of the inputs: {} s; the policy acts on the state predicted for that time\n",
                significant(delay, 6)
            );
        }
        if let Some(lag) = self.summary.input_lag {
            text += &format!(
                "lag of the inputs: first order, {} s; what actuators deliver is part of the state, and computed from the actions\n",
                significant(lag, 6)
            );
        }
        if let Some(late) = &training.late {
            text += &report((None, "in the model, with inputs that act so late"), late, false);
        }
        if let Some(collect) = &training.collect {
            text += &wanted(collect);
        }
        if let Some(coverage) = &training.coverage {
            text += &covered(coverage);
        }
        if let Some(failure) = &training.failure {
            text += &format!("training ended early: {failure}\n");
        }
        text += &match evaluation {
            Some(evaluation) => report((*threshold, "on the system"), evaluation, false),
            None if self.summary.interrupted => format!(
                "interrupted before the end of {}; `sindyna train --resume {}` continues\n",
                if self.summary.from_log { "the comparison with the data" } else { "the evaluation on the system" },
                self.record.display()
            ),
            None if training.coverage.is_some() => String::new(),
            None if self.summary.from_log => "not evaluated: there is no system, only a log\n".into(),
            None if training.model_return.is_some() => "the policy was not evaluated on the system\n".into(),
            None => "no policy to evaluate: training ended before the first trial in the model\n".into(),
        };
        if let Some(seconds) = self.timing.and_then(|timing| timing.act_seconds) {
            text += &format!("one action takes {:.1} µs", 1e6 * seconds);
            let slowest = self.timing.and_then(|timing| timing.slowest_act_seconds);
            text += &slowest.map_or("\n".into(), |slowest| format!(", the slowest took {slowest:.3} s\n"));
        }
        if let Some(timing) = self.timing {
            let after = if evaluation.is_some() { "evaluation" } else { "figures of the report" };
            text += &format!(
                "seconds: {:.1} (identification {:.3}, training {:.1}, {after} {:.1})\n",
                timing.wall_seconds, timing.identify_seconds, timing.train_seconds, timing.evaluate_seconds
            );
        }
        text += &format!("record: {}\n", self.record.display());
        if self.page {
            text += &format!("report: {}\n", self.record.join(pages::PAGE).display());
        }
        text
    }
}

/// What planners earned in the model, and which was kept.
fn planned(planners: &[PlannerReturn], kept: &str) -> String {
    let each = planners.iter().map(|planner| format!("{} {}", planner.name, fixed(planner.model_return, 1)));
    let each = each.collect::<Vec<_>>().join(", ");
    let why =
        if planners.len() > 1 { format!("; {kept} is used: no other return is 1 % higher") } else { String::new() };
    format!("mean return of trials in the model: {each}{why}\n")
}

fn predicted(
    Prediction { mean, level, low, high }: &Prediction,
    episodes: Option<usize>,
    (approximate, delayed): (bool, bool),
) -> String {
    let place = if delayed { "in the model, without the delay" } else { "on the system" };
    let of = episodes.map_or_else(String::new, |episodes| format!(" of {}", plural(episodes, "episode")));
    format!(
        "predicted mean return{of} {place}: {} ({:.0} % interval {} to {}{})\n",
        significant(*mean, 4),
        100.0 * level,
        significant(*low, 4),
        significant(*high, 4),
        if approximate { "; parameter uncertainty only, the equations are an approximation" } else { "" }
    )
}

/// What to collect next.
fn wanted(Collect { share, states, controls }: &Collect) -> String {
    let mut text = format!(
        "the interval is wide. To narrow it, collect data where models drawn from the posterior disagree ({:.0} % of the disagreement is in a tenth of the steps):\n",
        100.0 * share
    );
    for Span { channel, unit, low, high } in states.iter().chain(controls) {
        text += &format!("  {channel} {} to {} {unit}\n", significant(*low, 3), significant(*high, 3));
    }
    text
}

/// Where the policy goes and what it does, and where the data were.
fn covered(Coverage { episodes, terminated, share_outside, states, controls }: &Coverage) -> String {
    let range = |(low, high): (f64, f64)| format!("{} to {}", significant(low, 3), significant(high, 3));
    let mut text = format!(
        "not evaluated: there is no system, only a log. In {} in the model, {:.0} % of the steps are beyond the data\n",
        plural(*episodes, "episode"),
        100.0 * share_outside
    );
    if *terminated > 0 {
        text += &format!("the task's condition for termination ended {terminated} of these episodes early\n");
    }
    for of in states.iter().chain(controls) {
        let ChannelRange { channel, unit, data, policy, .. } = of;
        let beyond = if of.is_beyond() { "  beyond the data" } else { "" };
        text += &format!("  {channel} {}: data {} {unit}{beyond}\n", range(*policy), range(*data));
    }
    text
}

/// How far a policy is from the best there is.
fn far(Improvable { episodes, policy, improved }: &Improvable) -> String {
    format!(
        "warning: in {} in the model the policy earns {}, and its actions improved by differential dynamic programming {}: it is far from the best; --controller ilqr may be nearer\n",
        plural(*episodes, "episode"),
        fixed(*policy, 1),
        fixed(*improved, 1)
    )
}

/// What came of the policy's real episode.
fn confirmed(confirmation: &Confirmation) -> String {
    let Confirmation { real, predicted, spread, agrees, .. } = confirmation;
    let mut text = format!(
        "confirmation episode: return {}, predicted {} ± {}\n",
        fixed(*real, 1),
        fixed(*predicted, 1),
        fixed(*spread, 1)
    );
    if !agrees {
        text += "warning: the return of the confirmation episode contradicts its prediction, or the models disagree about it: the policy may fail\n";
    }
    text
}
