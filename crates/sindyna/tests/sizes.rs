//! Typical sizes of states, declared with a task, say nothing to whoever learns it: half of them or five times as much change no byte.

use sindyna_core::{Agent, Event, Observer, Redeclared, Seed, Sensors, Simulated, Space, Task};
use sindyna_dyna::{Dyna, Learned, Schedule, Swings};
use sindyna_envs::System;
use sindyna_rl::{Sac, SacConfig, SacDiscrete, Scaling};
use sindyna_sindy::{Identifier, Model, NoiseChoice};

struct Silent;

impl Observer for Silent {
    fn on(&mut self, _event: &Event<'_>) -> std::io::Result<()> {
        Ok(())
    }
}

/// What a short training leaves where every declared size of `system` is multiplied by `factor`.
fn learn(system: &System, factor: f64) -> Learned<Model> {
    let task = Redeclared::new(system.task(), |spec| {
        for channel in spec.state.iter_mut().chain(&mut spec.observation).chain(&mut spec.control) {
            channel.prior.scale *= factor;
        }
    });
    let (spec, seed) = (task.spec(), Seed::new(0));
    let sensors = Sensors::new(spec).expect("sizes change no channel");
    let mut schedule = Schedule::new(task.max_steps());
    schedule.optimality.max_updates = 500;
    let settings = SacConfig { discount: schedule.discount, ..SacConfig::in_model() };
    let (scaling, mut weights) = (Scaling::identity(spec.observation_dim()), seed.stream("initial weights", 0));
    let agent: Box<dyn Agent> = match &spec.action_space {
        Space::Box { low, high } => Box::new(Sac::new(settings, scaling, low, high, &mut weights).expect("usable")),
        Space::Discrete { controls } => {
            Box::new(SacDiscrete::new(settings, scaling, controls.nrows(), &mut weights).expect("usable"))
        }
    };
    let learner = Identifier::new(spec).with_noise(NoiseChoice::Estimated);
    let dyna = Dyna { task: &task, sensors: &sensors, learner: &learner, schedule: &schedule, seed };
    let mut real = Simulated::new(system.dynamics(), &task as &dyn Task, sensors.clone());
    dyna.run(&mut real, &mut Swings::new(spec), agent, &mut Silent, &|| false).expect("a simulation runs")
}

#[test]
fn declared_sizes_change_nothing_on_any_task() {
    for system in sindyna_envs::systems() {
        let all = |factor| {
            let Learned { data, model, policy, model_return, prediction, .. } = learn(&system, factor);
            let policy = policy.expect("there were trials").to_bytes();
            (data, model.map(|m| m.to_json()), policy, model_return, prediction)
        };
        let declared = all(1.0);
        for factor in [0.5, 2.0, 5.0] {
            assert!(all(factor) == declared, "{}: sizes × {factor}", system.name());
        }
    }
}
