//! What all parameters would change of pieces, near those that were fitted.

use nalgebra::DMatrix;
use ndarray::Array2;

use super::fit::{Data, Fitted, Slopes};
use super::grouped::{Group, block};
use crate::mechanics::Equations;

/// Rows of each piece, linearised at `fitted`: all parameters but the unit for what they would have to explain, with the start of the piece taken out.
///
/// Of residuals r and their slopes J by the parameters θ and B by the start, rows are Q⊥ᵀ \[J | J θ − r\], where Q⊥ is orthogonal to B.
///
/// For slopes each parameter is changed by at least the part `least` of its own.
pub(super) fn groups(
    data: &Data<'_>,
    all: &Equations,
    (theta, least): (&[f64], f64),
    fitted: &Fitted,
) -> Vec<Option<Group>> {
    let free: Vec<usize> = (1..theta.len()).collect();
    let slopes = data.slopes(&|theta| all.at(theta), (theta, &fitted.starts, &fitted.sigma), &free, least);
    let count = slopes.len();
    slopes
        .into_iter()
        .enumerate()
        .map(|(at, slopes)| Some(Group { rows: rows(&slopes?, &theta[1..]), block: block(at, count) }))
        .collect()
}

fn rows(Slopes { residuals, by_theta, by_start }: &Slopes, theta: &[f64]) -> Array2<f64> {
    let (d, width) = (residuals.len(), theta.len() + 1);
    let mut rows = DMatrix::zeros(d, width);
    for (j, theta) in theta.iter().enumerate() {
        rows.set_column(j, &by_theta.column(j));
        let target = rows.column(width - 1) + *theta * by_theta.column(j);
        rows.set_column(width - 1, &target);
    }
    let target = rows.column(width - 1) - residuals;
    rows.set_column(width - 1, &target);
    let q = by_start.clone().qr().q();
    let rest = &rows - &q * (q.transpose() * &rows);
    Array2::from_shape_fn((d, width), |(i, j)| rest[(i, j)])
}
