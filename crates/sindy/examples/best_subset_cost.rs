//! What proving best subsets costs, as JSON: seconds, operations and nodes per size, and how they grow.
//!
//! `best_subset_cost` prints the cost cases; `best_subset_cost FILE` solves the problems in FILE, a JSON list of
//! `{"rows": [[…, y], …], "terms": k, "normalised": […], "as_they_are": […], "repeats": 3}`, and prints what best subset and STLSQ find.

#![allow(clippy::print_stdout)]

use std::error::Error;
use std::time::Instant;

use ndarray::Array2;
use rand::RngExt as _;
use serde::Deserialize;
use serde_json::{Value, json};
use sindyna_core::Seed;
use sindyna_sindy::{BestSubset, Bound, Columns, Constraints, Path, Selection, Stlsq, SubsetPath, Triangle};

fn main() -> Result<(), Box<dyn Error>> {
    let answer = match std::env::args().nth(1) {
        Some(file) => solve(&serde_json::from_str::<Vec<Task>>(&std::fs::read_to_string(file)?)?)?,
        None => costs()?,
    };
    println!("{answer}");
    Ok(())
}

/// A problem from outside.
#[derive(Deserialize)]
struct Task {
    /// Rows of the columns and the target last.
    rows: Vec<Vec<f64>>,
    /// Number of terms to look for.
    terms: usize,
    /// Thresholds for STLSQ on columns of unit length.
    normalised: Vec<f64>,
    /// Thresholds for STLSQ on the columns as they are.
    as_they_are: Vec<f64>,
    /// Times each solver runs.
    repeats: usize,
}

fn solve(tasks: &[Task]) -> Result<Value, Box<dyn Error>> {
    let mut answers = Vec::new();
    for task in tasks {
        let width = task.rows.first().map_or(1, Vec::len);
        let (p, rows) = (width - 1, Array2::from_shape_vec((task.rows.len(), width), task.rows.concat())?);
        let mut factored = Vec::new();
        let mut triangle = Triangle::new(width);
        for _ in 0..task.repeats {
            let start = Instant::now();
            triangle = Triangle::new(width);
            triangle.push(rows.view())?;
            factored.push(start.elapsed().as_secs_f64());
        }
        let (path, seconds) = timed(task.repeats, || path(&triangle, p, task.terms, Bound::Gains))?;
        let sweep = task.normalised.iter().map(|t| (t, Columns::Normalised));
        let sweep = sweep.chain(task.as_they_are.iter().map(|t| (t, Columns::AsTheyAre)));
        let stlsq = |(threshold, columns): (&f64, Columns)| -> Result<Value, Box<dyn Error>> {
            let solver = Stlsq::new(*threshold, 0.0)?.with_columns(columns);
            let (fit, seconds) = timed(task.repeats, || Ok(solver.solve(&triangle, p, p)))?;
            let support: Vec<usize> = (0..p).filter(|&j| fit.coefficients[j] != 0.0).collect();
            Ok(json!({ "support": support, "seconds": seconds }))
        };
        answers.push(json!({
            "factor_seconds": median(factored),
            "seconds": seconds,
            "sizes": account(&path),
            "stlsq": sweep.map(stlsq).collect::<Result<Vec<_>, _>>()?,
        }));
    }
    Ok(answers.into())
}

fn path(triangle: &Triangle, p: usize, terms: usize, bound: Bound) -> Result<Path, Box<dyn Error>> {
    let solver = SubsetPath::default().with_max_size(terms).with_bound(bound);
    Ok(solver.solve(triangle, p, p, &Constraints::default())?)
}

/// The last result, and the median time \[s\]; what takes longer than a second is not repeated.
fn timed<T>(repeats: usize, run: impl Fn() -> Result<T, Box<dyn Error>>) -> Result<(T, f64), Box<dyn Error>> {
    let mut seconds = Vec::new();
    loop {
        let start = Instant::now();
        let result = run()?;
        seconds.push(start.elapsed().as_secs_f64());
        if seconds.len() >= repeats || seconds.iter().sum::<f64>() > 1.0 {
            return Ok((result, median(seconds)));
        }
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn account(path: &Path) -> Vec<Value> {
    let size = |s: &sindyna_sindy::SizeResult| {
        json!({
            "size": s.size,
            "support": s.subsets.first().map(|best| &best.support),
            "rss": s.subsets.first().map(|best| best.rss),
            "proved": s.proved,
            "gap": s.gap(),
            "operations": s.operations,
            "nodes": s.nodes,
        })
    };
    path.sizes.iter().map(size).collect()
}

/// Columns with correlation ρ^|i − j|, ten true terms of coefficient ±1 spread over them, and noise of variance 10 / SNR.
fn design(seed: u64, n: usize, p: usize, terms: usize, rho: f64, snr: f64) -> Array2<f64> {
    let mut rng = Seed::new(seed).stream("design", 0);
    // Twelve uniform numbers: near enough to a normal one, and the same everywhere.
    let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
    let mut rows = Array2::zeros((n, p + 1));
    for mut row in rows.rows_mut() {
        let mut last = normal();
        for j in 0..p {
            row[j] = last;
            last = rho * last + (1.0 - rho * rho).sqrt() * normal();
        }
        let signal: f64 = (0..terms).map(|i| row[i * p / terms] * if i % 2 == 0 { 1.0 } else { -1.0 }).sum();
        row[p] = signal + (terms as f64 / snr).sqrt() * normal();
    }
    rows
}

/// All monomials up to degree 5 of the Lorenz system's states, and ẏ with noise of a part of its size.
fn lorenz(n: usize, noise: f64) -> Array2<f64> {
    let rate = |s: [f64; 3]| [10.0 * (s[1] - s[0]), s[0] * (28.0 - s[2]) - s[1], s[0] * s[1] - 8.0 / 3.0 * s[2]];
    let along = |s: [f64; 3], v: [f64; 3], h: f64| [s[0] + h * v[0], s[1] + h * v[1], s[2] + h * v[2]];
    let mut rng = Seed::new(1).stream("noise", 0);
    let mut state = [-8.0_f64, 7.0, 27.0];
    let mut rows = Array2::zeros((n, 57));
    for mut row in rows.rows_mut() {
        let powers = (0..6).flat_map(|i| (0..6 - i).flat_map(move |j| (0..6 - i - j).map(move |k| [i, j, k])));
        for (slot, [i, j, k]) in row.iter_mut().zip(powers) {
            *slot = state[0].powi(i) * state[1].powi(j) * state[2].powi(k);
        }
        row[56] = rate(state)[1] + noise * 60.0 * (rng.random::<f64>() - 0.5);
        let h = 0.01;
        let a = rate(state);
        let b = rate(along(state, a, h / 2.0));
        let c = rate(along(state, b, h / 2.0));
        let d = rate(along(state, c, h));
        for i in 0..3 {
            state[i] += h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]);
        }
    }
    rows
}

