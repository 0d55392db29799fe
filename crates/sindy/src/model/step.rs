//! A model as dynamics.

use std::sync::Arc;

use ndarray::{Array2, ArrayView1};
use sindyna_core::{Diverged, Dynamics, Held, InterSample, Jacobians, Rng, Scheme, Seed, VectorField};

use super::frame::back;
use super::right_side::STACK;
use super::{Form, Model};

/// States whose right-hand sides are computed side by side.
const LANES: usize = 8;

/// Registers of a small model.
const FEW: usize = 24;

impl Model {
    /// Writes Θ(z; u) Ξᵀ, the right-hand side of the equations, at a state `z` of the model.
    pub(super) fn right_side(&self, z: &[f64], u: &[f64], out: &mut [f64]) {
        match self.tape.n_registers() {
            // Zeros are not free where a step costs less than a hundred nanoseconds.
            needed if needed <= FEW => self.right_side_in(&mut [0.0; FEW][..needed], z, u, out),
            needed if needed <= STACK => self.right_side_in(&mut [0.0; STACK][..needed], z, u, out),
            needed => self.right_side_in(&mut vec![0.0; needed], z, u, out),
        }
    }

    fn right_side_in(&self, registers: &mut [f64], z: &[f64], u: &[f64], out: &mut [f64]) {
        self.fill(registers, z, u);
        self.right.eval(registers, out);
    }

    /// Writes the terms at a state `z` of the model into their registers.
    #[inline(always)]
    pub(super) fn fill(&self, registers: &mut [f64], z: &[f64], u: &[f64]) {
        self.place(registers, z, u);
        self.tape.run(registers);
    }

    /// Writes a state `z` of the model and its input into the first registers.
    #[inline(always)]
    pub(super) fn place(&self, registers: &mut [f64], z: &[f64], u: &[f64]) {
        for ((register, z), offset) in registers.iter_mut().zip(z).zip(&self.parts.offsets) {
            *register = z + offset;
        }
        registers[z.len()..z.len() + u.len()].copy_from_slice(u);
    }

    /// Writes the right-hand sides (N, n), row by row, at model states (N, n) and controls (N, k); each is what [`VectorField::eval`] gives.
    ///
    /// # Panics
    /// If the numbers of rows differ.
    pub fn eval_rows(&self, states: &[f64], controls: &[f64], out: &mut [f64]) {
        let (n, k) = (self.parts.states.len(), self.parts.controls.len());
        let (mut z, mut u, mut out) = (states, controls, out);
        let mut registers = vec![[0.0; LANES]; self.tape.n_registers()];
        while self.right.is_explicit() && out.len() >= LANES * n && n > 0 {
            let (these, rest) = out.split_at_mut(LANES * n);
            for l in 0..LANES {
                for (i, offset) in self.parts.offsets.iter().enumerate() {
                    registers[i][l] = z[l * n + i] + offset;
                }
                for j in 0..k {
                    registers[n + j][l] = u[l * k + j];
                }
            }
            self.tape.run_first(&mut registers, self.tape.n_ops());
            self.right.eval_explicit(&registers, these);
            (z, u, out) = (&z[LANES * n..], &u[LANES * k..], rest);
        }
        for (i, out) in out.chunks_exact_mut(n.max(1)).enumerate() {
            self.right_side(&z[i * n..(i + 1) * n], &u[i * k..(i + 1) * k], out);
        }
    }

    /// One control interval in the model's own space.
    fn step_own(&self, z: &[f64], u: &[f64], rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
        match self.parts.form {
            Form::Discrete => self.right_side(z, u, next),
            Form::Increment => {
                self.right_side(z, u, next);
                for (next, z) in next.iter_mut().zip(z) {
                    *next = z + self.parts.dt * *next;
                }
            }
            Form::SemiImplicit { substeps: 0 | 1 } => self.semi_implicit(self.parts.dt, z, u, next),
            Form::SemiImplicit { substeps } => {
                let h = self.parts.dt / substeps as f64;
                let mut z = z.to_vec();
                for _ in 0..substeps {
                    self.semi_implicit(h, &z, u, next);
                    z.copy_from_slice(next);
                }
            }
            Form::Continuous(scheme) => return self.held((scheme, self.parts.dt), z, u, rng, next),
        }
        Diverged::check(next)
    }

    /// Writes the state `dt` seconds later, of a model that is continuous in time.
    pub(super) fn held(
        &self,
        (scheme, dt): (Scheme, f64),
        z: &[f64],
        u: &[f64],
        rng: &mut Rng,
        next: &mut [f64],
    ) -> Result<(), Diverged> {
        let (Some(friction), Scheme::Rk4 { substeps }) = (&self.friction, scheme) else {
            return Held::new(Own(self), scheme, dt).step(z, u, rng, next);
        };
        let mut scratch = self.scratch(friction);
        next.copy_from_slice(z);
        (0..substeps).try_for_each(|_| self.rubbed(friction, dt / substeps as f64, next, u, &mut scratch))
    }

