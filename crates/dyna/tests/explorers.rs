//! What every explorer promises, and what each is for.

use ndarray::array;
use sindyna_core::{Channel, Dataset, Explorer, Kind, Precision, Seed, Space, Spec};
use sindyna_dyna::{Alternating, Levels, Uniform};

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
        max_steps: 10,
        solved_at: None,
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

/// Lengths of the stretches over which `values` stay the same, the last one cut off.
fn holds(values: &[f64]) -> Vec<usize> {
    let mut lengths: Vec<_> = values.chunk_by(|a, b| a == b).map(<[f64]>::len).collect();
    lengths.pop();
    lengths
}

#[test]
fn actions_are_the_spaces_and_follow_from_the_seed() {
    for spec in [pushes(), numbered(1), numbered(2), numbered(3)] {
        let makes: [&dyn Fn() -> Box<dyn Explorer>; 3] =
            [&|| Box::new(Uniform::new(&spec)), &|| Box::new(Alternating::new(&spec, 0.2)), &|| {
                Box::new(Levels::new(&spec))
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

#[test]
fn held_pushes_last_one_to_four_steps_and_change_sides() {
    let spec = pushes();
    let taken = actions(&mut Levels::new(&spec), &spec, 5, 4000);
    let columns: [Vec<f64>; 2] = [0, 1].map(|i| taken.iter().map(|a| a[i]).collect());
    for (column, middle) in columns.iter().zip([0.0, 3.0]) {
        let lengths = holds(column);
        for length in 1..=4 {
            let share = lengths.iter().filter(|l| **l == length).count() as f64 / lengths.len() as f64;
            assert!((share - 0.25).abs() < 0.05, "{length} steps: {share}");
        }
        assert!(lengths.iter().all(|l| *l <= 4));
        let levels: Vec<f64> = column.chunk_by(|a, b| a == b).map(|held| held[0] - middle).collect();
        assert!(levels.windows(2).all(|l| l[0] * l[1] < 0.0), "sides alternate");
        assert!(levels.iter().all(|l| (0.6..=2.0).contains(&l.abs())), "0.3 to 1 of the bound");
        let mean = levels.iter().map(|l| l.abs()).sum::<f64>() / levels.len() as f64;
        assert!((mean - 1.3).abs() < 0.05, "{mean}");
    }
    let together = taken.iter().filter(|a| a[0] * (a[1] - 3.0) > 0.0).count() as f64 / 4000.0;
    assert!((together - 0.5).abs() < 0.1, "inputs keep their own time: {together}");
}

#[test]
fn held_numbered_actions_go_to_any_other() {
    let spec = numbered(3);
    let taken: Vec<f64> = actions(&mut Levels::new(&spec), &spec, 5, 4000).into_iter().flatten().collect();
    // Every change is to another action, so that holds are seen in full.
    assert!(holds(&taken).iter().all(|l| *l <= 4));
    let changes: Vec<_> = taken.windows(2).filter(|a| a[0] != a[1]).map(|a| (a[0] as u8, a[1] as u8)).collect();
    for change in [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)] {
        let share = changes.iter().filter(|c| **c == change).count() as f64 / changes.len() as f64;
        assert!((share - 1.0 / 6.0).abs() < 0.03, "{change:?}: {share}");
    }
}

#[test]
fn alternating_pushes_change_sides_with_every_step() {
    let spec = pushes();
    let taken = actions(&mut Alternating::new(&spec, 0.0), &spec, 5, 100);
    assert!(taken.windows(2).all(|a| a[0][0] * a[1][0] <= 0.0));
}
