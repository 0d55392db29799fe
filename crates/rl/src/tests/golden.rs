//! Against PyTorch's gradients and Stable-Baselines3's updates; `scripts/golden/sac` makes the files.

use ndarray::{Array1, Array2};
use serde::Deserialize;
use sindyna_core::{Batch, Seed};

use super::{STILL, agent, discrete_agent, distance};
use crate::{Sac, SacConfig, learner::Learner, mlp::Mlp};

type Rows = Vec<Vec<f64>>;

/// A linear layer as PyTorch has it: weight (outputs, inputs).
#[derive(Deserialize)]
struct Linear {
    weight: Rows,
    bias: Vec<f64>,
}

/// The layers as one vector in our order: weights (inputs, outputs), biases, next layer.
fn flat(layers: &[Linear]) -> Vec<f64> {
    let mut params = Vec::new();
    for layer in layers {
        let inputs = layer.weight[0].len();
        params.extend((0..inputs).flat_map(|i| layer.weight.iter().map(move |row| row[i])));
        params.extend(&layer.bias);
    }
    params
}

fn flat32(layers: &[Linear]) -> Vec<f32> {
    flat(layers).into_iter().map(|p| p as f32).collect()
}

fn load(net: &mut Mlp, layers: &[Linear]) {
    *net = Mlp::from_params(net.sizes(), flat32(layers));
}

fn table(rows: &Rows) -> Array2<f64> {
    let width = rows[0].len();
    Array2::from_shape_vec((rows.len(), width), rows.concat()).expect("rows of one width")
}

#[derive(Deserialize)]
struct Transitions {
    observations: Rows,
    actions: Rows,
    rewards: Vec<f64>,
    next_observations: Rows,
    terminated: Vec<f64>,
    /// Absent where nothing is drawn.
    #[serde(default)]
    noise: Rows,
}

impl Transitions {
    fn batch(&self) -> Batch {
        Batch {
            observations: table(&self.observations),
            actions: table(&self.actions),
            rewards: Array1::from(self.rewards.clone()),
            next_observations: table(&self.next_observations),
            terminated: Array1::from(self.terminated.clone()),
        }
    }
}

#[derive(Deserialize)]
struct Losses {
    temperature: f64,
    critic: f64,
    actor: f64,
}

#[derive(Deserialize)]
struct Gradients {
    tolerance: f64,
    discount: f64,
    temperature: f64,
    target_entropy: f64,
    actor: Vec<Linear>,
    critics: [Vec<Linear>; 2],
    targets: [Vec<Linear>; 2],
    #[serde(flatten)]
    transitions: Transitions,
    losses: Losses,
    temperature_gradient: f64,
    critic_gradients: [Vec<Linear>; 2],
    actor_gradients: Vec<Linear>,
}

impl Gradients {
    fn read(text: &str) -> Self {
        serde_json::from_str(text).expect("the golden file is whole")
    }

    fn config(&self) -> SacConfig {
        SacConfig {
            hidden: vec![32, 32],
            learning_rate: STILL,
            discount: self.discount,
            initial_temperature: self.temperature,
            target_entropy: Some(self.target_entropy),
            ..SacConfig::default()
        }
    }

    fn load(&self, actor: &mut Mlp, learner: &mut Learner) {
        load(actor, &self.actor);
        for (i, critic) in learner.critics.iter_mut().enumerate() {
            load(&mut critic.net, &self.critics[i]);
            load(&mut critic.target, &self.targets[i]);
        }
    }

