//! results/exact.json, docs/exact.md and docs/exact.svg.

use serde::{Deserialize, Serialize};
use sindyna_bench::study::{Chart, Document, Page, Result, Scale, count, median, root, rounded, share, short};
use sindyna_bench::{Measured, Off, Rivals};
use sindyna_core::number::significant;
use sindyna_record::save;

/// Error of the rates, as part of their spread, below which equations are exact.
pub(crate) const EXACT: f64 = 1e-4;

/// Real steps of the first table.
const FEW: usize = 10;

/// One identification.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Row {
    pub(crate) seed: u64,
    pub(crate) resets: usize,
    /// None where nothing was identified.
    pub(crate) measured: Option<Measured>,
    pub(crate) rivals: Rivals,
}

/// The result file.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Figures {
    pub(crate) exact_below: f64,
    pub(crate) groups: Vec<Group>,
}

/// One system and number of steps.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Group {
    system: String,
    steps: usize,
    pub(crate) seeds: usize,
    pub(crate) exact: usize,
    true_terms: usize,
    true_terms_shown: usize,
    refused: usize,
    not_exact_and_said_so: usize,
    not_exact_and_not_said: usize,
    resets: Spread,
    deviation: Spread,
    coefficients: Coefficients,
    standardised_errors: Scores,
    seconds: Spread,
    stlsq: Rival,
    stlsq_best: Rival,
    examples_not_exact: Vec<Example>,
}

/// Of finite numbers.
#[derive(Debug, Serialize, Deserialize)]
struct Spread {
    median: Option<f64>,
    largest: Option<f64>,
}

impl Spread {
    fn of(values: impl Iterator<Item = f64> + Clone) -> Self {
        Self {
            median: median(values.clone()).and_then(rounded),
            largest: values.max_by(f64::total_cmp).and_then(rounded),
        }
    }

    fn shown(&self) -> String {
        format!("{} ({})", short(self.median), short(self.largest))
    }
}

#[derive(Debug, Serialize, Deserialize)]
struct Coefficients {
    median_relative_error: Option<f64>,
    largest_relative_error: Option<f64>,
}

/// Of (estimate − truth)/(standard error).
#[derive(Debug, Serialize, Deserialize)]
struct Scores {
    count: usize,
    median: Option<f64>,
    within_1: Option<f64>,
    within_2: Option<f64>,
    within_3: Option<f64>,
}

#[derive(Debug, Serialize, Deserialize)]
struct Rival {
    exact: usize,
    median_deviation: Option<f64>,
}

#[derive(Debug, Serialize, Deserialize)]
struct Example {
    seed: u64,
    deviation: Option<f64>,
    explained: bool,
    equations: Vec<String>,
}

/// What is not finite, or not there, is infinitely far off.
fn worst(off: &Off) -> f64 {
    off.worst.unwrap_or(f64::INFINITY)
}

