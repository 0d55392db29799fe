//! The double pendulum of the boards and its simulator.

use rand_distr::{Distribution as _, Normal};
use sindyna_core::{Diverged, Dynamics, Held, Rng, Scheme, Seed, VectorField};

/// Step of the simulator and of controllers \[s\].
pub(crate) const DT: f64 = 0.002;

/// Steps of a run of 10 s.
pub(crate) const STEPS: usize = 5_000;

/// Largest torque of the driven joint \[N m\].
pub(crate) const LIMIT: f64 = 6.0;

/// Which joint is driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Robot {
    /// The elbow.
    Acrobot,
    /// The shoulder.
    Pendubot,
}

impl Robot {
    pub(crate) const ALL: [Self; 2] = [Self::Acrobot, Self::Pendubot];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Acrobot => "acrobot",
            Self::Pendubot => "pendubot",
        }
    }

    /// Number of the driven joint.
    pub(crate) fn joint(self) -> usize {
        match self {
            Self::Acrobot => 1,
            Self::Pendubot => 0,
        }
    }
}

/// Two links in a plane; q₁ = 0 hangs down, q₂ is the angle between the links:
///
/// M(q) q̈ + C(q, q̇) q̇ − G(q) = τ, without friction.
///
/// # References
/// Wiebe et al. (2024), IEEE RAM 31(4), "Open Source Dual-Purpose Acrobot and Pendubot Platform", doi:10.1109/MRA.2023.3341257. Parameters of design C.1, model 1.1 (BSD-3).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plant {
    /// Masses \[kg\], centres of mass from the joint \[m\], moments of inertia about the joint \[kg m²\].
    pub(crate) m: [f64; 2],
    pub(crate) r: [f64; 2],
    pub(crate) i: [f64; 2],
}

/// Lengths of the links \[m\].
pub(crate) const LENGTHS: [f64; 2] = [0.2, 0.3];

const GRAVITY: f64 = 9.81;

impl Plant {
    pub(crate) const NOMINAL: Self = Self {
        m: [0.523_460_230_231_027_1, 0.625_567_723_417_443_7],
        r: [0.2, 0.255_693_054_360_529_64],
        i: [0.031_887_199_591_513_114, 0.050_869_848_128_072_57],
    };
}

impl VectorField for Plant {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        let Self { m, r, i } = self;
        let (s1, (s2, c2), s12) = (x[0].sin(), x[1].sin_cos(), (x[0] + x[1]).sin());
        let (v1, v2, h) = (x[2], x[3], m[1] * LENGTHS[0] * r[1]);
        let m11 = i[0] + i[1] + m[1] * LENGTHS[0] * LENGTHS[0] + 2.0 * h * c2;
        let m12 = i[1] + h * c2;
        let m22 = i[1];
        let distal = m[1] * GRAVITY * r[1] * s12;
        let weight = m[0] * GRAVITY * r[0] * s1 + m[1] * GRAVITY * LENGTHS[0] * s1 + distal;
        let first = u[0] + h * s2 * (2.0 * v1 + v2) * v2 - weight;
        let second = u[1] - h * s2 * v1 * v1 - distal;
        let determinant = m11 * m22 - m12 * m12;
        x_dot[..2].copy_from_slice(&x[2..4]);
        x_dot[2] = (m22 * first - m12 * second) / determinant;
        x_dot[3] = (m11 * second - m12 * first) / determinant;
    }
}

/// Equations of motion as the boards' simulator steps them.
pub(crate) fn stepped<F: VectorField>(equations: F) -> Held<F> {
    Held::new(equations, Scheme::Rk4 { substeps: 1 }, DT)
}

/// A run: states (T + 1), and the torques that were applied (T).
pub(crate) struct Run {
    pub(crate) x: Vec<[f64; 4]>,
    pub(crate) torque: Vec<[f64; 2]>,
}

/// A run of 10 s from rest, hanging, in the boards' simulator or another one, under `control`, which is asked for the torque of the driven joint at each step.
///
/// # Errors
/// [`Diverged`] if a state is not finite.
pub(crate) fn run(
    simulator: &impl Dynamics,
    robot: Robot,
    mut control: impl FnMut(&[f64; 4]) -> f64,
) -> Result<Run, Diverged> {
    let mut unused = Seed::new(0).stream("simulator", 0);
    let mut run = Run { x: vec![[0.0; 4]], torque: Vec::with_capacity(STEPS) };
    for t in 0..STEPS {
        let (mut torque, mut next) = ([0.0; 2], [0.0; 4]);
        torque[robot.joint()] = control(&run.x[t]).clamp(-LIMIT, LIMIT);
        simulator.step(&run.x[t], &torque, &mut unused, &mut next)?;
        run.x.push(next);
        run.torque.push(torque);
    }
    Ok(run)
}

/// A normal deviate of standard deviation `sigma`.
pub(crate) fn deviate(sigma: f64, rng: &mut Rng) -> f64 {
    Normal::new(0.0, sigma).map_or(0.0, |normal| normal.sample(rng))
}