    /// Compares what one update reported, and what gradients it left behind.
    fn check(&self, losses: &crate::Losses, actor: &Mlp, learner: &Learner) {
        assert_eq!(actor.params, flat32(&self.actor), "nothing moved");
        let relative = |a: f64, b: f64| (a / b - 1.0).abs();
        let temperature_loss = self.temperature.ln() * (losses.entropy - self.target_entropy);
        let temperature_gradient = learner.temperature.adam.mean / 0.1;
        let figures = [
            ("temperature loss", relative(temperature_loss, self.losses.temperature)),
            ("critic loss", relative(losses.critic, self.losses.critic)),
            ("actor loss", relative(losses.actor, self.losses.actor)),
            ("temperature gradient", relative(temperature_gradient, self.temperature_gradient)),
            ("first critic", distance(&learner.critics[0].gradients, &flat(&self.critic_gradients[0]))),
            ("second critic", distance(&learner.critics[1].gradients, &flat(&self.critic_gradients[1]))),
            ("actor", distance(&learner.actor_gradients, &flat(&self.actor_gradients))),
        ];
        println!("{figures:?}");
        for (what, error) in figures {
            assert!(error < self.tolerance, "{what} is off by {error:e}");
        }
    }
}

#[test]
fn gradients_equal_those_of_pytorch_in_double_precision() {
    let golden = Gradients::read(include_str!("../../tests/golden/gradients.json"));
    let mut sac = agent(golden.config(), 3, 2);
    golden.load(&mut sac.policy.net.net, &mut sac.learner);
    let noise = golden.transitions.noise.concat();
    let losses = sac.update_with_noise(&golden.transitions.batch(), &noise).expect("finite losses");
    golden.check(&losses, &sac.policy.net.net, &sac.learner);
}

#[test]
fn gradients_over_numbered_actions_equal_those_of_pytorch_in_double_precision() {
    let golden = Gradients::read(include_str!("../../tests/golden/discrete.json"));
    let mut sac = discrete_agent(golden.config(), 3, 3);
    golden.load(&mut sac.policy.net.net, &mut sac.learner);
    let losses = sac.update(&golden.transitions.batch(), &mut Seed::new(0).numpy()).expect("finite losses");
    golden.check(&losses, &sac.policy.net.net, &sac.learner);
}

#[derive(Deserialize)]
struct Settings {
    learning_rate: f64,
    gamma: f64,
    tau: f64,
    hidden: Vec<usize>,
    target_entropy: f64,
}

#[derive(Deserialize)]
struct Tolerance {
    losses: f64,
    parameters: f64,
}

#[derive(Deserialize)]
struct Networks {
    actor: Vec<Linear>,
    critic_0: Vec<Linear>,
    target_0: Vec<Linear>,
    critic_1: Vec<Linear>,
    target_1: Vec<Linear>,
}

impl Networks {
    fn all(&self) -> [&[Linear]; 5] {
        [&self.actor, &self.critic_0, &self.target_0, &self.critic_1, &self.target_1].map(Vec::as_slice)
    }
}

/// The networks in the order of [`Networks::all`].
fn networks(sac: &Sac) -> [&Mlp; 5] {
    let [first, second] = &sac.learner.critics;
    [&sac.policy.net.net, &first.net, &first.target, &second.net, &second.target]
}

#[derive(Deserialize)]
struct Moments {
    exp_avg: Vec<Linear>,
    exp_avg_sq: Vec<Linear>,
}

#[derive(Deserialize)]
struct AllMoments {
    actor: Moments,
    critic_0: Moments,
    critic_1: Moments,
}

#[derive(Deserialize)]
struct ScalarMoments {
    log_value: f64,
    exp_avg: f64,
    exp_avg_sq: f64,
}

#[derive(Deserialize)]
struct Logged {
    critic_loss: f64,
    actor_loss: f64,
    ent_coef_loss: f64,
    ent_coef: f64,
}

#[derive(Deserialize)]
struct After {
    log_temperature: f64,
    networks: Networks,
}

#[derive(Deserialize)]
struct Updates {
    tolerance: Tolerance,
    settings: Settings,
    steps_before: u64,
    start: Networks,
    adam: AllMoments,
    temperature: ScalarMoments,
    batches: Vec<Transitions>,
    losses: Vec<Logged>,
    after: std::collections::BTreeMap<usize, After>,
}

