//! MJCF files, against MuJoCo's own dynamics.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use sindyna_bodies::{Mjcf, forces};

const CRANE: &str = include_str!("golden/crane.xml");

/// States with the forces that MuJoCo needs for them.
fn golden() -> Vec<[Vec<f64>; 4]> {
    let text: serde_json::Value = serde_json::from_str(include_str!("golden/crane.json")).unwrap();
    let list = |state: &serde_json::Value, name: &str| -> Vec<f64> {
        state[name].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
    };
    text["states"].as_array().unwrap().iter().map(|s| ["q", "v", "a", "forces"].map(|name| list(s, name))).collect()
}

#[test]
fn forces_are_those_of_mujoco() {
    let model = Mjcf::parse(CRANE).unwrap();
    assert_eq!(model.tree.len(), 5);
    for [q, v, a, expected] in golden() {
        let found = forces(&model.tree, &model.tree.parameters(), (&q, &v, &a), true);
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{found} {expected}");
        }
    }
}

#[test]
fn motors_have_the_gears_of_their_class_or_their_own() {
    let drives = Mjcf::parse(CRANE).unwrap().drives;
    let told: Vec<(&str, usize, f64)> = drives.iter().map(|d| (d.name.as_str(), d.joint, d.gear)).collect();
    assert_eq!(told, [("mx", 0, 20.0), ("myaw", 2, 2.0)]);
}

#[test]
fn what_is_written_is_what_is_read_again() {
    let model = Mjcf::parse(CRANE).unwrap();
    let mut parameters = model.tree.parameters();
    let n = model.tree.len();
    // Heavier loads, more friction.
    (0..n)
        .filter(|i| !model.tree.joints[*i].is_massless)
        .for_each(|i| parameters[10 * i..10 * i + 10].iter_mut().for_each(|p| *p *= 1.5));
    parameters[10 * n..].iter_mut().enumerate().for_each(|(i, p)| *p = 0.01 * (1.0 + i as f64));
    let again = Mjcf::parse(&model.with_parameters(&parameters).unwrap()).unwrap();
    for [q, v, a, _] in golden() {
        let of = |tree, parameters: &[f64]| forces(tree, parameters, (&q, &v, &a), true);
        let (one, other) = (of(&model.tree, &parameters), of(&again.tree, &again.tree.parameters()));
        assert!(one.iter().zip(&other).all(|(a, b)| (a - b).abs() < 1e-7 * (1.0 + a.abs())), "{one:?} {other:?}");
    }
}

#[test]
fn what_the_equations_do_not_have_is_refused() {
    let refused = |from: &str, to: &str, expected: &str| {
        let told = Mjcf::parse(&CRANE.replace(from, to)).unwrap_err().to_string();
        assert!(told.contains(expected), "{told}");
    };
    refused("name=\"swing\"", "name=\"swing\" type=\"ball\"", "the joint `swing` is `ball`");
    refused("name=\"swing\"", "name=\"swing\" stiffness=\"2\"", "the spring of the joint `swing` is not supported");
    refused(
        "<motor name=\"mx\" joint=\"x\"/>",
        "<position name=\"mx\" joint=\"x\"/>",
        "the actuator `mx`, which is no motor of a joint",
    );
    refused("<worldbody>", "<worldbody><include file=\"x.xml\"/>", "<include> is not supported");
    refused("mass=\"3\"", "mass=\"heavy\"", "mass of `trolley`: `heavy` is not 1 finite number");
    refused(
        "</worldbody>",
        &("<body>".repeat(100_000) + &"</body>".repeat(100_000) + "</worldbody>"),
        "more than 200 elements inside each other",
    );
    refused("<mujoco model=\"crane\">", "<mujoco model=\"crane\"", "no XML");
}
