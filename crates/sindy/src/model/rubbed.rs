//! Steps with dry friction: speeds come to rest and stay there until they are pushed harder.

use sindyna_core::Diverged;

use super::Model;
use super::friction::{Friction, Given, Joint};

/// Rounds of projected Gauss–Seidel, at most.
const SWEEPS: usize = 50;

/// Change of an impulse, as part of the largest possible, below which all are settled.
const SETTLED: f64 = 1e-13;

/// Room for one step.
pub(super) struct Scratch {
    registers: Vec<f64>,
    /// The state at the beginning (n), and at a stage (n).
    before: Vec<f64>,
    at: Vec<f64>,
    /// Rates at the four stages (4 n).
    k: Vec<f64>,
    signs: Vec<f64>,
}

impl Model {
    /// Its joints with dry friction, and its terms and equations with the signs beside it as variables after the controls, one for each joint; `None` if a
    /// step knows no dry friction.
    pub(crate) fn with_signs(&self) -> Option<Given> {
        let signs = self.parts.states.len() + self.parts.controls.len();
        let (joints, terms, equations) = self.friction.as_ref()?.with_signs(&self.parts.equations, &self.terms, signs);
        Some((joints, terms.iter().map(|term| term.shifted(&self.parts.offsets)).collect(), equations))
    }

    /// Room for steps with dry friction.
    pub(super) fn scratch(&self, friction: &Friction) -> Scratch {
        let (n, zeros) = (self.parts.states.len(), |count: usize| vec![0.0; count]);
        Scratch {
            registers: zeros(self.tape.n_registers()),
            before: zeros(n),
            at: zeros(n),
            k: zeros(4 * n),
            signs: zeros(friction.joints.len()),
        }
    }

    /// The state a time h after `z`, in its place, with dry friction.
    pub(super) fn rubbed(
        &self,
        friction: &Friction,
        h: f64,
        z: &mut [f64],
        u: &[f64],
        Scratch { registers, before, at, k, signs }: &mut Scratch,
    ) -> Result<(), Diverged> {
        let n = z.len();
        before.copy_from_slice(z);
        signs.iter_mut().zip(&friction.joints).for_each(|(s, j)| *s = sign(z[j.speed]));
        for stage in 0..4 {
            let (done, now) = k.split_at_mut(stage * n);
            at.copy_from_slice(before);
            if stage > 0 {
                let part = if stage == 3 { h } else { 0.5 * h };
                at.iter_mut().zip(&done[(stage - 1) * n..]).for_each(|(at, k)| *at += part * k);
            }
            self.fill(registers, at, u);
            self.smooth.sums(registers, &mut now[..n]);
            friction.add(registers, signs, &mut now[..n]);
            self.smooth.couple(registers, &mut now[..n]);
        }
        for i in 0..n {
            z[i] += h / 6.0 * (k[i] + 2.0 * k[n + i] + 2.0 * k[2 * n + i] + k[3 * n + i]);
        }
        Diverged::check(z)?;
        let turns = |(joint, sign): (&Joint, &f64)| *sign == 0.0 || z[joint.speed] * sign < 0.0;
        if friction.joints.iter().zip(&*signs).any(turns) {
            self.fill(registers, before, u);
            self.hold(friction, h, z, registers, (before, signs));
        }
        Diverged::check(z)
    }

    /// Exchanges impulses between friction and the speeds of `z`, a time h after the state `before` with these `signs`, where the registers are.
    fn hold(&self, friction: &Friction, h: f64, z: &mut [f64], registers: &[f64], (before, signs): (&[f64], &[f64])) {
        let q = friction.joints.len();
        let mut limits = vec![0.0; q];
        for (c, register, joint) in &friction.summands {
            limits[*joint] -= h * c * registers[*register as usize];
        }
        let states: Vec<usize> = friction.joints.iter().map(|j| j.speed).collect();
        // What the friction of joint j takes from speed i.
        let mut taken = self.smooth.response(registers, &states);
        (0..q * q).for_each(|at| taken[at] *= limits[at % q]);
        let mut speeds: Vec<f64> = states.iter().map(|i| z[*i]).collect();
        let free = speeds.clone();
        // Parts of friction that act, −1 to 1.
        let mut parts = signs.to_vec();
        for _ in 0..SWEEPS {
            let mut moved = false;
            for j in 0..q {
                let own = taken[j * q + j];
                // What drives instead of holding holds nothing.
                if own <= 0.0 {
                    continue;
                }
                let wanted = (parts[j] + speeds[j] / own).clamp(-1.0, 1.0);
                let change = wanted - parts[j];
                parts[j] = wanted;
                (0..q).for_each(|i| speeds[i] -= taken[i * q + j] * change);
                moved |= change.abs() > SETTLED;
            }
            if !moved {
                break;
            }
        }
        for (j, joint) in friction.joints.iter().enumerate() {
            // What was stopped is at rest to the last digit.
            if taken[j * q + j] > 0.0 && parts[j].abs() < 1.0 {
                speeds[j] = 0.0;
            }
            z[joint.speed] = speeds[j];
            for &p in &joint.positions {
                let stays = signs[j] == 0.0 && speeds[j] == 0.0;
                z[p] = if stays { before[p] } else { z[p] + 0.5 * h * (speeds[j] - free[j]) };
            }
        }
    }
}

