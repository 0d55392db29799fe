//! Products against their definition, and one instruction set against another.

use super::{Finish, Matrix, dots, matmul, matmul_and_sums};
use crate::Isa;

fn sets() -> impl Iterator<Item = Isa> {
    Isa::ALL.into_iter().filter(|isa| isa.present())
}

fn whole(i: usize) -> f32 {
    ((i * 37 + 11) % 23) as f32 - 11.0
}

fn wave(n: usize, phase: f64) -> Vec<f32> {
    (0..n).map(|i| (1.7 * i as f64 + phase).sin() as f32).collect()
}

const SHAPES: [(usize, usize, usize); 12] = [
    (1, 1, 1),
    (5, 3, 7),
    (64, 4, 1),
    (1, 64, 64),
    (33, 17, 2),
    (19, 300, 75),
    (37, 129, 64),
    (8, 9, 200),
    (256, 64, 64),
    (14, 0, 5),
    (0, 9, 5),
    (3, 4, 40),
];

/// The shapes; the small ones alone under Miri, which is a thousand times slower.
fn shapes() -> impl Iterator<Item = (usize, usize, usize)> {
    SHAPES.into_iter().filter(|(m, k, n)| !cfg!(miri) || m * k * n < 500)
}

#[test]
fn products_of_transposes_are_those_of_the_definition() {
    for isa in sets() {
        for (m, k, n) in shapes() {
            let a: Vec<f32> = (0..m * k).map(whole).collect();
            let b: Vec<f32> = (0..k * n).map(|i| whole(i + 5)).collect();
            let (mut at, mut bt) = (vec![0.0; m * k], vec![0.0; k * n]);
            (0..m * k).for_each(|i| at[i % k * m + i / k] = a[i]);
            (0..k * n).for_each(|i| bt[i % n * k + i / n] = b[i]);
            let biases: Vec<f32> = (0..n).map(|i| whole(i + 3)).collect();
            let outputs: Vec<f32> = (0..2 * m * n).map(|i| whole(i + 2)).collect();
            let rows: Vec<usize> = (0..m).map(|i| (7 * i + 1) % (2 * m)).collect();
            // Whole numbers below 2²⁴ add exactly, in any order.
            let exact: Vec<f32> =
                (0..m * n).map(|i| (0..k).map(|j| a[i / n * k + j] * b[j * n + i % n]).sum()).collect();
            let finished = |finish: Finish<'_>, i: usize| match finish {
                Finish::Plain => exact[i],
                Finish::Biases(_) => exact[i] + biases[i % n],
                Finish::BiasesRelu(_) => (exact[i] + biases[i % n]).max(0.0),
                Finish::ThroughRelu { rows, .. } => {
                    let row = rows.map_or(i / n, |rows| rows[i / n]);
                    if outputs[row * n + i % n] > 0.0 { exact[i] } else { 0.0 }
                }
                Finish::ThroughSlopes(slopes) => exact[i] * slopes[i],
            };
            let mut c = vec![f32::NAN; m * n];
            for left in [Matrix::new(&a, m, k), Matrix::new(&at, k, m).t()] {
                for right in [Matrix::new(&b, k, n), Matrix::new(&bt, n, k).t()] {
                    for finish in [
                        Finish::Plain,
                        Finish::Biases(&biases),
                        Finish::BiasesRelu(&biases),
                        Finish::ThroughRelu { outputs: &outputs, rows: None },
                        Finish::ThroughRelu { outputs: &outputs, rows: Some(&rows) },
                        Finish::ThroughSlopes(&outputs[..m * n]),
                    ] {
                        c.fill(f32::NAN);
                        matmul(isa, &mut c, left, right, finish);
                        let truth: Vec<f32> = (0..m * n).map(|i| finished(finish, i)).collect();
                        assert_eq!(c, truth, "{isa} ({m}, {k}) × ({k}, {n}) {finish:?}");
                        c.fill(f32::NAN);
                        let mut sums = vec![f32::NAN; n];
                        matmul_and_sums(isa, &mut c, left, right, finish, Some(&mut sums));
                        let column = |j: usize| truth.iter().skip(j).step_by(n).sum::<f32>();
                        assert_eq!(c, truth, "{isa} ({m}, {k}) × ({k}, {n}) {finish:?}");
                        assert_eq!(sums, (0..n).map(column).collect::<Vec<f32>>(), "{isa} ({m}, {k}) × ({k}, {n})");
                    }
                }
            }
        }
    }
}

