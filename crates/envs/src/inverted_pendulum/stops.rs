//! The ends of a joint's travel: MuJoCo's soft limits.

use super::integrator::TIMESTEP;

/// Largest share d of the reference acceleration that a stop imposes.
const MAX_IMPEDANCE: f64 = 0.95;
/// The share it imposes at first touch.
const MIN_IMPEDANCE: f64 = 0.9;
/// Depth over which the share rises from the smallest to the largest (in the joint's unit).
const WIDTH: f64 = 0.001;
/// Time in which a stop pushes back \[s\]: 0.02 s is asked for, but MuJoCo takes no less than two time steps.
const TIME_CONSTANT: f64 = 2.0 * TIMESTEP;
/// 1: pushed back without overshoot.
const DAMPING_RATIO: f64 = 1.0;

/// A joint that may move within ±`limit`.
pub(super) struct Stops {
    /// Half the joint's travel.
    pub(super) limit: f64,
    /// What a unit force accelerates the joint by, in the rest position: what MuJoCo's regularisation scales with.
    pub(super) mobility: f64,
}

/// A joint beyond the end of its travel.
#[derive(Clone, Copy)]
pub(super) struct Contact {
    /// Way back: +1 at the lower stop, −1 at the upper.
    direction: f64,
    /// Acceleration a* the stop aims at, along `direction`.
    reference: f64,
    /// Softness R: f units of force come with R f units of acceleration missing from a*.
    softness: f64,
}

impl Stops {
    /// The contact at position `q` and velocity `v`, if there is one.
    ///
    /// With r < 0 the distance left and v its rate: a* = −b v − k d r, b = 2/(d₁ τ), k = 1/(d₁ τ ζ)², and
    /// R = (1 − d)/d times the mobility; d(|r|) rises from d₀ to d₁ in two parabolas.
    ///
    /// # References
    /// MuJoCo documentation, chapters "Computation" (constraint model) and "Modeling" (solver parameters).
    pub(super) fn contact(&self, q: f64, v: f64) -> Option<Contact> {
        let distance = self.limit - q.abs();
        if distance >= 0.0 || !distance.is_finite() {
            return None;
        }
        let direction = -q.signum();
        let impedance = impedance(-distance);
        let damping = 2.0 / (MAX_IMPEDANCE * TIME_CONSTANT);
        let stiffness = (MAX_IMPEDANCE * TIME_CONSTANT * DAMPING_RATIO).powi(-2);
        Some(Contact {
            direction,
            reference: -damping * direction * v - stiffness * impedance * distance,
            softness: (1.0 - impedance) / impedance * self.mobility,
        })
    }
}

/// d at `depth` \> 0 beyond the end.
fn impedance(depth: f64) -> f64 {
    let x = (depth / WIDTH).min(1.0);
    let rise = if x <= 0.5 { 2.0 * x * x } else { 1.0 - 2.0 * (1.0 - x) * (1.0 - x) };
    MIN_IMPEDANCE + rise * (MAX_IMPEDANCE - MIN_IMPEDANCE)
}

/// Accelerations of two joints whose stops push back.
///
/// `free` (2) are the accelerations without stops, `mobility` (2, 2) is the inverse mass matrix. Each force f ≥ 0 either closes
/// the gap between the acceleration it causes and a*, up to R f, or is zero because the joint leaves fast enough by
/// itself: (A + R) f ≥ a* − a, complementary to f, with A the mobility along the contacts' directions.
pub(super) fn resisted(free: [f64; 2], mobility: [[f64; 2]; 2], contacts: [Option<Contact>; 2]) -> [f64; 2] {
    let pushed = |forces: [f64; 2]| {
        let row = |i: usize| free[i] + mobility[i][0] * forces[0] + mobility[i][1] * forces[1];
        [row(0), row(1)]
    };
    let gap = |i: usize, c: Contact| c.reference - c.direction * free[i];
    let alone = |i: usize, c: Contact| (gap(i, c) / (mobility[i][i] + c.softness)).max(0.0);
    match contacts {
        [None, None] => free,
        [Some(c), None] => pushed([c.direction * alone(0, c), 0.0]),
        [None, Some(c)] => pushed([0.0, c.direction * alone(1, c)]),
        [Some(c0), Some(c1)] => {
            let coupling = c0.direction * c1.direction * mobility[0][1];
            let (alone0, alone1) = (alone(0, c0), alone(1, c1));
            let forces = if coupling * alone0 >= gap(1, c1) {
                [alone0, 0.0]
            } else if coupling * alone1 >= gap(0, c0) {
                [0.0, alone1]
            } else {
                let (a, b) = (mobility[0][0] + c0.softness, mobility[1][1] + c1.softness);
                let determinant = a * b - coupling * coupling;
                [
                    (b * gap(0, c0) - coupling * gap(1, c1)) / determinant,
                    (a * gap(1, c1) - coupling * gap(0, c0)) / determinant,
                ]
            };
            pushed([c0.direction * forces[0], c1.direction * forces[1]])
        }
    }
}
