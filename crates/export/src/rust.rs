//! Modules of Rust.

use sindyna_sindy::export::{Stepping, System};
use sindyna_sindy::{Expr, Function};

use super::code::{Dialect, assignments, expression, list, uses, value};
use super::friction;
use super::interface::Interface;
use super::network::{Head, Network};
use super::program::Program;

const DIALECT: Dialect = Dialect {
    call: |function, a| match function {
        Function::Log => format!("f64::ln({a})"),
        Function::Sign => format!("sign_of({a})"),
        Function::PositivePart => format!("positive_part({a})"),
        other => format!("f64::{}({a})", other.name()),
    },
    power: |a, exponent| format!("f64::powi({a}, {exponent})"),
    end: ";",
};

/// A module of Rust.
pub(super) fn write(program: &Program) -> String {
    let system = &program.system;
    let (n, k) = (system.states.len(), system.controls.len());
    let mut text = String::from("//! Written by sindyna export.\n");
    text += &program.comments().iter().map(|line| format!("// {line}\n")).collect::<String>();
    if program.closed().is_some() {
        text += "// One step of equations and policy: x = clip(&step(&x, &control(&act(&observe(&x)))))\n";
    }
    text += &format!(
        "\n/// States.\npub const N: usize = {n};\n/// Inputs.\npub const K: usize = {k};\n/// Control interval \\[s\\].\npub const DT: f64 = {:?};\n",
        system.dt
    );
    if uses(system, program.readings(), Function::Sign) {
        text += "\nfn sign_of(a: f64) -> f64 {\n    if a > 0.0 { 1.0 } else if a < 0.0 { -1.0 } else { a * 0.0 }\n}\n";
    }
    if uses(system, program.readings(), Function::PositivePart) {
        text += "\nfn positive_part(a: f64) -> f64 {\n    if a < 0.0 { 0.0 } else { a }\n}\n";
    }
    text += &equations(system);
    text += &program.policy.as_ref().map_or_else(String::new, policy);
    text + &program.closed().map_or_else(String::new, closed)
}

fn equations(system: &System) -> String {
    const HEAD: &str = "#[allow(unused_variables, unused_parens, clippy::all)]\npub fn";
    if system.stepping == Stepping::Map {
        let lines = assignments(&DIALECT, system, "next", &value, |i, l| format!("left[{i}][{l}]"));
        return format!(
            "\n/// The state one step later.\n{HEAD} step(x: &[f64; N], u: &[f64; K]) -> [f64; N] {{\n    let mut next = [0.0; N];\n{lines}    next\n}}\n"
        );
    }
    let solve = if system.is_implicit() { SOLVE } else { "" };
    let rates = format!("{solve}\n/// The rate of every state.\n{HEAD} {}", rates(system, "rhs", "K"));
    let held = match &system.stepping {
        Stepping::Friction(friction) => {
            let of = "The same with the signs beside dry friction as further inputs.";
            let count = format!("K + {}", friction.joints.len());
            format!(
                "\n/// {of}\n{} {}",
                HEAD.replace("pub fn", "fn"),
                self::rates(&friction.held, "rates_held", &count)
            )
        }
        _ => String::new(),
    };
    rates + &held + &step(&system.stepping)
}

/// A function of the rates, of so many inputs.
fn rates(system: &System, name: &str, inputs: &str) -> String {
    let lines = assignments(&DIALECT, system, "rate", &value, |i, l| format!("left[{i}][{l}]"));
    let (before, after) = if system.is_implicit() {
        ("    let mut left = [[0.0; N]; N];\n    (0..N).for_each(|i| left[i][i] = 1.0);\n", "    solve(left, rate)\n")
    } else {
        ("", "    rate\n")
    };
    format!(
        "{name}(x: &[f64; N], u: &[f64; {inputs}]) -> [f64; N] {{\n    let mut rate = [0.0; N];\n{before}{lines}{after}}}\n"
    )
}

/// Gaussian elimination with the largest pivot of each column.
const SOLVE: &str = "
#[allow(clippy::all)]
fn solve(mut left: [[f64; N]; N], mut right: [f64; N]) -> [f64; N] {
    for k in 0..N {
        let pivot = (k..N).fold(k, |best, i| if left[i][k].abs() > left[best][k].abs() { i } else { best });
        left.swap(k, pivot);
        right.swap(k, pivot);
        for i in k + 1..N {
            let factor = left[i][k] / left[k][k];
            for j in k..N {
                left[i][j] -= factor * left[k][j];
            }
            right[i] -= factor * right[k];
        }
    }
    for k in (0..N).rev() {
        for j in k + 1..N {
            right[k] -= left[k][j] * right[j];
        }
        right[k] /= left[k][k];
    }
    right
}
";