#[test]
fn dots_are_those_of_the_definition() {
    for isa in sets() {
        for (m, k, n) in shapes().filter(|s| s.1 > 0) {
            let xs: Vec<f32> = (0..m * k).map(whole).collect();
            let vectors: Vec<f32> = (0..n * k).map(|i| whole(i + 5)).collect();
            let biases: Vec<f32> = (0..n).map(|i| whole(i + 3)).collect();
            let exact: Vec<f32> = (0..m * n)
                .map(|i| (0..k).map(|j| xs[i / n * k + j] * vectors[i % n * k + j]).sum::<f32>() + biases[i % n])
                .collect();
            let mut ys = vec![f32::NAN; m * n];
            dots(isa, &mut ys, &xs, &vectors, k, Some(&biases));
            assert_eq!(ys, exact, "{isa} ({m}, {k}) × ({n}, {k})ᵀ");
        }
    }
}

#[test]
fn fused_sums_are_one_chain_that_rounds_once_a_product() {
    for isa in sets().filter(|isa| *isa != Isa::Portable) {
        for (m, k, n) in shapes().filter(|s| s.1 > 0) {
            let (a, b) = (wave(m * k, 0.3), wave(k * n, 1.1));
            let mut c = vec![0.0; m * n];
            matmul(isa, &mut c, Matrix::new(&a, m, k), Matrix::new(&b, k, n), Finish::Plain);
            let chain = |i: usize, j: usize| (0..k).fold(0.0, |sum: f32, l| a[i * k + l].mul_add(b[l * n + j], sum));
            let expected: Vec<u32> = (0..m * n).map(|at| chain(at / n, at % n).to_bits()).collect();
            let bits: Vec<u32> = c.iter().map(|c| c.to_bits()).collect();
            assert!(bits == expected, "{isa} ({m}, {k}, {n})");
        }
    }
}

#[test]
fn wider_vectors_give_the_same_bits() {
    let sets: Vec<Isa> = sets().filter(|isa| *isa != Isa::Portable).collect();
    for (m, k, n) in shapes().filter(|s| s.1 > 0) {
        let (a, b) = (wave(m * k, 0.3), wave(k * n, 1.1));
        let of = |isa| {
            let (mut c, mut d) = (vec![0.0; m * n], vec![0.0; m * n]);
            matmul(isa, &mut c, Matrix::new(&a, m, k), Matrix::new(&b, k, n), Finish::Plain);
            dots(isa, &mut d, &a, &b, k, None);
            [c, d].concat().into_iter().map(f32::to_bits).collect::<Vec<u32>>()
        };
        for pair in sets.windows(2) {
            assert!(of(pair[0]) == of(pair[1]), "{} and {} differ at ({m}, {k}, {n})", pair[0], pair[1]);
        }
    }
}

#[test]
fn a_number_that_is_none_is_not_hidden_by_relu() {
    for isa in sets() {
        let mut c = [0.0; 3];
        let (a, b) = ([f32::NAN], [1.0; 3]);
        matmul(isa, &mut c, Matrix::new(&a, 1, 1), Matrix::new(&b, 1, 3), Finish::BiasesRelu(&[0.0; 3]));
        assert!(c.iter().all(|c| c.is_nan()), "{isa}: {c:?}");
    }
}
