//! Parameters by the errors of simulated motions.

use nalgebra::{DMatrix, DVector};

use crate::Tree;
use crate::base::Base;
use crate::regression::Regression;
use crate::regressor::{forces, inverse_dynamics};
use crate::rows::Motion;
use crate::simulate::{masses, simulated_from, smoothed};

/// Pieces of motions that are simulated, at most, and rounds of Levenberg–Marquardt.
const PIECES: usize = 40;
const ROUNDS: usize = 12;

/// Part of a value by which slopes of accelerations are taken.
const NUDGE: f64 = 1e-6;

/// Part of the cost by which a round must lower it for another one.
const GAIN: f64 = 1e-4;

/// A piece with the state from which it is simulated.
struct Piece {
    motion: Motion,
    start: Vec<f64>,
}

/// What a simulated piece says: errors of samples (2 n each), and their slopes by base parameters and start.
struct Slopes {
    errors: DVector<f64>,
    by_parameters: DMatrix<f64>,
    by_start: DMatrix<f64>,
}

/// The base parameters near `values` (b) for which motions simulated over pieces of so many steps are nearest to the samples, each piece from a start of its own; channels are weighed by what is
/// left of them. Standard errors are those of the curvature of the cost, times the square root of what pieces pull more than that tells: tr(H⁻¹ Σ g gᵀ)/b of their gradients g. `None` if nothing can be
/// simulated, or `go_on` says no.
///
/// # References
/// Ljung (1999), System Identification, §7.4: the prediction-error method for output-error models. McCullagh, Nelder (1989), Generalized Linear Models, §9.2: overdispersion.
pub(crate) fn output_error(
    (tree, base): (&Tree, &Base),
    values: &[f64],
    (motions, steps): (&[Motion], usize),
    go_on: &dyn Fn() -> bool,
) -> Option<Regression> {
    let (n, b) = (tree.len(), base.len());
    let mut values = values.to_vec();
    let mut pieces = pieces(motions, steps);
    let simulate = |values: &[f64], pieces: &[Piece]| -> Option<Vec<DMatrix<f64>>> {
        let parameters = base.as_parameters(values);
        let one = |piece: &Piece| {
            let x = simulated_from(tree, &parameters, &piece.motion, &piece.start).filter(|_| go_on())?;
            Some(DMatrix::from_fn(x.nrows(), 2 * n, |t, i| measured(&piece.motion, t, i) - x[(t, i)]))
        };
        pieces.iter().map(one).collect()
    };
    // What cannot be simulated tells nothing.
    pieces.retain(|piece| simulate(&values, std::slice::from_ref(piece)).is_some());
    if pieces.is_empty() {
        return None;
    }
    let mut errors = simulate(&values, &pieces)?;
    let mut sizes = spreads(&errors);
    let cost = |errors: &[DMatrix<f64>], sizes: &[f64]| -> f64 {
        errors.iter().map(|e| (0..2 * n).map(|i| e.column(i).norm_squared() / sizes[i].powi(2)).sum::<f64>()).sum()
    };
    let mut damping = 1e-4;
    let (mut information, mut spread) = (DMatrix::zeros(b, b), DMatrix::zeros(b, b));
    for _ in 0..ROUNDS {
        let parameters = base.as_parameters(&values);
        (information, spread) = (DMatrix::zeros(b, b), DMatrix::zeros(b, b));
        let mut right = DVector::zeros(b);
        let mut own = Vec::with_capacity(pieces.len());
        for piece in &pieces {
            let slopes = slopes((tree, base), &parameters, piece, &sizes).filter(|_| go_on())?;
            let of_start = (slopes.by_start.transpose() * &slopes.by_start).cholesky()?;
            let cross = slopes.by_start.transpose() * &slopes.by_parameters;
            let pull = slopes.by_start.transpose() * &slopes.errors;
            information +=
                slopes.by_parameters.transpose() * &slopes.by_parameters - cross.transpose() * of_start.solve(&cross);
            let told = slopes.by_parameters.transpose() * &slopes.errors - cross.transpose() * of_start.solve(&pull);
            spread += &told * told.transpose();
            right += told;
            own.push((of_start.solve(&pull), of_start.solve(&cross)));
        }
        let before = cost(&errors, &sizes);
        let mut next = None;
        while next.is_none() && damping < 1e8 {
            let mut damped = information.clone();
            (0..b).for_each(|i| damped[(i, i)] *= 1.0 + damping);
            if let Some(step) = scaled_solution(&damped, &right) {
                let moved: Vec<f64> = values.iter().zip(step.iter()).map(|(value, step)| value + step).collect();
                let begun = |(piece, (free, by)): (&Piece, &(DVector<f64>, DMatrix<f64>))| {
                    let change = free - by * &step;
                    let start = piece.start.iter().zip(change.iter()).map(|(x, change)| x + change).collect();
                    Piece { motion: piece.motion.clone(), start }
                };
                let there: Vec<Piece> = pieces.iter().zip(&own).map(begun).collect();
                next = simulate(&moved, &there).filter(|e| cost(e, &sizes) < before).map(|e| (moved, there, e));
            }
            if !go_on() {
                return None;
            }
            damping *= if next.is_some() { 0.1 } else { 10.0 };
        }
        let Some((moved, there, e)) = next else { break };
        let gain = 1.0 - cost(&e, &sizes) / before;
        (values, pieces, errors) = (moved, there, e);
        sizes = spreads(&errors);
        damping = damping.max(1e-12);
        if gain < GAIN {
            break;
        }
    }
    let inverse = inverse(&information)?;
    // Where the equations are not quite those of the robot, or friction has corners that slopes do not see, pieces disagree by more than noise.
    let dispersion = ((&inverse * &spread).trace() / b.max(1) as f64).max(1.0);
    Some(Regression {
        values,
        errors: (0..b).map(|i| (dispersion * inverse[(i, i)]).max(0.0).sqrt()).collect(),
        condition: f64::NAN,
        undetermined: 0,
        information,
    })
}

