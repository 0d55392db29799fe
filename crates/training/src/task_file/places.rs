//! Where bodies and sites of a MuJoCo model are, as formulas of its positions.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use anyhow::{Context as _, bail};
use sindyna_mujoco::{Joint, JointKind, Tree};

use super::document::{Document, Normal, StartValue};

/// Part of the largest coefficient of a coordinate below which one is rounding.
const ROUNDING: f64 = 1e-14;

/// A coordinate: the sum of c·cos(k·q) and s·sin(k·q), some of them times the position of a slide. The key is k, and which slide; the value c and s.
#[derive(Debug, Clone, Default, PartialEq)]
struct Coordinate(BTreeMap<(Vec<i32>, Option<usize>), [f64; 2]>);

/// A point.
type Point = [Coordinate; 3];

impl Coordinate {
    /// A number, of a system with `n` positions.
    fn number(value: f64, n: usize) -> Self {
        Self(BTreeMap::from([((vec![0; n], None), [value, 0.0])]))
    }

    /// The position `i` of a slide.
    fn slide(i: usize, n: usize) -> Self {
        Self(BTreeMap::from([((vec![0; n], Some(i)), [1.0, 0.0])]))
    }

    fn add(&mut self, (mut angles, slide): (Vec<i32>, Option<usize>), [cosine, sine]: [f64; 2]) {
        let turned = angles.iter().find(|k| **k != 0).is_some_and(|k| *k < 0);
        angles.iter_mut().filter(|_| turned).for_each(|k| *k = -*k);
        let sine = if angles.iter().all(|k| *k == 0) { 0.0 } else { sine };
        let held = self.0.entry((angles, slide)).or_default();
        held[0] += cosine;
        held[1] += if turned { -sine } else { sine };
    }

    /// The sum of others, each times a number.
    fn sum<'a>(parts: impl IntoIterator<Item = (f64, &'a Self)>) -> Self {
        let mut sum = Self::default();
        for (factor, part) in parts {
            part.0.iter().for_each(|(key, [c, s])| sum.add(key.clone(), [factor * c, factor * s]));
        }
        sum
    }

    /// It times a·cos(q) + b·sin(q) of the angle `i`.
    fn turned(&self, i: usize, (a, b): (f64, f64)) -> Self {
        let mut product = Self::default();
        for ((angles, slide), [c, s]) in &self.0 {
            for (sign, values) in [(1, [c * a - s * b, c * b + s * a]), (-1, [c * a + s * b, s * a - c * b])] {
                let mut angles = angles.clone();
                angles[i] += sign;
                product.add((angles, *slide), values.map(|value| 0.5 * value));
            }
        }
        product
    }

    /// As a formula over positions called `names`.
    fn text(&self, names: &[&str]) -> String {
        let largest = self.0.values().flatten().fold(0.0_f64, |m, v| m.max(v.abs()));
        let mut text = String::new();
        for ((angles, slide), values) in &self.0 {
            let each = angles.iter().zip(names).filter(|(k, _)| **k != 0);
            let sum = each.map(|(k, name)| match k {
                1 => format!("+ {name} "),
                -1 => format!("- {name} "),
                k if *k < 0 => format!("- {}*{name} ", -k),
                k => format!("+ {k}*{name} "),
            });
            let sum = sum.collect::<String>();
            let sum = sum.trim_start_matches("+ ").trim_end();
            for (value, function) in values.iter().zip(["cos", "sin"]).filter(|(v, _)| v.abs() > ROUNDING * largest) {
                let _ = write!(text, "{} {:?}", if *value < 0.0 { " -" } else { " +" }, value.abs());
                if !sum.is_empty() {
                    let _ = write!(text, "*{function}({sum})");
                }
                if let Some(i) = slide {
                    let _ = write!(text, "*{}", names[*i]);
                }
            }
        }
        match text.strip_prefix(" + ") {
            _ if text.is_empty() => "0".into(),
            Some(text) => text.to_owned(),
            None => format!("0{text}"),
        }
    }
}