impl Group {
    /// What the seeds come to.
    pub(crate) fn of(system: &str, steps: usize, rows: &[Row]) -> Self {
        let fitted = || rows.iter().filter_map(|row| Some((row.seed, row.measured.as_ref()?)));
        let failed: Vec<_> = fitted().filter(|(_, m)| worst(&m.deviation) >= EXACT).collect();
        let scores: Vec<f64> = fitted().flat_map(|(_, m)| m.standardised_errors.iter().map(|z| z.abs())).collect();
        let within = |k: f64| rounded(count(&scores, |z| *z <= k) as f64 / scores.len() as f64);
        let errors = Spread::of(fitted().flat_map(|(_, m)| m.relative_errors.iter().copied()));
        let rival = |of: fn(&Rivals) -> &Off| Rival {
            exact: count(rows, |row| worst(of(&row.rivals)) < EXACT),
            median_deviation: median(rows.iter().map(|row| worst(of(&row.rivals)))).and_then(rounded),
        };
        let example = |(seed, m): &(u64, &Measured)| Example {
            seed: *seed,
            deviation: m.deviation.worst.and_then(rounded),
            explained: m.explained,
            equations: m.equations.clone(),
        };
        Self {
            system: system.to_owned(),
            steps,
            seeds: rows.len(),
            exact: fitted().count() - failed.len(),
            true_terms: fitted().filter(|(_, m)| m.true_terms).count(),
            true_terms_shown: fitted().filter(|(_, m)| m.true_terms_shown).count(),
            refused: rows.len() - fitted().count(),
            not_exact_and_said_so: count(&failed, |(_, m)| !m.explained),
            not_exact_and_not_said: count(&failed, |(_, m)| m.explained),
            resets: Spread::of(rows.iter().map(|row| row.resets as f64)),
            deviation: Spread::of(fitted().map(|(_, m)| worst(&m.deviation))),
            coefficients: Coefficients { median_relative_error: errors.median, largest_relative_error: errors.largest },
            standardised_errors: Scores {
                count: scores.len(),
                median: median(scores.iter().copied()).and_then(rounded),
                within_1: within(1.0),
                within_2: within(2.0),
                within_3: within(3.0),
            },
            seconds: Spread::of(fitted().map(|(_, m)| m.seconds)),
            stlsq: rival(|r| &r.stlsq),
            stlsq_best: rival(|r| &r.stlsq_best),
            examples_not_exact: failed.iter().take(2).map(example).collect(),
        }
    }

    fn is_exact(&self) -> String {
        format!("{} of {}", self.exact, self.seeds)
    }

    fn terms(&self) -> String {
        format!("{} ({})", self.true_terms, self.true_terms_shown)
    }

    /// Name and steps.
    fn key(&self) -> [String; 2] {
        [self.system.clone(), self.steps.to_string()]
    }
}

/// docs/STEM.md, and the figure beside it.
pub(crate) fn page(document: &Document<Figures>, stem: &str) -> Result<String> {
    let groups = &document.figures.groups;
    // Of other systems nobody asks for so few steps.
    let is_task = |g: &&Group| groups.iter().any(|other| other.system == g.system && other.steps == FEW);
    let (tasks, others): (Vec<&Group>, Vec<&Group>) = groups.iter().partition(is_task);
    save(&root().join("docs").join(format!("{stem}.svg")), chart(&tasks).as_bytes())?;
    let few: Vec<&Group> = tasks.iter().copied().filter(|g| g.steps == FEW).collect();
    let page = Page::new("Exact equations from ten steps").list(findings(&few, &tasks, &others));
    let page = of_few(page, &few);
    let page = by_steps(page, &tasks, stem);
    let page = coefficients(page, &tasks);
    let page = of_others(page, &others);
    Ok(page
        .section("How it was measured")
        .text(
            "Every row is `Identifier::new(&spec).identify(&data)` with default settings, on data of the default warm-up (`Swings`), which are those of `sindyna train TASK \
             --seed S`.",
        )
        .text(
            "*Exact*: over 10,000 states and inputs drawn from the task's box (declared bounds, else the channels' scales), the model's accelerations (velocity increments \
             for mountain-car) differ from the true ones by less than 1e-4 of their standard deviation there, in every equation and on every point. *True terms*: the true \
             rates satisfy the equations found with one set of coefficients, none of them zero; in brackets, how often true terms are at least among the sets the report \
             shows. Implicit equations of motion can be written in several ways, and each counts.",
        )
        .text(&document.made.origin(stem))
        .markdown())
}

