//! Parameters of robots that are known.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64;
use sindyna_bodies::nalgebra::DMatrix;
use sindyna_bodies::{Motion, Tree, Urdf, calibrate, forces, inverse_dynamics, momenta, simulated};

/// An arm in space: a hinge about z, one about an oblique axis, a slide, a hinge, with a tool fixed to the last link.
const ARM: &str = r#"<?xml version="1.0"?>
<robot name="arm">
  <link name="base"/>
  <link name="shoulder">
    <inertial><origin xyz="0.02 -0.01 0.1" rpy="0 0 0.3"/><mass value="2.1"/>
      <inertia ixx="0.03" ixy="0.001" ixz="0" iyy="0.028" iyz="0.002" izz="0.011"/></inertial>
  </link>
  <link name="upper">
    <inertial><origin xyz="0.2 0.01 -0.02"/><mass value="1.4"/>
      <inertia ixx="0.004" ixy="0" ixz="0.001" iyy="0.021" iyz="0" izz="0.022"/></inertial>
  </link>
  <link name="boom">
    <inertial><origin xyz="0 0.02 0.15"/><mass value="0.8"/><inertia ixx="0.009" ixy="0" ixz="0" iyy="0.0095" iyz="0" izz="0.0012"/></inertial>
  </link>
  <link name="wrist"><inertial><origin xyz="0.03 0 0.01"/><mass value="0.3"/><inertia ixx="0.0004" ixy="0" ixz="0" iyy="0.0005" iyz="0" izz="0.0006"/></inertial></link>
  <link name="tool"><inertial><mass value="0.1"/><inertia ixx="0.0001" ixy="0" ixz="0" iyy="0.0001" iyz="0" izz="0.0001"/></inertial></link>
  <joint name="turn" type="revolute"><parent link="base"/><child link="shoulder"/><origin xyz="0 0 0.2"/><axis xyz="0 0 1"/><dynamics damping="0.3" friction="0.2"/></joint>
  <joint name="lift" type="continuous"><parent link="shoulder"/><child link="upper"/><origin xyz="0.05 0 0.15" rpy="0.2 0 0.1"/><axis xyz="0 1 0.2"/><dynamics damping="0.2"/></joint>
  <joint name="reach" type="prismatic"><parent link="upper"/><child link="boom"/><origin xyz="0.3 0 0" rpy="0 1.2 0"/><axis xyz="0 0 1"/><dynamics damping="4"/></joint>
  <joint name="roll" type="revolute"><parent link="boom"/><child link="wrist"/><origin xyz="0 0 0.2"/><axis xyz="1 0 0"/><dynamics damping="0.02"/></joint>
  <joint name="flange" type="fixed"><parent link="wrist"/><child link="tool"/><origin xyz="0.05 0 0.02" rpy="0.4 0 0"/></joint>
</robot>
"#;

fn random(rng: &mut Pcg64, n: usize, scale: f64) -> Vec<f64> {
    (0..n).map(|_| scale * (2.0 * rng.random::<f64>() - 1.0)).collect()
}

/// The sum of twelve uniform numbers, each of variance 1/3, has a deviation of 2.
fn normal(rng: &mut Pcg64) -> f64 {
    0.5 * random(rng, 12, 1.0).iter().sum::<f64>()
}

