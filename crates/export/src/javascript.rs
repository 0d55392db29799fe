//! Modules for Node.js and browsers.

use sindyna_sindy::export::{Stepping, System};
use sindyna_sindy::{Expr, Function};

use super::code::{Coefficient, Dialect, assignments, expression, list, number, value};
use super::friction;
use super::interface::Interface;
use super::network::{Head, Network};
use super::program::Program;

const DIALECT: Dialect = Dialect {
    call: |function, a| match function {
        Function::PositivePart => format!("Math.max({a}, 0.0)"),
        other => format!("Math.{}({a})", other.name()),
    },
    power: |a, exponent| format!("Math.pow({a}, {exponent})"),
    end: ";",
};

/// A module of JavaScript.
pub(super) fn write(program: &Program) -> String {
    module(program, &value)
}

/// The same with coefficients written otherwise.
pub(super) fn module(program: &Program, coefficient: Coefficient<'_>) -> String {
    let system = &program.system;
    let mut text = String::from("// Written by sindyna export.\n");
    text += &program.comments().iter().map(|line| format!("// {line}\n")).collect::<String>();
    if program.closed().is_some() {
        text += "// One step of equations and policy: x = clip(step(x, control(act(observe(x)))))\n";
    }
    text += &format!("\n// Control interval in seconds.\nexport const DT = {:?};\n", system.dt);
    text += &equations(system, coefficient);
    text += &program.policy.as_ref().map_or_else(String::new, policy);
    text + &program.closed().map_or_else(String::new, closed)
}

fn equations(system: &System, coefficient: Coefficient<'_>) -> String {
    let n = system.states.len();
    if system.stepping == Stepping::Map {
        let lines = assignments(&DIALECT, system, "next", coefficient, |i, l| format!("left[{i}][{l}]"));
        return format!(
            "\n// The state one step later.\nexport function step(x, u) {{\n    const next = new Array({n}).fill(0.0);\n{lines}    return next;\n}}\n"
        );
    }
    let solve = if system.is_implicit() { SOLVE } else { "" };
    let rates = format!("{solve}\n// The rate of every state.\nexport {}", rates(system, "rhs", coefficient));
    let held = match &system.stepping {
        Stepping::Friction(friction) => {
            let of = "The same with the signs beside dry friction as further inputs.";
            format!("\n// {of}\n{}", self::rates(&friction.held, "ratesHeld", coefficient))
        }
        _ => String::new(),
    };
    rates + &held + &step(&system.stepping)
}

/// A function of the rates.
fn rates(system: &System, name: &str, coefficient: Coefficient<'_>) -> String {
    let n = system.states.len();
    let lines = assignments(&DIALECT, system, "rate", coefficient, |i, l| format!("left[{i}][{l}]"));
    let (before, after) = if system.is_implicit() {
        (
            format!(
                "    const left = Array.from({{ length: {n} }}, (_, i) => Array.from({{ length: {n} }}, (_, j) => (i === j ? 1.0 : 0.0)));\n"
            ),
            "    return solve(left, rate);\n",
        )
    } else {
        (String::new(), "    return rate;\n")
    };
    format!("function {name}(x, u) {{\n    const rate = new Array({n}).fill(0.0);\n{before}{lines}{after}}}\n")
}

/// Gaussian elimination with the largest pivot of each column.
const SOLVE: &str = "
function solve(left, right) {
    const n = right.length;
    for (let k = 0; k < n; k++) {
        let pivot = k;
        for (let i = k + 1; i < n; i++) {
            if (Math.abs(left[i][k]) > Math.abs(left[pivot][k])) pivot = i;
        }
        [left[k], left[pivot]] = [left[pivot], left[k]];
        [right[k], right[pivot]] = [right[pivot], right[k]];
        for (let i = k + 1; i < n; i++) {
            const factor = left[i][k] / left[k][k];
            for (let j = k; j < n; j++) left[i][j] -= factor * left[k][j];
            right[i] -= factor * right[k];
        }
    }
    for (let k = n - 1; k >= 0; k--) {
        for (let j = k + 1; j < n; j++) right[k] -= left[k][j] * right[j];
        right[k] /= left[k][k];
    }
    return right;
}
";

