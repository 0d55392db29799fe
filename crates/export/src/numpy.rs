//! Policies in NumPy, and what closes the loop, after the equations in the same module.

use sindyna_sindy::{Expr, Function};

use super::code::{Dialect, expression, list};
use super::network::Head;
use super::program::{Program, harmless};

const DIALECT: Dialect = Dialect {
    call: |function, a| match function {
        Function::PositivePart => format!("np.maximum({a}, 0.0)"),
        Function::Atan => format!("np.arctan({a})"),
        other => format!("np.{}({a})", other.name()),
    },
    power: |a, exponent| format!("({a}**{exponent}.0)"),
    end: "",
};

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

/// How the functions follow each other, for the head of the module.
pub(super) fn notes(program: &Program) -> Vec<String> {
    let mut notes = program.notes.clone();
    if program.closed().is_some() {
        notes.push("One step of equations and policy: x = clip(step(x, control(act(observe(x))))).".into());
    }
    notes
}

/// Observations, controls and bounds; nothing where they are not known.
pub(super) fn closed(program: &Program) -> String {
    let Some(interface) = program.closed() else { return String::new() };
    let array = |values: &mut dyn Iterator<Item = f64>| format!("np.array([{}])", list(values.map(number)));
    let (n, k) = (interface.bounds.len(), interface.controls.len());
    // A number is one for every row.
    let reading = |o: &Expr| match o.max_variable() {
        Some(_) => expression(&DIALECT, o, n).replace("x[", "x[..., "),
        None => format!("np.full(x.shape[:-1], {})", expression(&DIALECT, o, n)),
    };
    let readings: Vec<String> = interface.readings.iter().map(reading).collect();
    let rounded = if interface.rounded { ".astype(np.float32).astype(float)" } else { "" };
    let control = if interface.numbered.is_empty() {
        format!(
            "CONTROL_LOW = {}\nCONTROL_HIGH = {}\n\n\ndef control(action):\n    \"\"\"The control (..., {k}) that an action (..., {k}) puts on the system.\"\"\"\n    \
             return np.clip(np.asarray(action, dtype=float), CONTROL_LOW, CONTROL_HIGH)\n",
            array(&mut interface.controls.iter().map(|c| c.0)),
            array(&mut interface.controls.iter().map(|c| c.1)),
        )
    } else {
        let rows: Vec<String> = interface
            .numbered
            .iter()
            .map(|row| format!("    [{}],\n", row.iter().map(|v| number(*v)).collect::<Vec<_>>().join(", ")))
            .collect();
        format!(
            "CONTROLS = np.array([\n{}])\n\n\ndef control(action):\n    \"\"\"The control (..., {k}) of the action with a number (..., 1).\"\"\"\n    \
             return CONTROLS[np.asarray(action)[..., 0].astype(int)]\n",
            rows.concat()
        )
    };
    format!(
        "\n\n# What stands between equations and policy.\nSTATE_LOW = {}\nSTATE_HIGH = {}\n{control}\n\n@np.errstate(divide=\"ignore\")\ndef observe(x):\n    \
         \"\"\"What the policy observes (..., {}) of a state (..., {n}).\"\"\"\n    x = np.asarray(x, dtype=float)\n    \
         return np.stack([{}], axis=-1){rounded}\n\n\ndef clip(x):\n    \
         \"\"\"A state (..., {n}) within its declared bounds, as it was while the policy was trained.\"\"\"\n    \
         return np.clip(np.asarray(x, dtype=float), STATE_LOW, STATE_HIGH)\n",
        array(&mut interface.bounds.iter().map(|b| b.0)),
        array(&mut interface.bounds.iter().map(|b| b.1)),
        readings.len(),
        readings.join(", "),
    )
}

fn number(value: f64) -> String {
    if value.is_finite() {
        format!("{value:?}")
    } else if value > 0.0 {
        "np.inf".into()
    } else {
        "-np.inf".into()
    }
}
