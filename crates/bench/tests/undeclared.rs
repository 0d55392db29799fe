//! The systems whose noise nobody declares are what they say, and are judged rightly.

use sindyna_bench::undeclared::{Judge, Set, System, find, generate, systems};
use sindyna_bench::{Term, summands};
use sindyna_core::Seed;

fn all() -> Vec<System> {
    [systems(Set::Reported), systems(Set::Development)].concat()
}

#[test]
fn true_equations_are_judged_right_and_any_other_wrong() -> anyhow::Result<()> {
    for system in all() {
        let (judge, truth) = (Judge::new(&system)?, system.equations()?);
        let verdict = judge.judge(&truth)?;
        assert!(verdict.right, "{}: {verdict:#?}", system.name());
        // The laboratory's constants are printed with six digits.
        assert!(verdict.coefficient_error.is_some_and(|e| e < 1e-5), "{}: {verdict:#?}", system.name());
        for i in system.judged() {
            let mut lacking = truth.clone();
            let gone = lacking[i].remove(0).label(&system.states());
            let verdict = judge.judge(&lacking)?;
            let missing: Vec<_> = verdict.equations.iter().flat_map(|e| &e.missing).collect();
            assert!(!verdict.right && missing == [&gone], "{} without {gone}: {verdict:#?}", system.name());
            let mut wider = truth.clone();
            wider[i].push(Term {
                text: "exp(0.1*".to_owned() + &system.states()[i] + ")",
                rate: None,
                coefficient: 1e-12,
                error: None,
            });
            let verdict = judge.judge(&wider)?;
            assert!(!verdict.right && verdict.equations.iter().any(|e| e.spurious.len() == 1), "{verdict:#?}");
        }
    }
    Ok(())
}

#[test]
fn names_are_unique() {
    let mut names: Vec<&str> = all().iter().map(System::name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), all().len());
}

#[test]
fn the_same_equation_in_other_words_is_right() -> anyhow::Result<()> {
    let system = find("dragged-pendulum").expect("a system for development");
    let states = system.states();
    let said = |second: &str| Ok::<_, anyhow::Error>(vec![summands("1 w", &states)?, summands(second, &states)?]);
    let judge = Judge::new(&system)?;
    assert!(judge.judge(&said("-9.81 sin(-th)*sign(-1); -0.3 abs(w)*w; 4 0.5*t")?)?.right);
    assert!(!judge.judge(&said("-9.81 sin(th); -0.1 w*abs(w); 2 t; 1e-14 1")?)?.right, "junk is junk however small");
    Ok(())
}

#[test]
fn logs_of_one_seed_differ_in_their_noise_alone() -> anyhow::Result<()> {
    for system in all() {
        let log = |noise, seed| generate(&system, 150, noise, Seed::new(seed));
        let (clean, noisy, other) = (log(0.0, 3)?, log(0.01, 3)?, log(0.0, 4)?);
        assert_eq!(clean.trajectories.iter().map(|t| t.states.nrows()).sum::<usize>(), 150);
        assert_ne!(clean.trajectories[0].states, other.trajectories[0].states);
        for (a, b) in clean.trajectories.iter().zip(&noisy.trajectories) {
            assert_eq!(a.controls, b.controls);
            assert_ne!(a.states, b.states);
        }
    }
    Ok(())
}
