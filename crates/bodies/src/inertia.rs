//! The inertial parameters of a rigid body.

use nalgebra::{Isometry3, Matrix3, Matrix4, Point3, SVector, Vector3};

/// Inertial parameters of a body in a frame that is fixed to it: mass m \[kg\], first moments m c \[kg m\], and the inertia about the origin (xx, xy, xz, yy, yz, zz) \[kg m²\]. All
/// dynamics are linear in them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Inertia(pub SVector<f64, 10>);

impl Inertia {
    /// Names of the parameters.
    pub const NAMES: [&'static str; 10] = ["m", "mx", "my", "mz", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz"];

    /// A body of `mass` with its center at `com`, and the inertia `about_com` about that.
    #[must_use]
    pub fn new(mass: f64, com: Vector3<f64>, about_com: Matrix3<f64>) -> Self {
        let i = about_com + mass * (com.norm_squared() * Matrix3::identity() - com * com.transpose());
        let h = mass * com;
        Self(SVector::from([mass, h.x, h.y, h.z, i.m11, i.m12, i.m13, i.m22, i.m23, i.m33]))
    }

    /// Mass \[kg\].
    #[must_use]
    pub fn mass(&self) -> f64 {
        self.0[0]
    }

    /// m c \[kg m\].
    fn moments(&self) -> Vector3<f64> {
        Vector3::new(self.0[1], self.0[2], self.0[3])
    }

    /// Center of mass \[m\]; the origin for a body without mass.
    #[must_use]
    pub fn com(&self) -> Vector3<f64> {
        if self.mass() == 0.0 { Vector3::zeros() } else { self.moments() / self.mass() }
    }

    fn about_origin(&self) -> Matrix3<f64> {
        let i = &self.0;
        Matrix3::new(i[4], i[5], i[6], i[5], i[7], i[8], i[6], i[8], i[9])
    }

    /// Inertia about the center of mass \[kg m²\].
    #[must_use]
    pub fn about_com(&self) -> Matrix3<f64> {
        let c = self.com();
        self.about_origin() - self.mass() * (c.norm_squared() * Matrix3::identity() - c * c.transpose())
    }

    /// The same body in the frame in which its own has the pose `place`.
    #[must_use]
    pub fn seen_from(&self, place: &Isometry3<f64>) -> Self {
        let turn = place.rotation.to_rotation_matrix();
        let com = place.transform_point(&Point3::from(self.com())).coords;
        Self::new(self.mass(), com, turn * self.about_com() * turn.inverse())
    }

    /// The pseudo-inertia \[\[Σ, h\], \[hᵀ, m\]\] with Σ = tr(I)/2 − I: positive definite where, and only where, a distribution of mass has these parameters.
    ///
    /// # References
    /// Wensing, Kim, Slotine (2018), IEEE Robotics and Automation Letters 3(1), equation 17.
    pub(crate) fn pseudo(&self) -> Matrix4<f64> {
        let i = self.about_origin();
        let sigma = 0.5 * i.trace() * Matrix3::identity() - i;
        let mut pseudo = Matrix4::zeros();
        pseudo.fixed_view_mut::<3, 3>(0, 0).copy_from(&sigma);
        pseudo.fixed_view_mut::<3, 1>(0, 3).copy_from(&self.moments());
        pseudo.fixed_view_mut::<1, 3>(3, 0).copy_from(&self.moments().transpose());
        pseudo[(3, 3)] = self.mass();
        pseudo
    }

    /// Whether a distribution of mass has these parameters.
    #[must_use]
    pub fn is_consistent(&self) -> bool {
        self.pseudo().cholesky().is_some()
    }
}

impl std::ops::Add for Inertia {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_that_there_can_be_are_told_from_others() {
        let about_com = Matrix3::new(0.04, 0.01, 0.0, 0.01, 0.05, 0.002, 0.0, 0.002, 0.03);
        let body = Inertia::new(1.3, Vector3::new(0.1, -0.2, 0.3), about_com);
        assert!(body.is_consistent());
        assert!((body.com() - Vector3::new(0.1, -0.2, 0.3)).norm() < 1e-15);
        assert!((body.about_com() - about_com).norm() < 1e-15);
        // No body has more inertia about one axis than about the two others together.
        let turned = Matrix3::from_diagonal(&Vector3::new(0.1, 0.1, 0.3));
        assert!(!Inertia::new(1.0, Vector3::zeros(), turned).is_consistent());
        assert!(!Inertia::new(-1.0, Vector3::zeros(), Matrix3::identity()).is_consistent());
    }

    #[test]
    fn a_body_seen_from_elsewhere_has_the_same_inertia_about_its_center() {
        let body =
            Inertia::new(2.0, Vector3::new(0.1, 0.0, 0.0), Matrix3::from_diagonal(&Vector3::new(0.1, 0.2, 0.25)));
        let place = Isometry3::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.0, 0.0, std::f64::consts::FRAC_PI_2));
        let seen = body.seen_from(&place);
        assert!((seen.com() - Vector3::new(1.0, 2.1, 3.0)).norm() < 1e-14);
        assert!((seen.about_com() - Matrix3::from_diagonal(&Vector3::new(0.2, 0.1, 0.25))).norm() < 1e-13);
    }
}
