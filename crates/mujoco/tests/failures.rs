//! What goes wrong is an error with a reason: nothing prints, nothing ends the process, nothing is written.

#![allow(clippy::unwrap_used, reason = "a test stops at what it cannot do")]

mod common;

use std::path::Path;
use std::process::Command;

use sindyna_core::{EnvError, Environment as _, Seed};
use sindyna_mujoco::{Library, MujocoEnvironment, MujocoError, MujocoModel, Place, Search, inverted_pendulum};

/// A ball in free fall, thrown by a motor, which `size` may leave too little memory.
fn falling(size: &str, bodies: &str) -> String {
    format!(
        r#"<mujoco>{size}<worldbody><geom type="plane" size="9 9 1"/>
        <body pos="0 0 5"><joint name="z" type="slide" axis="0 0 1"/><geom size="0.1"/></body>{bodies}
        </worldbody><actuator><motor joint="z"/></actuator></mujoco>"#
    )
}

fn refusal(loaded: Result<MujocoModel, MujocoError>) -> String {
    loaded.expect_err("the model is bad").to_string()
}

#[test]
fn bad_models_are_refused_in_mujocos_words() {
    let Some(library) = common::library() else { return };
    for (xml, words) in [
        ("", "XML"),
        ("<mujoco", "XML"),
        ("<mujoco><worldbody><bodi/></worldbody></mujoco>", "bodi"),
        ("<mujoco><actuator><motor joint='nowhere'/></actuator></mujoco>", "nowhere"),
        ("<mujoco><option timestep='quick'/></mujoco>", "timestep"),
        ("<mujoco><include file='not_there.xml'/></mujoco>", "not_there.xml"),
        ("<mujoco><worldbody><body><freejoint/></body></worldbody></mujoco>", "mass"),
        ("<mujoco><worldbody><geom size='nan'/></worldbody></mujoco>", ""),
        (&falling("<size memory='1'/>", ""), ""),
    ] {
        let message = refusal(MujocoModel::from_xml(&library, xml));
        assert!(message.starts_with("MuJoCo cannot use the model's text: "), "{message}");
        assert!(message.contains(words) && !message.contains('\n'), "{xml}: {message}");
    }
}

#[test]
fn missing_and_unreadable_files_are_named() {
    let Some(library) = common::library() else { return };
    let folder = tempfile::tempdir().unwrap();
    for path in ["no_such_model.xml", folder.path().to_str().unwrap(), "a\0b.xml"] {
        let message = refusal(MujocoModel::from_file(&library, path));
        assert!(message.starts_with(&format!("MuJoCo cannot use {path}: ")), "{message}");
    }
}

#[test]
fn models_from_a_file_find_what_lies_beside_them() {
    let Some(library) = common::library() else { return };
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("ball.xml"),
        "<mujoco><worldbody><body><freejoint/><geom size='1'/></body></worldbody></mujoco>",
    )
    .unwrap();
    std::fs::write(folder.path().join("scene.xml"), "<mujoco><include file='ball.xml'/></mujoco>").unwrap();
    let model = MujocoModel::from_file(&library, folder.path().join("scene.xml")).unwrap();
    assert_eq!((model.position_dim(), model.velocity_dim(), model.control_dim()), (7, 6, 0));
}

#[test]
fn states_and_controls_that_are_no_numbers_are_refused() {
    let Some(library) = common::library() else { return };
    let mut env = inverted_pendulum(&library).unwrap();
    let mut rng = Seed::new(0).numpy();
    env.reset(&mut rng).unwrap();
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(matches!(env.step(&[bad], &mut rng), Err(EnvError::NotAnAction { .. })));
        assert!(matches!(env.set_state(&[0.0, bad, 0.0, 0.0], &mut rng), Err(EnvError::System { .. })));
        assert!(matches!(env.reset_to(&[0.0, 0.0, 0.0, bad], &mut rng), Err(EnvError::System { .. })));
    }
    assert!(matches!(env.step(&[], &mut rng), Err(EnvError::NotAnAction { .. })));
    assert!(matches!(env.reset_to(&[0.0; 3], &mut rng), Err(EnvError::System { .. })));
    env.step(&[0.0], &mut rng).expect("refusals leave the episode as it was");
}

#[test]
fn a_simulation_that_diverges_says_where_and_can_be_reset() {
    let Some(library) = common::library() else { return };
    let model = MujocoModel::from_xml(&library, &falling("", "")).unwrap();
    let mut env = common::environment(&model, 1);
    let mut rng = Seed::new(0).numpy();
    // MuJoCo's own border is 1e10; beyond it, it would begin anew from the rest position and say nothing.
    for (state, index) in [([1e11, 0.0], 0), ([0.0, 1e11], 1)] {
        env.reset_to(&state, &mut rng).unwrap();
        let Err(EnvError::Diverged { state: diverged }) = env.step(&[0.0], &mut rng) else { panic!("it diverged") };
        assert_eq!(diverged, env.spec().state[index].name);
        assert!(env.warning().is_some_and(|w| w.contains("unstable")), "{:?}", env.warning());
        assert_eq!(env.step(&[0.0], &mut rng), Err(EnvError::NeedsReset));
    }
    env.reset(&mut rng).unwrap();
    env.step(&[0.0], &mut rng).unwrap();
}