    /// The same under inputs that change by `ramp` (k) over the interval. Friction takes them as they are in the middle of each substep.
    pub(super) fn ramped(
        &self,
        (scheme, dt): (Scheme, f64),
        z: &[f64],
        (u, ramp, intersample): (&[f64], &[f64], InterSample),
        rng: &mut Rng,
        next: &mut [f64],
    ) -> Result<(), Diverged> {
        if let (Some(friction), Scheme::Rk4 { substeps }) = (&self.friction, scheme) {
            let mut scratch = self.scratch(friction);
            next.copy_from_slice(z);
            return (0..substeps).try_for_each(|at| {
                let part = intersample.share((at as f64 + 0.5) / substeps as f64, dt);
                let u: Vec<f64> = u.iter().zip(ramp).map(|(u, ramp)| u + part * ramp).collect();
                self.rubbed(friction, dt / substeps as f64, next, &u, &mut scratch)
            });
        }
        let changes = Ramped { model: self, u, ramp, intersample, dt };
        let mut both = vec![0.0; z.len() + 1];
        Held::new(changes, scheme, dt).step(&[z, &[0.0]].concat(), &[], rng, &mut both)?;
        next.copy_from_slice(&both[..z.len()]);
        Ok(())
    }

    /// Writes the state a time h later: rates move first, then the states they belong to by the new ones.
    fn semi_implicit(&self, h: f64, z: &[f64], u: &[f64], next: &mut [f64]) {
        self.right_side(z, u, next);
        for (next, z) in next.iter_mut().zip(z) {
            *next = z + h * *next;
        }
        for &i in &self.positions {
            let row = &self.parts.equations[i];
            let moved: f64 = row.iter().map(|e| e.coefficient * self.terms[e.term].eval(next)).sum();
            next[i] = z[i] + h * moved;
        }
    }
}

impl Model {
    /// The states (T + 1, n) from `x0` on under the inputs `u` (T, k), each held for its `dt` \[s\] (T), of a model that is continuous in time and in the states'
    /// own coordinates; `None` where it diverges.
    pub(crate) fn along(&self, x0: &[f64], u: &Array2<f64>, dt: &[f64]) -> Option<Array2<f64>> {
        let Form::Continuous(scheme) = self.parts.form else { return None };
        let mut rng = Seed::new(0).stream("no randomness", 0);
        let mut x = Array2::zeros((u.nrows() + 1, x0.len()));
        let (mut now, mut next) = (x0.to_vec(), x0.to_vec());
        let mut input = vec![0.0; u.ncols()];
        let mut scratch = self.friction.as_ref().map(|friction| self.scratch(friction));
        x.row_mut(0).assign(&ArrayView1::from(x0));
        for (t, dt) in dt.iter().enumerate() {
            input.iter_mut().zip(u.row(t)).for_each(|(slot, u)| *slot = *u);
            match (&self.friction, &mut scratch, scheme) {
                (Some(friction), Some(scratch), Scheme::Rk4 { substeps }) => {
                    next.copy_from_slice(&now);
                    let mut step = |_| self.rubbed(friction, dt / substeps as f64, &mut next, &input, scratch);
                    (0..substeps).try_for_each(&mut step).ok()?;
                }
                _ => self.held((scheme, *dt), &now, &input, &mut rng, &mut next).ok()?,
            }
            x.row_mut(t + 1).assign(&ArrayView1::from(&next));
            std::mem::swap(&mut now, &mut next);
        }
        Some(x)
    }
}

impl Dynamics for Model {
    fn step(&self, x: &[f64], u: &[f64], rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
        let Some(readings) = &self.parts.readings else { return self.step_own(x, u, rng, next) };
        let n = readings.len();
        let mut stack = [0.0; STACK];
        let mut heap = Vec::new();
        let buffer = if 2 * n <= STACK {
            &mut stack[..2 * n]
        } else {
            heap.resize(2 * n, 0.0);
            &mut heap[..]
        };
        let (z, z_next) = buffer.split_at_mut(n);
        for (z, reading) in z.iter_mut().zip(readings) {
            *z = reading.of(x);
        }
        self.step_own(z, u, rng, z_next)?;
        back(readings, z_next, x, next);
        Diverged::check(next)
    }

    fn linearize(&self, x: &[f64], u: &[f64], rng: &mut Rng) -> Result<Jacobians, Diverged> {
        match self.of_step(x, u) {
            Some(exact) => Ok(exact),
            None => Stepped(self).linearize(x, u, rng),
        }
    }

