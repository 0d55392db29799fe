//! Bodies and how they hang on each other.

use nalgebra::{Isometry3, Unit, Vector3};

use crate::Inertia;

/// How a joint moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// About its axis \[rad\].
    Hinge,
    /// Along its axis \[m\].
    Slide,
}

/// A joint, and the body that it moves. The frame of the body is that of the joint, moved by its position.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name of the joint.
    pub name: String,
    /// Name of the body.
    pub body: String,
    /// How it moves.
    pub kind: Kind,
    /// The joint, earlier in the tree, on whose body it sits; `None` on what stands still.
    pub parent: Option<usize>,
    /// The frame of the joint in that of the body on which it sits.
    pub place: Isometry3<f64>,
    /// Its position where the body stands as `place` says.
    pub reference: f64,
    /// Whether another joint of the same body follows, and this one moves no mass of its own.
    pub is_massless: bool,
    /// Its axis.
    pub axis: Unit<Vector3<f64>>,
    /// Inertial parameters of the body as the file has them.
    pub inertia: Inertia,
    /// Those of what is fixed to it, which stay as they are.
    pub attached: Inertia,
    /// Armature, damping and dry friction as the file has them.
    pub own: JointParameters,
}

/// What an input acts on.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// Name of the drive.
    pub name: String,
    /// The joint.
    pub joint: usize,
    /// Force on the joint for an input of 1 \[N m; N\].
    pub gear: f64,
}

/// Parameters of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointParameters {
    /// Inertia of the rotor, times the square of the gear \[kg m²; kg\].
    pub armature: f64,
    /// Viscous friction \[N m s/rad; N s/m\].
    pub damping: f64,
    /// Dry friction \[N m; N\].
    pub friction: f64,
}

/// A tree of joints on a base that stands still, each after that on which it sits.
#[derive(Debug, Clone, PartialEq)]
pub struct Tree {
    /// The joints (n).
    pub joints: Vec<Joint>,
    /// Acceleration of gravity in the frame of the base \[m/s²\].
    pub gravity: Vector3<f64>,
}

/// Parameters of a body or a joint, 13 for each joint: the inertial ones of the bodies, then armatures, damping and dry friction of the joints.
pub(crate) const PER_JOINT: usize = 13;

impl Tree {
    /// Number of joints.
    #[must_use]
    pub fn len(&self) -> usize {
        self.joints.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.joints.is_empty()
    }

    /// The parameters of the tree as its file has them (13 n).
    #[must_use]
    pub fn parameters(&self) -> Vec<f64> {
        let bodies = self.joints.iter().flat_map(|j| (j.inertia + j.attached).0.iter().copied().collect::<Vec<f64>>());
        let armatures = self.joints.iter().map(|j| j.own.armature);
        let damping = self.joints.iter().map(|j| j.own.damping);
        bodies.chain(armatures).chain(damping).chain(self.joints.iter().map(|j| j.own.friction)).collect()
    }

    /// Names of the parameters, such as `Izz(link1)` and `damping(joint1)`.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        let bodies =
            self.joints.iter().flat_map(|j| Inertia::NAMES.iter().map(move |name| format!("{name}({})", j.body)));
        let of_joints = ["armature", "damping", "friction"].into_iter();
        bodies
            .chain(of_joints.flat_map(|name| self.joints.iter().map(move |j| format!("{name}({})", j.name))))
            .collect()
    }
}
