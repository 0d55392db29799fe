//! Explicit Runge–Kutta schemes.

use std::sync::LazyLock;

/// Coefficients of an explicit scheme.
#[derive(Debug)]
pub(super) struct Tableau {
    /// Per stage: weights of the slopes of the stages before it.
    pub(super) a: Vec<Vec<f64>>,
    /// Weights of all slopes in the step.
    pub(super) b: Vec<f64>,
}

/// The classical scheme of order four.
pub(super) static FOURTH: LazyLock<Tableau> = LazyLock::new(|| Tableau {
    a: vec![vec![], vec![0.5], vec![0.0, 0.5], vec![0.0, 0.0, 1.0]],
    b: vec![1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0],
});

/// A scheme of order eight with eleven stages.
///
/// # References
/// Cooper, Verner (1972), SIAM J. Numer. Anal. 9(3).
pub(super) static EIGHTH: LazyLock<Tableau> = LazyLock::new(|| {
    let s = 21_f64.sqrt();
    let a = vec![
        vec![],
        vec![0.5],
        vec![0.25, 0.25],
        vec![1.0 / 7.0, (-7.0 - 3.0 * s) / 98.0, (21.0 + 5.0 * s) / 49.0],
        vec![(11.0 + s) / 84.0, 0.0, (18.0 + 4.0 * s) / 63.0, (21.0 - s) / 252.0],
        vec![(5.0 + s) / 48.0, 0.0, (9.0 + s) / 36.0, (-231.0 + 14.0 * s) / 360.0, (63.0 - 7.0 * s) / 80.0],
        vec![
            (10.0 - s) / 42.0,
            0.0,
            (-432.0 + 92.0 * s) / 315.0,
            (633.0 - 145.0 * s) / 90.0,
            (-504.0 + 115.0 * s) / 70.0,
            (63.0 - 13.0 * s) / 35.0,
        ],
        vec![1.0 / 14.0, 0.0, 0.0, 0.0, (14.0 - 3.0 * s) / 126.0, (13.0 - 3.0 * s) / 63.0, 1.0 / 9.0],
        vec![
            1.0 / 32.0,
            0.0,
            0.0,
            0.0,
            (91.0 - 21.0 * s) / 576.0,
            11.0 / 72.0,
            (-385.0 - 75.0 * s) / 1152.0,
            (63.0 + 13.0 * s) / 128.0,
        ],
        vec![
            1.0 / 14.0,
            0.0,
            0.0,
            0.0,
            1.0 / 9.0,
            (-733.0 - 147.0 * s) / 2205.0,
            (515.0 + 111.0 * s) / 504.0,
            (-51.0 - 11.0 * s) / 56.0,
            (132.0 + 28.0 * s) / 245.0,
        ],
        vec![
            0.0,
            0.0,
            0.0,
            0.0,
            (-42.0 + 7.0 * s) / 18.0,
            (-18.0 + 28.0 * s) / 45.0,
            (-273.0 - 53.0 * s) / 72.0,
            (301.0 + 53.0 * s) / 72.0,
            (28.0 - 28.0 * s) / 45.0,
            (49.0 - 7.0 * s) / 18.0,
        ],
    ];
    let b = vec![1.0 / 20.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 49.0 / 180.0, 16.0 / 45.0, 49.0 / 180.0, 1.0 / 20.0];
    Tableau { a, b }
});

#[cfg(test)]
mod tests {
    use super::*;

    /// One step of ẋ = −x² + t, ṫ = 1.
    fn step(tableau: &Tableau, x: f64, t: f64, h: f64) -> f64 {
        let mut slopes: Vec<f64> = Vec::new();
        for row in &tableau.a {
            let at = x + h * row.iter().zip(&slopes).map(|(a, k)| a * k).sum::<f64>();
            slopes.push(t + h * row.iter().sum::<f64>() - at * at);
        }
        x + h * tableau.b.iter().zip(&slopes).map(|(b, k)| b * k).sum::<f64>()
    }

    #[test]
    fn errors_fall_with_the_order() {
        for (tableau, order) in [(&*FOURTH, 4), (&*EIGHTH, 8)] {
            let end = |steps: usize| {
                let h = 2.0 / steps as f64;
                (0..steps).fold(0.3, |x, i| step(tableau, x, i as f64 * h, h))
            };
            let exact = end(1000);
            let ratio = (end(5) - exact).abs() / (end(10) - exact).abs();
            assert!((ratio.log2() - f64::from(order)).abs() < 0.6, "order {}", ratio.log2());
        }
    }
}