fn findings(few: &[&Group], tasks: &[&Group], others: &[&Group]) -> Vec<String> {
    let sum = |groups: &[&Group], of: fn(&Group) -> usize| groups.iter().map(|g| of(g)).sum::<usize>();
    let exact = |groups: &[&Group]| (sum(groups, |g| g.exact), sum(groups, |g| g.seeds));
    let ((found, runs), (other, other_runs)) = (exact(few), exact(others));
    let silent = sum(tasks, |g| g.not_exact_and_not_said);
    vec![
        format!(
            "From {FEW} real steps the equations of {} tasks are exact in {found} of {runs} runs ({}).",
            few.len(),
            share(found, runs)
        ),
        format!(
            "STLSQ with the same candidate terms is exact in {} of them, with the best threshold for each run in {}.",
            sum(few, |g| g.stlsq.exact),
            sum(few, |g| g.stlsq_best.exact)
        ),
        format!(
            "In {silent} of {} runs from all numbers of steps the equations are reported as exact and are not.",
            exact(tasks).1
        ),
        format!("Other systems, same defaults: exact in {other} of {other_runs} runs."),
    ]
}

fn of_few(page: Page, few: &[&Group]) -> Page {
    let row = |g: &&Group| {
        let milliseconds = |seconds: Option<f64>| short(seconds.map(|s| 1e3 * s));
        let [name, _] = g.key();
        let seconds = format!("{} ({})", milliseconds(g.seconds.median), milliseconds(g.seconds.largest));
        vec![name, g.is_exact(), g.terms(), g.deviation.shown(), g.resets.shown(), seconds]
    };
    let head = [
        "task",
        "exact",
        "true terms (shown)",
        "deviation, median (largest)",
        "resets, median (maximum)",
        "fit [ms], median (largest)",
    ];
    page.section(&format!("{FEW} real steps")).table(&head, few.iter().map(row)).text(
        "Resets are counted with the first; an episode that ends is followed by another within the same ten steps. Times are processor time of one thread.",
    )
}

fn by_steps(page: Page, tasks: &[&Group], stem: &str) -> Page {
    let row = |g: &&Group| {
        let numbers = [g.refused, g.not_exact_and_said_so, g.not_exact_and_not_said, g.stlsq.exact, g.stlsq_best.exact];
        let first = g.key().into_iter().chain([g.is_exact(), g.terms()]);
        first.chain(numbers.map(|n| n.to_string())).collect()
    };
    let head = [
        "task",
        "real steps",
        "exact",
        "true terms (shown)",
        "refused",
        "not exact, reported as such",
        "not exact, reported as exact",
        "STLSQ exact",
        "STLSQ exact, best threshold",
    ];
    page.section("Against the number of steps")
        .text(&format!("![Share of seeds against real steps]({stem}.svg)"))
        .table(&head, tasks.iter().map(row))
        .text(
            "*Refused*: fewer steps than a model linear in states and inputs has unknowns. *Reported as such*: the report says that residuals are above the level of \
             rounding (`reached_floor` is false). *STLSQ*: sequentially thresholded least squares on increments with the same candidate terms and the paper's threshold of \
             0.0009; *best threshold*: the nearest to the truth of 11 thresholds from 1e-4 to 10, on increments and on central differences, chosen with \
             knowledge of the true equations.",
        )
}

fn coefficients(page: Page, tasks: &[&Group]) -> Page {
    let row = |g: &&&Group| {
        let (errors, z) = (&g.coefficients, &g.standardised_errors);
        let relative = format!("{} ({})", short(errors.median_relative_error), short(errors.largest_relative_error));
        let shares = [z.within_1, z.within_2, z.within_3, z.median].map(short);
        g.key().into_iter().chain([relative, z.count.to_string()]).chain(shares).collect()
    };
    let head = [
        "task",
        "real steps",
        "relative error, median (largest)",
        "errors counted",
        "within 1",
        "within 2",
        "within 3",
        "median",
    ];
    let told = tasks.iter().filter(|g| g.true_terms > 0 && [8, 10, 20, 50].contains(&g.steps));
    page.section("Coefficients and the bound from rounding")
        .text(
            "The reported standard errors are the Cramér–Rao bound for observations rounded as the spec declares. If they are right, 68 % of the errors (estimate − \
             truth)/(standard error) are within 1, 95 % within 2, and the median magnitude is 0.67.",
        )
        .table(&head, told.collect::<Vec<_>>().iter().map(row))
        .text(
            "Errors are not counted where the standard error is below 1e-11 of the coefficient, to which the true coefficients themselves are computed from the true rates: \
             the inverted pendulum shows float64, and what is left there is the rounding of the computation.",
        )
        .text(&too_small(tasks))
}