/// `point` turned by the angle `i` beyond its `reference` around `axis` through the origin.
fn turned(point: &Point, axis: [f64; 3], i: usize, reference: f64) -> Point {
    let (sin, cos) = reference.sin_cos();
    // cos(q − r) and sin(q − r) as parts of cos q and sin q.
    let (cosine, sine) = ((cos, sin), (-sin, cos));
    let along = Coordinate::sum(axis.into_iter().zip(point));
    std::array::from_fn(|d| {
        let (e, f) = ((d + 1) % 3, (d + 2) % 3);
        let across = Coordinate::sum([(axis[e], &point[f]), (-axis[f], &point[e])]);
        let flat = Coordinate::sum([(1.0, &point[d]), (-axis[d], &along)]);
        let (flat, across) = (flat.turned(i, cosine), across.turned(i, sine));
        Coordinate::sum([(axis[d], &along), (1.0, &flat), (1.0, &across)])
    })
}

/// `point` turned by the quaternion (w, x, y, z), then moved by `pos`.
fn placed(point: &Point, [w, x, y, z]: [f64; 4], pos: [f64; 3], n: usize) -> Point {
    let rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ];
    std::array::from_fn(|d| {
        let moved = Coordinate::number(pos[d], n);
        let turned = Coordinate::sum(rows[d].into_iter().zip(point));
        Coordinate::sum([(1.0, &turned), (1.0, &moved)])
    })
}

/// Where the point `pos` of `body` is.
fn place(tree: &Tree, mut body: usize, pos: [f64; 3], n: usize) -> anyhow::Result<Point> {
    let mut point = pos.map(|value| Coordinate::number(value, n));
    while body != 0 {
        for Joint { kind, position, pos, axis, reference, .. } in tree.joints.iter().rev().filter(|j| j.body == body) {
            let shifted = |point: &Point, by: f64| -> Point {
                std::array::from_fn(|d| Coordinate::sum([(1.0, &point[d]), (by, &Coordinate::number(pos[d], n))]))
            };
            point = match kind {
                JointKind::Hinge => shifted(&turned(&shifted(&point, -1.0), *axis, *position, *reference), 1.0),
                JointKind::Slide => std::array::from_fn(|d| {
                    let (slide, rest) = (Coordinate::slide(*position, n), Coordinate::number(*reference, n));
                    Coordinate::sum([(1.0, &point[d]), (axis[d], &slide), (-axis[d], &rest)])
                }),
                JointKind::Free | JointKind::Ball => {
                    bail!("it depends on a free or a ball joint, which is not supported")
                }
            };
        }
        let own = &tree.bodies[body];
        (point, body) = (placed(&point, own.quat, own.pos, n), own.parent);
    }
    Ok(point)
}

impl Document {
    /// The same with formulas in place of `site("NAME").x` and `body("NAME").x` (`y`, `z`) in definitions, and with the stops of joints as bounds of states that have none and begin
    /// within them. `n` is the number of positions, the first states.
    pub(super) fn placed(mut self, tree: &Tree, n: usize) -> anyhow::Result<Self> {
        let names: Vec<String> = self.state.iter().take(n).map(|state| state.name.clone()).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        for (name, text) in &mut self.definitions {
            *text = written_out(text, tree, &names).with_context(|| format!("[let] `{name}`"))?;
        }
        for joint in &tree.joints {
            let (Some(range), Some(state)) = (joint.range, self.state.get_mut(joint.position)) else { continue };
            let begins = match state.start {
                Some(StartValue::Range([low, high])) => range.0 <= low && high <= range.1,
                Some(StartValue::Normal(Normal { mean, .. })) => range.0 < mean && mean < range.1,
                None => (range.0..=range.1).contains(&joint.reference),
            };
            let alone = matches!(joint.kind, JointKind::Hinge | JointKind::Slide);
            if alone && begins && state.bounds.is_none() {
                state.bounds = Some([range.0, range.1]);
            }
        }
        Ok(self)
    }
}