fn pieces(motions: &[Motion], steps: usize) -> Vec<Piece> {
    let all: Vec<(&Motion, usize)> = motions
        .iter()
        .flat_map(|m| (0..m.steps()).step_by(steps).filter(|from| from + steps <= m.steps()).map(move |from| (m, from)))
        .collect();
    let hop = all.len().div_ceil(PIECES).max(1);
    let piece = |(motion, from): &(&Motion, usize)| {
        Some(Piece { start: smoothed(motion, *from)?, motion: motion.part(*from, from + steps) })
    };
    all.iter().step_by(hop).filter_map(piece).collect()
}

/// Position or rate number `i` of 2 n in sample `t`.
fn measured(motion: &Motion, t: usize, i: usize) -> f64 {
    let n = motion.positions.ncols();
    if i < n { motion.positions[(t, i)] } else { motion.rates[(t, i - n)] }
}

/// RMS of the errors of each channel.
fn spreads(errors: &[DMatrix<f64>]) -> Vec<f64> {
    let width = errors.first().map_or(0, DMatrix::ncols);
    let count = errors.iter().map(DMatrix::nrows).sum::<usize>().max(1) as f64;
    let rms = |i: usize| (errors.iter().map(|e| e.column(i).norm_squared()).sum::<f64>() / count).sqrt();
    (0..width).map(|i| rms(i).max(f64::MIN_POSITIVE.sqrt())).collect()
}

/// A⁻¹ of a symmetric A whose rows are of very different size.
fn inverse(a: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let scale = a.diagonal().map(|d| 1.0 / d.max(f64::MIN_POSITIVE).sqrt());
    let scaled = DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * scale[i] * scale[j]);
    let inverse = scaled.try_inverse()?;
    Some(DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| inverse[(i, j)] * scale[i] * scale[j]))
}

fn scaled_solution(a: &DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let scale = a.diagonal().map(|d| 1.0 / d.max(f64::MIN_POSITIVE).sqrt());
    let scaled = DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * scale[i] * scale[j]);
    let found = scaled.cholesky()?.solve(&right.component_mul(&scale)).component_mul(&scale);
    found.iter().all(|v| v.is_finite()).then_some(found)
}

