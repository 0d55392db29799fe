//! MJCF files: the arrangement of joints, and parameters written back.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};
use roxmltree::Node;

use crate::tree::Drive;
use crate::xml::{Change, changed, child, digits, document, numbers, replaced, vector, with_attribute};
use crate::{BodiesError, Inertia, Joint, JointParameters, Kind, Tree};

/// A model as an MJCF file describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct Mjcf {
    /// Its joints.
    pub tree: Tree,
    /// Its motors.
    pub drives: Vec<Drive>,
    text: String,
    /// Where the elements of the body and of the joint begin, of each joint.
    places: Vec<(usize, usize)>,
    /// Where the elements of bodies begin that are fixed to others and whose parameters only geoms tell: they are part of these.
    absorbed: Vec<usize>,
}

/// What holds for the whole file.
struct Settings<'a> {
    in_degrees: bool,
    sequence: String,
    defaults: Defaults<'a>,
}

/// Attributes of elements by default: of each class those of each element.
type Defaults<'a> = BTreeMap<String, BTreeMap<&'a str, BTreeMap<&'a str, &'a str>>>;

/// The class that holds where none is named.
const MAIN: &str = "main";

impl Mjcf {
    /// Reads the text of a file, which includes no other. Bodies without joints become parts of those on which they sit. Inertial parameters are read from `inertial` elements only, not
    /// computed from geoms.
    ///
    /// # Errors
    /// [`BodiesError`] if it has other joints than hinges and slides, springs, constraints, or other drives than motors.
    pub fn parse(text: &str) -> Result<Self, BodiesError> {
        let document = document(text, "mujoco")?;
        let root = document.root_element();
        let refused = ["include", "equality", "tendon"];
        if let Some(node) = root.descendants().find(|n| {
            refused.iter().any(|tag| n.has_tag_name(*tag))
                && (n.has_tag_name("include") || n.first_element_child().is_some())
        }) {
            return Err(BodiesError::Unsupported { what: format!("<{}>", node.tag_name().name()) });
        }
        let compiler = child(root, "compiler");
        let of_compiler = |name: &str| compiler.and_then(|node| node.attribute(name));
        let mut settings = Settings {
            in_degrees: of_compiler("angle") != Some("radian"),
            sequence: of_compiler("eulerseq").unwrap_or("xyz").to_owned(),
            defaults: Defaults::default(),
        };
        for node in root.children().filter(|n| n.has_tag_name("default")) {
            read_defaults(node, &BTreeMap::new(), &mut settings.defaults);
        }
        let gravity = match child(root, "option") {
            Some(option) => vector(option, "gravity", "option")?,
            None => None,
        };
        let flag = child(root, "option").and_then(|option| child(option, "flag"));
        let is_off = flag.and_then(|flag| flag.attribute("gravity")) == Some("disable");
        let gravity = if is_off { Vector3::zeros() } else { gravity.unwrap_or(Vector3::new(0.0, 0.0, -9.81)) };
        for what in ["density", "viscosity"] {
            let of = child(root, "option").map(|option| numbers::<1>(option, what, "option")).transpose()?.flatten();
            if of.is_some_and(|[value]| value != 0.0) {
                return Err(BodiesError::Unsupported { what: format!("a medium with {what}") });
            }
        }
        let mut model = Self {
            tree: Tree { joints: Vec::new(), gravity },
            drives: Vec::new(),
            text: text.to_owned(),
            places: Vec::new(),
            absorbed: Vec::new(),
        };
        for world in root.children().filter(|n| n.has_tag_name("worldbody")) {
            model.grow(world, (None, Isometry3::identity(), MAIN), &settings)?;
        }
        if model.tree.is_empty() {
            return Err(BodiesError::NoJoint);
        }
        for drive in
            root.children().filter(|n| n.has_tag_name("actuator")).flat_map(|n| n.children().filter(Node::is_element))
        {
            model.drives.push(read_drive(drive, &model.tree, &settings)?);
        }
        Ok(model)
    }

