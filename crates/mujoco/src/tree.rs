//! Bodies, joints and sites of a compiled model, as MuJoCo prints them: the same in all versions from 3.0.0 to 4.0.0, unlike the memory they lie in.

use std::collections::BTreeMap;
use std::ffi::CString;

use crate::error::MujocoError;
use crate::model::MujocoModel;

/// What stands where, and on what.
#[derive(Debug, Clone, PartialEq)]
pub struct Tree {
    /// The first is the world.
    pub bodies: Vec<Body>,
    /// In the order of their positions.
    pub joints: Vec<Joint>,
    /// Points that have names.
    pub sites: Vec<Site>,
}

/// A body.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Empty where it has none.
    pub name: String,
    /// The body that it hangs on.
    pub parent: usize,
    /// Where it is in its parent, its joints at rest \[m\].
    pub pos: [f64; 3],
    /// How it is turned there: a quaternion (w, x, y, z).
    pub quat: [f64; 4],
}

/// A joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// How it moves.
    pub kind: JointKind,
    /// Its body.
    pub body: usize,
    /// Index of its first position.
    pub position: usize,
    /// Its point in the body \[m\].
    pub pos: [f64; 3],
    /// Its axis in the body, a unit vector.
    pub axis: [f64; 3],
    /// Its position where the body is as it was drawn.
    pub reference: f64,
    /// Lowest and highest position at which no stop acts, where it has stops: its range without their margin.
    pub range: Option<(f64, f64)>,
}

/// How a joint moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// Anyhow.
    Free,
    /// It turns any way.
    Ball,
    /// Along its axis.
    Slide,
    /// Around its axis.
    Hinge,
}

/// A point of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Site {
    /// Empty where it has none.
    pub name: String,
    /// Its body.
    pub body: usize,
    /// Where it is in the body \[m\].
    pub pos: [f64; 3],
}

/// The lines of one object: what MuJoCo calls a value, and the value.
type Fields<'a> = BTreeMap<&'a str, &'a str>;

impl Tree {
    /// That of `model`.
    ///
    /// # Errors
    /// [`MujocoError::Raised`] if MuJoCo does not print the model, or prints something else.
    pub fn of(model: &MujocoModel) -> Result<Self, MujocoError> {
        let failed = |message: String| MujocoError::Raised { message };
        let folder = tempfile::tempdir().map_err(|e| failed(e.to_string()))?;
        let file = folder.path().join("model.txt");
        let name = CString::new(file.to_string_lossy().as_bytes()).map_err(|e| failed(e.to_string()))?;
        model.handle().print(&name).map_err(|raised| failed(raised.0))?;
        let text = std::fs::read(&file).map_err(|e| failed(e.to_string()))?;
        Self::parse(&String::from_utf8_lossy(&text)).ok_or_else(|| failed("it prints a model in another form".into()))
    }

