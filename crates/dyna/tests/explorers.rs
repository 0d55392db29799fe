//! What every explorer promises, and what each is for.

#![allow(clippy::unwrap_used, clippy::float_cmp, reason = "a test may panic, and asks for exact actions")]

use ndarray::array;
use sindyna_core::{Channel, Dataset, End, Explorer, Kind, Precision, Seed, Space, Spec};
use sindyna_dyna::{Alternating, Swings, Uniform};

fn spec(action_space: Space) -> Spec {
    let k = action_space.control_dim();
    Spec {
        name: "any".into(),
        state: vec![Channel::new("x", "m", Kind::Plain, 1.0)],
        observation: vec![Channel::new("x", "m", Kind::Plain, 1.0)],
        control: (0..k).map(|i| Channel::new(&format!("u{i}"), "N", Kind::Plain, 1.0)).collect(),
        action_space,
        precision: Precision::F64,
        noise: 0.0,
        dt: 0.1,
    }
}

/// Two inputs, the second not around zero.
fn pushes() -> Spec {
    spec(Space::Box { low: vec![-2.0, 1.0], high: vec![2.0, 5.0] })
}

fn numbered(n: usize) -> Spec {
    let controls = [array![[0.0]], array![[-1.0], [1.0]], array![[-1.0], [0.0], [1.0]]];
    spec(Space::Discrete { controls: controls[n - 1].clone() })
}

fn actions(explorer: &mut dyn Explorer, spec: &Spec, seed: u64, steps: usize) -> Vec<Vec<f64>> {
    let data = Dataset::new(1, spec.control_dim(), spec.action_space.action_dim(), spec.dt);
    let mut rng = Seed::new(seed).numpy();
    let mut action = vec![0.0; spec.action_space.action_dim()];
    let step = |_| {
        explorer.next(&data, &mut rng, &mut action);
        action.clone()
    };
    (0..steps).map(step).collect()
}

#[test]
fn actions_are_the_spaces_and_follow_from_the_seed() {
    for spec in [pushes(), numbered(1), numbered(2), numbered(3)] {
        let makes: [&dyn Fn() -> Box<dyn Explorer>; 3] =
            [&|| Box::new(Uniform::new(&spec)), &|| Box::new(Alternating::new(&spec, 0.2)), &|| {
                Box::new(Swings::new(&spec))
            }];
        for make in makes {
            let first = actions(&mut *make(), &spec, 1, 500);
            assert_eq!(first, actions(&mut *make(), &spec, 1, 500));
            for action in &first {
                let mut control = vec![0.0; spec.control_dim()];
                assert!(spec.action_space.control_into(action, &mut control), "{action:?}");
                if let Space::Box { .. } = spec.action_space {
                    assert_eq!(control, *action, "nothing had to be clipped");
                }
            }
            if !matches!(&spec.action_space, Space::Discrete { controls } if controls.nrows() == 1) {
                assert_ne!(first, actions(&mut *make(), &spec, 2, 500));
            }
        }
    }
}

/// On which side of the middle each step was, as lengths of the stretches on one side; the last one is cut off.
fn stretches(values: impl Iterator<Item = f64>) -> Vec<usize> {
    let values: Vec<f64> = values.collect();
    let mut lengths: Vec<_> = values.chunk_by(|a, b| (*a > 0.0) == (*b > 0.0)).map(<[f64]>::len).collect();
    lengths.pop();
    lengths
}

#[test]
fn swings_stay_six_to_eight_steps_on_a_side_with_a_new_size_at_every_step() {
    let spec = pushes();
    let taken = actions(&mut Swings::new(&spec), &spec, 5, 4000);
    for (column, middle) in [(0, 0.0), (1, 3.0)] {
        let pushes = || taken.iter().map(|a| a[column] - middle);
        let lengths = stretches(pushes());
        for length in 6..=8 {
            let share = lengths.iter().filter(|l| **l == length).count() as f64 / lengths.len() as f64;
            assert!((share - 1.0 / 3.0).abs() < 0.07, "{length} steps: {share}");
        }
        assert!(lengths.iter().all(|l| (6..=8).contains(l)), "{lengths:?}");
        assert!(pushes().all(|u| (1.0..=2.0).contains(&u.abs())), "half to all of the way to the bound");
        assert!(pushes().zip(pushes().skip(1)).all(|(a, b)| a != b), "sizes are redrawn");
    }
    let together = taken.iter().filter(|a| a[0] * (a[1] - 3.0) > 0.0).count() as f64 / 4000.0;
    assert!((together - 0.5).abs() < 0.1, "inputs keep their own time: {together}");
}

#[test]
fn swings_of_numbered_actions_go_from_the_first_to_the_last() {
    let spec = numbered(3);
    let taken = actions(&mut Swings::new(&spec), &spec, 5, 400);
    assert!(taken.iter().all(|a| a[0] == 0.0 || a[0] == 2.0));
    let lengths = stretches(taken.iter().map(|a| a[0] - 1.0));
    // The first one is short, so that even a few steps hold both pushes.
    assert!((3..=5).contains(&lengths[0]), "{lengths:?}");
    assert!(lengths[1..].iter().all(|l| (6..=8).contains(l)), "{lengths:?}");
}

#[test]
fn swings_alternate_once_the_system_has_fallen() {
    let spec = pushes();
    let mut data = Dataset::new(1, 2, 2, spec.dt);
    let (mut rng, mut action) = (Seed::new(5).numpy(), vec![0.0; 2]);
    let mut explorer = Swings::new(&spec);
    let mut push = |data: &Dataset| {
        explorer.next(data, &mut rng, &mut action);
        action[0]
    };
    data.begin(&[0.0]).unwrap();
    let first = push(&data);
    data.push(&[first, 3.0], &[first, 3.0], 0.0, &[0.0]).unwrap();
    data.finish(End::Terminated);
    let sides: Vec<f64> = (0..50).map(|_| push(&data)).collect();
    assert!(first * sides[0] < 0.0 && sides.windows(2).all(|u| u[0] * u[1] < 0.0), "{sides:?}");
}

#[test]
fn alternating_pushes_change_sides_with_every_step() {
    let spec = pushes();
    let taken = actions(&mut Alternating::new(&spec, 0.0), &spec, 5, 100);
    assert!(taken.windows(2).all(|a| a[0][0] * a[1][0] <= 0.0));
}