/// A recorded motion of `tree` with the `parameters` under forces that are held, drawn anew every 20 samples, and noise of the part `noise` of each spread.
fn motion(tree: &Tree, parameters: &[f64], (steps, dt, noise): (usize, f64, f64), seed: u64) -> Motion {
    let (n, mut rng) = (tree.len(), Pcg64::seed_from_u64(seed));
    let mut still = Motion {
        times: (0..=steps).map(|t| dt * t as f64).collect(),
        positions: DMatrix::zeros(steps + 1, n),
        rates: DMatrix::zeros(steps + 1, n),
        forces: DMatrix::zeros(steps, n),
        accelerations: None,
    };
    // Around what holds the robot, with a spring that brings it back.
    let rest = [0.3, -0.4, 0.1, 0.5];
    let strength = [6.0, 10.0, 12.0, 0.6];
    let mut x: Vec<f64> = rest.iter().copied().chain(vec![0.0; n]).collect();
    let mut push = vec![0.0; n];
    for t in 0..steps {
        if t % 20 == 0 {
            push = random(&mut rng, n, 1.0);
        }
        let none = vec![0.0; n];
        let heavy = forces(tree, parameters, (&x[..n], &none, &none), true);
        for i in 0..n {
            still.positions[(t, i)] = x[i];
            still.rates[(t, i)] = x[n + i];
            still.forces[(t, i)] = heavy[i] + strength[i] * (push[i] - (x[i] - rest[i]) - 0.2 * x[n + i]);
        }
        let step = simulated(tree, parameters, &still.part(t, t + 1)).unwrap();
        x = step.row(1).iter().copied().collect();
    }
    for i in 0..n {
        (still.positions[(steps, i)], still.rates[(steps, i)]) = (x[i], x[n + i]);
    }
    for of in [&mut still.positions, &mut still.rates] {
        for mut column in of.column_iter_mut() {
            let (mean, count) = (column.mean(), column.len() as f64);
            let spread = (column.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt();
            column.iter_mut().for_each(|v| *v += noise * spread * normal(&mut rng));
        }
    }
    still
}

#[test]
fn forces_and_momenta_are_those_of_one_lagrangian() {
    let tree = Urdf::parse(ARM).unwrap().tree;
    let (n, mut rng) = (tree.len(), Pcg64::seed_from_u64(1));
    let parameters = tree.parameters();
    let column = DMatrix::from_column_slice(parameters.len(), 1, &parameters);
    for _ in 0..20 {
        let (q, v, a) = (random(&mut rng, n, 2.0), random(&mut rng, n, 3.0), random(&mut rng, n, 5.0));
        let direct = forces(&tree, &parameters, (&q, &v, &a), true);
        let by_regressor = inverse_dynamics(&tree, &q, &v, &a) * &column;
        // d/dt p − F along q(t) with these derivatives.
        let h = 1e-5;
        let at = |s: f64| {
            let along = |i: usize| q[i] + s * v[i] + 0.5 * s * s * a[i];
            let q: Vec<f64> = (0..n).map(along).collect();
            let v: Vec<f64> = (0..n).map(|i| v[i] + s * a[i]).collect();
            momenta(&tree, &q, &v)
        };
        let left = ((at(h).0 - at(-h).0) / (2.0 * h) - at(0.0).1) * &column;
        for i in 0..n {
            assert!((direct[i] - by_regressor[i]).abs() < 1e-10, "{direct:?} {by_regressor}");
            assert!((direct[i] - left[i]).abs() < 1e-5 * (1.0 + direct[i].abs()), "{direct:?} {left}");
        }
    }
}

#[test]
fn energy_is_kept_without_friction_and_forces() {
    let tree = Urdf::parse(ARM).unwrap().tree;
    let n = tree.len();
    let mut parameters = tree.parameters();
    parameters[11 * n..].fill(0.0);
    let steps = 200;
    let still = Motion {
        times: (0..=steps).map(|t| 0.002 * t as f64).collect(),
        positions: DMatrix::from_fn(steps + 1, n, |_, i| [0.3, -0.4, 0.1, 0.5][i]),
        rates: DMatrix::from_fn(steps + 1, n, |_, i| [1.0, 0.5, -0.2, 2.0][i]),
        forces: DMatrix::zeros(steps, n),
        accelerations: None,
    };
    let x = simulated(&tree, &parameters, &still).unwrap();
    let column = DMatrix::from_column_slice(parameters.len(), 1, &parameters);
    let split = |t: usize| {
        (x.row(t).iter().take(n).copied().collect::<Vec<f64>>(), x.row(t).iter().skip(n).copied().collect::<Vec<f64>>())
    };
    let kinetic = |t: usize| {
        let (q, v) = split(t);
        0.5 * (momenta(&tree, &q, &v).0 * &column).iter().zip(&v).map(|(p, v)| p * v).sum::<f64>()
    };
    // The work of gravity, by the trapezoidal rule along the way.
    let power = |t: usize| {
        let (q, v) = split(t);
        let none = vec![0.0; n];
        forces(&tree, &parameters, (&q, &none, &none), true).iter().zip(&v).map(|(g, v)| -g * v).sum::<f64>()
    };
    let work: f64 = (0..steps).map(|t| 0.001 * (power(t) + power(t + 1))).sum();
    assert!((kinetic(steps) - kinetic(0) - work).abs() < 1e-4, "{} {} {work}", kinetic(steps), kinetic(0));
}

#[test]
fn base_parameters_of_a_planar_arm_are_the_textbook_ones() {
    let link = |name: &str| format!(r#"<link name="{name}"/>"#);
    let joint = |name: &str, parent: &str, child: &str, x: f64| {
        format!(
            r#"<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/><origin xyz="{x} 0 0" rpy="{} 0 0"/><axis xyz="0 0 1"/></joint>"#,
            if x == 0.0 { std::f64::consts::FRAC_PI_2 } else { 0.0 }
        )
    };
    let text = format!(
        "<robot>{}{}{}{}{}</robot>",
        link("a"),
        link("b"),
        link("c"),
        joint("one", "a", "b", 0.0),
        joint("two", "b", "c", 0.5)
    );
    let tree = Urdf::parse(&text).unwrap().tree;
    let base = sindyna_bodies::Base::of(&tree);
    let told: Vec<String> = (0..base.len()).map(|i| base.told(i, &tree.names())).collect();
    let expected = [
        "mx(b) + 0.5 m(c)",
        "my(b)",
        "Izz(b) + 0.25 m(c) + armature(one)",
        "mx(c)",
        "my(c)",
        "Izz(c)",
        "armature(two)",
        "damping(one)",
        "damping(two)",
        "friction(one)",
        "friction(two)",
    ];
    assert_eq!(told, expected);
}

#[test]
fn what_no_motion_moves_is_no_base_parameter() {
    let link = |name: &str| format!(r#"<link name="{name}"/>"#);
    let joint = |name: &str, (parent, child): (&str, &str), (xyz, axis): (&str, &str)| {
        format!(
            r#"<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/><origin xyz="{xyz}"/><axis xyz="{axis}"/></joint>"#
        )
    };
    // The shoulder turns in a plane with the axis of the waist: the first moment of its body across that plane moves nothing.
    for place in ["0.1 0 0.2", "0.07 0 0.31", "0.05 0 0.25", "0 0 0.2"] {
        let text = format!(
            "<robot>{}{}{}{}{}</robot>",
            link("a"),
            link("b"),
            link("c"),
            joint("waist", ("a", "b"), ("0 0 0.15", "0 0 1")),
            joint("shoulder", ("b", "c"), (place, "0 1 0")),
        );
        let tree = Urdf::parse(&text).unwrap().tree;
        let base = sindyna_bodies::Base::of(&tree);
        let told: Vec<String> = (0..base.len()).map(|i| base.told(i, &tree.names())).collect();
        assert!(!told.iter().any(|t| t.starts_with("my(c)")), "{place} {told:?}");
        assert_eq!(told.iter().filter(|t| t.starts_with("mx(c)") || t.starts_with("mz(c)")).count(), 2, "{told:?}");
    }
}

#[test]
fn an_arm_in_space_is_found_from_clean_and_from_noisy_motions() {
    let urdf = Urdf::parse(ARM).unwrap();
    let tree = &urdf.tree;
    let truth = tree.parameters();
    // Nobody knows the parameters: the file that is given has others.
    let given = ["2.1", "1.4", "0.8", "0.3"]
        .iter()
        .fold(ARM.to_owned(), |text, mass| text.replace(&format!("mass value=\"{mass}\""), "mass value=\"1\""));
    let given = Urdf::parse(&given.replace("damping=\"0.3\" friction=\"0.2\"", "damping=\"0\"")).unwrap();
    for (noise, steps, bound) in [(0.0, 1000, 2e-4), (0.01, 1600, 0.1)] {
        let found = calibrate(&given.tree, &[motion(tree, &truth, (steps, 0.005, noise), 7)], &|| true).unwrap();
        let expected = found.base.values(&truth);
        let of = |values: &[f64]| {
            let (q, v, a) = ([0.5, 0.8, -0.1, -1.0], [1.0, -1.0, 0.2, 2.0], [3.0, 2.0, -1.0, 5.0]);
            forces(tree, values, (&q, &v, &a), true)
        };
        for (found, expected) in of(&found.parameters).iter().zip(of(&truth)) {
            assert!((found - expected).abs() < bound * (1.0 + expected.abs()), "{noise}: {found} {expected}");
        }
        assert_eq!(found.undetermined, 0);
        let covered = (0..expected.len())
            .filter(|&i| (found.values[i] - expected[i]).abs() < 3.0 * found.errors[i] + 1e-4)
            .count();
        assert!(10 * covered >= 8 * expected.len(), "{covered} of {}", expected.len());
        let written = given.with_parameters(&found.parameters).unwrap();
        let again = Urdf::parse(&written).unwrap().tree;
        assert!(again.joints.iter().all(|j| j.inertia.is_consistent()), "{written}");
        for (one, other) in of(&found.parameters).iter().zip(of(&again.parameters())) {
            assert!(
                (one - other).abs() < 1e-2 * (1.0 + one.abs()),
                "what is written differs by the armature alone: {one} {other}"
            );
        }
    }
}

#[test]
fn what_is_no_tree_of_hinges_and_slides_is_refused() {
    let refused = |text: &str, expected: &str| {
        let told = Urdf::parse(text).unwrap_err().to_string();
        assert!(told.contains(expected), "{told}");
    };
    refused("<robot", "no XML");
    refused("<sdf/>", "<sdf>, not <robot>");
    refused("<robot><link name='a'/></robot>", "no joint moves");
    refused(&ARM.replace("continuous", "floating"), "the joint `lift` is `floating`");
    refused(&ARM.replace("<child link=\"upper\"/>", "<child link=\"elbow\"/>"), "names the link `elbow`");
    refused(&ARM.replace("<parent link=\"base\"/>", "<parent link=\"wrist\"/>"), "joints form a circle");
    refused(&ARM.replace("axis xyz=\"1 0 0\"", "axis xyz=\"0 0 0\""), "the axis of the joint `roll`");
    let chain: String = (0..3000)
        .map(|i| {
            let links = format!("<parent link='l{i}'/><child link='l{}'/>", i + 1);
            format!("<link name='l{}'/><joint name='j{i}' type='revolute'>{links}</joint>", i + 1)
        })
        .collect();
    refused(&format!("<robot><link name='l0'/>{chain}</robot>"), "a robot with more than 200 links");
    refused(&ARM.replace("mass value=\"0.8\"", "mass value=\"nan\""), "`nan` is not 1 finite number");
}