    /// Adds the bodies in `node`, which is the body that joint `on` moves; `place` is its pose in the frame of that joint.
    fn grow(
        &mut self,
        node: Node<'_, '_>,
        (on, place, class): (Option<usize>, Isometry3<f64>, &str),
        settings: &Settings<'_>,
    ) -> Result<(), BodiesError> {
        for body in node.children().filter(|n| n.has_tag_name("body")) {
            let class = body.attribute("childclass").unwrap_or(class);
            let name = body.attribute("name").map_or_else(|| format!("body{}", self.tree.len() + 1), str::to_owned);
            let here = place * pose(body, &name, settings)?;
            if numbers::<1>(body, "gravcomp", &name)?.is_some_and(|[value]| value != 0.0) {
                return Err(BodiesError::Unsupported { what: format!("gravity compensation of the body `{name}`") });
            }
            let own = inertia(body, &name, settings)?;
            if let Some(node) = body.children().find(|n| n.has_tag_name("freejoint")) {
                let name = node.attribute("name").map_or_else(|| name.clone(), str::to_owned);
                return Err(BodiesError::Joint { name, kind: "`free`".into() });
            }
            let joints: Vec<Node<'_, '_>> = body.children().filter(|n| n.has_tag_name("joint")).collect();
            let (mut on, mut offset, mut frame) = (on, here, here);
            let mut origin = Vector3::zeros();
            for (number, joint) in joints.iter().enumerate() {
                let read = Settled::read(*joint, class, &name, settings)?;
                // The frame of a joint is that of its body, moved to the point of the joint.
                frame =
                    offset * Isometry3::from_parts(Translation3::from(read.pos - origin), UnitQuaternion::identity());
                origin = read.pos;
                let is_last = number + 1 == joints.len();
                let back = Isometry3::from_parts(Translation3::from(-read.pos), UnitQuaternion::identity());
                self.tree.joints.push(Joint {
                    name: joint
                        .attribute("name")
                        .map_or_else(|| format!("joint{}", self.tree.len() + 1), str::to_owned),
                    body: if is_last { name.clone() } else { format!("{name}.{}", number + 1) },
                    kind: read.kind,
                    parent: on,
                    place: frame,
                    reference: read.reference,
                    is_massless: !is_last,
                    axis: read.axis,
                    inertia: if is_last { own.seen_from(&back) } else { Inertia::default() },
                    attached: Inertia::default(),
                    own: read.own,
                });
                self.places.push((body.range().start, joint.range().start));
                on = Some(self.tree.len() - 1);
                offset = Isometry3::identity();
                frame = back;
            }
            if let (true, Some(joint)) = (joints.is_empty(), on.and_then(|on| self.tree.joints.get_mut(on))) {
                joint.attached = joint.attached + own.seen_from(&here);
                self.absorbed.extend(child(body, "inertial").is_none().then(|| body.range().start));
            }
            self.grow(body, (on, frame, class), settings)?;
        }
        Ok(())
    }

    /// The text of the file with other `parameters` (13 n): an `inertial` element for each body that moves, and damping, armature and dry friction of each joint.
    ///
    /// # Errors
    /// [`BodiesError::Shape`] if there are not 13 n parameters.
    pub fn with_parameters(&self, parameters: &[f64]) -> Result<String, BodiesError> {
        let n = self.tree.len();
        if parameters.len() != 13 * n {
            return Err(BodiesError::Shape { what: "parameters", expected: 13 * n, got: parameters.len() });
        }
        let document = document(&self.text, "mujoco")?;
        let at = |start: usize| document.descendants().find(|n| n.is_element() && n.range().start == start);
        let mut changes: Vec<Change> = Vec::new();
        for (i, (joint, (body, own))) in self.tree.joints.iter().zip(&self.places).enumerate() {
            if let (Some(node), false) = (at(*body), joint.is_massless) {
                let mut all = Inertia::default();
                all.0.copy_from_slice(&parameters[10 * i..10 * i + 10]);
                let pos = at(*own).and_then(|joint| vector(joint, "pos", "").ok().flatten()).unwrap_or_default();
                let there = Isometry3::from_parts(Translation3::from(pos), UnitQuaternion::identity());
                changes.push(replaced(
                    node,
                    "inertial",
                    &inertial(&Inertia(all.0 - joint.attached.0).seen_from(&there)),
                ));
            }
            if let Some(node) = at(*own) {
                for (name, value) in [("armature", 10), ("damping", 11), ("frictionloss", 12)] {
                    changes.push(with_attribute(node, name, &digits(parameters[value * n + i])));
                }
            }
        }
        for node in self.absorbed.iter().filter_map(|start| at(*start)) {
            changes.push(replaced(node, "inertial", "<inertial pos=\"0 0 0\" mass=\"0\" diaginertia=\"0 0 0\"/>"));
        }
        let compiler = child(document.root_element(), "compiler");
        if let Some(compiler) = compiler.filter(|node| node.attribute("inertiafromgeom") == Some("true")) {
            changes.push(with_attribute(compiler, "inertiafromgeom", "auto"));
        }
        Ok(changed(&self.text, changes))
    }
}

