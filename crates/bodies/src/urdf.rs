//! URDF files: the arrangement of joints, and parameters written back.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Matrix3, Translation3, Unit, UnitQuaternion, Vector3};
use roxmltree::Node;

use crate::xml::{Change, DEEPEST, changed, child, digits, document, numbers, replaced, vector};
use crate::{BodiesError, Inertia, Joint, JointParameters, Kind, Tree};

/// A robot as a URDF file describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct Urdf {
    /// Its joints that move.
    pub tree: Tree,
    text: String,
}

impl Urdf {
    /// Reads the text of a file. Links that are fixed to others become parts of these. Gravity points down, along −z of the base, with 9.81 m/s².
    ///
    /// # Errors
    /// [`BodiesError`] if it is no tree of hinges and slides.
    pub fn parse(text: &str) -> Result<Self, BodiesError> {
        let document = document(text, "robot")?;
        let robot = document.root_element();
        let links = named(robot, "link")?;
        if links.len() > DEEPEST {
            return Err(BodiesError::Unsupported { what: format!("a robot with more than {DEEPEST} links") });
        }
        let joints = named(robot, "joint")?;
        let read = joints.values().map(|joint| Connection::read(*joint)).collect::<Result<Vec<_>, _>>()?;
        for connection in &read {
            for link in [&connection.parent, &connection.child] {
                if !links.contains_key(link.as_str()) {
                    return Err(tree_error(format!(
                        "the joint `{}` names the link `{link}`, which is none",
                        connection.name
                    )));
                }
            }
            if read.iter().filter(|other| other.child == connection.child).count() > 1 {
                return Err(tree_error(format!("the link `{}` hangs on several joints", connection.child)));
            }
        }
        let bases: Vec<&String> = links.keys().filter(|link| read.iter().all(|c| c.child != **link)).collect();
        let [base] = bases[..] else {
            return Err(tree_error(format!("{} links hang on no joint, not 1", bases.len())));
        };
        let mut tree = Tree { joints: Vec::new(), gravity: Vector3::new(0.0, 0.0, -9.81) };
        let mut seen = 1;
        grow(&mut tree, (&links, &read), (base, None, Isometry3::identity()), &mut seen)?;
        if seen < links.len() {
            return Err(tree_error("joints form a circle".into()));
        }
        if tree.is_empty() {
            return Err(BodiesError::NoJoint);
        }
        Ok(Self { tree, text: text.to_owned() })
    }

    /// The text of the file with other `parameters` (13 n): mass, center of mass and inertia of the link that each joint moves, less those of links that are fixed to it; damping and dry
    /// friction of the joints. URDF has no armature; a comment tells it.
    ///
    /// # Errors
    /// [`BodiesError::Shape`] if there are not 13 n parameters.
    pub fn with_parameters(&self, parameters: &[f64]) -> Result<String, BodiesError> {
        let n = self.tree.len();
        if parameters.len() != 13 * n {
            return Err(BodiesError::Shape { what: "parameters", expected: 13 * n, got: parameters.len() });
        }
        let document = document(&self.text, "robot")?;
        let robot = document.root_element();
        let (links, joints) = (named(robot, "link")?, named(robot, "joint")?);
        let mut changes: Vec<Change> = Vec::new();
        for (i, joint) in self.tree.joints.iter().enumerate() {
            let mut all = Inertia::default();
            all.0.copy_from_slice(&parameters[10 * i..10 * i + 10]);
            let own = Inertia(all.0 - joint.attached.0);
            let (armature, damping, friction) =
                (parameters[10 * n + i], parameters[11 * n + i], parameters[12 * n + i]);
            if let Some(link) = links.get(&joint.body) {
                changes.push(replaced(*link, "inertial", &inertial(&own)));
            }
            if let Some(node) = joints.get(&joint.name) {
                let text =
                    format!("<dynamics damping=\"{damping}\" friction=\"{friction}\"/> <!-- armature {armature} -->");
                changes.push(replaced(*node, "dynamics", &text));
            }
        }
        Ok(changed(&self.text, changes))
    }
}

fn tree_error(reason: String) -> BodiesError {
    BodiesError::NoTree { reason }
}

/// The children of `robot` with the tag `tag`, by their names.
fn named<'a, 'i>(robot: Node<'a, 'i>, tag: &'static str) -> Result<BTreeMap<String, Node<'a, 'i>>, BodiesError> {
    let mut all = BTreeMap::new();
    for node in robot.children().filter(|n| n.has_tag_name(tag)) {
        let missing = || BodiesError::Missing { element: tag, name: String::new(), what: "name" };
        let name = node.attribute("name").ok_or_else(missing)?.to_owned();
        if all.insert(name.clone(), node).is_some() {
            return Err(tree_error(format!("two {tag}s are called `{name}`")));
        }
    }
    Ok(all)
}

/// A joint as it is written.
struct Connection {
    name: String,
    parent: String,
    child: String,
    place: Isometry3<f64>,
    /// `None` for one that is fixed.
    moves: Option<(Kind, Unit<Vector3<f64>>, JointParameters)>,
}

