//! Rows of all joints in one regression, each joint weighed by the momentum that it exchanges.

use ndarray::Array2;

use crate::Triangle;
use crate::library::Lagrangian;

/// Times the rows of each joint are weighed by the momentum that it exchanges.
const WEIGHINGS: usize = 3;

/// The triangle of the parameters `choice` for what `unit` explains, rows of each joint weighed by the momentum it exchanges.
pub(crate) fn weighed(
    lagrangian: &Lagrangian,
    rows: &[Vec<Array2<f64>>],
    (unit, choice): (usize, &[usize]),
) -> Option<Triangle> {
    let n_joints = lagrangian.joints.len();
    let triangle_of = |weights: &[f64]| {
        let mut triangle = Triangle::new(choice.len() + 1);
        for rows in rows {
            for (own, weight) in rows.iter().zip(weights) {
                let column = |c: usize| choice.get(c).map_or((unit, -weight), |&p| (p, *weight));
                let of = |(t, c): (usize, usize)| column(c).1 * own[[t, column(c).0]];
                triangle.push(Array2::from_shape_fn((own.nrows(), choice.len() + 1), of).view()).ok()?;
            }
        }
        Some(triangle)
    };
    let mut triangle = triangle_of(&vec![1.0; n_joints])?;
    let all: Vec<usize> = (0..choice.len()).collect();
    for _ in 0..WEIGHINGS {
        let values = triangle.solve_unit(&all, choice.len());
        let parameters: Vec<(usize, f64)> = choice.iter().copied().zip(values).chain([(unit, 1.0)]).collect();
        let weights: Vec<f64> = (0..n_joints).map(|i| 1.0 / exchanged(lagrangian, rows, i, &parameters)).collect();
        if weights.iter().any(|w| !w.is_finite()) {
            return None;
        }
        triangle = triangle_of(&weights)?;
    }
    Some(triangle)
}

/// RMS of the momentum that joint `i` exchanges in a row.
fn exchanged(lagrangian: &Lagrangian, rows: &[Vec<Array2<f64>>], i: usize, parameters: &[(usize, f64)]) -> f64 {
    let inertias: Vec<(usize, f64)> =
        parameters.iter().copied().filter(|(p, _)| !lagrangian.momenta(*p).is_empty()).collect();
    let (mut sum, mut count) = (0.0, 0.0);
    for rows in rows {
        for row in rows[i].rows() {
            sum += inertias.iter().map(|(p, c)| c * row[*p]).sum::<f64>().powi(2);
            count += 1.0;
        }
    }
    (sum / f64::max(count, 1.0)).sqrt()
}
