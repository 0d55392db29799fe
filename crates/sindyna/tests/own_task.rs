//! Tasks of one's own, put together from the libraries: goals far from the data, states far from zero, sizes that nobody declares.

use rand::RngExt as _;
use sindyna_core::{
    Channel, Dynamics, Event, Held, Kind, Observer, Precision, Rng, Scheme, Seed, Sensors, Simulated, Space, Spec,
    Task, VectorField,
};
use sindyna_dyna::{Dyna, Learned, Schedule, Swings, evaluate};
use sindyna_rl::{Sac, SacConfig, Scaling};
use sindyna_sindy::{Identifier, Model, NoiseChoice};

/// A slider without friction, of 1 kg, that is to be 2 m from where it began. Its position is told from `origin`.
struct Reach {
    spec: Spec,
    origin: f64,
}

impl Reach {
    fn new(origin: f64, scale: f64) -> Self {
        let x = Channel::new("x", "m", Kind::Plain, scale);
        let v = Channel::new("v", "m/s", Kind::RateOf(0), scale);
        let spec = Spec {
            name: "reach".into(),
            observation: vec![x.clone(), v.clone()],
            state: vec![x, v],
            control: vec![Channel::new("u", "N", Kind::Plain, 1.0).within(-1.0, 1.0)],
            action_space: Space::Box { low: vec![-1.0], high: vec![1.0] },
            precision: Precision::F64,
            noise: 0.0,
            dt: 0.1,
        };
        Self { spec, origin }
    }
}

impl Task for Reach {
    fn spec(&self) -> &Spec {
        &self.spec
    }
    fn max_steps(&self) -> usize {
        100
    }
    fn initial(&self, rng: &mut Rng, x: &mut [f64]) {
        x[0] = self.origin + rng.random_range(-0.1..0.1);
        x[1] = rng.random_range(-0.1..0.1);
    }
    fn reward(&self, x: &[f64], _action: &[f64], _u: &[f64], _next: &[f64]) -> f64 {
        -(x[0] - self.origin - 2.0).powi(2)
    }
    fn terminated(&self, _next: &[f64]) -> bool {
        false
    }
}

#[derive(Clone)]
struct Slider;

impl VectorField for Slider {
    fn eval(&self, x: &[f64], u: &[f64], x_dot: &mut [f64]) {
        (x_dot[0], x_dot[1]) = (x[1], u[0]);
    }
}

struct Silent;

impl Observer for Silent {
    fn on(&mut self, _event: &Event<'_>) -> std::io::Result<()> {
        Ok(())
    }
}

/// What a run with default settings leaves, and the mean return of its policy on the system.
fn learn<D: Dynamics + Clone>(task: &dyn Task, system: D, seed: u64) -> (Learned<Model>, f64) {
    let (spec, seed) = (task.spec(), Seed::new(seed));
    let sensors = Sensors::new(spec).expect("all is shown");
    let learner = Identifier::new(spec).with_noise(NoiseChoice::Estimated);
    let schedule = Schedule::new(task.max_steps());
    let settings = SacConfig { discount: schedule.discount, ..SacConfig::in_model() };
    let scaling = Scaling::identity(spec.observation_dim());
    let mut weights = seed.stream("initial weights", 0);
    let agent = Sac::new(settings, scaling, &[-1.0], &[1.0], &mut weights).expect("usable settings");
    let dyna = Dyna { task, sensors: &sensors, learner: &learner, schedule: &schedule, seed };
    let mut real = Simulated::new(system.clone(), task, sensors.clone());
    let learned = dyna
        .run(&mut real, &mut Swings::new(spec), Box::new(agent), &mut Silent, &|| false)
        .expect("nothing fails here");
    let mut envs: Vec<_> = (0..100).map(|_| Simulated::new(system.clone(), task, sensors.clone())).collect();
    let policy = learned.policy.as_ref().expect("there were trials");
    let returns = evaluate(&mut envs, &**policy, 100, seed, "evaluation").expect("nothing fails here");
    (learned, returns.iter().sum::<f64>() / 100.0)
}

fn reach(origin: f64, scale: f64, seed: u64) -> (Learned<Model>, f64) {
    let slider = Held::new(Slider, Scheme::Rk4 { substeps: 1 }, 0.1);
    learn(&Reach::new(origin, scale), slider, seed)
}

#[test]
fn a_goal_far_beyond_the_data_is_reached() {
    for seed in 0..3 {
        let (learned, earned) = reach(0.0, 1.0, seed);
        // With full thrust to the middle and full brake from there it takes 2.8 s: −42 or so.
        assert!(earned > -65.0, "seed {seed}: {earned} after {} real steps", learned.data.n_steps());
    }
}

#[test]
fn declared_sizes_change_nothing() {
    let (small, large) = (reach(0.0, 0.5, 0), reach(0.0, 5.0, 0));
    let policy = |learned: &Learned<Model>| learned.policy.as_ref().expect("there were trials").to_bytes();
    assert_eq!(policy(&small.0), policy(&large.0));
    assert_eq!(small.0.data, large.0.data);
}

#[test]
fn a_position_of_300_m_is_as_good_as_one_of_0() {
    let (learned, earned) = reach(300.0, 1.0, 0);
    assert!(earned > -65.0, "{earned}; {:?}", learned.model.map(|m| m.equations()));
}