#[test]
fn an_acceleration_without_bounds_is_a_divergence_also_in_the_first_step_and_without_a_new_beginning() {
    let Some(library) = common::library() else { return };
    for flag in ["", r#"<option><flag autoreset="disable"/></option>"#] {
        // 1e12 N on 1 kg is more than MuJoCo's border.
        let xml = format!(
            r#"<mujoco>{flag}<worldbody><body><joint type="slide"/><joint name="x" type="slide" axis="1 0 0"/>
            <geom size="0.1" mass="1"/></body></worldbody><actuator><motor joint="x" gear="1e9"/></actuator></mujoco>"#
        );
        let model = match MujocoModel::from_xml(&library, &xml) {
            Ok(model) => model,
            Err(e) => {
                assert!(e.to_string().contains("autoreset"), "the flag is as old as 3.2.1, the rest older: {e}");
                continue;
            }
        };
        for frame_skip in [1, 3] {
            let mut env = common::environment(&model, frame_skip);
            let mut rng = Seed::new(0).numpy();
            for quiet in [0, 0, 3] {
                env.reset(&mut rng).unwrap();
                for _ in 0..quiet {
                    env.step(&[0.0], &mut rng).unwrap();
                }
                let Err(EnvError::Diverged { state: diverged }) = env.step(&[1000.0], &mut rng) else {
                    panic!("it diverged")
                };
                assert_eq!(diverged, env.spec().state[3].name, "the velocity of the second joint");
            }
        }
    }
}

