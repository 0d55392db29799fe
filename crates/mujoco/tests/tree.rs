//! Bodies, joints and sites as MuJoCo itself tells them, the same in every version.

#![allow(clippy::unwrap_used, reason = "a test stops at what it cannot do")]
#![allow(clippy::float_cmp, reason = "numbers are told with every digit")]

mod common;

use sindyna_mujoco::{JointKind, MujocoModel, Tree};

#[test]
fn a_model_tells_what_stands_where() {
    let Some(library) = common::library() else { return };
    let xml = r#"<mujoco>
      <compiler angle="radian"/>
      <default><joint range="-0.5 0.25"/></default>
      <worldbody>
        <site name="ground" pos="1 2 3"/>
        <body name="a body" pos="0.1 0.2 0.3" quat="0 1 0 0">
          <joint type="slide" axis="0 3 4" ref="0.7" limited="false"/>
          <joint name="hinge" pos="0 0 0.125" axis="1 0 0" limited="true"/>
          <geom size="0.1"/>
          <body pos="0 0 1"><joint type="ball" limited="false"/><geom size="0.1"/><site name="top" pos="0 0 0.5"/></body>
        </body>
      </worldbody>
    </mujoco>"#;
    let tree = Tree::of(&MujocoModel::from_xml(&library, xml).unwrap()).unwrap();
    let bodies: Vec<_> = tree.bodies.iter().map(|b| (b.name.as_str(), b.parent, b.pos)).collect();
    assert_eq!(bodies, [("world", 0, [0.0; 3]), ("a body", 0, [0.1, 0.2, 0.3]), ("", 1, [0.0, 0.0, 1.0])]);
    assert_eq!(tree.bodies[1].quat, [0.0, 1.0, 0.0, 0.0]);
    let joints: Vec<_> = tree.joints.iter().map(|j| (j.kind, j.body, j.position, j.reference, j.range)).collect();
    let expected = [
        (JointKind::Slide, 1, 0, 0.7, None),
        (JointKind::Hinge, 1, 1, 0.0, Some((-0.5, 0.25))),
        (JointKind::Ball, 2, 2, 1.0, None),
    ];
    assert_eq!(joints, expected);
    let length = tree.joints[0].axis.iter().map(|v| v * v).sum::<f64>();
    assert!((length - 1.0).abs() < 1e-12 && (tree.joints[0].axis[1] - 0.6).abs() < 1e-12);
    assert_eq!(tree.joints[1].pos, [0.0, 0.0, 0.125]);
    let sites: Vec<_> = tree.sites.iter().map(|s| (s.name.as_str(), s.body, s.pos)).collect();
    assert_eq!(sites, [("ground", 0, [1.0, 2.0, 3.0]), ("top", 2, [0.0, 0.0, 0.5])]);
}