fn start(golden: &Updates) -> Sac {
    let config = SacConfig {
        hidden: golden.settings.hidden.clone(),
        learning_rate: golden.settings.learning_rate,
        discount: golden.settings.gamma,
        polyak: golden.settings.tau,
        target_entropy: None,
        ..SacConfig::default()
    };
    let mut sac = agent(config, 3, 2);
    let t = &mut sac.learner.temperature;
    assert_eq!(t.target_entropy, golden.settings.target_entropy, "the default is minus the number of action values");
    t.log_value = golden.temperature.log_value;
    (t.adam.mean, t.adam.square) = (golden.temperature.exp_avg, golden.temperature.exp_avg_sq);
    t.adam.step = golden.steps_before;

    let [first, second] = &mut sac.learner.critics;
    let nets = [&mut sac.policy.net.net, &mut first.net, &mut first.target, &mut second.net, &mut second.target];
    nets.into_iter().zip(golden.start.all()).for_each(|(net, layers)| load(net, layers));
    let optimisers = [
        (&mut sac.learner.actor_adam, &golden.adam.actor),
        (&mut first.adam, &golden.adam.critic_0),
        (&mut second.adam, &golden.adam.critic_1),
    ];
    for (adam, moments) in optimisers {
        adam.step = golden.steps_before;
        (adam.mean, adam.square) = (flat32(&moments.exp_avg), flat32(&moments.exp_avg_sq));
    }
    sac
}

#[test]
fn five_updates_equal_those_of_stable_baselines3() {
    let golden: Updates =
        serde_json::from_str(include_str!("../../tests/golden/updates.json")).expect("the golden file is whole");
    let mut sac = start(&golden);
    let (mut worst_loss, mut worst_parameter, mut worst_move) = (0.0_f64, 0.0_f64, 0.0_f64);
    for (i, (transitions, logged)) in golden.batches.iter().zip(&golden.losses).enumerate() {
        let (temperature, log_temperature) = (sac.temperature(), sac.learner.temperature.log_value);
        let losses = sac.update_with_noise(&transitions.batch(), &transitions.noise.concat()).expect("finite losses");
        let temperature_loss = log_temperature * (losses.entropy - golden.settings.target_entropy);
        let pairs = [
            (losses.critic, logged.critic_loss),
            (losses.actor, logged.actor_loss),
            (temperature_loss, logged.ent_coef_loss),
            (temperature, logged.ent_coef),
        ];
        for (ours, theirs) in pairs {
            worst_loss = worst_loss.max((ours / theirs - 1.0).abs());
        }
        if let Some(after) = golden.after.get(&(i + 1)) {
            for ((net, theirs), begun) in networks(&sac).into_iter().zip(after.networks.all()).zip(golden.start.all()) {
                let (theirs, begun) = (flat(theirs), flat(begun));
                worst_parameter = worst_parameter.max(distance(&net.params, &theirs));
                let moved: Vec<f32> = net.params.iter().zip(&begun).map(|(p, b)| (f64::from(*p) - b) as f32).collect();
                let they_moved: Vec<f64> = theirs.iter().zip(&begun).map(|(p, b)| p - b).collect();
                worst_move = worst_move.max(distance(&moved, &they_moved));
            }
            worst_parameter =
                worst_parameter.max((sac.learner.temperature.log_value / after.log_temperature - 1.0).abs());
        }
    }
    println!("losses {worst_loss:.1e}, parameters {worst_parameter:.1e}, their moves {worst_move:.1e}");
    assert!(golden.after.keys().eq([1, 5].iter()), "parameters after one and after five updates");
    assert!(worst_loss < golden.tolerance.losses, "a loss is off by {worst_loss:e}");
    assert!(worst_parameter < golden.tolerance.parameters, "parameters are off by {worst_parameter:e}");
    // Parameters hardly move in five updates, so their moves are looked at too. A target's first move is 1e-6, where
    // f32 resolves a hundredth.
    assert!(worst_move < 0.01, "moves are off by {worst_move:e}");
}
