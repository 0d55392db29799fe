//! results/noise.json, docs/noise.md and docs/noise.svg.

use serde::{Deserialize, Serialize};
use sindyna_bench::study::{
    Chart, Document, Page, Result, Scale, by, count, median, percent, plain, root, rounded, short,
};
use sindyna_bench::{Measured, Off, Rivals};
use sindyna_record::save;

/// One seed.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Row {
    pub(crate) seed: u64,
    pub(crate) resets: usize,
    /// None where nothing was identified.
    pub(crate) measured: Option<Measured>,
    /// The same by an identifier that is told how noisy the sensors are.
    pub(crate) told: Option<Measured>,
    pub(crate) rivals: Rivals,
    pub(crate) regulators: Option<Regulators>,
}

/// Mean returns on the noisy true system; none where there is no regulator.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Regulators {
    /// Of least squares' linear model.
    pub(crate) least_squares: Option<f64>,
    /// Of the equations found.
    pub(crate) identified: Option<f64>,
    /// Of the true system.
    pub(crate) true_system: Option<f64>,
}

impl Row {
    /// RMS error of the rates.
    pub(crate) fn error(&self) -> Option<f64> {
        self.measured.as_ref()?.deviation.rms
    }
}

/// The result file.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Figures {
    pub(crate) groups: Vec<Group>,
    /// What is to be said of these runs alone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) notes: Vec<String>,
}

/// One task, noise and number of real steps.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Group {
    task: String,
    noise: f64,
    steps: usize,
    seeds: usize,
    refused: usize,
    true_terms: usize,
    true_terms_shown: usize,
    resets: Option<f64>,
    median_relative_error: Option<f64>,
    largest_relative_error: Option<f64>,
    standard_errors_within_2: Option<f64>,
    worst_deviation: Deviations,
    rms_deviation: Deviations,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    told: Option<Told>,
    largest_worst_deviation: Option<f64>,
    seconds: Seconds,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    regulators: Option<Regulated>,
}

/// Medians; none where infinite.
#[derive(Debug, Serialize, Deserialize)]
struct Deviations {
    deviation: Option<f64>,
    stlsq: Option<f64>,
    stlsq_best: Option<f64>,
}

#[derive(Debug, Serialize, Deserialize)]
struct Told {
    true_terms: usize,
    rms_deviation: Option<f64>,
    seconds: Option<f64>,
}

#[derive(Debug, Serialize, Deserialize)]
struct Seconds {
    median: Option<f64>,
    largest: Option<f64>,
}

#[derive(Debug, Serialize, Deserialize)]
struct Regulated {
    least_squares: Returns,
    identified: Returns,
    true_system: Returns,
}

#[derive(Debug, Serialize, Deserialize)]
struct Returns {
    median_return: Option<f64>,
    lowest_return: Option<f64>,
    /// How often there was no regulator.
    none: usize,
}

impl Returns {
    fn of(rows: &[Row], of: fn(&Regulators) -> Option<f64>) -> Self {
        let found: Vec<Option<f64>> = rows.iter().filter_map(|row| row.regulators.as_ref()).map(of).collect();
        // A regulator there is none of earns nothing.
        let earned = || found.iter().map(|r| r.unwrap_or(0.0));
        let two = |value: f64| (100.0 * value).round() / 100.0;
        Self {
            median_return: median(earned()).map(two),
            lowest_return: earned().min_by(f64::total_cmp).map(two),
            none: count(&found, Option::is_none),
        }
    }

    fn shown(&self) -> String {
        format!("{} ({})", plain(self.median_return), plain(self.lowest_return))
    }
}

/// The median, in which what is not there is infinite.
fn middle(values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    median(values.map(|v| v.unwrap_or(f64::INFINITY))).and_then(rounded)
}

fn largest(values: impl Iterator<Item = f64>) -> Option<f64> {
    values.max_by(f64::total_cmp).and_then(rounded)
}

