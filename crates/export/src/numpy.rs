//! Policies in NumPy, after the equations in the same module.

use super::code::list;
use super::network::Head;
use super::program::{Program, harmless};

/// The function `act`; nothing without a policy.
pub(super) fn policy(program: &Program) -> String {
    let Some(network) = &program.policy else { return String::new() };
    let array =
        |values: Vec<String>, kind: &str| format!("np.array([\n    {}\n], dtype=np.{kind})", list(values.into_iter()));
    let doubles = |values: &[f64]| array(values.iter().map(|v| format!("{v:?}")).collect(), "float64");
    let floats = |values: &[f32]| array(values.iter().map(|v| format!("{v:?}")).collect(), "float32");
    let mut text = format!(
        "\n\n# The policy: a network between scaled observations and actions.\nCENTER = {}\nSCALE = {}\n",
        doubles(&network.center),
        doubles(&network.scale)
    );
    let layers = network.layers.iter().map(|layer| {
        format!(
            "    ({}.reshape({}, {}), {}),\n",
            floats(&layer.weights),
            layer.inputs,
            layer.outputs,
            floats(&layer.biases)
        )
    });
    text += &format!("LAYERS = [\n{}]\n", layers.collect::<String>());
    let (what, head) = match &network.head {
        Head::Squashed { low, high } => {
            text += &format!("LOW = {}\nHIGH = {}\n", doubles(low), doubles(high));
            (
                "The action for an observation",
                "    return np.clip(LOW + 0.5 * (np.tanh(at.astype(np.float64)) + 1.0) * (HIGH - LOW), LOW, HIGH)\n",
            )
        }
        Head::Largest => (
            "The number of the action for an observation",
            "    return np.argmax(at, axis=-1)[..., np.newaxis].astype(float)\n",
        ),
    };
    let observed: Vec<String> = program.observed.iter().map(|name| harmless(name).replace('"', "_")).collect();
    let observed = if observed.is_empty() { String::new() } else { format!(": {}", observed.join(", ")) };
    let m = network.observed();
    text + &format!(
        "\n\ndef act(o):\n    \"\"\"{what} (..., {m}){observed}.\"\"\"\n    o = np.asarray(o, dtype=float)\n    if o.ndim == 0 or o.shape[-1] != {m}:\n        \
         raise ValueError(f\"o must have shape (..., {m}), got {{o.shape}}\")\n    at = ((o - CENTER) / SCALE).astype(np.float32)\n    \
         for i, (weights, biases) in enumerate(LAYERS):\n        at = at.astype(np.float64) @ weights.astype(np.float64) + biases\n        \
         if i < len(LAYERS) - 1:\n            at = np.maximum(at, 0.0)\n        at = at.astype(np.float32)\n{head}"
    )
}
