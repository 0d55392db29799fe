//! Mass and inertia of a capsule.

use std::f64::consts::PI;

/// A cylinder with a hemisphere on either end, of density 1000 kg/m³.
pub(super) struct Capsule {
    /// Radius r of cylinder and hemispheres \[m\].
    pub(super) radius: f64,
    /// Length h of the cylinder, without the hemispheres \[m\].
    pub(super) length: f64,
}

impl Capsule {
    const DENSITY: f64 = 1000.0;

    /// Mass of the cylinder: ρ π r² h \[kg\].
    fn cylinder_mass(&self) -> f64 {
        Self::DENSITY * PI * self.radius.powi(2) * self.length
    }

    /// Mass of both hemispheres: ρ (4/3) π r³ \[kg\].
    fn sphere_mass(&self) -> f64 {
        Self::DENSITY * 4.0 / 3.0 * PI * self.radius.powi(3)
    }

    /// \[kg\]
    pub(super) fn mass(&self) -> f64 {
        self.cylinder_mass() + self.sphere_mass()
    }

    /// Inertia about an axis through the centre, across the capsule \[kg·m²\].
    ///
    /// Cylinder: m (3 r² + h²) / 12. Hemispheres: 2 m r² / 5 about the middle of their flat sides, taken to the capsule's centre by
    /// the parallel axes (their own centres lie 3 r / 8 further out): + m (h²/4 + 3 r h / 8).
    pub(super) fn inertia_across(&self) -> f64 {
        let (r, h) = (self.radius, self.length);
        let cylinder = self.cylinder_mass() * (3.0 * r * r + h * h) / 12.0;
        let hemispheres = self.sphere_mass() * (0.4 * r * r + h * h / 4.0 + 3.0 * r * h / 8.0);
        cylinder + hemispheres
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn capsules_weigh_what_mujoco_compiles() {
        // mujoco 4.0.0, Gymnasium's inverted_pendulum.xml: body_mass and the two equal values of body_inertia.
        let cart = Capsule { radius: 0.1, length: 0.2 };
        let pole = Capsule { radius: 0.049, length: 0.6_f64.hypot(0.001) };
        for (capsule, mass, inertia) in
            [(cart, 10.47197551196598, 0.12671090369478838), (pole, 5.018591641363306, 0.1887497668730885)]
        {
            assert!((capsule.mass() - mass).abs() < 1e-13);
            assert!((capsule.inertia_across() - inertia).abs() < 1e-14);
        }
    }
}
