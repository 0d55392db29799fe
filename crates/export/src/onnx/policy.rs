//! A policy as a graph.

use super::graph::Builder;
use crate::network::{Head, Network};

/// The graph from `o`, (batch, m), to `action`, (batch, k), or (batch, 1) with numbers of actions.
pub(crate) fn write(network: &Network, text: &[String]) -> Vec<u8> {
    let mut builder = Builder::default();
    builder.input("o", network.observed());
    let (center, scale) = (builder.row(&network.center), builder.row(&network.scale));
    let centered = builder.op("Sub", &["o", &center]);
    let mut at = builder.op("Div", &[&centered, &scale]);
    for (l, layer) in network.layers.iter().enumerate() {
        let weights = builder.floats(&[layer.inputs, layer.outputs], &layer.weights);
        let biases = builder.floats(&[layer.outputs], &layer.biases);
        let product = builder.op("MatMul", &[&at, &weights]);
        at = builder.op("Add", &[&product, &biases]);
        if l + 1 < network.layers.len() {
            at = builder.op("Relu", &[&at]);
        }
    }
    match &network.head {
        Head::Squashed { low, high } => {
            let half: Vec<f64> = low.iter().zip(high).map(|(low, high)| 0.5 * (high - low)).collect();
            let (low, high, half, one) = (builder.row(low), builder.row(high), builder.row(&half), builder.number(1.0));
            let squashed = builder.op("Tanh", &[&at]);
            let positive = builder.op("Add", &[&squashed, &one]);
            let wide = builder.op("Mul", &[&positive, &half]);
            let shifted = builder.op("Add", &[&wide, &low]);
            let above = builder.op("Max", &[&shifted, &low]);
            builder.output("action", network.actions(), "Min", &[&above, &high], None);
        }
        Head::Largest => builder.output("action", 1, "ArgMax", &[&at], Some(("axis", 1))),
    }
    builder.file("policy", text)
}
