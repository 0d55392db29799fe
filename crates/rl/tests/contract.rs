//! The agents keep what agents promise, and the check finds those that do not.

use std::sync::Arc;

use ndarray::{ArrayView2, ArrayViewMut2};
use sindyna_core::{
    Agent, AgentError, Batch, Channel, Checkpoint, CheckpointError, Kind, Mode, Policy, Precision, Rng, Seed, Space,
    Spec, TrainedPolicy, check_agent,
};
use sindyna_rl::{Sac, SacConfig, SacDiscrete, Scaling};

fn spec(action_space: Space) -> Spec {
    let x = Channel::new("x", "m", Kind::Plain, 1.0);
    let v = Channel::new("v", "m/s", Kind::RateOf(0), 1.0);
    Spec {
        name: "any".into(),
        state: vec![x.clone(), v.clone()],
        observation: vec![x, v],
        control: vec![Channel::new("u", "N", Kind::Plain, 2.0).within(-2.0, 2.0)],
        action_space,
        precision: Precision::F64,
        noise: 0.0,
        dt: 0.1,
    }
}

#[test]
fn the_agents_keep_their_promises() {
    let mut rng = Seed::new(0).numpy();
    let range = spec(Space::Box { low: vec![-2.0], high: vec![2.0] });
    for config in [SacConfig::default(), SacConfig::in_model()] {
        let mut sac = Sac::new(config.clone(), Scaling::identity(2), &[-2.0], &[2.0], &mut rng).expect("usable");
        assert_eq!(check_agent(&mut sac, &range), Ok(()));
        let numbered = spec(Space::Discrete { controls: ndarray::array![[-2.0], [0.0], [2.0]] });
        let mut sac = SacDiscrete::new(config, Scaling::identity(2), 3, &mut rng).expect("usable");
        assert_eq!(check_agent(&mut sac, &numbered), Ok(()));
    }
}

/// Acts beyond what is allowed.
#[derive(Clone)]
struct Strong;

impl Policy for Strong {
    fn act_batch(&self, _: ArrayView2<'_, f64>, _: Mode, _: &mut Rng, mut actions: ArrayViewMut2<'_, f64>) {
        actions.fill(3.0);
    }
}

impl Checkpoint for Strong {}

impl TrainedPolicy for Strong {
    fn to_bytes(&self) -> Vec<u8> {
        Vec::new()
    }
}

impl Agent for Strong {
    fn name(&self) -> &'static str {
        "strong"
    }
    fn learn(&mut self, _: &Batch, _: &mut Rng) -> Result<(), AgentError> {
        Ok(())
    }
    fn policy(&self) -> Arc<dyn TrainedPolicy> {
        Arc::new(Self)
    }
    fn read_policy(&self, _: &[u8]) -> Result<Arc<dyn TrainedPolicy>, CheckpointError> {
        Ok(self.policy())
    }
}

#[test]
fn an_agent_that_acts_beyond_its_range_is_told() {
    let told = check_agent(&mut Strong, &spec(Space::Box { low: vec![-2.0], high: vec![2.0] }));
    assert!(told.expect_err("3 is beyond 2").to_string().contains("[3.0] is no action"));
}

#[test]
fn averaged_weights_follow_those_of_the_actor_slowly() {
    let batch = |value: f64| {
        let mut batch = Batch::zeros(32, 2, 1);
        batch.observations.fill(value);
        batch.rewards.fill(1.0);
        batch
    };
    let (mut rng, low, high) = (Seed::new(0).numpy(), [-2.0], [2.0]);
    let of = |averaging: f64| SacConfig { averaging, learning_rate: 1e-2, ..SacConfig::default() };
    let make =
        |averaging, rng: &mut Rng| Sac::new(of(averaging), Scaling::identity(2), &low, &high, rng).expect("usable");
    let (mut slow, mut own) = (make(0.01, &mut rng.clone()), make(1.0, &mut rng));
    let act = |policy: &dyn Policy| {
        let mut action = [0.0];
        policy.act(&[0.5, 0.5], Mode::Exploit, &mut Seed::new(0).numpy(), &mut action);
        action[0]
    };
    let start = act(&slow.frozen());
    assert_eq!(start, act(&own.frozen()), "nothing to average yet");
    for _ in 0..300 {
        slow.update(&batch(0.5), &mut Seed::new(1).numpy()).expect("finite");
        own.update(&batch(0.5), &mut Seed::new(1).numpy()).expect("finite");
    }
    assert_eq!(act(&own), act(&own.frozen()));
    assert_eq!(act(&slow), act(&own), "the actor learns the same");
    assert_ne!(act(&slow.frozen()), act(&slow), "what is handed over is its average");
}