/// `text` with a formula for every place in it.
fn written_out(text: &str, tree: &Tree, names: &[&str]) -> anyhow::Result<String> {
    let (mut done, mut rest) = (String::new(), text);
    while let Some((at, what)) = ["site(\"", "body(\""].into_iter().filter_map(|w| Some((rest.find(w)?, w))).min() {
        let (before, after) = (&rest[..at], &rest[at + what.len()..]);
        let parts = after.split_once("\")").and_then(|(name, after)| Some((name, after.strip_prefix('.')?)));
        let (name, after) = parts.with_context(|| format!("expected {what}NAME\").x, got `{}`", &rest[at..]))?;
        let word = after.find(|c: char| !c.is_alphanumeric() && c != '_').map_or(after, |end| &after[..end]);
        let axis = ["x", "y", "z"].iter().position(|axis| *axis == word);
        let axis = axis.with_context(|| format!("{what}{name}\") has .x, .y and .z"))?;
        let (body, pos) = if what.starts_with("site") {
            let site = tree.sites.iter().find(|site| site.name == name);
            site.map(|site| (site.body, site.pos))
                .with_context(|| unknown("site", name, tree.sites.iter().map(|s| &s.name)))?
        } else {
            let body = tree.bodies.iter().position(|body| body.name == name);
            (body.with_context(|| unknown("body", name, tree.bodies.iter().map(|b| &b.name)))?, [0.0; 3])
        };
        let point = place(tree, body, pos, names.len()).with_context(|| format!("{what}{name}\")"))?;
        let _ = write!(done, "{before}({})", point[axis].text(names));
        rest = &after[1..];
    }
    Ok(done + rest)
}

fn unknown<'a>(what: &str, name: &str, known: impl Iterator<Item = &'a String>) -> String {
    let known: Vec<&str> = known.map(String::as_str).filter(|name| !name.is_empty()).collect();
    format!(
        "the model has no {what} `{name}`; known: {}",
        if known.is_empty() { "none".into() } else { known.join(", ") }
    )
}

#[cfg(test)]
mod tests {
    use sindyna_mujoco::{Body, Site};
    use sindyna_sindy::parse;

    use super::*;

    fn body(name: &str, parent: usize, pos: [f64; 3], quat: [f64; 4]) -> Body {
        Body { name: name.into(), parent, pos, quat }
    }

    fn joint(kind: JointKind, body: usize, position: usize, axis: [f64; 3], reference: f64) -> Joint {
        Joint { kind, body, position, pos: [0.1, -0.2, 0.3], axis, reference, range: None }
    }

    /// Two links in a plane, then a slide and a hinge across it.
    fn tree() -> Tree {
        let (none, turned) = ([1.0, 0.0, 0.0, 0.0], [0.5_f64.sqrt(), 0.0, 0.5_f64.sqrt(), 0.0]);
        let joints = vec![
            Joint { pos: [0.0; 3], ..joint(JointKind::Hinge, 1, 0, [0.0, 0.0, 1.0], 0.0) },
            Joint { pos: [0.0; 3], ..joint(JointKind::Hinge, 2, 1, [0.0, 0.0, 1.0], 0.0) },
            joint(JointKind::Slide, 3, 2, [0.6, 0.8, 0.0], 0.4),
            joint(JointKind::Hinge, 3, 3, [0.0, 0.6, 0.8], 0.7),
        ];
        Tree {
            bodies: vec![
                body("world", 0, [0.0; 3], none),
                body("upper", 0, [0.0; 3], none),
                body("lower", 1, [0.12, 0.0, 0.0], none),
                body("hand", 2, [0.0, 0.5, 0.25], turned),
            ],
            joints,
            sites: vec![
                Site { name: "tip".into(), body: 2, pos: [0.1, 0.0, 0.0] },
                Site { name: "nail".into(), body: 3, pos: [0.3, 0.2, -0.1] },
            ],
        }
    }

    /// The same by matrices.
    fn by_matrices(tree: &Tree, site: &Site, q: &[f64]) -> [f64; 3] {
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let about = |v: [f64; 3], axis: [f64; 3], angle: f64| {
            let (s, c) = angle.sin_cos();
            let (along, across): (f64, _) = (axis.iter().zip(v).map(|(a, v)| a * v).sum(), cross(axis, v));
            std::array::from_fn(|d| v[d] * c + across[d] * s + axis[d] * along * (1.0 - c))
        };
        let (mut v, mut body) = (site.pos, site.body);
        while body != 0 {
            for joint in tree.joints.iter().rev().filter(|j| j.body == body) {
                let by = q[joint.position] - joint.reference;
                v = match joint.kind {
                    JointKind::Slide => std::array::from_fn(|d| v[d] + joint.axis[d] * by),
                    _ => {
                        let turned: [f64; 3] = about(std::array::from_fn(|d| v[d] - joint.pos[d]), joint.axis, by);
                        std::array::from_fn(|d| turned[d] + joint.pos[d])
                    }
                };
            }
            let own = &tree.bodies[body];
            let half = own.quat[0].acos();
            let axis =
                if half == 0.0 { [1.0, 0.0, 0.0] } else { std::array::from_fn(|d| own.quat[d + 1] / half.sin()) };
            let turned: [f64; 3] = about(v, axis, 2.0 * half);
            v = std::array::from_fn(|d| turned[d] + own.pos[d]);
            body = own.parent;
        }
        v
    }

