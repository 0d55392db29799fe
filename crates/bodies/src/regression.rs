//! The regression of forces on base parameters.

use nalgebra::{DMatrix, DVector};

use crate::BodiesError;
use crate::base::Base;
use crate::rows::Rows;

/// Part of the largest residual that residuals of other joints are taken to be at least.
const LEAST: f64 = 1e-6;

/// Blocks of consecutive rows whose errors are taken as independent of each other.
const BLOCKS: usize = 40;

/// Part of the largest singular value of scaled columns below which no motion in the data tells a direction.
const SINGULAR: f64 = 1e-9;

/// What rows tell of base parameters (b).
#[derive(Debug, Clone)]
pub(crate) struct Regression {
    pub(crate) values: Vec<f64>,
    /// Standard errors, of blocks of rows; infinite where the data do not determine a value.
    pub(crate) errors: Vec<f64>,
    /// H of the squared misfit (β − β̂)ᵀ H (β − β̂), in units of the squared residuals.
    pub(crate) information: DMatrix<f64>,
    /// Of the columns, each of length 1.
    pub(crate) condition: f64,
    /// Combinations that no motion in the data tells apart from others.
    pub(crate) undetermined: usize,
}

/// Least squares over `rows`, those of each joint weighed by what unweighted ones leave of them.
pub(crate) fn regression(base: &Base, rows: &[Rows]) -> Result<Regression, BodiesError> {
    let (n, b) = (rows.first().map_or(0, |r| r.forces.len()), base.len());
    if rows.len() * n < 2 * b {
        return Err(BodiesError::TooFew { got: rows.len() * n, needed: 2 * b });
    }
    let mut x = DMatrix::zeros(rows.len() * n, b);
    let mut y = DVector::zeros(rows.len() * n);
    for (t, row) in rows.iter().enumerate() {
        x.rows_mut(t * n, n).copy_from(&base.columns(&row.parameters));
        y.rows_mut(t * n, n).copy_from(&row.forces);
    }
    if y.iter().all(|force| *force == 0.0) {
        return Err(BodiesError::NoForce);
    }
    let scales: Vec<f64> = x.column_iter().map(|c| if c.norm() > 0.0 { c.norm() } else { 1.0 }).collect();
    x.column_iter_mut().zip(&scales).for_each(|(mut column, scale)| column /= *scale);
    let mut weights = vec![1.0; n];
    let first = weighed(&x, &y, &weights);
    // Not again and again: a joint without forces would be explained better and better by parameters that vanish.
    let left = &y - &x * &first.values;
    let sums = (0..n).map(|j| left.iter().skip(j).step_by(n).map(|r| r * r).sum::<f64>());
    let sizes: Vec<f64> = sums.map(|sum| (sum / rows.len() as f64).sqrt()).collect();
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    if largest > 0.0 {
        weights = sizes.iter().map(|size| 1.0 / size.max(LEAST * largest)).collect();
    }
    let solved = weighed(&x, &y, &weights);
    let left = &y - &x * &solved.values;
    let mut spread = DMatrix::zeros(b, b);
    let blocks = BLOCKS.min(rows.len());
    for block in 0..blocks {
        let (from, to) = (block * rows.len() / blocks, (block + 1) * rows.len() / blocks);
        let mut slope = DVector::zeros(b);
        for at in from * n..to * n {
            slope.axpy(left[at] * weights[at % n].powi(2), &x.row(at).transpose(), 1.0);
        }
        spread += &slope * slope.transpose();
    }
    let few = blocks as f64 / (blocks as f64 - 1.0).max(1.0);
    let covariance = &solved.inverse * (spread * few) * &solved.inverse;
    let error =
        |i: usize| if solved.is_determined[i] { covariance[(i, i)].max(0.0).sqrt() / scales[i] } else { f64::INFINITY };
    let unscaled = DMatrix::from_diagonal(&DVector::from_vec(scales.clone()));
    Ok(Regression {
        values: solved.values.iter().zip(&scales).map(|(value, scale)| value / scale).collect(),
        errors: (0..b).map(error).collect(),
        information: &unscaled * solved.information * &unscaled,
        condition: solved.condition,
        undetermined: solved.undetermined,
    })
}

struct Solved {
    values: DVector<f64>,
    information: DMatrix<f64>,
    inverse: DMatrix<f64>,
    is_determined: Vec<bool>,
    condition: f64,
    undetermined: usize,
}

/// Weighted least squares by QR decomposition, with the least values where the data tell nothing.
fn weighed(x: &DMatrix<f64>, y: &DVector<f64>, weights: &[f64]) -> Solved {
    let n = weights.len();
    let (mut x, mut y) = (x.clone(), y.clone());
    for (at, mut row) in x.row_iter_mut().enumerate() {
        row *= weights[at % n];
        y[at] *= weights[at % n];
    }
    let b = x.ncols();
    let decomposed = x.qr();
    decomposed.q_tr_mul(&mut y);
    let triangle = decomposed.r();
    let svd = triangle.clone().svd(true, true);
    let largest = svd.singular_values.max();
    let kept = |i: usize| svd.singular_values[i] > SINGULAR * largest;
    let (Some(u), Some(v_t)) = (&svd.u, &svd.v_t) else {
        let none = DMatrix::zeros(b, b);
        return Solved {
            values: DVector::zeros(b),
            information: none.clone(),
            inverse: none,
            is_determined: vec![false; b],
            condition: f64::INFINITY,
            undetermined: b,
        };
    };
    let mut values = DVector::zeros(b);
    let mut inverse = DMatrix::zeros(b, b);
    let mut is_determined = vec![true; b];
    for i in 0..b {
        let direction = v_t.row(i).transpose();
        if kept(i) {
            let size = svd.singular_values[i];
            values.axpy(u.column(i).dot(&y.rows(0, b)) / size, &direction, 1.0);
            inverse += &direction * direction.transpose() / (size * size);
        } else {
            (0..b).filter(|&p| direction[p].abs() > 1e-6).for_each(|p| is_determined[p] = false);
        }
    }
    let smallest = svd.singular_values.min();
    Solved {
        values,
        information: triangle.transpose() * triangle,
        inverse,
        is_determined,
        condition: if smallest > 0.0 { largest / smallest } else { f64::INFINITY },
        undetermined: (0..b).filter(|&i| !kept(i)).count(),
    }
}