impl Group {
    /// What the seeds come to.
    pub(crate) fn of((task, noise, steps): (&str, f64, usize), rows: &[Row]) -> Self {
        let fitted = || rows.iter().filter_map(|row| row.measured.as_ref());
        let told = || rows.iter().filter_map(|row| row.told.as_ref());
        let errors = || fitted().flat_map(|m| m.relative_errors.iter().copied());
        let scores: Vec<f64> = fitted().flat_map(|m| m.standardised_errors.iter().copied()).collect();
        let deviations = |of: fn(&Off) -> Option<f64>| Deviations {
            deviation: middle(rows.iter().map(|row| of(&row.measured.as_ref()?.deviation))),
            stlsq: middle(rows.iter().map(|row| of(&row.rivals.stlsq))),
            stlsq_best: middle(rows.iter().map(|row| of(&row.rivals.stlsq_best))),
        };
        let worst = rows.iter().map(|row| row.measured.as_ref().and_then(|m| m.deviation.worst));
        let regulated = rows.iter().any(|row| row.regulators.is_some());
        Self {
            task: task.to_owned(),
            noise,
            steps,
            seeds: rows.len(),
            refused: rows.len() - fitted().count(),
            true_terms: fitted().filter(|m| m.true_terms).count(),
            true_terms_shown: fitted().filter(|m| m.true_terms_shown).count(),
            resets: median(rows.iter().map(|row| row.resets as f64)),
            median_relative_error: median(errors()).and_then(rounded),
            largest_relative_error: largest(errors()),
            standard_errors_within_2: rounded(count(&scores, |z| z.abs() <= 2.0) as f64 / scores.len() as f64),
            worst_deviation: deviations(|off| off.worst),
            rms_deviation: deviations(|off| off.rms),
            told: Some(Told {
                true_terms: told().filter(|m| m.true_terms).count(),
                rms_deviation: middle(rows.iter().map(|row| row.told.as_ref()?.deviation.rms)),
                seconds: median(told().map(|m| m.seconds)).and_then(rounded),
            }),
            largest_worst_deviation: largest(worst.map(|w| w.unwrap_or(f64::INFINITY))),
            seconds: Seconds {
                median: median(fitted().map(|m| m.seconds)).and_then(rounded),
                largest: largest(fitted().map(|m| m.seconds)),
            },
            regulators: regulated.then(|| Regulated {
                least_squares: Returns::of(rows, |r| r.least_squares),
                identified: Returns::of(rows, |r| r.identified),
                true_system: Returns::of(rows, |r| r.true_system),
            }),
        }
    }

    fn key(&self) -> [String; 3] {
        [self.task.clone(), percent(self.noise), self.steps.to_string()]
    }
}

/// docs/STEM.md, and the figure beside it.
pub(crate) fn page(document: &Document<Figures>, stem: &str) -> Result<String> {
    let Figures { groups, notes } = &document.figures;
    save(&root().join("docs").join(format!("{stem}.svg")), chart(groups).as_bytes())?;
    let seeds = groups.iter().map(|g| g.seeds).max().unwrap_or(0);
    let page = Page::new("Equations of the tasks under noise").list(findings(groups)).text(&notes.join("\n"));
    let page = regulators(equations(page, groups, stem), groups);
    Ok(page
        .section("How it was measured")
        .text(&format!(
            "{seeds} seeds a row. Noise is Gaussian, independent from step to step, on every observation of the system; its standard deviation is the given part of each \
             channel's scale. Real steps are those of the default warm-up. Controllers trained in equations from noisy data: [loop-noise.md](loop-noise.md)."
        ))
        .text(&document.made.origin(stem))
        .markdown())
}

fn findings(groups: &[Group]) -> Vec<String> {
    let of_noise = by(groups, |g| g.noise).into_iter().map(|(noise, of)| {
        let sum = |of_group: fn(&Group) -> usize| of.iter().map(|g| of_group(g)).sum::<usize>();
        let errors = |error: fn(&Deviations) -> Option<f64>| middle(of.iter().map(|g| error(&g.rms_deviation)));
        format!(
            "With {} noise the terms are the true ones in {} of {} runs. The error of the accelerations is {} of their spread (median of the rows), by STLSQ with the best \
             threshold {}.",
            percent(noise),
            sum(|g| g.true_terms),
            sum(|g| g.seeds),
            short(errors(|d| d.deviation)),
            short(errors(|d| d.stlsq_best))
        )
    });
    let regulated: Vec<&Regulated> = groups.iter().filter_map(|g| g.regulators.as_ref()).collect();
    let above = count(&regulated, |r| r.identified.median_return > r.least_squares.median_return);
    let below = count(&regulated, |r| r.identified.median_return < r.least_squares.median_return);
    let regulator = (!regulated.is_empty()).then(|| {
        format!(
            "A regulator of the identified equations has a higher return than one of least squares in {above} of {} rows, and a lower one in {below}.",
            regulated.len()
        )
    });
    of_noise.chain(regulator).collect()
}

