//! The equations found, and what they are worth.

use crate::document::Block;
use crate::equations::{Equations, Judged, Summand};
use crate::figure;
use crate::numbers::{NONE, or_none, plural, rough, significant};
use crate::portrait::{Portrait, closed_loop, portrait};
use crate::stats::median;
use crate::{Comparison, Figure};

pub(super) fn equations(found: &[Equations]) -> Vec<Block> {
    let mut blocks = vec![
        Block::Section("Equations found".into()),
        Block::text(
            "True terms: the true rates satisfy the equations found with exactly one set of coefficients, none of them zero. Equations \
             that can be solved for a rate can be written in several ways; each is compared with the true coefficients in the \
             same form, which follow from the true rates over the whole box of states. The error of a seed is the largest relative error of \
             any of its coefficients.",
        ),
    ];
    if found.is_empty() {
        blocks.push(Block::text("No run here has equations."));
        return blocks;
    }
    let row = |found: &Equations| {
        let errors = found.errors();
        [
            found.task.clone(),
            format!("{} of {}", found.true_terms(), found.judged.len()),
            or_none(errors.map(|(median, _)| significant(median, 2))),
            or_none(errors.map(|(_, largest)| significant(largest, 2))),
        ]
    };
    let head = ["task", "seeds with the true terms", "error, median", "error, largest"];
    blocks.push(Block::table(1, head, found.iter().map(row).collect()));
    for task in found {
        let Some(first) = task.judged.first() else { continue };
        blocks.push(Block::Part(task.task.clone()));
        let truth = task.system.true_equations().join("\n  ");
        let ours = first.model.equations().join("\n  ");
        blocks.push(Block::Code(format!(
            "true\n  {truth}\n\nfound with seed {} from {} in {}\n  {ours}",
            first.seed,
            plural(first.real_steps, "real step"),
            plural(first.real_episodes, "episode")
        )));
        blocks.extend(first.summands.as_ref().map(|summands| coefficients(first, summands)));
    }
    blocks
}

/// The coefficients of one model beside the true ones.
fn coefficients(judged: &Judged, summands: &[Summand]) -> Block {
    let row = |summand: &Summand| {
        let state = &judged.model.states()[summand.equation];
        let digits = |value: f64| significant(value, 9);
        [
            format!("d{state}/dt"),
            summand.term.clone(),
            digits(summand.truth),
            digits(summand.found),
            significant(summand.relative_error(), 2),
        ]
    };
    let head = ["equation of", "term", "true coefficient", "identified", "relative error"];
    Block::table(2, head, summands.iter().map(row).collect())
}

pub(super) fn portraits(comparison: &Comparison<'_>, found: &[Equations]) -> Vec<Block> {
    let figures = |found: &Equations| -> Vec<Figure> {
        let Some(model) = found.judged.first().map(|judged| &judged.model) else { return Vec::new() };
        let free = drawn(found, "portrait", "no input", &portrait(&found.system, model));
        let closed = comparison.catalog.expert(&found.task).map(|expert| {
            let portrait = closed_loop(&found.system, model, &*expert);
            drawn(found, "closed-loop", "the expert acts", &portrait)
        });
        [free].into_iter().chain(closed).collect()
    };
    vec![
        Block::Section("Phase portraits".into()),
        Block::text(
            "The true system (broad and pale) and the model that sindy identified with the first seed, from the same ten start \
             states (dots): without any input, and in closed loop with the expert, which acts on each by what it observes of it. \
             Records have no policies, so the trained ones are not drawn. A path ends where a limit might act, which is no part of the equations: at a wall, at the largest speed, \
             or where a pole has fallen by a quarter turn.",
        ),
        Block::Figures(found.iter().flat_map(figures).collect()),
    ]
}

/// One portrait, of a kind called `kind`; `how` says what acts.
fn drawn(found: &Equations, kind: &str, how: &str, portrait: &Portrait) -> Figure {
    let spec = found.system.spec();
    let apart = significant(portrait.distance(spec), 2);
    let steps = plural(portrait.steps(), "step");
    let caption = format!("{}, {how}: apart by at most {apart} of a state's scale within {steps}", found.task);
    figure::portraits((kind, &found.task, how), spec, portrait, caption)
}

/// Table 1 of the paper with the same numbers of ours.
pub(super) fn table_of_the_paper(comparison: &Comparison<'_>, found: &[Equations]) -> Vec<Block> {
    let Comparison { catalog, ref groups, .. } = *comparison;
    let rows = found.iter().flat_map(|task| {
        let middle = |of: &dyn Fn(&Judged) -> usize| {
            let values: Vec<f64> = task.judged.iter().map(|judged| of(judged) as f64).collect();
            median(&values).map_or_else(|| NONE.into(), rough)
        };
        let exact = task.true_terms();
        let group = groups.iter().find(|g| g.task == task.task && g.method == "sindy");
        let ours = [
            task.task.clone(),
            "sindyna".into(),
            middle(&|judged| judged.real_episodes),
            middle(&|judged| judged.real_steps),
            "∞".into(),
            if exact == task.judged.len() {
                "exact".into()
            } else {
                format!("exact for {exact} of {}", task.judged.len())
            },
            group.map_or_else(|| NONE.into(), |g| format!("{} of {}", g.solved, g.runs)),
            middle(&|judged| judged.model.parameters()),
            middle(&|judged| judged.model.nonzero_paper()),
        ];
        let theirs = catalog.published(&task.task).map(|row| {
            [
                task.task.clone(),
                "paper".into(),
                row.rollouts.to_string(),
                row.rollout_len.to_string(),
                "∞".into(),
                row.dynamics.into(),
                row.generalises.into(),
                row.parameters.to_string(),
                row.nonzero.into(),
            ]
        });
        [ours].into_iter().chain(theirs)
    });
    let head = ["task", "of", "Nₑ", "real steps", "N", "dynamics learned", "generalises", "P", "P′"];
    vec![
        Block::Section("Table 1 of the paper".into()),
        Block::table(2, head, rows.collect()),
        Block::text(format!(
            "Nₑ: real rollouts (ours end where an episode does, so the same real steps may take several); real steps: R of the paper in \
             all of them together; N: rollouts in the model for each real one; P: size of Ξ, states times candidate terms; P′: coefficients that are not zero, in \
             the paper's counting. Ours are medians over seeds; dynamics are exact if the equations have the true terms, and generalise \
             if the policy solves the task. Of mountain-car the text of the paper says 100 real steps, its table 50. The MBPO of the paper has {} parameters.",
            catalog.published_network_parameters()
        )),
    ]
}
