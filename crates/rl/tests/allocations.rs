//! A steady update takes nothing from the heap.

mod counting;

use counting::asked;
use sindyna_core::{Agent, Batch, Seed};
use sindyna_rl::{Isa, Sac, SacConfig, SacDiscrete, Scaling};

fn batch() -> Batch {
    let mut batch = Batch::zeros(256, 3, 1);
    batch.observations.iter_mut().enumerate().for_each(|(i, v)| *v = (i as f64).sin());
    batch.next_observations.iter_mut().enumerate().for_each(|(i, v)| *v = (i as f64 + 0.1).sin());
    batch.rewards.iter_mut().enumerate().for_each(|(i, v)| *v = (7.0 * i as f64).cos());
    batch
}

fn check(mut agent: impl Agent, isa: Isa) {
    let (batch, mut rng) = (batch(), Seed::new(0).stream("allocations", 0));
    agent.learn(&batch, &mut rng).expect("finite losses");
    let before = asked();
    for _ in 0..50 {
        agent.learn(&batch, &mut rng).expect("finite losses");
    }
    assert_eq!(asked() - before, 0, "allocations in 50 updates with {isa}");
}

#[test]
fn no_update_but_the_first_allocates() {
    for isa in Isa::ALL {
        for hidden in [vec![64, 64], vec![96, 33]] {
            let (config, mut rng) = (SacConfig { hidden, ..SacConfig::default() }, Seed::new(1).numpy());
            let sac = Sac::new(config.clone(), Scaling::identity(3), &[-2.0], &[2.0], &mut rng).expect("usable");
            let numbered = SacDiscrete::new(config, Scaling::identity(3), 2, &mut rng).expect("usable");
            // Machines without the instructions have nothing to check.
            sac.with_isa(isa).into_iter().for_each(|agent| check(agent, isa));
            numbered.with_isa(isa).into_iter().for_each(|agent| check(agent, isa));
        }
    }
}
