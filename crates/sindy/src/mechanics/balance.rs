//! Momenta balanced over steps: rows that are linear in the parameters of a Lagrangian.

use ndarray::{Array2, ArrayView2};

use crate::design::LOBATTO;
use crate::expr::Tape;
use crate::library::Lagrangian;

/// Consecutive samples: states (T + 1, n), controls (T, k), lengths of the steps (T).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Steps<'a> {
    pub(crate) x: ArrayView2<'a, f64>,
    pub(crate) u: ArrayView2<'a, f64>,
    pub(crate) dt: &'a [f64],
}

/// Per joint, a row for each step: what every parameter would change of the momentum minus what it does (T, P).
///
/// Momenta are those of the samples, forces are averaged along the cubics through positions and speeds at both ends of a step. Of steps with the
/// accelerations at their beginning (`at_once`) rows are the equations there, with Δq̇/Δt for q̈.
pub(crate) fn balance(lagrangian: &Lagrangian, steps: Steps<'_>, at_once: bool) -> Vec<Array2<f64>> {
    if at_once { at_beginnings(lagrangian, steps) } else { over_steps(lagrangian, steps) }
}

fn over_steps(lagrangian: &Lagrangian, Steps { x, u, dt }: Steps<'_>) -> Vec<Array2<f64>> {
    let n_parameters = lagrangian.parameters.len();
    let (mut momenta, mut forces) = (Vec::new(), Vec::new());
    for p in 0..n_parameters {
        momenta.extend(lagrangian.momenta(p).into_iter().map(|(row, expr, factor)| (p, row, expr, factor)));
        forces.extend(lagrangian.forces(p).into_iter().map(|(row, expr, factor)| (p, row, expr, factor)));
    }
    let (n, k) = (x.ncols(), u.ncols());
    let of_momenta = Tape::new(n + k, momenta.iter().map(|(_, _, expr, _)| expr));
    let of_forces = Tape::new(n + k, forces.iter().map(|(_, _, expr, _)| expr));
    let mut registers = vec![0.0; of_momenta.n_registers().max(of_forces.n_registers())];
    let mut at_samples = Array2::zeros((x.nrows(), momenta.len()));
    for (t, x) in x.rows().into_iter().enumerate() {
        registers[..n].iter_mut().zip(x).for_each(|(r, x)| *r = *x);
        of_momenta.run(&mut registers);
        of_momenta.outputs().iter().enumerate().for_each(|(m, &r)| at_samples[[t, m]] = registers[r as usize]);
    }
    let mut rows = vec![Array2::<f64>::zeros((u.nrows(), n_parameters)); lagrangian.joints.len()];
    for t in 0..u.nrows() {
        for (m, (p, row, _, factor)) in momenta.iter().enumerate() {
            rows[*row][[t, *p]] += factor * (at_samples[[t + 1, m]] - at_samples[[t, m]]);
        }
        registers[..n].iter_mut().zip(x.row(t)).for_each(|(r, x)| *r = *x);
        registers[n..n + k].iter_mut().zip(u.row(t)).for_each(|(r, u)| *r = *u);
        for (at, weight) in LOBATTO {
            for &(q, v) in &lagrangian.joints {
                let ends = [x[[t, q]], x[[t, v]], x[[t + 1, q]], x[[t + 1, v]]];
                (registers[q], registers[v]) = between(ends, dt[t], at);
            }
            of_forces.run(&mut registers);
            for ((p, row, _, factor), &r) in forces.iter().zip(of_forces.outputs()) {
                rows[*row][[t, *p]] -= dt[t] * weight * factor * registers[r as usize];
            }
        }
    }
    rows
}

fn at_beginnings(lagrangian: &Lagrangian, Steps { x, u, dt }: Steps<'_>) -> Vec<Array2<f64>> {
    let n_parameters = lagrangian.parameters.len();
    let all: Vec<_> = (0..n_parameters).flat_map(|p| lagrangian.summands(p).into_iter().map(move |s| (p, s))).collect();
    let (n, k) = (x.ncols(), u.ncols());
    let tape = Tape::new(n + k, all.iter().map(|(_, (_, (expr, _), _))| expr));
    let mut registers = vec![0.0; tape.n_registers()];
    let mut rows = vec![Array2::<f64>::zeros((u.nrows(), n_parameters)); lagrangian.joints.len()];
    for t in 0..u.nrows() {
        registers[..n].iter_mut().zip(x.row(t)).for_each(|(r, x)| *r = *x);
        registers[n..n + k].iter_mut().zip(u.row(t)).for_each(|(r, u)| *r = *u);
        tape.run(&mut registers);
        for ((p, (row, (_, rate), factor)), &r) in all.iter().zip(tape.outputs()) {
            let change = rate.map_or(dt[t], |v| x[[t + 1, v]] - x[[t, v]]);
            rows[*row][[t, *p]] += factor * change * registers[r as usize];
        }
    }
    rows
}

/// Position and speed at the part `at` of a step of `dt` seconds on the cubic through both at its ends.
fn between([q, v, q_next, v_next]: [f64; 4], dt: f64, at: f64) -> (f64, f64) {
    let (c, d) = (3.0 * (q_next - q) - dt * (2.0 * v + v_next), 2.0 * (q - q_next) + dt * (v + v_next));
    (q + at * (dt * v + at * (c + at * d)), v + at * (2.0 * c + 3.0 * at * d) / dt)
}
