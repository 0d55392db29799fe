//! Learning while acting that goes on from a checkpoint ends as if it had never been stopped.

mod common;

use common::{EXACT, Given, Line, Push, Student};
use rand::RngExt as _;
use sindyna_core::{
    Dataset, DynamicsLearner, End, EnvError, Environment, FitError, Knowledge, NoModel, Outcome, Rng, Seed, Sensors,
    Simulated, Spec,
};
use sindyna_dyna::{Branches, Checks, DynaError, Online, OnlineLoop, OnlinePhase, OnlineSchedule, Practised, Swings};

/// All that a run is made of but its loop.
struct Lab<L> {
    task: Line,
    sensors: Sensors,
    learner: L,
    schedule: OnlineSchedule,
}

type Real<'a> = Simulated<Push, &'a Line, &'a Sensors>;

impl<L: DynamicsLearner> Lab<L> {
    fn new(learner: L, branches: Option<Branches>) -> Self {
        let task = Line::new(12);
        let sensors = Sensors::new(&task.0).expect("the observation names the state").with_noise(&[0.05]);
        let schedule = OnlineSchedule {
            real_steps: 45,
            first_steps: 20,
            held_steps: 3,
            updates_per_step: 2,
            batch_size: 20,
            replay_capacity: 30,
            branches,
            checks: Checks { every: 10, episodes: 4, until: None },
        };
        Self { task, sensors, learner, schedule }
    }

    fn online(&self) -> Online<'_, L> {
        let Self { task, sensors, learner, schedule } = self;
        Online { task, sensors, learner, schedule, seed: Seed::new(4) }
    }

    fn real(&self) -> Real<'_> {
        Simulated::new(EXACT, &self.task, &self.sensors)
    }

    fn student() -> Box<Student> {
        Box::new(Student::default())
    }

    /// Advances `begun` by so many steps, or to its end.
    fn go(&self, begun: &mut OnlineLoop<'_, L>, env: &mut dyn Environment, explorer: &mut Swings, steps: usize) {
        let mut judges = vec![self.real(); 2];
        for _ in 0..steps {
            if begun.has_ended() {
                return;
            }
            begun.advance(env, &mut judges, explorer).expect("nothing fails here");
        }
    }

    /// Stops a run after every phase and goes on with it in another environment, explorer and agent; the phases there were.
    fn stop_everywhere(&self) -> Vec<OnlinePhase> {
        let online = self.online();
        let (mut env, mut explorer) = (self.real(), Swings::new(&self.task.0));
        let mut whole = online.begin(Self::student()).expect("a usable schedule");
        let (mut phases, mut saved) = (Vec::new(), Vec::new());
        while !whole.has_ended() {
            phases.push(whole.phase());
            saved.push(whole.save(&mut env, &explorer).expect("a simulation can be put back"));
            self.go(&mut whole, &mut env, &mut explorer, 1);
        }
        assert!(whole.save(&mut env, &explorer).is_none(), "there is nothing to go on with");
        let whole = all_of(whole.finish());
        for (at, saved) in saved.iter().enumerate() {
            let (mut env, mut explorer) = (self.real(), Swings::new(&self.task.0));
            let mut resumed = online.resume(&mut env, &mut explorer, Self::student(), saved).expect("it was saved");
            assert_eq!(resumed.save(&mut env, &explorer).as_ref(), Some(saved), "phase {at}");
            self.go(&mut resumed, &mut env, &mut explorer, usize::MAX);
            assert_eq!(all_of(resumed.finish()), whole, "phase {at}");
        }
        phases
    }
}

/// All that is left of a run, bit by bit.
fn all_of<M>(left: Practised<M>) -> String {
    let Practised { policy, real_steps, real_episodes, updates, model_steps, diverged, checks, .. } = left;
    format!("{:?} {real_steps} {real_episodes} {updates} {model_steps} {diverged} {checks:?}", policy.to_bytes())
}

fn branches() -> Branches {
    Branches { every: 6, per_step: 3, length: 2, rounds_kept: 2, real_share: 0.25 }
}

#[test]
fn wherever_it_was_saved_a_model_free_run_ends_the_same() {
    use OnlinePhase::{Act, Check, Learn};
    let phases = Lab::new(NoModel, None).stop_everywhere();
    let count = |wanted: OnlinePhase| phases.iter().filter(|phase| **phase == wanted).count();
    assert_eq!([Act, Learn, Check].map(count), [45, 25, 4]);
    assert_eq!(phases.len(), 74, "nothing else happened");
}

/// Goes on from the model before, by all that the data hold and by chance; writes nothing down.
struct GoingOn;