#[test]
fn the_time_step_is_that_of_the_model_to_the_last_bit() {
    let Some(library) = common::library() else { return };
    for timestep in [0.002_f64, 0.1, 1.0 / 3.0, 1e-5] {
        for integrator in ["Euler", "RK4", "implicit", "implicitfast"] {
            let option = format!(r#"<option timestep="{timestep:?}" integrator="{integrator}"/>"#);
            let model = MujocoModel::from_xml(&library, &falling(&option, "")).unwrap();
            assert_eq!(model.timestep().to_bits(), timestep.to_bits(), "{integrator}");
            assert_eq!(model.warning(), None);
        }
    }
}

#[test]
fn running_out_of_memory_in_a_step_is_an_error_and_not_the_end() {
    // At rest, nothing touches; pushed together, more contacts arise than a few kilobytes hold.
    let bodies: String = (0..40)
        .map(|i| format!(r#"<body pos="{i} 0 1"><freejoint/><geom type="box" size="0.2 0.2 0.2"/></body>"#))
        .collect();
    let Some(library) = common::library() else { return };
    let model = MujocoModel::from_xml(&library, &falling(r#"<size memory="256K"/>"#, &bodies)).unwrap();
    let mut env = common::environment(&model, 1);
    let mut rng = Seed::new(0).numpy();
    let mut heap = model.rest().to_vec();
    for i in 0..40 {
        heap[1 + 7 * i] = 0.01 * i as f64;
        heap[1 + 7 * i + 2] = 0.1;
    }
    let failed = env.reset_to(&heap, &mut rng).and_then(|()| env.step(&[0.0], &mut rng));
    match failed {
        Err(EnvError::System { reason }) => {
            assert!(reason.contains("memory"), "{reason}");
            assert_eq!(env.step(&[0.0], &mut rng), Err(EnvError::NeedsReset));
        }
        // Older versions leave contacts out and say so.
        _ => assert!(env.warning().is_some_and(|w| w.contains("memory")), "{failed:?}, {:?}", env.warning()),
    }

    env.reset(&mut rng).unwrap();
    env.step(&[0.0], &mut rng).unwrap();
    let mut fresh = common::environment(&model, 1);
    fresh.reset(&mut rng).unwrap();
    fresh.step(&[0.0], &mut rng).unwrap();
    assert_eq!(common::bits(env.state()), common::bits(fresh.state()), "a reset leaves nothing of the error");
}

#[test]
fn tasks_that_do_not_fit_the_model_are_refused() {
    let Some(library) = common::library() else { return };
    let ball = MujocoModel::from_xml(&library, &falling("", "")).unwrap();
    let pendulum = sindyna_envs::find("inverted-pendulum").unwrap();
    let refused = |model, frame_skip| {
        MujocoEnvironment::new(model, frame_skip, pendulum.task(), pendulum.sensors()).expect_err("it does not fit")
    };
    let message = refused(&ball, 2).to_string();
    assert_eq!(message, "the model has 2 states (positions and velocities), but task `inverted-pendulum` declares 4");

    let hinged = r#"<body><joint/><geom size="1"/></body>"#;
    let like = MujocoModel::from_xml(&library, &falling("", hinged)).unwrap();
    for frame_skip in [0, 2] {
        let message = refused(&like, frame_skip).to_string();
        assert_eq!(
            message,
            format!(
                "{frame_skip} steps of 0.002 s are not the control interval of 0.04 s \
                 that task `inverted-pendulum` declares"
            )
        );
    }
    MujocoEnvironment::new(&like, 20, pendulum.task(), pendulum.sensors()).unwrap();
}

#[test]
fn where_there_is_no_mujoco_the_message_says_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::create_dir(path("empty")).unwrap();
    std::fs::write(path("libmujoco.so.3.17.0"), "not a library").unwrap();
    let search = Search::new(vec![
        Place::File(path("missing.so")),
        Place::Folder(path("empty")),
        Place::Folder(path("nowhere")),
        Place::Folder(path("")),
        Place::VirtualEnvironment(path("empty")),
        Place::Interpreter(path("no-python")),
    ]);
    let message = Library::load(&search).expect_err("there is none").to_string();
    assert!(message.contains("pip install mujoco"), "{message}");
    assert_eq!(message.lines().count(), 7, "a line for each place:\n{message}");
    for words in ["missing.so: no such file", "nowhere: ", "libmujoco.so.3.17.0: ", "no package `mujoco`", "no-python"]
    {
        assert!(message.contains(words), "{words} in\n{message}");
    }
    let nowhere = Library::load(&Search::new(vec![])).expect_err("there is none").to_string();
    assert!(nowhere.contains("nowhere to look"), "{nowhere}");
}

/// Compiles a library that says it is a MuJoCo.
#[cfg(unix)]
fn pretend(folder: &Path, source: &str) -> std::path::PathBuf {
    let (code, library) = (folder.join("pretend.c"), folder.join("libmujoco.so"));
    std::fs::write(&code, source).unwrap();
    // Rust itself needs `cc` to link.
    let built = Command::new("cc").args(["-shared", "-fPIC", "-o"]).arg(&library).arg(&code).status();
    assert!(built.expect("cc runs").success());
    library
}

#[cfg(unix)]
#[test]
fn other_major_versions_and_strangers_are_refused() {
    let says = |version: &str| format!(r#"const char* mj_versionString(void) {{ return "{version}"; }}"#);
    for (source, words) in [
        (says("5.0.0"), "this is MuJoCo 5.0.0; the versions supported are 3.x and 4.x"),
        (says("2.3.7"), "this is MuJoCo 2.3.7; "),
        (says("34.0.0"), "this is MuJoCo 34.0.0; "),
        (says(""), "this is MuJoCo ; "),
        (says("3.99.1"), "no function `mju_user_error`"),
        ("const char* mj_versionString(void) { return 0; }".into(), "this is MuJoCo ; "),
        ("int something_else;".into(), "no function `mj_versionString`"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let file = pretend(folder.path(), &source);
        let message = Library::load(&Search::new(vec![Place::File(file)])).expect_err("it is none").to_string();
        assert!(message.contains(words), "{message}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_library_that_is_cut_short_is_refused_and_does_not_end_the_process() {
    let folder = tempfile::tempdir().unwrap();
    let file = pretend(folder.path(), "int table[100000] = {1};");
    let whole = std::fs::read(&file).unwrap();
    for kept in [whole.len() / 2, whole.len() / 10, 100, 64, 3] {
        std::fs::write(&file, &whole[..kept]).unwrap();
        let search = Search::new(vec![Place::File(file.clone())]);
        let message = Library::load(&search).expect_err("it is cut short").to_string();
        let short = message.contains(&format!("it is cut short: {kept} bytes of ")) || kept <= 100;
        assert!(short, "{kept}: {message}");
    }
}

#[test]
fn nothing_is_printed_and_no_log_is_written() {
    if common::library().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let this = std::env::current_exe().unwrap();
    let played = Command::new(this)
        .args(["--exact", "a_simulation_that_diverges_says_where_and_can_be_reset", "--nocapture"])
        .env(common::VENV, common::venv())
        .current_dir(folder.path())
        .output()
        .unwrap();
    let printed = [played.stdout, played.stderr].map(|out| String::from_utf8_lossy(&out).into_owned());
    assert!(played.status.success(), "{printed:?}");
    assert!(!printed.iter().any(|out| out.to_lowercase().contains("warning")), "{printed:?}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "MuJoCo writes no log");
}