/// What is to be said where standard errors promise too much.
fn too_small(tasks: &[&Group]) -> String {
    let mut low: Vec<(&str, f64)> = Vec::new();
    for group in tasks.iter().filter(|g| g.standardised_errors.count >= 50) {
        let within = group.standardised_errors.within_2.unwrap_or(1.0);
        match low.iter_mut().find(|(name, _)| *name == group.system) {
            Some((_, least)) => *least = least.min(within),
            None => low.push((&group.system, within)),
        }
    }
    let low = low.iter().filter(|(_, within)| *within < 0.9);
    let named: Vec<String> =
        low.map(|(name, within)| format!("{name} (down to {:.0} % within 2)", 100.0 * within)).collect();
    if named.is_empty() {
        return String::new();
    }
    format!(
        "Standard errors are too small for {}. On mountain-car the rounding is not the sensors' alone: the state itself is rounded to float32 after every step, as Gymnasium \
         does it, so errors add up from step to step, while the bound takes each for an error of one observation.",
        named.join(", ")
    )
}

fn of_others(page: Page, others: &[&Group]) -> Page {
    let row = |g: &&Group| {
        let numbers = [g.not_exact_and_said_so, g.not_exact_and_not_said].map(|n| n.to_string());
        let rest = [short(g.deviation.median), short(g.stlsq_best.median_deviation), g.seconds.shown()];
        g.key().into_iter().chain([g.is_exact(), g.terms()]).chain(numbers).chain(rest).collect()
    };
    let head = [
        "system",
        "samples",
        "exact",
        "true terms (shown)",
        "not exact, reported as such",
        "not exact, reported as exact",
        "deviation, median",
        "STLSQ, best threshold",
        "fit [s], median (largest)",
    ];
    let mut page = page
        .section("Other systems, same defaults")
        .table(&head, others.iter().map(row))
        .text("Exact without the true terms means terms beside the true ones with coefficients too small to matter.");
    let most = others.iter().map(|g| g.steps).max();
    for g in others.iter().filter(|g| Some(g.steps) == most) {
        if let Some(example) = g.examples_not_exact.iter().find(|e| !e.explained) {
            page = page
                .text(&format!(
                    "`{}` from {} samples is *not determined* for {} of {} seeds: residuals stay above what rounding and the integrator explain, so the report does not \
                     claim it. Seed {}:",
                    g.system, g.steps, g.not_exact_and_said_so, g.seeds, example.seed
                ))
                .code(&example.equations);
        }
    }
    page
}

/// Shares of seeds against the number of steps.
fn chart(tasks: &[&Group]) -> String {
    let mut steps: Vec<usize> = tasks.iter().map(|g| g.steps).collect();
    steps.sort_unstable();
    steps.dedup();
    let mut names: Vec<&str> = tasks.iter().map(|g| g.system.as_str()).collect();
    names.dedup();
    let panel = |name: &&str| {
        let line = |what: &str, of: fn(&Group) -> usize| {
            let at = |r: &usize| tasks.iter().find(|g| g.system == *name && g.steps == *r);
            let values = steps.iter().map(|r| at(r).map(|g| of(g) as f64 / g.seeds as f64)).collect();
            (what.to_owned(), values)
        };
        let lines = vec![
            line("exact", |g| g.exact),
            line("true terms", |g| g.true_terms),
            line("STLSQ, best threshold", |g| g.stlsq_best.exact),
            line("STLSQ", |g| g.stlsq.exact),
        ];
        ((*name).to_owned(), lines)
    };
    Chart {
        across: "real steps",
        up: "share of seeds",
        categories: steps.iter().map(|r| significant(*r as f64, 6)).collect(),
        range: (0.0, 1.0),
        scale: Scale::Linear,
        panels: names.iter().map(panel).collect(),
    }
    .svg()
}
