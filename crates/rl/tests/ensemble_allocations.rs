//! A steady epoch of an ensemble's training takes nothing from the heap but its line of the report.

mod counting;

use counting::asked;
use ndarray::Array2;
use sindyna_core::Seed;
use sindyna_rl::{Activation, EnsembleConfig, EnsembleTrainer};

fn allocations(activation: Activation, epochs: usize) -> usize {
    let config = EnsembleConfig {
        members: 2,
        elites: 1,
        hidden: vec![20, 30],
        weight_decay: vec![0.0; 3],
        activation,
        patience: epochs,
        max_epochs: Some(epochs),
        ..EnsembleConfig::janner()
    };
    let trainer = EnsembleTrainer::new(config).expect("usable settings");
    let rows = Array2::from_shape_fn((700, 3), |(i, j)| (1.7 * (i * 3 + j) as f64).sin());
    let before = asked();
    trainer.fit(rows.view(), rows.view(), None, &mut Seed::new(0).numpy()).expect("enough rows");
    asked() - before
}

#[test]
fn no_epoch_but_the_first_allocates() {
    for activation in [Activation::Relu, Activation::Swish] {
        let more = allocations(activation, 12) - allocations(activation, 2);
        assert_eq!(more, 10, "allocations in ten epochs more with {activation:?}: one entry of the report each");
    }
}
