//! Momenta and forces of a tree of bodies, linear in its parameters.

use nalgebra::{DMatrix, Matrix3, Rotation3, SMatrix, SVector, Vector3, Vector6};

use crate::tree::PER_JOINT;
use crate::{Kind, Tree};

/// A twist (ω, v), or a wrench.
type Spatial = Vector6<f64>;

fn spatial(angular: Vector3<f64>, linear: Vector3<f64>) -> Spatial {
    Spatial::new(angular.x, angular.y, angular.z, linear.x, linear.y, linear.z)
}

fn angular(of: &Spatial) -> Vector3<f64> {
    of.fixed_rows::<3>(0).into_owned()
}

fn linear(of: &Spatial) -> Vector3<f64> {
    of.fixed_rows::<3>(3).into_owned()
}

/// V × m of two twists.
fn cross(v: &Spatial, m: &Spatial) -> Spatial {
    spatial(angular(v).cross(&angular(m)), angular(v).cross(&linear(m)) + linear(v).cross(&angular(m)))
}

/// V ×* h of a twist and momenta (6, 10).
fn cross_force(v: &Spatial, h: &SMatrix<f64, 6, 10>) -> SMatrix<f64, 6, 10> {
    let (w, v) = (angular(v).cross_matrix(), linear(v).cross_matrix());
    let (above, below) = (h.fixed_rows::<3>(0), h.fixed_rows::<3>(3));
    let mut all = SMatrix::<f64, 6, 10>::zeros();
    all.fixed_rows_mut::<3>(0).copy_from(&(w * above + v * below));
    all.fixed_rows_mut::<3>(3).copy_from(&(w * below));
    all
}

/// A(V) with A(V) π the momentum of a body with the twist V and the inertial parameters π.
fn momentum(of: &Spatial) -> SMatrix<f64, 6, 10> {
    let (w, v) = (angular(of), linear(of));
    let mut a = SMatrix::<f64, 6, 10>::zeros();
    a.fixed_view_mut::<3, 1>(3, 0).copy_from(&v);
    a.fixed_view_mut::<3, 3>(0, 1).copy_from(&-v.cross_matrix());
    a.fixed_view_mut::<3, 3>(3, 1).copy_from(&w.cross_matrix());
    let of_inertia = SMatrix::<f64, 3, 6>::new(
        w.x, w.y, w.z, 0.0, 0.0, 0.0, //
        0.0, w.x, 0.0, w.y, w.z, 0.0, //
        0.0, 0.0, w.x, 0.0, w.y, w.z,
    );
    a.fixed_view_mut::<3, 6>(0, 4).copy_from(&of_inertia);
    a
}

/// How a body moves.
struct Moving {
    twist: Spatial,
    acceleration: Spatial,
    /// From the base's frame to that of the body.
    turn: Matrix3<f64>,
    /// The joints that move it, with their axes s, and V × s of each joint's own body, in the frame of the body.
    axes: Vec<(usize, Spatial, Spatial)>,
}

/// The motion of all bodies at positions `q`, rates `v` and accelerations `a` (n), gravity among the latter where `is_heavy`.
fn motions(tree: &Tree, (q, v, a): (&[f64], &[f64], &[f64]), is_heavy: bool) -> Vec<Moving> {
    let mut all: Vec<Moving> = Vec::with_capacity(tree.len());
    for (i, joint) in tree.joints.iter().enumerate() {
        let axis = joint.axis.into_inner();
        let q = q[i] - joint.reference;
        let fixed: Matrix3<f64> = joint.place.rotation.to_rotation_matrix().into_inner();
        let (own, turn, place) = match joint.kind {
            Kind::Hinge => {
                let turned = fixed * Rotation3::from_axis_angle(&joint.axis, q).into_inner();
                (spatial(axis, Vector3::zeros()), turned, joint.place.translation.vector)
            }
            Kind::Slide => (spatial(Vector3::zeros(), axis), fixed, joint.place.translation.vector + fixed * axis * q),
        };
        let back = turn.transpose();
        let moved = |m: &Spatial| spatial(back * angular(m), back * (linear(m) + angular(m).cross(&place)));
        let gravity = if is_heavy { -tree.gravity } else { Vector3::zeros() };
        let (below, acceleration, turn, mut axes) = match joint.parent.map(|p| &all[p]) {
            Some(parent) => {
                let axes = parent.axes.iter().map(|(j, s, w)| (*j, moved(s), moved(w))).collect();
                (moved(&parent.twist), moved(&parent.acceleration), back * parent.turn, axes)
            }
            None => (Spatial::zeros(), moved(&spatial(Vector3::zeros(), gravity)), back, Vec::new()),
        };
        let twist = below + own * v[i];
        axes.push((i, own, cross(&twist, &own)));
        let acceleration = acceleration + own * a[i] + cross(&twist, &(own * v[i]));
        all.push(Moving { twist, acceleration, turn, axes });
    }
    all
}

