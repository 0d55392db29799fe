//! The best subsets of every size, against looking at all of them.

use ndarray::Array2;
use sindyna_sindy::{Bound, ConstraintError, Constraints, SubsetPath, Triangle};

/// A reproducible stream of numbers in ±1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Rows (n, p + 1) of p random columns and a target near the span of three of them.
fn random(seed: u64, n: usize, p: usize, noise: f64) -> Array2<f64> {
    let mut numbers = Numbers(seed);
    let mut rows = Array2::from_shape_fn((n, p + 1), |_| numbers.next());
    for mut row in rows.rows_mut() {
        row[p] = row[1] - 2.0 * row[p / 2] + 0.5 * row[p - 1] + noise * row[p];
    }
    rows
}

fn triangle(rows: &Array2<f64>) -> Triangle {
    let mut triangle = Triangle::new(rows.ncols());
    triangle.push(rows.view()).expect("finite rows");
    triangle
}

/// Every choice of `r` of 0..n.
fn choices(n: usize, r: usize) -> Vec<Vec<usize>> {
    if r == 0 {
        return vec![vec![]];
    }
    let longer = |last: usize| {
        choices(last, r - 1).into_iter().map(move |mut c| {
            c.push(last);
            c
        })
    };
    (r - 1..n).flat_map(longer).collect()
}

/// The squared residuals of all subsets of each size, the smallest first, by least squares one by one.
fn brute(triangle: &Triangle, p: usize, constraints: &Constraints, size: usize) -> Vec<(f64, Vec<usize>)> {
    let taken: Vec<usize> = [&constraints.fixed, &constraints.forbidden]
        .into_iter()
        .chain(&constraints.groups)
        .flatten()
        .copied()
        .collect();
    let mut units: Vec<Vec<usize>> = (0..p).filter(|j| !taken.contains(j)).map(|j| vec![j]).collect();
    units.extend(constraints.groups.clone());
    let mut all: Vec<(f64, Vec<usize>)> = choices(units.len(), size)
        .into_iter()
        .map(|choice| {
            let mut support: Vec<usize> =
                choice.iter().flat_map(|&i| units[i].clone()).chain(constraints.fixed.clone()).collect();
            support.sort_unstable();
            let xi = triangle.solve(&support, p, 0.0);
            (triangle.residual_norm(&support, &xi, p).powi(2), support)
        })
        .collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all
}

/// Every size up to `max_size`: proved, with the residuals of the `keep` best, whatever the bound.
fn check(rows: &Array2<f64>, constraints: &Constraints, max_size: usize, keep: usize) {
    let p = rows.ncols() - 1;
    let triangle = triangle(rows);
    let total = triangle.norm(p).powi(2);
    let every: Vec<_> = (0..=max_size).map(|size| brute(&triangle, p, constraints, size)).collect();
    for bound in [Bound::None, Bound::Exclusion, Bound::Gains, Bound::Relaxation] {
        let solver = SubsetPath::default().with_max_size(max_size).with_keep(keep).with_bound(bound);
        let path = solver.solve(&triangle, p, p, constraints).expect("valid constraints");
        for found in &path.sizes {
            let all = &every[found.size];
            assert!(found.proved, "{bound:?} {found:?}");
            assert_eq!(found.gap(), 0.0);
            assert_eq!(found.subsets.len(), keep.min(all.len()), "{bound:?} size {}", found.size);
            for (subset, (rss, support)) in found.subsets.iter().zip(all) {
                let close = (subset.rss - rss).abs() <= 1e-7 * rss + 1e-24 * total;
                assert!(close, "{bound:?} size {}: {subset:?}, not {rss} {support:?}", found.size);
            }
        }
        let sizes: Vec<usize> = path.sizes.iter().map(|s| s.size).collect();
        assert_eq!(sizes, (0..=max_size).collect::<Vec<_>>());
    }
}

#[test]
fn every_size_is_that_of_brute_force() {
    for seed in 0..6 {
        check(&random(seed, 40, 12, 0.5), &Constraints::default(), 12, 3);
        check(&random(seed, 25, 14, 3.0), &Constraints::default(), 7, 1);
    }
}

#[test]
fn bounds_agree_with_brute_force_where_they_cut() {
    for seed in 0..2 {
        check(&random(seed, 60, 19, 0.3), &Constraints::default(), 9, 2);
    }
}

#[test]
fn residuals_far_below_the_target_are_told_apart() {
    for seed in 0..4 {
        check(&random(seed, 30, 12, 1e-9), &Constraints::default(), 5, 4);
    }
}

#[test]
fn fewer_rows_than_columns_are_enumerated() {
    for seed in 0..4 {
        check(&random(seed, 8, 15, 0.5), &Constraints::default(), 5, 2);
    }
}

#[test]
fn nearly_dependent_columns_are_told_apart() {
    for seed in 0..4 {
        let mut rows = random(seed, 40, 12, 0.1);
        for mut row in rows.rows_mut() {
            row[3] = row[2] + 1e-6 * row[3];
            row[7] = row[4] + row[5] + 1e-5 * row[7];
            row[8] = row[7] + 1e-4 * row[8];
        }
        check(&rows, &Constraints::default(), 8, 1);
    }
}