    #[test]
    fn formulas_of_sites_are_where_the_joints_put_them() {
        let (tree, names) = (tree(), ["a", "b", "s", "w"]);
        let symbols = names.map(String::from);
        for q in [[0.3, -0.8, 0.5, 1.1], [-2.0, 0.4, -0.7, 3.0], [0.0; 4]] {
            for site in &tree.sites {
                let expected = by_matrices(&tree, site, &q);
                for (axis, expected) in "xyz".chars().zip(expected) {
                    let text = written_out(&format!("2*site(\"{}\").{axis} + 1", site.name), &tree, &names).unwrap();
                    let found = parse(&text, &symbols).unwrap().eval(&q);
                    assert!((found - (2.0 * expected + 1.0)).abs() < 1e-12, "{text}: {found}, {expected}");
                }
            }
        }
        assert_eq!(written_out("site(\"tip\").x", &tree, &names).unwrap(), "(0.12*cos(a) + 0.1*cos(a + b))");
        assert_eq!(written_out("-body(\"lower\").y", &tree, &names).unwrap(), "-(0.12*sin(a))");
    }

    /// MuJoCo 3.17.0's `site_xpos` of an arm with a joint beside its axis, on a trolley.
    #[test]
    fn formulas_of_sites_are_where_mujoco_puts_them() {
        let turned = [0.8785122060499201, 0.24479231586341083, 0.18214796572990116, 0.36758011983238364];
        let none = [1.0, 0.0, 0.0, 0.0];
        let axis = [1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0];
        let hinge =
            |body, position, axis| Joint { pos: [0.0; 3], ..joint(JointKind::Hinge, body, position, axis, 0.0) };
        let tree = Tree {
            bodies: vec![
                body("world", 0, [0.0; 3], none),
                body("trolley", 0, [0.0, 0.0, 1.0], none),
                body("arm", 1, [0.1, 0.2, 0.3], turned),
                body("hand", 2, [0.4, 0.0, 0.0], none),
            ],
            joints: vec![
                Joint { kind: JointKind::Slide, ..hinge(1, 0, [0.0, 1.0, 0.0]) },
                Joint { pos: [0.05, -0.1, 0.2], reference: 0.17453292519943295, ..hinge(2, 1, axis) },
                hinge(3, 2, [0.0, 0.0, 1.0]),
            ],
            sites: vec![Site { name: "tip".into(), body: 3, pos: [0.1, 0.2, -0.3] }],
        };
        let symbols = ["p", "a", "b"].map(String::from);
        for (q, tip) in [
            ([0.3, 0.7, -1.1], [-0.023206066046637774, 1.0303153671862049, 1.0599084747843999]),
            ([-0.5, 2.0, 0.4], [-0.3012116427829695, -0.6458207000975487, 1.6641296336724487]),
        ] {
            for (axis, expected) in "xyz".chars().zip(tip) {
                let text = written_out(&format!("site(\"tip\").{axis}"), &tree, &["p", "a", "b"]).unwrap();
                let found = parse(&text, &symbols).unwrap().eval(&q);
                assert!((found - expected).abs() < 1e-12, "{text}: {found}, {expected}");
            }
        }
    }

    #[test]
    fn places_there_are_not_are_named() {
        let mut tree = tree();
        tree.joints[1].kind = JointKind::Ball;
        for (text, says) in [
            ("site(\"top\").x", "the model has no site `top`; known: tip, nail"),
            ("body(\"foot\").z", "the model has no body `foot`; known: world, upper, lower, hand"),
            ("site(\"tip\").r", "has .x, .y and .z"),
            ("site(\"tip\")", "expected site(\"NAME\").x"),
            ("site(\"tip\").xy", "has .x, .y and .z"),
            ("site(\"tip\").x", "it depends on a free or a ball joint"),
        ] {
            let refusal = format!("{:#}", written_out(text, &tree, &["a", "b", "s", "w"]).unwrap_err());
            assert!(refusal.contains(says), "{text}: {refusal}");
        }
    }
}
