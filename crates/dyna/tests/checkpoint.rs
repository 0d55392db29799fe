//! A run that goes on from a checkpoint ends as the one that was never stopped.

mod common;

use common::{Doubting, EXACT, Line, Push, Silent, Student, Undecided, auto};
use sindyna_core::{DynamicsLearner, Seed, Sensors, Simulated};
use sindyna_dyna::{Dyna, DynaError, Learned, Loop, Phase, Schedule, Swings};

/// All that a run is made of but its loop.
struct Lab<L> {
    task: Line,
    sensors: Sensors,
    learner: L,
    schedule: Schedule,
}

impl Lab<Doubting> {
    fn new() -> Self {
        // The model is wrong and doubted: data are collected twice, episodes do not confirm, agents begin anew.
        Self::of(Doubting { model: Push { gain: 0.5, ..EXACT }, enough: 1000 }, auto())
    }
}

impl<L: DynamicsLearner> Lab<L> {
    fn of(learner: L, mut schedule: Schedule) -> Self {
        let task = Line::new(20);
        let sensors = Sensors::new(&task.0).expect("the observation names the state");
        schedule.optimality.max_updates = 400;
        Self { task, sensors, learner, schedule }
    }

    fn dyna(&self) -> Dyna<'_, L> {
        let Self { task, sensors, learner, schedule } = self;
        Dyna { task, sensors, learner, schedule, seed: Seed::new(4) }
    }

    fn student() -> Box<Student> {
        Box::new(Student { eager: true, ..Student::default() })
    }

    /// Advances `begun` by so many steps, or to its end.
    fn go(&self, begun: &mut Loop<'_, L>, explorer: &mut Swings, steps: usize) {
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
    let Learned { data, model_return, prediction, gap, confirmation, updates, model_steps, policy, .. } = learned;
    let policy = policy.map(|p| p.to_bytes());
    format!("{data:?} {model_return:?} {prediction:?} {gap:?} {confirmation:?} {updates} {model_steps} {policy:?}")
}

#[test]
fn wherever_it_was_saved_a_run_ends_the_same() {
    let phases = ends_the_same(&Lab::new(), 1);
    let count = |wanted: Phase| phases.iter().filter(|phase| **phase == wanted).count();
    let seen = [Phase::Fit, Phase::CollectMore, Phase::Confirm].map(count);
    assert!(seen[0] > 3 && seen[1] == 1 && seen[2] > 3, "all that a run can do was done: {seen:?}");
}

#[test]
fn wherever_it_was_saved_a_run_that_chooses_its_data_ends_the_same() {
    let phases = ends_the_same(&Lab::of(Undecided(vec![0.5, 1.5]), Schedule { rollout_len: 40, ..auto() }), 20);
    assert!(phases.iter().filter(|phase| **phase == Phase::CollectMore).count() > 1, "{phases:?}");
}

/// Resumes a run from wherever it can be saved, or `every` so many times; its phases.
fn ends_the_same<L: DynamicsLearner<Model = Push>>(lab: &Lab<L>, every: usize) -> Vec<Phase> {
    let dyna = lab.dyna();
    let mut explorer = Swings::new(&lab.task.0);
    let (mut whole, mut saved) = (dyna.begin(Lab::<L>::student()).expect("a usable schedule"), Vec::new());
    let mut phases = Vec::new();
    while !whole.has_ended() {
        phases.push(whole.phase());
        saved.extend(whole.save(&explorer));
        lab.go(&mut whole, &mut explorer, 1);
    }
    assert!(whole.save(&explorer).is_none(), "there is nothing to go on with");
    let whole = all_of(whole.finish());
    for (at, saved) in saved.iter().enumerate().step_by(every) {
        let mut explorer = Swings::new(&lab.task.0);
        let mut resumed = dyna.resume(Lab::<L>::student(), &mut explorer, saved).expect("it was saved");
        assert_eq!(resumed.save(&explorer).as_ref(), Some(saved), "step {at}");
        lab.go(&mut resumed, &mut explorer, usize::MAX);
        assert_eq!(all_of(resumed.finish()), whole, "step {at}");
    }
    phases
}

#[test]
fn what_is_no_checkpoint_of_such_a_run_is_refused() {
    let lab = Lab::new();
    let dyna = lab.dyna();
    let mut explorer = Swings::new(&lab.task.0);
    let mut begun = dyna.begin(Lab::<Doubting>::student()).expect("a usable schedule");
    lab.go(&mut begun, &mut explorer, 20);
    let saved = begun.save(&explorer).expect("it has not ended");
    let other = Schedule { replay_capacity: 7, ..lab.schedule.clone() };
    let refused = |dyna: &Dyna<'_, Doubting>, saved: &[u8]| {
        let told = dyna.resume(Lab::<Doubting>::student(), &mut Swings::new(&lab.task.0), saved);
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
        let resumed = dyna.resume(Lab::<Doubting>::student(), &mut Swings::new(&lab.task.0), &changed);
        assert!(resumed.is_ok() || matches!(resumed.err(), Some(DynaError::Checkpoint(_))), "byte {at}");
    }
}
