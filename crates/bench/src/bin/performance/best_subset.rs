//! docs/best-subset.md, of what `scripts/peers best-subset` measured.

use anyhow::Context as _;
use serde::Deserialize;
use sindyna_bench::study::{Document, Page, Result, load, short};
use sindyna_core::number::significant;

#[derive(Debug, Deserialize)]
struct Figures {
    versions: std::collections::BTreeMap<String, String>,
    data_sets: usize,
    comparison: Vec<Design>,
    costs: Costs,
}

#[derive(Debug, Deserialize)]
struct Design {
    design: String,
    rows: usize,
    columns: usize,
    terms: usize,
    recovered: Recovered,
    proved: f64,
    abess_residual_is_larger: f64,
    median_seconds: Seconds,
    slowest_seconds: f64,
    median_ratio_to_abess_path: f64,
}

#[derive(Debug, Deserialize)]
struct Recovered {
    best_subset: f64,
    abess: f64,
    stlsq: f64,
}

#[derive(Debug, Deserialize)]
struct Seconds {
    best_subset_path: f64,
    triangle: f64,
}

#[derive(Debug, Deserialize)]
struct Costs {
    cases: Vec<Cost>,
    bounds: Vec<Cost>,
    growth: Vec<Cost>,
}

#[derive(Debug, Deserialize)]
struct Cost {
    case: String,
    rows: usize,
    features: usize,
    terms: Option<usize>,
    bound: Option<String>,
    sizes_tried: Option<usize>,
    proved_up_to: usize,
    operations: Option<f64>,
    seconds: f64,
}

/// docs/best-subset.md.
pub(crate) fn page() -> Result<String> {
    let document: Document<Figures> = load("best-subset")?.context("there is no results/best-subset.json")?;
    let Figures { versions, data_sets, comparison, costs } = &document.figures;
    let percent = |share: f64| format!("{:.0}%", 100.0 * share);
    let row = |d: &Design| {
        let shares =
            [d.recovered.best_subset, d.recovered.abess, d.recovered.stlsq, d.abess_residual_is_larger, d.proved];
        let seconds = d.median_seconds.best_subset_path + d.median_seconds.triangle;
        let times = [
            format!("{:.1}", 1e3 * seconds),
            format!("{:.1}", 1e3 * d.slowest_seconds),
            short(Some(d.median_ratio_to_abess_path)),
        ];
        let size = format!("{} × {}, {}", d.rows, d.columns, d.terms);
        [d.design.clone(), size].into_iter().chain(shares.map(percent)).chain(times).collect()
    };
    let head = [
        "design",
        "rows × columns, terms",
        "best subset",
        "abess",
        "STLSQ",
        "abess misses the best",
        "all sizes proved",
        "median [ms]",
        "slowest [ms]",
        "time / abess",
    ];
    let mut page =
        Page::new("Best subset: recovery and cost").list(findings(comparison)).table(&head, comparison.iter().map(row));
    for (title, cases) in [
        ("What a proof costs", &costs.cases),
        ("What each bound gives", &costs.bounds),
        ("How the cost grows", &costs.growth),
    ] {
        let head = ["case", "rows × columns", "sizes up to", "bound", "proved up to", "operations", "ratio", "seconds"];
        page = page.section(title).table(&head, cases.iter().map(|case| cost(case, cases)));
    }
    let abess = versions.get("abess").map_or("", String::as_str);
    Ok(page
        .section("How it was measured")
        .text(&format!(
            "{data_sets} data sets per design, abess {abess}. Every solver knows the true number of terms; STLSQ counts as right if any of 80 thresholds is, half of them on columns of \
             unit length. Times are medians for one thread; best subset is the whole path with its proofs and the triangle, abess its path over the same sizes, which proves nothing. \
             Operations are pairs of columns looked at and their like; the ratio is to the first row of the same name. Seconds are one machine's."
        ))
        .text(&format!("{}.", super::ours::origin(&document.made)))
        .markdown())
}

fn findings(comparison: &[Design]) -> Vec<String> {
    let better = |than: fn(&Recovered) -> f64| {
        let of = |holds: &dyn Fn(&Design) -> bool| comparison.iter().filter(|d| holds(d)).count();
        let (more, less) = (
            of(&|d| d.recovered.best_subset > than(&d.recovered)),
            of(&|d| d.recovered.best_subset < than(&d.recovered)),
        );
        format!("in {more} of {} designs, and less often in {less}", comparison.len())
    };
    let time = |d: &&Design| d.median_ratio_to_abess_path;
    let ratios = || comparison.iter().map(|d| time(&d));
    let range = [ratios().fold(f64::INFINITY, f64::min), ratios().fold(0.0, f64::max)].map(|r| short(Some(r)));
    let proved = comparison.iter().map(|d| d.proved).sum::<f64>() / comparison.len().max(1) as f64;
    vec![
        format!("Best subset finds the true terms more often than abess {}.", better(|r| r.abess)),
        format!("It finds them more often than STLSQ with the best of 80 thresholds {}.", better(|r| r.stlsq)),
        format!(
            "It takes {} to {} times as long as abess (medians), and proves all its sizes on {:.0} % of the data sets.",
            range[0],
            range[1],
            100.0 * proved
        ),
    ]
}

fn cost(case: &Cost, all: &[Cost]) -> Vec<String> {
    let size = format!("{} × {}", case.rows, case.features);
    let ends = [case.proved_up_to.to_string(), format!("{:.4}", case.seconds)];
    let [proved, seconds] = ends;
    if let Some(tried) = case.sizes_tried {
        let up_to = tried.saturating_sub(1).to_string();
        return vec![case.case.clone(), size, up_to, "all".into(), proved, String::new(), String::new(), seconds];
    }
    let operations = case.operations.unwrap_or(0.0);
    let base =
        all.iter().find(|other| other.case == case.case).and_then(|other| other.operations).unwrap_or(operations);
    vec![
        case.case.clone(),
        size,
        case.terms.map_or_else(String::new, |terms| terms.to_string()),
        case.bound.clone().unwrap_or_default(),
        proved,
        significant(operations, 3),
        significant(operations / base, 3),
        seconds,
    ]
}
