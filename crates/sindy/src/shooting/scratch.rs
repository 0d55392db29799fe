//! Memory in which steps are made.

use nalgebra::DMatrix;
use sindyna_core::InterSample;

use super::lanes::add;

/// Memory in which steps from `L` samples are made side by side.
#[derive(Debug, Clone)]
pub(crate) struct Scratch<const L: usize = 1> {
    /// Inputs at the beginning of the step, by how much they change over it (nothing if they are held), how long it takes \[s\], and the part of it
    /// that is over.
    pub(super) u: Vec<[f64; L]>,
    pub(super) ramp: Vec<[f64; L]>,
    pub(super) dt: [f64; L],
    pub(super) over: f64,
    pub(super) intersample: InterSample,
    /// By how much of their change inputs have changed, where they do so at once.
    pub(super) changed: Option<f64>,
    /// (x; u), signs, parameters inside terms, and what is made of them.
    pub(super) registers: Vec<[f64; L]>,
    pub(super) f: Vec<[f64; L]>,
    pub(super) masses: Masses<L>,
    pub(super) f_x: Vec<[f64; L]>,
    pub(super) f_xi: Vec<[f64; L]>,
    /// What stands for the sign of each switch.
    pub(super) modes: Vec<[f64; L]>,
    /// Whether a sign turned, or one was not told, in a step that was made side by side with others.
    pub(super) turns: [bool; L],
    /// The switch whose argument stays zero, if there is one.
    pub(super) sliding: Option<usize>,
    pub(super) slopes: Vec<[f64; L]>,
    pub(super) s_stage: Vec<[f64; L]>,
    pub(super) s_slopes: Vec<[f64; L]>,
}

impl<const L: usize> Scratch<L> {
    /// Writes the inputs, unless they are held, at the part `stage` of the next time h into their registers, which are those after the first n.
    pub(super) fn put_inputs(&mut self, n: usize, stage: f64, h: [f64; L]) {
        for (at, (u, ramp)) in self.u.iter().zip(&self.ramp).enumerate() {
            let part = |l: usize| {
                let over = || self.over + stage * h[l] / self.dt[l];
                self.changed.unwrap_or_else(|| self.intersample.share(over(), self.dt[l]))
            };
            self.registers[n + at] = std::array::from_fn(|l| u[l] + part(l) * ramp[l]);
        }
    }
}

/// The inverse of what the rates of some states are multiplied by.
#[derive(Debug, Clone)]
pub(super) struct Masses<const L: usize> {
    matrix: DMatrix<f64>,
    inverse: Vec<[f64; L]>,
    column: Vec<[f64; L]>,
}

impl<const L: usize> Masses<L> {
    pub(super) fn new(n: usize) -> Self {
        Self { matrix: DMatrix::zeros(n, n), inverse: vec![[0.0; L]; n * n], column: vec![[0.0; L]; n] }
    }

    /// Inverts the identity as `change` changes it at each place; NaN where that is singular.
    pub(super) fn invert(&mut self, change: &dyn Fn(usize, &mut DMatrix<f64>)) {
        let n = self.column.len();
        for l in 0..L {
            self.matrix.fill_with_identity();
            change(l, &mut self.matrix);
            if !self.matrix.try_inverse_mut() {
                self.matrix.fill(f64::NAN);
            }
            for (at, slot) in self.inverse.iter_mut().enumerate() {
                slot[l] = self.matrix[(at / n, at % n)];
            }
        }
    }

    /// Multiplies the rows `among` of `matrix`, `width` long, by the inverse from the left.
    pub(super) fn solve(&mut self, among: &[usize], matrix: &mut [[f64; L]], width: usize) {
        let Self { inverse, column, .. } = self;
        for j in 0..width {
            among.iter().zip(&mut *column).for_each(|(&k, slot)| *slot = matrix[k * width + j]);
            for (&i, row) in among.iter().zip(inverse.chunks_exact(among.len())) {
                let mut sum = [0.0; L];
                for (a, v) in row.iter().zip(&*column) {
                    add(&mut sum, |l| a[l] * v[l]);
                }
                matrix[i * width + j] = sum;
            }
        }
    }
}
