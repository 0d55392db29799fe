//! A run that goes on from a checkpoint ends as the one that was never stopped.

mod common;

use common::{Doubting, EXACT, Line, Push, Silent, Student, auto};
use sindyna_core::{Seed, Sensors, Simulated};
use sindyna_dyna::{Dyna, DynaError, Learned, Loop, Phase, Schedule, Swings};

/// All that a run is made of but its loop.
struct Lab {
    task: Line,
    sensors: Sensors,
    learner: Doubting,
    schedule: Schedule,
}

impl Lab {
    fn new() -> Self {
        let task = Line::new(20);
        let sensors = Sensors::new(&task.0).expect("the observation names the state");
        // The model is wrong and doubted: data are collected twice, episodes do not confirm, agents begin anew.
        let learner = Doubting { model: Push { gain: 0.5, ..EXACT }, enough: 1000 };
        let mut schedule = auto();
        schedule.optimality.max_updates = 150;
        Self { task, sensors, learner, schedule }
    }

    fn dyna(&self) -> Dyna<'_, Doubting> {
        let Self { task, sensors, learner, schedule } = self;
        Dyna { task, sensors, learner, schedule, seed: Seed::new(4) }
    }

    fn student() -> Box<Student> {
        Box::new(Student { eager: true, ..Student::default() })
    }

    /// Advances `begun` by so many steps, or to its end.
    fn go(&self, begun: &mut Loop<'_, Doubting>, explorer: &mut Swings, steps: usize) {
        let mut real = Simulated::new(EXACT, &self.task, self.sensors.clone());
        for _ in 0..steps {
            if begun.has_ended() {
                return;
            }
            begun.advance(&mut real, explorer, &mut Silent, &|| false).expect("nothing fails here");
        }
    }
}

/// All that is left of a run, bit by bit.
fn all_of(learned: Learned<Push>) -> String {
    let Learned { data, model_return, prediction, confirmation, updates, model_steps, policy, .. } = learned;
    let policy = policy.map(|p| p.to_bytes());
    format!("{data:?} {model_return:?} {prediction:?} {confirmation:?} {updates} {model_steps} {policy:?}")
}

#[test]
fn wherever_it_was_saved_a_run_ends_the_same() {
    let lab = Lab::new();
    let dyna = lab.dyna();
    let mut explorer = Swings::new(&lab.task.0);
    let (mut whole, mut saved) = (dyna.begin(Lab::student()).expect("a usable schedule"), Vec::new());
    let mut phases = Vec::new();
    while !whole.has_ended() {
        phases.push(whole.phase());
        saved.extend(whole.save(&explorer));
        lab.go(&mut whole, &mut explorer, 1);
    }
    assert!(whole.save(&explorer).is_none(), "there is nothing to go on with");
    let whole = all_of(whole.finish());
    let count = |wanted: Phase| phases.iter().filter(|phase| **phase == wanted).count();
    let seen = [Phase::Fit, Phase::CollectMore, Phase::Confirm].map(count);
    assert!(seen[0] > 3 && seen[1] == 1 && seen[2] > 3, "all that a run can do was done: {seen:?}");
    for (at, saved) in saved.iter().enumerate() {
        let mut explorer = Swings::new(&lab.task.0);
        let mut resumed = dyna.resume(Lab::student(), &mut explorer, saved).expect("it was saved");
        assert_eq!(resumed.save(&explorer).as_ref(), Some(saved), "step {at}");
        lab.go(&mut resumed, &mut explorer, usize::MAX);
        assert_eq!(all_of(resumed.finish()), whole, "step {at}");
    }
}

#[test]
fn what_is_no_checkpoint_of_such_a_run_is_refused() {
    let lab = Lab::new();
    let dyna = lab.dyna();
    let mut explorer = Swings::new(&lab.task.0);
    let mut begun = dyna.begin(Lab::student()).expect("a usable schedule");
    lab.go(&mut begun, &mut explorer, 20);
    let saved = begun.save(&explorer).expect("it has not ended");
    let other = Schedule { replay_capacity: 7, ..lab.schedule.clone() };
    let refused = |dyna: &Dyna<'_, Doubting>, saved: &[u8]| {
        let told = dyna.resume(Lab::student(), &mut Swings::new(&lab.task.0), saved);
        matches!(told.err(), Some(DynaError::Checkpoint(_)))
    };
    assert!(!refused(&dyna, &saved));
    assert!(refused(&Dyna { schedule: &other, ..lab.dyna() }, &saved), "its replay has another size");
    for length in (0..saved.len()).step_by(saved.len() / 50) {
        assert!(refused(&dyna, &saved[..length]), "{length} of {} bytes", saved.len());
    }
    // Whatever was changed, it is refused or goes on; nothing panics.
    for at in (0..saved.len()).step_by(saved.len() / 500) {
        let mut changed = saved.clone();
        changed[at] ^= 0xff;
        let resumed = dyna.resume(Lab::student(), &mut Swings::new(&lab.task.0), &changed);
        assert!(resumed.is_ok() || matches!(resumed.err(), Some(DynaError::Checkpoint(_))), "byte {at}");
    }
}