/// The sign of v; 0 at rest.
fn sign(v: f64) -> f64 {
    if v == 0.0 { 0.0 } else { v.signum() }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use sindyna_core::Scheme;

    use super::super::{Entry, Form, Model, ModelParts};

    /// v̇ = −9 x − 1.5 sign v + u, ẋ = v.
    fn spring(dt: f64) -> Model {
        Model::new(ModelParts {
            form: Form::Continuous(Scheme::Rk4 { substeps: 1 }),
            dt,
            terms: ["x", "v", "sign(v)", "u"].map(String::from).to_vec(),
            equations: vec![
                vec![Entry::new(1, 1.0)],
                vec![Entry::new(0, -9.0), Entry::new(2, -1.5), Entry::new(3, 1.0)],
            ],
            n_features: 4,
            states: ["x", "v"].map(String::from).to_vec(),
            controls: vec!["u".into()],
            readings: None,
            offsets: vec![0.0; 2],
            kinematic: vec![true, false],
        })
        .expect("a model")
    }

    fn end(model: &Model, x0: [f64; 2], u: f64, steps: usize) -> Vec<f64> {
        model.simulate(&x0, Array2::from_elem((steps, 1), u).view()).expect("finite").row(steps).to_vec()
    }

    #[test]
    fn what_friction_holds_does_not_creep() {
        // |u − 9 x| = 1.1 < 1.5.
        assert_eq!(end(&spring(0.05), [0.1, 0.0], 2.0, 2000), [0.1, 0.0]);
        // And moves when it is pushed harder: about (u − 1.5)/9 from the side it comes from.
        assert!(end(&spring(0.05), [0.1, 0.0], 4.0, 3)[1] > 0.1);
    }

    #[test]
    fn an_oscillation_loses_four_thirds_of_a_newton_in_every_cycle_and_stops() {
        // Half a cycle from rest at x₀ ends at rest at −(x₀ − 2 F/k): 1.0, −2/3, 1/3, 0; 1/3 is beyond F/k = 1/6.
        let half = std::f64::consts::PI / 3.0;
        for (steps, tolerance) in [(200, 2e-3), (2000, 2e-4)] {
            let model = spring(half / steps as f64);
            for (halves, expected) in [(1, -2.0 / 3.0), (2, 1.0 / 3.0), (3, 0.0), (9, 0.0)] {
                let at = end(&model, [1.0, 0.0], 0.0, halves * steps);
                assert!((at[0] - expected).abs() < tolerance, "{steps} {halves}: {at:?}");
            }
            assert_eq!(end(&model, [1.0, 0.0], 0.0, 5 * steps)[1], 0.0, "it rests");
        }
    }

    #[test]
    fn two_coupled_joints_are_held_together() {
        // v̇ = 0.4 − sign v − 0.5 ẇ, ẇ = 0.4 − sign w − 0.5 v̇: neither moves; pushed by 2, both do.
        let model = |push: f64| {
            let coupled = |rate: usize| Entry { term: 2, coefficient: -0.5, rate: Some(rate) };
            Model::new(ModelParts {
                form: Form::Continuous(Scheme::Rk4 { substeps: 1 }),
                dt: 0.01,
                terms: ["sign(v)", "sign(w)", "1"].map(String::from).to_vec(),
                equations: vec![
                    vec![Entry::new(2, push), Entry::new(0, -1.0), coupled(1)],
                    vec![Entry::new(2, push), Entry::new(1, -1.0), coupled(0)],
                ],
                n_features: 3,
                states: ["v", "w"].map(String::from).to_vec(),
                controls: vec![],
                readings: None,
                offsets: vec![0.0; 2],
                kinematic: vec![false; 2],
            })
            .expect("a model")
        };
        let end = |push: f64, x0: [f64; 2]| {
            model(push).simulate(&x0, Array2::zeros((300, 0)).view()).expect("finite").row(300).to_vec()
        };
        assert_eq!(end(0.4, [0.0, 0.0]), [0.0, 0.0]);
        assert_eq!(end(0.4, [0.3, -0.2]), [0.0, 0.0]);
        // (2 − 1)/1.5 for 3 s.
        for v in end(2.0, [0.0, 0.0]) {
            assert!((v - 2.0).abs() < 1e-2, "{v}");
        }
    }
}