fn step(stepping: &Stepping) -> String {
    let body = match stepping {
        Stepping::Rk4 { substeps } => format!(
            "    const h = DT / {substeps};
    const ahead = (x, by, k) => x.map((value, i) => value + by * k[i]);
    for (let part = 0; part < {substeps}; part++) {{
        const k1 = rhs(x, u);
        const k2 = rhs(ahead(x, 0.5 * h, k1), u);
        const k3 = rhs(ahead(x, 0.5 * h, k2), u);
        const k4 = rhs(ahead(x, h, k3), u);
        x = x.map((value, i) => value + (h / 6.0) * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
    }}
    return x;
"
        ),
        Stepping::SemiImplicitEuler { positions, substeps } => {
            let order: Vec<String> = positions.iter().map(ToString::to_string).collect();
            format!(
                "    const h = DT / {substeps};
    for (let part = 0; part < {substeps}; part++) {{
        const rate = rhs(x, u);
        const moved = x.map((value, i) => value + h * rate[i]);
        for (const i of [{}]) moved[i] = x[i] + h * rhs(moved, u)[i];
        x = moved;
    }}
    return x;
",
                order.join(", ")
            )
        }
        Stepping::Friction(friction) => friction::javascript(friction),
        _ => "    const rate = rhs(x, u);\n    return x.map((value, i) => value + DT * rate[i]);\n".to_owned(),
    };
    format!("\n// The state one control interval later.\nexport function step(x, u) {{\n{body}}}\n")
}

fn policy(network: &Network) -> String {
    let doubles = |values: &[f64]| format!("[\n    {}\n]", list(values.iter().map(|v| format!("{v:?}"))));
    let floats = |values: &[f32]| format!("Float32Array.of(\n    {}\n)", list(values.iter().map(|v| format!("{v:?}"))));
    let mut text = "\n// The policy: a network between scaled observations and actions.\n".to_owned();
    text += &format!("const CENTER = {};\nconst SCALE = {};\n", doubles(&network.center), doubles(&network.scale));
    let layers: Vec<String> =
        network.layers.iter().map(|layer| format!("[{}, {}]", floats(&layer.weights), floats(&layer.biases))).collect();
    text += &format!("const LAYERS = [{}];\n", layers.join(", "));
    let (what, head) = match &network.head {
        Head::Squashed { low, high } => {
            text += &format!("const LOW = {};\nconst HIGH = {};\n", doubles(low), doubles(high));
            (
                "The action for an observation.",
                "    return Array.from(at, (value, i) => {\n        const action = LOW[i] + 0.5 * (Math.tanh(value) + 1.0) * (HIGH[i] - LOW[i]);\n        return Math.min(Math.max(action, LOW[i]), HIGH[i]);\n    });\n",
            )
        }
        Head::Largest => {
            ("The number of the action for an observation.", "    return [at.indexOf(Math.max(...at))];\n")
        }
    };
    text + &format!(
        "
// {what}
export function act(o) {{
    let at = o.map((value, i) => Math.fround((value - CENTER[i]) / SCALE[i]));
    LAYERS.forEach(([weights, biases], l) => {{
        const next = new Float32Array(biases.length);
        for (let j = 0; j < biases.length; j++) {{
            let sum = biases[j];
            for (let i = 0; i < at.length; i++) sum += at[i] * weights[i * biases.length + j];
            next[j] = l === LAYERS.length - 1 || sum > 0.0 ? sum : 0.0;
        }}
        at = next;
    }});
{head}}}
"
    )
}

/// Observations, controls and bounds.
fn closed(interface: &Interface) -> String {
    let n = interface.bounds.len();
    let reading = |reading: &Expr| {
        let value = expression(&DIALECT, reading, n);
        if interface.rounded { format!("Math.fround({value})") } else { value }
    };
    let readings: Vec<String> = interface.readings.iter().map(reading).collect();
    let control = if interface.numbered.is_empty() {
        format!("[{}]", clipped("action", &interface.controls))
    } else {
        let row = |u: &Vec<f64>| format!("[{}]", u.iter().map(|v| number(*v)).collect::<Vec<_>>().join(", "));
        let rows: Vec<String> = interface.numbered.iter().map(row).collect();
        format!("[{}][action[0]].slice()", rows.join(", "))
    };
    format!(
        "\n// What the policy observes of a state.\nexport function observe(x) {{\n    return [{}];\n}}\n\
         \n// The control that an action puts on the system.\nexport function control(action) {{\n    return {control};\n}}\n\
         \n// The state within its declared bounds, as it was while the policy was trained.\nexport function clip(x) {{\n    return [{}];\n}}\n",
        readings.join(", "),
        clipped("x", &interface.bounds)
    )
}

/// The elements of `array`, each between its bounds.
pub(super) fn clipped(array: &str, bounds: &[(f64, f64)]) -> String {
    let bound = |value: f64| match value {
        f64::INFINITY => "Infinity".to_owned(),
        f64::NEG_INFINITY => "-Infinity".to_owned(),
        _ => number(value),
    };
    let each = bounds.iter().enumerate();
    let each: Vec<String> = each
        .map(|(i, (low, high))| format!("Math.min(Math.max({array}[{i}], {}), {})", bound(*low), bound(*high)))
        .collect();
    each.join(", ")
}