fn case(name: &str, rows: &Array2<f64>, terms: usize, bound: Bound) -> Result<Value, Box<dyn Error>> {
    let p = rows.ncols() - 1;
    let mut triangle = Triangle::new(p + 1);
    triangle.push(rows.view())?;
    let (found, seconds) = timed(1, || path(&triangle, p, terms, bound))?;
    let total: u64 = found.sizes.iter().map(|s| s.operations).sum();
    Ok(json!({
        "case": name,
        "features": p,
        "rows": rows.nrows(),
        "terms": terms,
        "bound": format!("{bound:?}").to_lowercase(),
        "seconds": seconds,
        "operations": total,
        "proved_up_to": found.sizes.iter().take_while(|s| s.proved).map(|s| s.size).last(),
        "sizes": account(&found),
    }))
}

/// The search of all sizes that ends by choosing one.
fn chosen(name: &str, rows: &Array2<f64>) -> Result<Value, Box<dyn Error>> {
    let p = rows.ncols() - 1;
    let mut triangle = Triangle::new(p + 1);
    triangle.push(rows.view())?;
    let complexity = vec![2; p];
    let selection = Selection { floor: 1e-6, complexity: &complexity, region: None };
    let (found, seconds) = timed(5, || Ok(BestSubset::default().solve(&triangle, p, selection)))?;
    Ok(json!({
        "case": name,
        "features": p,
        "rows": rows.nrows(),
        "seconds": seconds,
        "support": found.support,
        "proved_up_to": found.path.iter().take_while(|s| s.proved).count() - 1,
        "sizes_tried": found.path.len(),
    }))
}

fn costs() -> Result<Value, Box<dyn Error>> {
    let mut cases = Vec::new();
    for (name, rho) in [("gaussian", 0.0), ("correlated 0.5", 0.5)] {
        for n in [200, 400, 1000] {
            cases.push(case(name, &design(1, n, 100, 10, rho, 10.0), 10, Bound::Gains)?);
        }
    }
    for noise in [0.0, 1e-8, 0.01, 0.1] {
        cases.push(case(&format!("lorenz, noise {noise}"), &lorenz(1000, noise), 8, Bound::Gains)?);
    }
    cases.push(case("fewer rows", &design(1, 50, 100, 4, 0.0, 10.0), 4, Bound::Gains)?);
    cases.push(case("fewer rows", &design(1, 50, 100, 5, 0.0, 10.0), 5, Bound::Gains)?);
    cases.push(case("fewer rows", &design(1, 12, 25, 6, 0.0, 10.0), 6, Bound::Gains)?);
    cases.push(case("ten rows", &design(1, 10, 90, 3, 0.0, 10.0), 3, Bound::Gains)?);
    cases.push(chosen("choosing a size", &design(1, 10, 90, 3, 0.0, 1e12))?);
    cases.push(chosen("choosing a size", &design(1, 50, 100, 4, 0.0, 10.0))?);
    let mut bounds = Vec::new();
    for bound in [Bound::None, Bound::Exclusion, Bound::Gains, Bound::Relaxation] {
        for (name, rho) in [("gaussian", 0.0), ("correlated 0.5", 0.5)] {
            bounds.push(case(name, &design(1, 200, 40, 8, rho, 10.0), 8, bound)?);
        }
        bounds.push(case("lorenz, noise 0.01", &lorenz(1000, 0.01), 6, bound)?);
    }
    for (name, rho) in [("gaussian, wide", 0.0), ("correlated 0.5, wide", 0.5)] {
        for bound in [Bound::Exclusion, Bound::Gains, Bound::Relaxation] {
            bounds.push(case(name, &design(1, 200, 100, 10, rho, 10.0), 10, bound)?);
        }
    }
    for bound in [Bound::Exclusion, Bound::Gains, Bound::Relaxation] {
        bounds.push(case("correlated 0.5, SNR 1", &design(1, 300, 60, 10, 0.5, 1.0), 10, bound)?);
    }
    let mut growth = Vec::new();
    for p in [25, 50, 100, 200] {
        growth.push(case("features", &design(1, 1000, p, 5, 0.0, 10.0), 5, Bound::Gains)?);
    }
    for terms in [2, 4, 6, 8, 10] {
        growth.push(case("terms", &design(1, 1000, 100, 10, 0.0, 10.0), terms, Bound::Gains)?);
    }
    for n in [200, 400, 800, 1600] {
        growth.push(case("rows", &design(1, n, 100, 10, 0.0, 10.0), 10, Bound::Gains)?);
    }
    Ok(json!({ "cases": cases, "bounds": bounds, "growth": growth }))
}