/// Errors of a piece and their slopes, each channel over its size: x(t) and ∂x/∂(β, x₀) in Runge–Kutta steps of a sample.
fn slopes((tree, base): (&Tree, &Base), parameters: &[f64], piece: &Piece, sizes: &[f64]) -> Option<Slopes> {
    let (n, b) = (tree.len(), base.len());
    let Piece { motion, start } = piece;
    let (width, rows) = (b + 2 * n, motion.steps() + 1);
    let mut x = DVector::from_column_slice(start);
    let mut s = DMatrix::zeros(2 * n, width);
    (0..2 * n).for_each(|i| s[(i, b + i)] = 1.0);
    let mut all = Slopes {
        errors: DVector::zeros(2 * n * rows),
        by_parameters: DMatrix::zeros(2 * n * rows, b),
        by_start: DMatrix::zeros(2 * n * rows, 2 * n),
    };
    for t in 0..rows {
        for i in 0..2 * n {
            let row = 2 * n * t + i;
            all.errors[row] = (measured(motion, t, i) - x[i]) / sizes[i];
            all.by_parameters.row_mut(row).copy_from(&(s.view((i, 0), (1, b)) / sizes[i]));
            all.by_start.row_mut(row).copy_from(&(s.view((i, b), (1, 2 * n)) / sizes[i]));
        }
        if t == motion.steps() {
            break;
        }
        let h = motion.times[t + 1] - motion.times[t];
        let u: Vec<f64> = motion.forces.row(t).iter().copied().collect();
        let rates = |x: &DVector<f64>, s: &DMatrix<f64>| rates((tree, base), parameters, (x, s), &u);
        let (k1, s1) = rates(&x, &s)?;
        let (k2, s2) = rates(&(&x + 0.5 * h * &k1), &(&s + 0.5 * h * &s1))?;
        let (k3, s3) = rates(&(&x + 0.5 * h * &k2), &(&s + 0.5 * h * &s2))?;
        let (k4, s4) = rates(&(&x + h * &k3), &(&s + h * &s3))?;
        x += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
        s += h / 6.0 * (s1 + 2.0 * s2 + 2.0 * s3 + s4);
    }
    all.errors.iter().chain(&all.by_parameters).all(|v| v.is_finite()).then_some(all)
}

/// ẋ and its slopes ∂ẋ/∂(β, x₀) where the state `x` has the slopes `s`: with the forces f(x, v̇) of the joints, ∂v̇/∂β = −M⁻¹ Y and ∂v̇/∂x = −M⁻¹ ∂f/∂x, the latter by differences, in which dry
/// friction stays as it is.
fn rates(
    (tree, base): (&Tree, &Base),
    parameters: &[f64],
    (x, s): (&DVector<f64>, &DMatrix<f64>),
    u: &[f64],
) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let (n, b) = (tree.len(), base.len());
    let (q, v) = x.as_slice().split_at(n);
    let mut smooth = parameters.to_vec();
    smooth[12 * n..].fill(0.0);
    let friction = |i: usize| if v[i] == 0.0 { 0.0 } else { parameters[12 * n + i] * v[i].signum() };
    let at_rest = forces(tree, &smooth, (q, v, &vec![0.0; n]), true);
    let right = DVector::from_iterator(n, (0..n).map(|i| u[i] - friction(i) - at_rest[i]));
    let inverse = masses(tree, parameters, q).try_inverse()?;
    let a = &inverse * right;
    let here = forces(tree, &smooth, (q, v, a.as_slice()), true);
    let mut by_state = DMatrix::zeros(n, 2 * n);
    for i in 0..2 * n {
        let mut moved = x.clone();
        let step = NUDGE * (1.0 + x[i].abs());
        moved[i] += step;
        let (q, v) = moved.as_slice().split_at(n);
        let there = forces(tree, &smooth, (q, v, a.as_slice()), true);
        (0..n).for_each(|j| by_state[(j, i)] = (here[j] - there[j]) / step);
    }
    let mut slopes = DMatrix::zeros(2 * n, b + 2 * n);
    slopes.rows_mut(0, n).copy_from(&s.rows(n, n));
    let mut pushed = by_state * s;
    let mut direct = pushed.columns_mut(0, b);
    direct -= base.columns(&inverse_dynamics(tree, q, v, a.as_slice()));
    slopes.rows_mut(n, n).copy_from(&(inverse * pushed));
    Some((DVector::from_iterator(2 * n, v.iter().copied().chain(a.iter().copied())), slopes))
}
