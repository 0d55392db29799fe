//! What must hold for any numbers.

use ndarray::{Array2, Axis, s};
use proptest::prelude::*;
use sindyna_sindy::{BestSubset, Differentiator, Expr, FiniteDifference, Function, Selection, Stlsq, Triangle, parse};

/// Rows (n, width) of numbers in ±1.
fn rows(n: std::ops::Range<usize>, width: usize) -> impl Strategy<Value = Array2<f64>> {
    n.prop_flat_map(move |n| {
        prop::collection::vec(-1.0..1.0_f64, n * width)
            .prop_map(move |values| Array2::from_shape_vec((n, width), values).expect("whole rows"))
    })
}

fn triangle(rows: &Array2<f64>) -> Triangle {
    let mut triangle = Triangle::new(rows.ncols());
    triangle.push(rows.view()).expect("finite rows");
    triangle
}

fn close(a: &[f64], b: &[f64], tolerance: f64) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= tolerance * (1.0 + b.abs()))
}

fn best(t: &Triangle, features: usize) -> (Vec<usize>, Vec<f64>) {
    let complexity = vec![2; features];
    let found =
        BestSubset::default().solve(t, features, Selection { floor: 0.0, complexity: &complexity, region: None });
    (found.support, found.coefficients)
}

/// Any term over two variables; powers and arguments are kept small.
fn term() -> impl Strategy<Value = Expr> {
    let leaf = prop_oneof![
        (0..2_usize).prop_map(Expr::Variable),
        (-1e3..1e3_f64).prop_map(Expr::Constant),
        prop::num::f64::NORMAL.prop_map(Expr::Constant),
    ];
    leaf.prop_recursive(5, 24, 2, |inner| {
        let pair = (inner.clone(), inner.clone());
        let boxed = |(a, b): (Expr, Expr)| (Box::new(a), Box::new(b));
        prop_oneof![
            pair.clone().prop_map(boxed).prop_map(|(a, b)| Expr::Add(a, b)),
            pair.clone().prop_map(boxed).prop_map(|(a, b)| Expr::Sub(a, b)),
            pair.clone().prop_map(boxed).prop_map(|(a, b)| Expr::Mul(a, b)),
            pair.prop_map(boxed).prop_map(|(a, b)| Expr::Div(a, b)),
            inner.clone().prop_map(|a| Expr::Neg(Box::new(a))),
            (inner.clone(), -3..5_i32).prop_map(|(a, n)| Expr::Power(Box::new(a), n)),
            (inner, 0..Function::ALL.len()).prop_map(|(a, f)| Expr::Call(Function::ALL[f], Box::new(a))),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_printed_term_is_read_back_as_the_same_term(term in term()) {
        let names = ["θ".to_owned(), "v_1".to_owned()];
        let text = term.display(&names).to_string();
        prop_assert_eq!(parse(&text, &names), Ok(term), "{}", text);
    }

    #[test]
    fn the_parser_answers_anything(text in "[a-zθω0-9+*/^(). ·²-]{0,40}") {
        let _ = parse(&text, &["x".to_owned(), "θ".to_owned()]);
    }

    #[test]
    fn stlsq_support_never_grows(rows in rows(8..30, 6), threshold in 0.0..1.0_f64, ridge in 0.0..1.0_f64) {
        let fit = Stlsq::new(threshold, ridge).expect("valid settings").solve(&triangle(&rows), 5, 5);
        prop_assert!(fit.history.windows(2).all(|w| w[1] <= w[0]), "{:?}", fit.history);
        prop_assert!(fit.history.first().is_none_or(|&n| n <= 5));
    }

    #[test]
    fn a_higher_threshold_after_one_round_keeps_no_other_terms(rows in rows(8..30, 6), low in 0.0..0.5_f64) {
        let t = triangle(&rows);
        let kept = |threshold| {
            let solver = Stlsq::new(threshold, 0.05).and_then(|s| s.with_max_iterations(1)).expect("valid settings");
            solver.solve(&t, 5, 5).coefficients.iter().map(|c| *c != 0.0).collect::<Vec<_>>()
        };
        let (few, many) = (kept(low + 0.3), kept(low));
        prop_assert!(few.iter().zip(&many).all(|(few, many)| !few || *many));
    }

    #[test]
    fn merged_pieces_are_the_whole(rows in rows(2..40, 4), at in 0.0..1.0_f64) {
        let cut = (rows.nrows() as f64 * at) as usize;
        let mut merged = triangle(&rows.slice(s![cut.., ..]).to_owned());
        merged.merge(&triangle(&rows.slice(s![..cut, ..]).to_owned())).expect("same columns");
        let whole = triangle(&rows);
        prop_assert_eq!(merged.n_rows(), whole.n_rows());
        // The last columns of a nearly singular triangle are rounding; inner products are what counts.
        for a in 0..4 {
            for b in 0..4 {
                let dot = |t: &Triangle| t.column(a).iter().zip(t.column(b)).map(|(x, y)| x * y).sum::<f64>();
                prop_assert!((dot(&merged) - dot(&whole)).abs() < 1e-12 * rows.nrows() as f64);
            }
        }
    }

    #[test]
    fn the_order_of_rows_does_not_matter(rows in rows(20..40, 6)) {
        let mut reversed = rows.clone();
        reversed.invert_axis(Axis(0));
        let (a, b) = (triangle(&rows), triangle(&reversed.as_standard_layout().to_owned()));
        let solver = Stlsq::new(0.1, 0.05).expect("valid settings");
        prop_assert!(close(&solver.solve(&a, 5, 5).coefficients, &solver.solve(&b, 5, 5).coefficients, 1e-9));
        let (a, b) = (best(&a, 5), best(&b, 5));
        prop_assert_eq!(a.0, b.0);
        prop_assert!(close(&a.1, &b.1, 1e-9));
    }

    #[test]
    fn permuted_terms_get_permuted_coefficients(rows in rows(20..40, 6), shift in 1..5_usize) {
        let mut permuted = rows.clone();
        for j in 0..5 {
            permuted.column_mut((j + shift) % 5).assign(&rows.column(j));
        }
        let (a, b) = (triangle(&rows), triangle(&permuted));
        let solver = Stlsq::new(0.1, 0.05).expect("valid settings");
        let (x, y) = (solver.solve(&a, 5, 5).coefficients, solver.solve(&b, 5, 5).coefficients);
        let moved: Vec<f64> = (0..5).map(|j| y[(j + shift) % 5]).collect();
        prop_assert!(close(&x, &moved, 1e-9), "{:?} {:?}", x, moved);
        let (x, y) = (best(&a, 5).0, best(&b, 5).0);
        let mut moved: Vec<usize> = x.iter().map(|j| (j + shift) % 5).collect();
        moved.sort_unstable();
        prop_assert_eq!(moved, y);
    }

    #[test]
    fn differences_are_exact_on_polynomials_of_their_order(order in 1..7_usize, c in prop::collection::vec(-1.0..1.0_f64, 8)) {
        let dt = 0.3;
        let value = |t: f64| (0..=order).map(|m| c[m] * t.powi(m as i32)).sum::<f64>();
        let slope = |t: f64| (1..=order).map(|m| c[m] * m as f64 * t.powi(m as i32 - 1)).sum::<f64>();
        let x = Array2::from_shape_fn((12, 1), |(i, _)| value(dt * (i as f64 - 6.0)));
        let x_dot = FiniteDifference::new(order).expect("a valid order").differentiate(x.view(), dt).expect("12 samples");
        for i in 0..12 {
            let exact = slope(dt * (i as f64 - 6.0));
            prop_assert!((x_dot[[i, 0]] - exact).abs() < 1e-8, "sample {}: {} is not {}", i, x_dot[[i, 0]], exact);
        }
    }

    #[test]
    fn smoothing_leaves_cubics_alone(c in prop::collection::vec(-1.0..1.0_f64, 4)) {
        let x = Array2::from_shape_fn((25, 1), |(i, _)| {
            let t = 0.1 * i as f64;
            c[0] + t * (c[1] + t * (c[2] + t * c[3]))
        });
        let smoothed = Differentiator::Smoothed(Default::default()).differentiate(x.view(), 0.1).expect("25 samples");
        prop_assert!((&smoothed.x - &x).iter().all(|e| e.abs() < 1e-12));
    }
}

#[test]
fn differences_converge_at_their_order() {
    let error = |order: usize, n: usize| {
        let dt = 1.0 / n as f64;
        let x = Array2::from_shape_fn((n + 1, 1), |(i, _)| (2.0 * dt * i as f64).sin());
        let x_dot = FiniteDifference::new(order).expect("a valid order").differentiate(x.view(), dt).expect("samples");
        (0..=n).map(|i| (x_dot[[i, 0]] - 2.0 * (2.0 * dt * i as f64).cos()).abs()).fold(0.0, f64::max)
    };
    for order in 1..=4 {
        let measured = (error(order, 60) / error(order, 120)).log2();
        assert!((measured - order as f64).abs() < 0.2, "order {order}: measured {measured}");
    }
}

/// All subsets of a size, by brute force.
#[test]
fn best_subsets_are_the_best_of_all() {
    let (n, m) = (25, 9);
    let mut state = 7_u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    for trial in 0..10 {
        let rows = Array2::from_shape_simple_fn((n, m + 1), &mut next);
        let t = triangle(&rows);
        let complexity = vec![2; m];
        let found = BestSubset::default().with_max_size(5).solve(
            &t,
            m,
            Selection { floor: 0.0, complexity: &complexity, region: None },
        );
        for report in &found.path {
            let size = report.support.len();
            assert!(report.proved);
            let mut smallest = f64::INFINITY;
            for mask in (0_usize..1 << m).filter(|mask| mask.count_ones() as usize == size) {
                let support: Vec<usize> = (0..m).filter(|j| mask >> j & 1 == 1).collect();
                smallest = smallest.min(t.residual_norm(&support, &t.solve(&support, m, 0.0), m));
            }
            let smallest = smallest / ((n - size) as f64).sqrt();
            assert!((report.residual - smallest).abs() < 1e-12, "trial {trial}: {report:?} against {smallest}");
        }
    }
}
