//! The whole report, and what is not in it.

use sindyna_record::comparison::{Digest, base};

use super::steps::speed_ups;
use super::{costs, findings, found, returns, settings, steps};
use crate::document::Block;
use crate::equations::equations;
use crate::names::method_name;
use crate::numbers::plural;
use crate::scores::scales;
use crate::{Catalog, Comparison, Page};

const TITLE: &str = "How many real steps each method needs";

impl Comparison<'_> {
    /// Everything that is to be said.
    #[must_use]
    pub fn report(&self) -> Page {
        Page { title: TITLE.into(), blocks: blocks(self) }
    }

    /// The table of real steps alone.
    #[must_use]
    pub fn steps_table(&self) -> Page {
        let mut blocks = speed_ups(self);
        blocks.extend(self.gaps().map(Block::Text));
        Page { title: TITLE.into(), blocks }
    }

    /// Pairs of task and method that have fewer seeds than were asked for, or than others, and why some have none.
    #[must_use]
    pub fn gaps(&self) -> Option<String> {
        gaps(self.digest, self.catalog)
    }
}

/// The report on a comparison.
fn blocks(comparison: &Comparison<'_>) -> Vec<Block> {
    let Comparison { digest, catalog, .. } = *comparison;
    let found = equations(digest, catalog);
    let scales = scales(digest);
    let mut blocks = findings::findings(comparison, &found, &scales);
    blocks.push(Block::Section("Records".into()));
    blocks.push(Block::text(overview(digest)));
    blocks.extend(settings::origin(&digest.settings).map(Block::Text));
    blocks.extend(gaps(digest, catalog).map(Block::Text));
    blocks.push(settings::block(&digest.settings));
    blocks.extend(steps::curves(comparison));
    blocks.extend(costs::against_time(comparison));
    blocks.push(Block::Section("Real steps until solved".into()));
    blocks.extend(speed_ups(comparison));
    blocks.extend(returns::returns(comparison));
    blocks.extend(returns::one_scale(comparison, &scales));
    blocks.extend(found::equations(&found));
    blocks.extend(found::portraits(comparison, &found));
    blocks.extend(found::table_of_the_paper(comparison, &found));
    blocks.extend(costs::costs(comparison));
    blocks
}

fn overview(digest: &Digest) -> String {
    let (tasks, methods) = (digest.tasks(), digest.methods());
    let mut seeds: Vec<u64> = digest.runs.iter().map(|run| run.seed).collect();
    seeds.sort_unstable();
    seeds.dedup();
    let noise = if tasks.iter().any(|task| base(task) != *task) {
        " A task called TASK+noise-F has sensors with Gaussian noise, independent from step to step, whose standard deviation is the fraction F of \
         each channel's scale; it is unknown to all methods, and policies are evaluated under it."
    } else {
        ""
    };
    format!(
        "{} of {} on {}, {}: all that were in the directory of the comparison. Numbers in brackets are 95\u{a0}% bootstrap intervals over seeds \
         (percentile, 10,000 samples, each task and method drawn from itself).{noise}",
        plural(digest.runs.len(), "run"),
        plural(methods.len(), "method"),
        plural(tasks.len(), "task"),
        plural(seeds.len(), "seed")
    )
}

/// Pairs of task and method that have fewer seeds than were asked for, or than others, and why some have none.
pub(crate) fn gaps(digest: &Digest, catalog: &dyn Catalog) -> Option<String> {
    let asked = |task: &str, method: &str| {
        digest.asked.iter().find(|a| a.task == task && a.method == method).map(|a| a.seeds.count())
    };
    let count = |task: &str, method: &str| digest.of(task, method).count();
    let named = digest.asked.iter().map(|a| (a.task.as_str(), a.method.as_str()));
    let (mut tasks, mut methods) = (digest.tasks(), digest.methods());
    for (task, method) in named {
        if !tasks.contains(&task) {
            tasks.push(task);
        }
        if !methods.contains(&method) {
            methods.push(method);
        }
    }
    let pairs = || tasks.iter().flat_map(|task| methods.iter().map(move |method| (*task, *method)));
    let most = pairs().map(|(task, method)| count(task, method)).max().unwrap_or(0);
    let gap = |(task, method): (&str, &str)| {
        let (few, name) = (count(task, method), method_name(method));
        match asked(task, method) {
            Some(all) if few < all => {
                Some(format!("{name} on {task} has {few} of the {} asked for", plural(all, "run")))
            }
            _ if few == 0 && catalog.methods().contains(&method) && !catalog.applies(method, task) => {
                Some(format!("{name} does not apply to {task}"))
            }
            _ if few < most => Some(format!("{name} on {task} has {} of {most}", plural(few, "run"))),
            _ => None,
        }
    };
    let gaps: Vec<String> = pairs().filter_map(gap).collect();
    (!gaps.is_empty()).then(|| format!("Not included: {}.", gaps.join("; ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::tests::Some7;
    use sindyna_record::comparison::{Outcome, Request, Seeds};

    #[test]
    fn gaps_are_told() {
        let mut digest = Digest::default();
        for (task, method, seed) in [
            ("pendulum", "sac", 0),
            ("pendulum", "sac", 1),
            ("cart-pole", "lqr", 0),
            ("cart-pole", "lqr", 1),
            ("cart-pole", "sac", 0),
        ] {
            digest.add(&Outcome::new(task, method, seed), None);
        }
        let told = gaps(&digest, &Some7).expect("there are gaps");
        assert_eq!(told, "Not included: lqr does not apply to pendulum; sac on cart-pole has 1 run of 2.");
        let asked =
            |task: &str, method: &str| Request { task: task.into(), method: method.into(), seeds: Seeds::first(3) };
        digest.asked = vec![asked("cart-pole", "sac"), asked("mountain-car", "sindy")];
        let told = gaps(&digest, &Some7).expect("there are gaps");
        assert!(told.contains("sac on cart-pole has 1 of the 3 runs asked for"), "{told}");
        assert!(told.contains("sindy on mountain-car has 0 of the 3 runs asked for"), "{told}");
        assert!(overview(&digest).starts_with("5 runs of 2 methods on 2 tasks, 2 seeds"));
    }

    #[test]
    fn a_report_has_all_its_sections_whatever_there_is() {
        let mut digest = Digest::default();
        digest.add(&Outcome::new("pendulum", "sac", 0), None);
        let blocks = blocks(&Comparison::new(&digest, &Some7));
        let sections: Vec<&str> = blocks
            .iter()
            .filter_map(|block| if let Block::Section(name) = block { Some(name.as_str()) } else { None })
            .collect();
        let expected = [
            "Findings",
            "Records",
            "Learning curves",
            "Real steps until solved",
            "Returns at the end",
            "All tasks on one scale",
            "Equations found",
            "Phase portraits",
            "Table 1 of the paper",
            "Models and costs",
        ];
        assert_eq!(sections, expected);
    }
}