fn step(stepping: &Stepping) -> String {
    let body = match stepping {
        Stepping::Rk4 { substeps } => format!(
            "    let h = DT / {substeps} as f64;
    let ahead = |x: &[f64; N], by: f64, k: &[f64; N]| -> [f64; N] {{ std::array::from_fn(|i| x[i] + by * k[i]) }};
    let mut x = *x;
    for _ in 0..{substeps} {{
        let k1 = rhs(&x, u);
        let k2 = rhs(&ahead(&x, 0.5 * h, &k1), u);
        let k3 = rhs(&ahead(&x, 0.5 * h, &k2), u);
        let k4 = rhs(&ahead(&x, h, &k3), u);
        x = std::array::from_fn(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
    }}
    x
"
        ),
        Stepping::SemiImplicitEuler { positions, substeps } => {
            let order: Vec<String> = positions.iter().map(ToString::to_string).collect();
            format!(
                "    let h = DT / {substeps} as f64;
    let mut x = *x;
    for _ in 0..{substeps} {{
        let rate = rhs(&x, u);
        let mut moved: [f64; N] = std::array::from_fn(|i| x[i] + h * rate[i]);
        for i in [{}] as [usize; {}] {{
            moved[i] = x[i] + h * rhs(&moved, u)[i];
        }}
        x = moved;
    }}
    x
",
                order.join(", "),
                positions.len()
            )
        }
        Stepping::Friction(friction) => friction::rust(friction),
        _ => "    let rate = rhs(x, u);\n    std::array::from_fn(|i| x[i] + DT * rate[i])\n".to_owned(),
    };
    format!(
        "\n/// The state one control interval later.\npub fn step(x: &[f64; N], u: &[f64; K]) -> [f64; N] {{\n{body}}}\n"
    )
}

fn policy(network: &Network) -> String {
    let doubles = |name: &str, values: &[f64]| {
        format!(
            "const {name}: [f64; {}] = [\n    {}\n];\n",
            values.len(),
            list(values.iter().map(|v| format!("{v:?}")))
        )
    };
    let floats = |name: String, values: &[f32]| {
        format!(
            "static {name}: [f32; {}] = [\n    {}\n];\n",
            values.len(),
            list(values.iter().map(|v| format!("{v:?}")))
        )
    };
    let (m, k) = (network.observed(), network.actions());
    let mut text = "\n// The policy: a network between scaled observations and actions.\n".to_owned();
    text += &(doubles("CENTER", &network.center) + &doubles("SCALE", &network.scale));
    for (l, layer) in network.layers.iter().enumerate() {
        text += &(floats(format!("WEIGHTS_{l}"), &layer.weights) + &floats(format!("BIASES_{l}"), &layer.biases));
    }
    text += "
fn layer<const I: usize, const O: usize>(weights: &[f32], biases: &[f32; O], is_last: bool, input: &[f32; I]) -> [f32; O] {
    std::array::from_fn(|j| {
        let products = input.iter().enumerate().map(|(i, value)| f64::from(*value) * f64::from(weights[i * O + j]));
        let sum = f64::from(biases[j]) + products.sum::<f64>();
        (if is_last || sum > 0.0 { sum } else { 0.0 }) as f32
    })
}
";
    let last = network.layers.len().saturating_sub(1);
    let calls: String = (0..network.layers.len())
        .map(|l| format!("    let at = layer(&WEIGHTS_{l}, &BIASES_{l}, {}, &at);\n", l == last))
        .collect();
    let (what, head) = match &network.head {
        Head::Squashed { low, high } => {
            text += &(doubles("LOW", low) + &doubles("HIGH", high));
            (
                "The action for an observation.",
                "    std::array::from_fn(|i| {\n        (LOW[i] + 0.5 * (f64::from(at[i]).tanh() + 1.0) * (HIGH[i] - LOW[i])).clamp(LOW[i], HIGH[i])\n    })\n",
            )
        }
        Head::Largest => (
            "The number of the action for an observation.",
            "    let best = (1..at.len()).fold(0, |best, i| if at[i] > at[best] { i } else { best });\n    [best as f64]\n",
        ),
    };
    text + &format!(
        "\n/// {what}\npub fn act(o: &[f64; {m}]) -> [f64; {k}] {{\n    let at: [f32; {m}] = std::array::from_fn(|i| ((o[i] - CENTER[i]) / SCALE[i]) as f32);\n{calls}{head}}}\n"
    )
}

/// Observations, controls and bounds.
fn closed(interface: &Interface) -> String {
    let n = interface.bounds.len();
    let reading = |reading: &Expr| {
        let value = expression(&DIALECT, reading, n);
        if interface.rounded { format!("f64::from({value} as f32)") } else { value }
    };
    let readings: Vec<String> = interface.readings.iter().map(reading).collect();
    let (actions, control) = if interface.numbered.is_empty() {
        (interface.controls.len(), format!("    [{}]\n", clipped("action", &interface.controls)))
    } else {
        let row = |u: &Vec<f64>| format!("[{}]", u.iter().map(|v| format!("{v:?}")).collect::<Vec<_>>().join(", "));
        let rows: Vec<String> = interface.numbered.iter().map(row).collect();
        (
            1,
            format!(
                "    const CONTROLS: [[f64; K]; {}] = [\n        {}\n    ];\n    CONTROLS[(action[0] as usize).min(CONTROLS.len() - 1)]\n",
                rows.len(),
                rows.join(",\n        ")
            ),
        )
    };
    format!(
        "\n/// What the policy observes of a state.\n#[allow(unused_parens, clippy::all)]\npub fn observe(x: &[f64; N]) -> [f64; {}] {{\n    [{}]\n}}\n\
         \n/// The control that an action puts on the system.\npub fn control(action: &[f64; {actions}]) -> [f64; K] {{\n{control}}}\n\
         \n/// The state within its declared bounds, as it was while the policy was trained.\npub fn clip(x: &[f64; N]) -> [f64; N] {{\n    [{}]\n}}\n",
        readings.len(),
        readings.join(", "),
        clipped("x", &interface.bounds)
    )
}

/// The elements of `array`, each between its bounds.
fn clipped(array: &str, bounds: &[(f64, f64)]) -> String {
    let bound = |value: f64| match value {
        f64::INFINITY => "f64::INFINITY".to_owned(),
        f64::NEG_INFINITY => "f64::NEG_INFINITY".to_owned(),
        _ => format!("{value:?}"),
    };
    let each = bounds.iter().enumerate();
    let each: Vec<String> =
        each.map(|(i, (low, high))| format!("{array}[{i}].clamp({}, {})", bound(*low), bound(*high))).collect();
    each.join(", ")
}