impl DynamicsLearner for GoingOn {
    type Model = Push;
    fn goes_on(&self) -> bool {
        true
    }
    fn fit(&self, data: &Dataset, previous: Option<&Push>, rng: &mut Rng) -> Result<Option<Knowledge<Push>>, FitError> {
        let ends: f64 = data.rollouts().map(|r| if r.end == End::Cut { 0.1 } else { 0.01 }).sum();
        let seen = data.rollouts().map(|r| r.observations.sum()).sum::<f64>() / data.n_steps() as f64;
        let gain = 0.3 * previous.map_or(1.0, |p| p.gain) + ends + seen.abs() + 0.1 * rng.random::<f64>();
        // It breaks off far out, so that some branches are cut.
        Ok(Some(Knowledge::certain(Push { gain, breaks_at: 0.9 })))
    }
}

#[test]
fn wherever_it_was_saved_a_run_with_branches_ends_the_same() {
    use OnlinePhase::{Act, Branch, Check, Fit, Learn};
    let phases = Lab::new(GoingOn, Some(branches())).stop_everywhere();
    let count = |wanted: OnlinePhase| phases.iter().filter(|phase| **phase == wanted).count();
    assert_eq!([Act, Fit, Branch, Learn, Check].map(count), [45, 5, 5, 25, 4]);
}

/// A system outside of the computer.
struct Rig<'a>(Real<'a>);

impl Environment for Rig<'_> {
    fn spec(&self) -> &Spec {
        self.0.spec()
    }
    fn observation(&self) -> &[f64] {
        self.0.observation()
    }
    fn reset(&mut self, rng: &mut Rng) -> Result<(), EnvError> {
        self.0.reset(rng)
    }
    fn step(&mut self, action: &[f64], rng: &mut Rng) -> Result<Outcome, EnvError> {
        self.0.step(action, rng)
    }
}

#[test]
fn what_cannot_be_put_back_is_saved_between_episodes() {
    let lab = Lab::new(NoModel, None);
    let online = lab.online();
    let (mut rig, mut explorer) = (Rig(lab.real()), Swings::new(&lab.task.0));
    assert!(rig.checkpoint().is_none() && lab.real().checkpoint().is_some_and(|env| !env.save().is_empty()));
    let mut whole = online.begin(Box::new(Student::default())).expect("a usable schedule");
    let (mut saved, mut asked) = (Vec::new(), 0);
    while !whole.has_ended() {
        asked += 1;
        saved.extend(whole.save(&mut rig, &explorer));
        lab.go(&mut whole, &mut rig, &mut explorer, 1);
    }
    assert!(saved.len() > 3 && saved.len() < asked / 2, "{} of {asked}", saved.len());
    let whole = all_of(whole.finish());
    for saved in saved {
        let (mut rig, mut explorer) = (Rig(lab.real()), Swings::new(&lab.task.0));
        let mut resumed = online
            .resume(&mut rig, &mut explorer, Box::new(Student::default()), &saved)
            .expect("no episode was running");
        lab.go(&mut resumed, &mut rig, &mut explorer, usize::MAX);
        assert_eq!(all_of(resumed.finish()), whole);
    }
}

#[test]
fn what_is_no_checkpoint_of_such_a_run_is_refused() {
    let lab = Lab::new(Given(EXACT), Some(branches()));
    let online = lab.online();
    let (mut env, mut explorer) = (lab.real(), Swings::new(&lab.task.0));
    let mut begun = online.begin(Box::new(Student::default())).expect("a usable schedule");
    lab.go(&mut begun, &mut env, &mut explorer, 40);
    let saved = begun.save(&mut env, &explorer).expect("it has not ended");
    let refused = |online: &Online<'_, Given>, env: &mut dyn Environment, saved: &[u8]| {
        let told = online.resume(env, &mut Swings::new(&lab.task.0), Box::new(Student::default()), saved);
        matches!(told.err(), Some(DynaError::Checkpoint(_)))
    };
    assert!(!refused(&online, &mut lab.real(), &saved));
    assert!(refused(&online, &mut Rig(lab.real()), &saved), "an episode was running");
    let other = OnlineSchedule { replay_capacity: 7, ..lab.schedule.clone() };
    assert!(
        refused(&Online { schedule: &other, ..lab.online() }, &mut lab.real(), &saved),
        "its replay has another size"
    );
    let other = OnlineSchedule { branches: None, ..lab.schedule.clone() };
    assert!(refused(&Online { schedule: &other, ..lab.online() }, &mut lab.real(), &saved), "nothing is imagined");
    for length in (0..saved.len()).step_by(saved.len() / 50) {
        assert!(refused(&online, &mut lab.real(), &saved[..length]), "{length} of {} bytes", saved.len());
    }
}
