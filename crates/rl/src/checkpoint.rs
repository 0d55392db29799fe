//! What an agent has learned and learns with, as bytes.

use serde::{Deserialize, Serialize};
use sindyna_core::{CheckpointError, decode, encode};

use crate::{adam::Adam, learner::Learner, scaled_net::ScaledNet, temperature::Temperature};

/// All of an agent that updates change.
#[derive(Serialize, Deserialize)]
struct State {
    center: Vec<f64>,
    scale: Vec<f64>,
    actor: Net,
    average: Vec<f32>,
    critics: [(Net, Vec<f32>); 2],
    temperature: Temperature,
    updates: u64,
}

/// Parameters and their optimiser.
#[derive(Serialize, Deserialize)]
struct Net {
    params: Vec<f32>,
    adam: Adam,
}

/// The state of an agent with this `actor`.
pub(crate) fn save(learner: &Learner, actor: &ScaledNet) -> Vec<u8> {
    let net = |params: &[f32], adam: &Adam| Net { params: params.to_vec(), adam: adam.clone() };
    encode(&State {
        center: actor.scaling.center.clone(),
        scale: actor.scaling.scale.clone(),
        actor: net(&actor.net.params, &learner.actor_adam),
        average: learner.average.clone(),
        critics: learner.critics.each_ref().map(|c| (net(&c.net.params, &c.adam), c.target.params.clone())),
        temperature: learner.temperature.clone(),
        updates: learner.updates,
    })
}

/// Gives `learner` and `actor` the state of another such agent.
pub(crate) fn restore(learner: &mut Learner, actor: &mut ScaledNet, saved: &[u8]) -> Result<(), CheckpointError> {
    let state: State = decode(saved)?;
    let fits = |what: &str, expected: usize, net: &Net| {
        let Net { params, adam } = net;
        [params, &adam.mean, &adam.square].iter().try_for_each(|v| CheckpointError::expect_len(what, expected, v.len()))
    };
    let observed = actor.scaling.width();
    CheckpointError::expect_len("observed values", observed, state.center.len())?;
    CheckpointError::expect_len("observed values", observed, state.scale.len())?;
    fits("parameters of the actor", actor.net.params.len(), &state.actor)?;
    CheckpointError::expect_len("averaged parameters", actor.net.params.len(), state.average.len())?;
    for (critic, (net, target)) in learner.critics.iter().zip(&state.critics) {
        let expected = critic.net.params.len();
        fits("parameters of a critic", expected, net)?;
        CheckpointError::expect_len("parameters of a target", expected, target.len())?;
    }
    (actor.scaling.center, actor.scaling.scale) = (state.center, state.scale);
    (actor.net.params, learner.actor_adam) = (state.actor.params, state.actor.adam);
    (learner.average, learner.temperature, learner.updates) = (state.average, state.temperature, state.updates);
    for (critic, (net, target)) in learner.critics.iter_mut().zip(state.critics) {
        (critic.net.params, critic.adam, critic.target.params) = (net.params, net.adam, target);
    }
    Ok(())
}