/// A joint, with what it has by default.
struct Settled {
    kind: Kind,
    pos: Vector3<f64>,
    axis: Unit<Vector3<f64>>,
    reference: f64,
    own: JointParameters,
}

impl Settled {
    fn read(joint: Node<'_, '_>, class: &str, body: &str, settings: &Settings<'_>) -> Result<Self, BodiesError> {
        let name = joint.attribute("name").unwrap_or(body).to_owned();
        let class = joint.attribute("class").unwrap_or(class);
        let of = |what: &str| joint.attribute(what).or_else(|| settings.default(class, "joint", what));
        let kind = match of("type").unwrap_or("hinge") {
            "hinge" => Kind::Hinge,
            "slide" => Kind::Slide,
            other => return Err(BodiesError::Joint { name, kind: format!("`{other}`") }),
        };
        let number = |what: &'static str| -> Result<f64, BodiesError> {
            Ok(of(what).map(|text| parsed::<1>(text, what, &name)).transpose()?.map_or(0.0, |[v]| v))
        };
        if number("stiffness")? != 0.0 {
            return Err(BodiesError::Unsupported { what: format!("the spring of the joint `{name}`") });
        }
        let three = |what: &'static str, default: [f64; 3]| -> Result<Vector3<f64>, BodiesError> {
            Ok(Vector3::from(of(what).map(|text| parsed::<3>(text, what, &name)).transpose()?.unwrap_or(default)))
        };
        let axis = Unit::try_new(three("axis", [0.0, 0.0, 1.0])?, 1e-9)
            .ok_or_else(|| BodiesError::Axis { name: name.clone() })?;
        let in_radians = settings.in_degrees && kind == Kind::Hinge;
        let reference = if in_radians { number("ref")?.to_radians() } else { number("ref")? };
        let own = JointParameters {
            armature: number("armature")?,
            damping: number("damping")?,
            friction: number("frictionloss")?,
        };
        Ok(Self { kind, pos: three("pos", [0.0; 3])?, axis, reference, own })
    }
}

impl Settings<'_> {
    fn default(&self, class: &str, tag: &str, attribute: &str) -> Option<&str> {
        self.defaults.get(class).or_else(|| self.defaults.get(MAIN))?.get(tag)?.get(attribute).copied()
    }
}

fn read_defaults<'a>(
    node: Node<'a, '_>,
    parent: &BTreeMap<&'a str, BTreeMap<&'a str, &'a str>>,
    all: &mut Defaults<'a>,
) {
    let mut own = parent.clone();
    for element in node.children().filter(|n| n.is_element() && !n.has_tag_name("default")) {
        let attributes = own.entry(element.tag_name().name()).or_default();
        attributes.extend(element.attributes().map(|a| (a.name(), a.value())));
    }
    for nested in node.children().filter(|n| n.has_tag_name("default")) {
        read_defaults(nested, &own, all);
    }
    all.insert(node.attribute("class").unwrap_or(MAIN).to_owned(), own);
}

/// So many numbers in a text.
fn parsed<const N: usize>(text: &str, what: &'static str, name: &str) -> Result<[f64; N], BodiesError> {
    let failed = || BodiesError::Number { what, name: name.to_owned(), text: text.to_owned(), expected: N };
    let all = text.split_whitespace().map(str::parse::<f64>).collect::<Result<Vec<_>, _>>().map_err(|_| failed())?;
    let all: [f64; N] = all.try_into().map_err(|_| failed())?;
    if all.iter().all(|v| v.is_finite()) { Ok(all) } else { Err(failed()) }
}

