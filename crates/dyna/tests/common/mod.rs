//! A task that is easy to see through, its dynamics, and an agent that shows what it was given.

#![allow(dead_code)]

use std::io;
use std::sync::{Arc, Mutex};

use ndarray::{ArrayView2, ArrayViewMut2};
use sindyna_core::{
    Agent, AgentError, Batch, Certainty, Channel, Checkpoint, CheckpointError, Dataset, Diverged, Dynamics,
    DynamicsLearner, Event, FitError, Kind, Knowledge, Mode, Observer, Policy, Posterior, Precision, Rng, Seed,
    Sensors, Simulated, Space, Spec, Task, TrainedPolicy, decode, encode,
};
use sindyna_dyna::{Dyna, Learned, Optimality, Refit, Rollouts, Schedule, Uniform};

/// A point on a line, pushed about; falls off at |x| > 1 and is paid −x² for every step.
pub(crate) struct Line(pub(crate) Spec, usize);

impl Line {
    pub(crate) fn new(max_steps: usize) -> Self {
        let spec = Spec {
            name: "line".into(),
            state: vec![Channel::new("x", "m", Kind::Plain, 2.0)],
            observation: vec![Channel::new("x", "m", Kind::Plain, 2.0)],
            control: vec![Channel::new("u", "m", Kind::Plain, 1.0)],
            action_space: Space::Box { low: vec![-0.4], high: vec![0.4] },
            precision: Precision::F64,
            noise: 0.0,
            dt: 1.0,
        };
        Self(spec, max_steps)
    }
}

impl Task for Line {
    fn spec(&self) -> &Spec {
        &self.0
    }
    fn max_steps(&self) -> usize {
        self.1
    }
    fn initial(&self, rng: &mut Rng, x: &mut [f64]) {
        use rand::RngExt as _;
        x[0] = rng.random_range(-0.1..0.1);
    }
    fn reward(&self, x: &[f64], _action: &[f64], _u: &[f64], _next: &[f64]) -> f64 {
        -x[0] * x[0]
    }
    fn terminated(&self, next: &[f64]) -> bool {
        next[0].abs() > 1.0
    }
}

/// x' = x + gain·u; beyond `breaks_at` the model blows up.
#[derive(Clone)]
pub(crate) struct Push {
    pub(crate) gain: f64,
    pub(crate) breaks_at: f64,
}

impl Dynamics for Push {
    fn step(&self, x: &[f64], u: &[f64], _rng: &mut Rng, next: &mut [f64]) -> Result<(), Diverged> {
        next[0] = if x[0].abs() > self.breaks_at { f64::NAN } else { x[0] + self.gain * u[0] };
        Diverged::check(next)
    }
}

pub(crate) struct Given(pub(crate) Push);

impl DynamicsLearner for Given {
    type Model = Push;
    fn fit(
        &self,
        _data: &Dataset,
        _previous: Option<&Push>,
        _rng: &mut Rng,
    ) -> Result<Option<Knowledge<Push>>, FitError> {
        Ok(Some(Knowledge::certain(self.0.clone())))
    }
}

/// Moves by a gain that improves a little with each update, and keeps what it was shown.
#[derive(Clone, Default)]
pub(crate) struct Student {
    pub(crate) gain: f64,
    /// Acts twice as strongly as its gain says: right where the model is half as lively as the truth.
    pub(crate) eager: bool,
    pub(crate) shown: Arc<Mutex<Vec<(f64, f64, f64)>>>,
}

impl Policy for Student {
    fn act_batch(&self, o: ArrayView2<'_, f64>, mode: Mode, rng: &mut Rng, mut actions: ArrayViewMut2<'_, f64>) {
        use rand::RngExt as _;
        for (o, mut a) in o.rows().into_iter().zip(actions.rows_mut()) {
            a[0] = match mode {
                Mode::Exploit => (-self.gain * if self.eager { 2.0 } else { 1.0 } * o[0]).clamp(-0.4, 0.4),
                Mode::Explore => rng.random_range(-0.4..0.4),
            };
        }
    }
}

impl Checkpoint for Student {
    fn save(&self) -> Vec<u8> {
        encode(&(self.gain, self.eager))
    }
    fn restore(&mut self, saved: &[u8]) -> Result<(), CheckpointError> {
        (self.gain, self.eager) = decode(saved)?;
        Ok(())
    }
}

impl TrainedPolicy for Student {
    fn to_bytes(&self) -> Vec<u8> {
        self.save()
    }
}

