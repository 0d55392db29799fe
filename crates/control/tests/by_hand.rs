//! Controllers written by hand reach what they are there to show.

use sindyna_control::ByHand;
use sindyna_core::Seed;
use sindyna_dyna::evaluate;
use sindyna_envs::find;

#[test]
fn each_law_masters_its_task() {
    for (task, least) in
        [("cart-pole", 499.0), ("inverted-pendulum", 999.0), ("mountain-car", 96.0), ("pendulum", -165.0)]
    {
        let system = find(task).expect("a task of ours");
        let mut envs: Vec<_> = (0..100).map(|_| system.environment()).collect();
        let law = ByHand::new(task).expect("a law for it");
        let returns = evaluate(&mut envs, &law, 200, Seed::new(9), "evaluation").expect("a simulation runs");
        let mean = returns.iter().sum::<f64>() / returns.len() as f64;
        assert!(mean >= least, "{task}: {mean}");
    }
    assert!(ByHand::new("walking").is_none());
}