    fn coarse(&self) -> Option<Arc<dyn Dynamics>> {
        let Form::Continuous(Scheme::Rk4 { substeps: substeps @ 2.. }) = self.parts.form else { return None };
        Some(Arc::new(self.with_form(Form::Continuous(Scheme::Rk4 { substeps: substeps.div_ceil(COARSE) }))))
    }
}

/// Substeps for one of the same model stepped coarsely: its error is 256 times as large.
const COARSE: usize = 4;

/// A model whose steps alone are known.
struct Stepped<'a>(&'a Model);

impl Dynamics for Stepped<'_> {
    fn step(&self, x: &[f64], u: &[f64], rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
        self.0.step(x, u, rng, next)
    }
}

/// The vector field in the model's own space.
pub(super) struct Own<'a>(pub(super) &'a Model);

impl VectorField for Own<'_> {
    fn eval(&self, z: &[f64], u: &[f64], z_dot: &mut [f64]) {
        self.0.right_side(z, u, z_dot);
    }
}

/// The same with inputs that change: its states are those of the model, and the time since the step began.
struct Ramped<'a> {
    model: &'a Model,
    u: &'a [f64],
    ramp: &'a [f64],
    intersample: InterSample,
    dt: f64,
}

impl VectorField for Ramped<'_> {
    fn eval(&self, z: &[f64], _: &[f64], z_dot: &mut [f64]) {
        let (Some((time, z)), Some((of_time, of_states))) = (z.split_last(), z_dot.split_last_mut()) else { return };
        let part = self.intersample.share(time / self.dt, self.dt);
        let u: Vec<f64> = self.u.iter().zip(self.ramp).map(|(u, ramp)| u + part * ramp).collect();
        self.model.right_side(z, &u, of_states);
        *of_time = 1.0;
    }
}

/// The right-hand side over the model's own states: ẋ for a continuous or semi-implicit model, (x⁺ − x)/Δt or x⁺
/// for the others.
impl VectorField for Model {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        self.right_side(x, u, x_dot);
    }
}

#[cfg(test)]
mod tests {
    use sindyna_core::{Scheme, VectorField as _};

    use super::super::{Entry, Form, Model, ModelParts};

    fn model(coupled: bool) -> Model {
        let second = Entry { term: 1, coefficient: 0.5, rate: coupled.then_some(0) };
        let parts = ModelParts {
            form: Form::Continuous(Scheme::Rk4 { substeps: 1 }),
            dt: 0.1,
            terms: vec!["x0*u0".into(), "sin(x1)".into(), "x0/x1".into()],
            equations: vec![vec![Entry::new(0, -1.5), Entry::new(2, 0.7)], vec![second], Vec::new()],
            n_features: 3,
            states: ["x0", "x1", "x2"].map(String::from).to_vec(),
            controls: vec!["u0".into()],
            readings: None,
            offsets: vec![0.25, 0.0, 0.0],
            kinematic: vec![false; 3],
        };
        Model::new(parts).expect("a model")
    }

    #[test]
    fn a_step_over_a_longer_interval_is_so_many_steps() {
        let short = model(true);
        let long = short.over_intervals(0.4).expect("it is continuous in time");
        let (x0, u) = ([0.3, -0.2, 0.1], |steps| ndarray::Array2::from_elem((steps, 1), 0.7));
        let ends = |model: &Model, steps| model.simulate(&x0, u(steps).view()).expect("finite").row(steps).to_vec();
        assert_eq!(long.dt(), 0.4);
        for (one, four) in ends(&long, 1).into_iter().zip(ends(&short, 4)) {
            assert!((one - four).abs() < 1e-12, "{one} {four}");
        }
        let discrete = Model::new(ModelParts { form: Form::Discrete, ..short.parts().clone() }).expect("a model");
        assert!(discrete.over_intervals(0.4).is_none() && discrete.over_intervals(0.1).is_some());
    }

    #[test]
    fn right_hand_sides_of_many_states_are_those_of_each_to_the_last_bit() {
        for (model, rows) in
            [(model(false), 0), (model(false), 7), (model(false), 8), (model(false), 45), (model(true), 45)]
        {
            let value = |i: usize| (i as f64 * 0.7).sin();
            let (x, u): (Vec<f64>, Vec<f64>) = ((0..3 * rows).map(value).collect(), (0..rows).map(value).collect());
            let mut found = vec![f64::NAN; 3 * rows];
            model.eval_rows(&x, &u, &mut found);
            for ((x, u), found) in x.chunks(3).zip(u.chunks(1)).zip(found.chunks(3)) {
                let mut alone = [f64::NAN; 3];
                model.eval(x, u, &mut alone);
                assert_eq!(alone.map(f64::to_bits)[..], found.iter().map(|v| v.to_bits()).collect::<Vec<_>>()[..]);
            }
        }
    }
}