    /// Reads what MuJoCo prints.
    fn parse(text: &str) -> Option<Self> {
        let reference = text.lines().find_map(|line| line.strip_prefix("qpos0")).map(numbers)?;
        let body = |fields: &Fields<'_>| {
            Some(Body {
                name: fields.get("name").unwrap_or(&"").to_string(),
                parent: fields.get("body_parentid")?.parse().ok()?,
                pos: array(fields.get("body_pos")?)?,
                quat: array(fields.get("body_quat")?)?,
            })
        };
        let joint = |fields: &Fields<'_>| {
            let position = fields.get("jnt_qposadr")?.parse().ok()?;
            let kind = match fields.get("jnt_type")?.parse().ok()? {
                0 => JointKind::Free,
                1 => JointKind::Ball,
                2 => JointKind::Slide,
                3 => JointKind::Hinge,
                _ => return None,
            };
            let [low, high] = array(fields.get("jnt_range")?)?;
            let margin: f64 = fields.get("jnt_margin")?.parse().ok()?;
            Some(Joint {
                kind,
                body: fields.get("jnt_bodyid")?.parse().ok()?,
                position,
                pos: array(fields.get("jnt_pos")?)?,
                axis: array(fields.get("jnt_axis")?)?,
                reference: *reference.get(position)?,
                range: (*fields.get("jnt_limited")? == "1").then_some((low + margin, high - margin)),
            })
        };
        let site = |fields: &Fields<'_>| {
            Some(Site {
                name: fields.get("name").unwrap_or(&"").to_string(),
                body: fields.get("site_bodyid")?.parse().ok()?,
                pos: array(fields.get("site_pos")?)?,
            })
        };
        let tree = Self {
            bodies: objects(text, "BODY ").iter().map(body).collect::<Option<_>>()?,
            joints: objects(text, "JOINT ").iter().map(joint).collect::<Option<_>>()?,
            sites: objects(text, "SITE ").iter().map(site).collect::<Option<_>>()?,
        };
        // A parent stands before its children, so that every way up ends in the world.
        let sound = tree.bodies.iter().enumerate().all(|(i, body)| body.parent < i.max(1));
        let on = tree.joints.iter().map(|joint| joint.body).chain(tree.sites.iter().map(|site| site.body));
        (sound && on.max().is_none_or(|body| body < tree.bodies.len()) && !tree.bodies.is_empty()).then_some(tree)
    }
}

/// The objects whose lines follow `head` and a number.
fn objects<'a>(text: &'a str, head: &str) -> Vec<Fields<'a>> {
    let mut found: Vec<Fields<'a>> = Vec::new();
    let mut inside = false;
    for line in text.lines() {
        if line.strip_prefix(head).is_some_and(|rest| rest.trim_end().ends_with(':')) {
            found.push(Fields::new());
            inside = true;
        } else if !line.starts_with(' ') {
            inside = false;
        } else if let (true, Some(fields)) = (inside, found.last_mut()) {
            let line = line.trim();
            let (name, value) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
            fields.insert(name, value.trim());
        }
    }
    found
}

/// The numbers of a line.
fn numbers(text: &str) -> Vec<f64> {
    text.split_whitespace().map_while(|number| number.parse().ok()).collect()
}

fn array<const N: usize>(text: &str) -> Option<[f64; N]> {
    numbers(text).try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_mujoco_prints_is_read() {
        let text = "MuJoCo version 3.0.0\n\nqpos0                0.5 0 \n\nBODY 0:\n  name                  world\n  body_parentid         0 \n  body_pos             0 0 0 \n  \
                    body_quat            1 0 0 0 \n\nBODY 1:\n  name                  a b\n  body_parentid         0 \n  body_pos             1 2 3 \n  body_quat            0.6 0 0 0.8 \n\n\
                    JOINT 0:\n  name                  \n  jnt_type              3 \n  jnt_qposadr           0 \n  jnt_bodyid            1 \n  jnt_limited           1 \n  jnt_pos              0 0 0 \n  \
                    jnt_axis             0 1 0 \n  jnt_range            -1 2 \n  jnt_margin           0.25 \n\nDOF 0:\n  name   no\n";
        let tree = Tree::parse(text).expect("it is as printed");
        assert_eq!((tree.bodies.len(), tree.bodies[1].name.as_str(), tree.sites.len()), (2, "a b", 0));
        let expected = Joint {
            kind: JointKind::Hinge,
            body: 1,
            position: 0,
            pos: [0.0; 3],
            axis: [0.0, 1.0, 0.0],
            reference: 0.5,
            range: Some((-0.75, 1.75)),
        };
        assert_eq!(tree.joints, [expected]);
        for broken in
            [text.replace("jnt_axis             0 1 0", "jnt_axis 0 1"), text.replace("qpos0", "qpos"), String::new()]
        {
            assert_eq!(Tree::parse(&broken), None);
        }
        assert_eq!(Tree::parse(&text.replace("jnt_bodyid            1", "jnt_bodyid            7")), None);
    }
}