/// The pose of an element in that in which it stands.
fn pose(node: Node<'_, '_>, name: &str, settings: &Settings<'_>) -> Result<Isometry3<f64>, BodiesError> {
    let pos = vector(node, "pos", name)?.unwrap_or_default();
    let angle = |value: f64| if settings.in_degrees { value.to_radians() } else { value };
    let turn = if let Some([w, x, y, z]) = numbers::<4>(node, "quat", name)? {
        UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
    } else if let Some([x, y, z, by]) = numbers::<4>(node, "axisangle", name)? {
        let axis =
            Unit::try_new(Vector3::new(x, y, z), 1e-9).ok_or_else(|| BodiesError::Axis { name: name.to_owned() })?;
        UnitQuaternion::from_axis_angle(&axis, angle(by))
    } else if let Some(angles) = vector(node, "euler", name)? {
        let mut turn = UnitQuaternion::identity();
        for (letter, by) in settings.sequence.chars().zip(angles.iter()) {
            let axis = match letter.to_ascii_lowercase() {
                'x' => Vector3::x_axis(),
                'y' => Vector3::y_axis(),
                _ => Vector3::z_axis(),
            };
            let step = UnitQuaternion::from_axis_angle(&axis, angle(*by));
            // Small letters turn about axes that turn with the body.
            turn = if letter.is_lowercase() { turn * step } else { step * turn };
        }
        turn
    } else if let Some([a, b, c, d, e, f]) = numbers::<6>(node, "xyaxes", name)? {
        let x = Vector3::new(a, b, c).normalize();
        let y = Vector3::new(d, e, f);
        let y = (y - x * x.dot(&y)).normalize();
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[
            x,
            y,
            x.cross(&y),
        ])))
    } else if let Some(z) = vector(node, "zaxis", name)? {
        UnitQuaternion::rotation_between(&Vector3::z(), &z)
            .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI))
    } else {
        UnitQuaternion::identity()
    };
    if turn.coords.iter().all(|v| v.is_finite()) {
        Ok(Isometry3::from_parts(Translation3::from(pos), turn))
    } else {
        Err(BodiesError::Axis { name: name.to_owned() })
    }
}

/// The inertial parameters of a body in its frame; zero without an element.
fn inertia(body: Node<'_, '_>, name: &str, settings: &Settings<'_>) -> Result<Inertia, BodiesError> {
    let Some(node) = child(body, "inertial") else { return Ok(Inertia::default()) };
    let mass = numbers::<1>(node, "mass", name)?.map_or(0.0, |[mass]| mass);
    let about_com = if let Some([xx, yy, zz, xy, xz, yz]) = numbers::<6>(node, "fullinertia", name)? {
        Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    } else {
        Matrix3::from_diagonal(&vector(node, "diaginertia", name)?.unwrap_or_default())
    };
    Ok(Inertia::new(mass, Vector3::zeros(), about_com).seen_from(&pose(node, name, settings)?))
}

fn read_drive(node: Node<'_, '_>, tree: &Tree, settings: &Settings<'_>) -> Result<Drive, BodiesError> {
    let tag = node.tag_name().name();
    let class = node.attribute("class").unwrap_or(MAIN);
    let name = node.attribute("name").or(node.attribute("joint")).unwrap_or_default().to_owned();
    let unsupported =
        || BodiesError::Unsupported { what: format!("the actuator `{name}`, which is no motor of a joint,") };
    let is_plain = ["gainprm", "biasprm", "biastype", "dyntype"].iter().all(|what| node.attribute(*what).is_none());
    if !(tag == "motor" || tag == "general" && is_plain) {
        return Err(unsupported());
    }
    let joint = node
        .attribute("joint")
        .and_then(|joint| tree.joints.iter().position(|j| j.name == joint))
        .ok_or_else(unsupported)?;
    let gear = node
        .attribute("gear")
        .or_else(|| settings.default(class, tag, "gear"))
        .map(|text| text.split_whitespace().next().unwrap_or("1"));
    let gear = gear.map(|text| parsed::<1>(text, "gear", &name)).transpose()?.map_or(1.0, |[gear]| gear);
    Ok(Drive { name, joint, gear })
}

fn inertial(of: &Inertia) -> String {
    let (c, i) = (of.com(), of.about_com());
    let [x, y, z, mass] = [c.x, c.y, c.z, of.mass()].map(digits);
    let full = [i.m11, i.m22, i.m33, i.m12, i.m13, i.m23].map(digits).join(" ");
    format!("<inertial pos=\"{x} {y} {z}\" mass=\"{mass}\" fullinertia=\"{full}\"/>")
}