#[test]
fn powers_of_one_variable_are_told_apart() {
    let rows = Array2::from_shape_fn((50, 13), |(i, j)| {
        let x = 0.3 + 0.7 * i as f64 / 50.0;
        if j == 12 { x.powi(2) - 0.7 * x.powi(5) + 1e-6 * (40.0 * x).sin() } else { x.powi(j as i32) }
    });
    check(&rows, &Constraints::default(), 4, 1);
}

#[test]
fn fixed_forbidden_and_grouped_terms_are_kept_to() {
    for seed in 0..4 {
        let constraints = Constraints { fixed: vec![0, 9], forbidden: vec![6], groups: vec![] };
        check(&random(seed, 40, 14, 0.5), &constraints, 6, 3);
        let constraints =
            Constraints { fixed: vec![2], forbidden: vec![1, 5], groups: vec![vec![0, 3], vec![7, 8, 10]] };
        check(&random(seed, 40, 12, 0.5), &constraints, 6, 3);
        check(&random(seed, 9, 12, 0.5), &constraints, 3, 2);
    }
}

#[test]
fn equal_columns_are_told_and_one_of_them_is_used() {
    let mut rows = random(1, 30, 10, 0.1);
    for mut row in rows.rows_mut() {
        row[8] = -3.0 * row[5];
    }
    let triangle = triangle(&rows);
    let path = SubsetPath::default()
        .with_max_size(4)
        .solve(&triangle, 10, 10, &Constraints::default())
        .expect("no constraints");
    assert_eq!(path.equal, [(8, 5)]);
    assert!(path.sizes.iter().all(|s| s.subsets.iter().all(|c| !c.support.contains(&8))));
}

#[test]
fn what_is_not_searched_is_not_proved() {
    let rows = random(3, 120, 40, 6.0);
    let triangle = triangle(&rows);
    let solver = SubsetPath::default().with_max_size(8);
    let (none, few) = (Constraints::default(), solver.with_budget(20_000));
    let whole = solver.solve(&triangle, 40, 40, &none).expect("no constraints");
    let part = few.solve(&triangle, 40, 40, &none).expect("no constraints");
    assert_eq!(part, few.solve(&triangle, 40, 40, &none).expect("no constraints"));
    assert!(part.sizes.iter().any(|s| !s.proved && s.gap() > 0.0));
    for (whole, part) in whole.sizes.iter().zip(&part.sizes) {
        assert!(whole.proved, "{whole:?}");
        assert!(part.lower_bound <= whole.subsets[0].rss * (1.0 + 1e-9));
        assert!(part.subsets[0].rss >= whole.subsets[0].rss * (1.0 - 1e-9));
        assert_eq!(part.proved, part.gap() == 0.0);
    }
    let stopped = solver.solve_while(&triangle, 40, 40, &none, &|| false).expect("no constraints");
    assert!(stopped.sizes[1..].iter().all(|s| !s.proved && !s.subsets.is_empty()));
}

#[test]
fn ten_of_a_hundred_columns_are_proved_on_twice_as_many_rows() {
    let mut numbers = Numbers(5);
    let mut rows = Array2::from_shape_fn((200, 101), |_| numbers.next());
    for mut row in rows.rows_mut() {
        // Ten terms of variance 1/3 each, and noise with a tenth of their variance.
        row[100] += (0..10).map(|i| row[10 * i] * if i % 2 == 0 { 1.0 } else { -1.0 }).sum::<f64>();
    }
    let path =
        SubsetPath::default().solve(&triangle(&rows), 100, 100, &Constraints::default()).expect("no constraints");
    assert!(path.sizes.iter().all(|s| s.proved), "{:?}", path.sizes);
    assert_eq!(path.sizes[10].subsets[0].support, (0..10).map(|i| 10 * i).collect::<Vec<_>>());
    // Looking at all subsets would be 2·10¹³.
    let operations: u64 = path.sizes.iter().map(|s| s.operations).sum();
    assert!(operations < 100_000_000, "{operations}");
}

#[test]
fn impossible_constraints_are_refused() {
    let triangle = triangle(&random(0, 20, 5, 0.1));
    let refused = |fixed: &[usize], forbidden: &[usize], groups: &[Vec<usize>]| {
        let constraints = Constraints { fixed: fixed.to_vec(), forbidden: forbidden.to_vec(), groups: groups.to_vec() };
        SubsetPath::default().solve(&triangle, 5, 5, &constraints).expect_err("refused")
    };
    assert_eq!(refused(&[5], &[], &[]), ConstraintError::NoColumn { column: 5, n_features: 5 });
    assert_eq!(refused(&[1], &[1], &[]), ConstraintError::Twice { column: 1 });
    assert_eq!(refused(&[], &[], &[vec![0], vec![]]), ConstraintError::EmptyGroup { group: 1 });
}