fn equations(page: Page, groups: &[Group], stem: &str) -> Page {
    let has_told = groups.iter().any(|g| g.told.is_some());
    let row = |g: &Group| {
        let told = |cell: fn(&Told) -> String| has_told.then(|| g.told.as_ref().map_or_else(String::new, cell));
        let error = |of: fn(&Deviations) -> Option<f64>| {
            format!("{} ({})", short(of(&g.rms_deviation)), short(of(&g.worst_deviation)))
        };
        let relative = format!("{} ({})", short(g.median_relative_error), short(g.largest_relative_error));
        let terms = format!("{} ({}) of {}", g.true_terms, g.true_terms_shown, g.seeds);
        let first = g.key().into_iter().chain([terms]).chain(told(|t| t.true_terms.to_string()));
        let middle = [relative, short(g.standard_errors_within_2), error(|d| d.deviation)];
        let last = [
            error(|d| d.stlsq),
            error(|d| d.stlsq_best),
            format!("{} ({})", short(g.seconds.median), short(g.seconds.largest)),
        ];
        first.chain(middle).chain(told(|t| short(t.rms_deviation))).chain(last).collect()
    };
    let told = |title: &'static str| has_told.then_some(title);
    let head = ["task", "noise", "real steps", "true terms (shown)"].into_iter().chain(told("known σ"));
    let head = head.chain([
        "coefficients' relative error, median (largest)",
        "within 2 standard errors",
        "accelerations' error, rms (worst)",
    ]);
    let head = head.chain(told("known σ, rms"));
    let head: Vec<&str> = head.chain(["STLSQ", "STLSQ, best threshold", "fit [s], median (largest)"]).collect();
    let page = page
        .section("Equations")
        .text(&format!("![Error of the accelerations against real steps]({stem}.svg)"))
        .table(&head, groups.iter().map(row));
    let told =
        if has_told { "The size of the noise is estimated; in the columns *known σ* it is declared. " } else { "" };
    page.text(&format!(
        "{told}Errors of accelerations (velocity increments for mountain-car) are over 10,000 states and inputs from the task's box, as parts of the true ones' standard \
         deviation there; medians over seeds. Coefficients are compared where the terms are the true ones. *STLSQ*: the same candidate terms with the paper's threshold, on \
         increments; *best threshold*: the nearest to the truth of 11 thresholds, on increments and on central differences, chosen with knowledge of the true equations."
    ))
}

fn regulators(page: Page, groups: &[Group]) -> Page {
    let row = |g: &Group| {
        let r = g.regulators.as_ref()?;
        let returns = [&r.least_squares, &r.identified, &r.true_system].map(Returns::shown);
        Some(g.key().into_iter().chain(returns).collect::<Vec<String>>())
    };
    let rows: Vec<_> = groups.iter().filter_map(row).collect();
    if rows.is_empty() {
        return page;
    }
    let head =
        ["task", "noise", "real steps", "least squares + LQR", "identified equations + LQR", "true system + LQR"];
    page.section("Comparison with least squares: returns of regulators").table(&head, rows).text(
        "Mean return of 20 episodes on the noisy true system: median (lowest) over seeds; where there is no regulator, 0. Least squares is x⁺ = x + Δt (A x + B u). The \
         regulators weigh every channel by its scale and act on the noisy observation as it is.",
    )
}

/// RMS errors of the accelerations against the number of steps.
fn chart(groups: &[Group]) -> String {
    let mut tasks: Vec<&str> = groups.iter().map(|g| g.task.as_str()).collect();
    tasks.dedup();
    let steps: Vec<usize> = by(groups, |g| g.steps as f64).iter().map(|(steps, _)| *steps as usize).collect();
    let panel = |task: &&str| {
        let of_task: Vec<&Group> = groups.iter().filter(|g| g.task == *task).collect();
        let line = |of: &[&&Group], value: fn(&Deviations) -> Option<f64>| {
            let at = |r: &usize| of.iter().find(|g| g.steps == *r);
            steps.iter().map(|r| at(r).and_then(|g| value(&g.rms_deviation))).collect::<Vec<_>>()
        };
        let levels = by(&of_task, |g| g.noise);
        let ours = levels.iter().map(|(noise, of)| (percent(*noise), line(of, |d| d.deviation)));
        let least = levels.first();
        let stlsq = least
            .map(|(noise, of)| (format!("STLSQ, best threshold, {}", percent(*noise)), line(of, |d| d.stlsq_best)));
        ((*task).to_owned(), ours.chain(stlsq).collect())
    };
    Chart {
        across: "real steps",
        up: "error of accelerations",
        categories: steps.iter().map(usize::to_string).collect(),
        range: (1e-4, 10.0),
        scale: Scale::Logarithmic,
        panels: tasks.iter().map(panel).collect(),
    }
    .svg()
}