/// Y with Y(q, v, a) π the forces of the joints, for the parameters π of the tree: (n, 13 n).
#[must_use]
pub fn inverse_dynamics(tree: &Tree, q: &[f64], v: &[f64], a: &[f64]) -> DMatrix<f64> {
    let n = tree.len();
    let mut all = DMatrix::zeros(n, PER_JOINT * n);
    for (b, body) in motions(tree, (q, v, a), true).iter().enumerate().filter(|(b, _)| !tree.joints[*b].is_massless) {
        let force = momentum(&body.acceleration) + cross_force(&body.twist, &momentum(&body.twist));
        for (j, axis, _) in &body.axes {
            all.view_mut((*j, 10 * b), (1, 10)).copy_from(&(axis.transpose() * force));
        }
    }
    for i in 0..n {
        all[(i, 10 * n + i)] = a[i];
        all[(i, 11 * n + i)] = v[i];
        all[(i, 12 * n + i)] = if v[i] == 0.0 { 0.0 } else { v[i].signum() };
    }
    all
}

/// (P, F) with P π the momenta ∂L/∂v of the joints, and F π what changes them besides the forces of the joints, ∂L/∂q and friction: (n, 13 n) each.
///
/// With s the axis of joint j in the frame of a body, V_j the twist of the body that it moves: ∂L/∂q_j = Σ (V_j × s)ᵀ A(V) π + sᵀ A(0, g) π over the bodies that it moves.
#[must_use]
pub fn momenta(tree: &Tree, q: &[f64], v: &[f64]) -> (DMatrix<f64>, DMatrix<f64>) {
    let n = tree.len();
    let (mut momenta, mut forces) = (DMatrix::zeros(n, PER_JOINT * n), DMatrix::zeros(n, PER_JOINT * n));
    for (b, body) in
        motions(tree, (q, v, &vec![0.0; n]), false).iter().enumerate().filter(|(b, _)| !tree.joints[*b].is_massless)
    {
        let own = momentum(&body.twist);
        let heavy = momentum(&spatial(Vector3::zeros(), body.turn * tree.gravity));
        for (j, axis, turned) in &body.axes {
            momenta.view_mut((*j, 10 * b), (1, 10)).copy_from(&(axis.transpose() * own));
            forces.view_mut((*j, 10 * b), (1, 10)).copy_from(&(turned.transpose() * own + axis.transpose() * heavy));
        }
    }
    for i in 0..n {
        momenta[(i, 10 * n + i)] = v[i];
        forces[(i, 11 * n + i)] = -v[i];
        forces[(i, 12 * n + i)] = if v[i] == 0.0 { 0.0 } else { -v[i].signum() };
    }
    (momenta, forces)
}

/// Forces of the joints (n) at positions `q`, rates `v` and accelerations `a` (n) for the `parameters` (13 n): what [`inverse_dynamics`] times these is, sooner.
#[must_use]
pub fn forces(tree: &Tree, parameters: &[f64], (q, v, a): (&[f64], &[f64], &[f64]), is_heavy: bool) -> Vec<f64> {
    let n = tree.len();
    let friction = |i: usize| {
        let sign = if v[i] == 0.0 { 0.0 } else { v[i].signum() };
        parameters[10 * n + i] * a[i] + parameters[11 * n + i] * v[i] + parameters[12 * n + i] * sign
    };
    let mut all: Vec<f64> = (0..n).map(friction).collect();
    for (b, body) in motions(tree, (q, v, a), is_heavy).iter().enumerate().filter(|(b, _)| !tree.joints[*b].is_massless)
    {
        let own = SVector::<f64, 10>::from_column_slice(&parameters[10 * b..10 * b + 10]);
        let of = momentum(&body.twist) * own;
        let (w, v) = (angular(&body.twist), linear(&body.twist));
        let turned = spatial(w.cross(&angular(&of)) + v.cross(&linear(&of)), w.cross(&linear(&of)));
        let wrench = momentum(&body.acceleration) * own + turned;
        for (j, axis, _) in &body.axes {
            all[*j] += axis.dot(&wrench);
        }
    }
    all
}