impl Agent for Student {
    fn name(&self) -> &'static str {
        "student"
    }
    fn learn(&mut self, batch: &Batch, _rng: &mut Rng) -> Result<(), AgentError> {
        self.gain = (self.gain + 0.1).min(1.0);
        let mut shown = self.shown.lock().expect("one thread");
        for i in 0..batch.len() {
            shown.push((batch.next_observations[[i, 0]], batch.rewards[i], batch.terminated[i]));
        }
        Ok(())
    }
    fn policy(&self) -> Arc<dyn TrainedPolicy> {
        Arc::new(self.clone())
    }
    fn read_policy(&self, bytes: &[u8]) -> Result<Arc<dyn TrainedPolicy>, CheckpointError> {
        let mut read = self.clone();
        read.restore(bytes)?;
        Ok(Arc::new(read))
    }
}

pub(crate) const EXACT: Push = Push { gain: 1.0, breaks_at: f64::INFINITY };

pub(crate) struct Silent;
impl Observer for Silent {
    fn on(&mut self, _event: &Event<'_>) -> io::Result<()> {
        Ok(())
    }
}

pub(crate) fn schedule() -> Schedule {
    Schedule {
        warmup_rollouts: 2,
        rollout_len: 15,
        curious: true,
        imagined_rollouts: Rollouts::Unlimited,
        refit: Refit::Never,
        systems: 4,
        imagined_len: 10,
        scattered_starts: 0.5,
        random_steps: 40,
        updates_per_turn: 1,
        batch_size: 8,
        replay_capacity: 500,
        max_real_steps: None,
        discount: 0.9,
        optimality: Optimality {
            trial_every: 10,
            trial_episodes: 5,
            settled: 2,
            tolerance: 0.01,
            patience: 2,
            gain: 0.01,
            max_updates: 200,
        },
    }
}

/// Who doubts a model of fewer than `enough` steps, and thinks the others adequate.
pub(crate) struct Doubting {
    pub(crate) model: Push,
    pub(crate) enough: usize,
}

impl DynamicsLearner for Doubting {
    type Model = Push;
    fn fit(&self, data: &Dataset, _: Option<&Push>, _: &mut Rng) -> Result<Option<Knowledge<Push>>, FitError> {
        let certainty = if data.n_steps() < self.enough { Certainty::Doubted } else { Certainty::Adequate };
        Ok(Some(Knowledge { certainty, ..Knowledge::certain(self.model.clone()) }))
    }
}

pub(crate) fn auto() -> Schedule {
    Schedule { imagined_rollouts: Rollouts::Auto, refit: Refit::AfterRollouts, ..schedule() }
}

/// Whose data allow pushes of more than one gain.
pub(crate) struct Undecided(pub(crate) Vec<f64>);

impl Posterior for Undecided {
    fn draw(&self, rng: &mut Rng) -> Arc<dyn Dynamics> {
        use rand::RngExt as _;
        Arc::new(Push { gain: self.0[rng.random_range(0..self.0.len())], ..EXACT })
    }
}

impl DynamicsLearner for Undecided {
    type Model = Push;
    fn fit(&self, _: &Dataset, _: Option<&Push>, _: &mut Rng) -> Result<Option<Knowledge<Push>>, FitError> {
        let posterior: Arc<dyn Posterior> = Arc::new(Self(self.0.clone()));
        let certain = Knowledge::certain(EXACT);
        Ok(Some(Knowledge { certainty: Certainty::Adequate, posterior: Some(posterior), ..certain }))
    }
}

pub(crate) fn run<L: DynamicsLearner>(
    learner: &L,
    schedule: &Schedule,
    agent: Student,
    interrupted: &dyn Fn() -> bool,
) -> Learned<L::Model> {
    run_seeded(0, learner, schedule, agent, interrupted)
}

pub(crate) fn run_seeded<L: DynamicsLearner>(
    seed: u64,
    learner: &L,
    schedule: &Schedule,
    agent: Student,
    interrupted: &dyn Fn() -> bool,
) -> Learned<L::Model> {
    let task = Line::new(20);
    let sensors = Sensors::new(&task.0).expect("the observation names the state");
    let truth = Push { gain: 1.0, breaks_at: f64::INFINITY };
    let mut real = Simulated::new(truth, &task, sensors.clone());
    let mut explorer = Uniform::new(&task.0);
    let dyna = Dyna { task: &task, sensors: &sensors, learner, schedule, seed: Seed::new(seed) };
    dyna.run(&mut real, &mut explorer, Box::new(agent), &mut Silent, interrupted).expect("nothing fails here")
}