impl Connection {
    fn read(joint: Node<'_, '_>) -> Result<Self, BodiesError> {
        let name = joint.attribute("name").unwrap_or_default().to_owned();
        let link = |what: &'static str| {
            let found = child(joint, what).and_then(|n| n.attribute("link")).map(str::to_owned);
            found.ok_or_else(|| BodiesError::Missing { element: "joint", name: name.clone(), what })
        };
        let kind = match joint.attribute("type").unwrap_or_default() {
            _ if child(joint, "mimic").is_some() => {
                return Err(BodiesError::Joint { name, kind: "one that follows another".into() });
            }
            "revolute" | "continuous" => Some(Kind::Hinge),
            "prismatic" => Some(Kind::Slide),
            "fixed" => None,
            other => return Err(BodiesError::Joint { name, kind: format!("`{other}`") }),
        };
        let moves = match kind {
            None => None,
            Some(kind) => {
                let axis = match child(joint, "axis") {
                    Some(node) => vector(node, "xyz", &name)?.unwrap_or(Vector3::x()),
                    None => Vector3::x(),
                };
                let axis = Unit::try_new(axis, 1e-9).ok_or_else(|| BodiesError::Axis { name: name.clone() })?;
                let dynamics = child(joint, "dynamics");
                let own = |what: &'static str| -> Result<f64, BodiesError> {
                    Ok(dynamics.map(|d| numbers::<1>(d, what, &name)).transpose()?.flatten().map_or(0.0, |[v]| v))
                };
                Some((
                    kind,
                    axis,
                    JointParameters { armature: 0.0, damping: own("damping")?, friction: own("friction")? },
                ))
            }
        };
        Ok(Self { parent: link("parent")?, child: link("child")?, place: place(joint, &name)?, moves, name })
    }
}

/// The pose in the `origin` of a node.
fn place(node: Node<'_, '_>, name: &str) -> Result<Isometry3<f64>, BodiesError> {
    let Some(origin) = child(node, "origin") else { return Ok(Isometry3::identity()) };
    let xyz = vector(origin, "xyz", name)?.unwrap_or_default();
    let rpy = vector(origin, "rpy", name)?.unwrap_or_default();
    Ok(Isometry3::from_parts(Translation3::from(xyz), UnitQuaternion::from_euler_angles(rpy.x, rpy.y, rpy.z)))
}

/// The inertial parameters of a link in its frame; zero without an element.
fn inertia(link: Node<'_, '_>, name: &str) -> Result<Inertia, BodiesError> {
    let Some(inertial) = child(link, "inertial") else { return Ok(Inertia::default()) };
    let value = |tag: &str, what: &'static str| -> Result<f64, BodiesError> {
        let found = child(inertial, tag).map(|n| numbers::<1>(n, what, name)).transpose()?.flatten();
        Ok(found.map_or(0.0, |[v]| v))
    };
    let [xx, xy, xz] = [value("inertia", "ixx")?, value("inertia", "ixy")?, value("inertia", "ixz")?];
    let [yy, yz, zz] = [value("inertia", "iyy")?, value("inertia", "iyz")?, value("inertia", "izz")?];
    let about_com = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    Ok(Inertia::new(value("mass", "value")?, Vector3::zeros(), about_com).seen_from(&place(inertial, name)?))
}

/// Adds what hangs on the link `link`, which has the pose `place` in the body that joint `on` moves.
fn grow(
    tree: &mut Tree,
    all: (&BTreeMap<String, Node<'_, '_>>, &[Connection]),
    (link, on, place): (&str, Option<usize>, Isometry3<f64>),
    seen: &mut usize,
) -> Result<(), BodiesError> {
    for connection in all.1.iter().filter(|c| c.parent == link) {
        *seen += 1;
        let here = place * connection.place;
        let own = inertia(all.0[&connection.child], &connection.child)?;
        let (on, place) = match &connection.moves {
            None => {
                if let Some(joint) = on.and_then(|on| tree.joints.get_mut(on)) {
                    joint.attached = joint.attached + own.seen_from(&here);
                }
                (on, here)
            }
            Some((kind, axis, parameters)) => {
                tree.joints.push(Joint {
                    name: connection.name.clone(),
                    body: connection.child.clone(),
                    kind: *kind,
                    parent: on,
                    place: here,
                    reference: 0.0,
                    is_massless: false,
                    axis: *axis,
                    inertia: own,
                    attached: Inertia::default(),
                    own: *parameters,
                });
                (Some(tree.joints.len() - 1), Isometry3::identity())
            }
        };
        grow(tree, all, (&connection.child, on, place), seen)?;
    }
    Ok(())
}

fn inertial(of: &Inertia) -> String {
    let (c, i) = (of.com(), of.about_com());
    let [x, y, z, mass] = [c.x, c.y, c.z, of.mass()].map(digits);
    let [xx, xy, xz, yy, yz, zz] = [i.m11, i.m12, i.m13, i.m22, i.m23, i.m33].map(digits);
    format!(
        "<inertial>\n      <origin xyz=\"{x} {y} {z}\" rpy=\"0 0 0\"/>\n      <mass value=\"{mass}\"/>\n      \
         <inertia ixx=\"{xx}\" ixy=\"{xy}\" ixz=\"{xz}\" iyy=\"{yy}\" iyz=\"{yz}\" izz=\"{zz}\"/>\n    </inertial>"
    )
}
