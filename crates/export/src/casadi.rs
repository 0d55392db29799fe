//! Python modules of CasADi functions, which can be differentiated.

use sindyna_sindy::Function;
use sindyna_sindy::export::{Stepping, System};

use super::code::{Dialect, assignments, expression, list, number, uses, value};
use super::friction;
use super::interface::Interface;
use super::network::{Head, Network};
use super::program::Program;

const DIALECT: Dialect = Dialect {
    call: |function, a| match function {
        Function::Abs => format!("ca.fabs({a})"),
        Function::PositivePart => format!("_positive_part({a})"),
        other => format!("ca.{}({a})", other.name()),
    },
    power: |a, exponent| format!("({a}**{exponent})"),
    end: "",
};

/// A module of Python.
pub(super) fn write(program: &Program) -> String {
    let system = &program.system;
    let is_map = system.stepping == Stepping::Map;
    let mut text = String::from("\"\"\"CasADi functions, written by sindyna export.\"\"\"\n\n");
    text += &program.comments().iter().map(|line| format!("# {line}\n")).collect::<String>();
    text +=
        "#\n# Each is a casadi.Function, called with numbers or with symbols; its derivatives are those of CasADi:\n";
    if !is_map {
        text += "#   f(x, u)     rate of every state\n";
    }
    text += "#   F(x, u)     state one control interval later\n";
    if program.policy.is_some() {
        text += "#   policy(o)   action for an observation\n";
    }
    if program.closed().is_some() {
        text += "#   observe(x), control(action), clip(x)   what closes the loop:\n#   x = clip(F(x, control(policy(observe(x)))))\n";
    }
    if let Stepping::Friction(_) = system.stepping {
        text += "#   held(x, u)  f with the signs beside dry friction as further inputs\n";
    }
    text += "\nimport casadi as ca\nimport numpy as np\n\n";
    text += &format!(
        "STATES = {}\nINPUTS = {}\n# Control interval in seconds.\nDT = {:?}\n",
        system.states.len(),
        system.controls.len(),
        system.dt
    );
    if uses(system, program.readings(), Function::PositivePart) {
        text += "\n\ndef _positive_part(a):\n    return ca.if_else(a < 0.0, 0.0, a)\n";
    }
    if is_map {
        text += &right_side(system, "F", "next");
    } else {
        text += &right_side(system, "f", "rate");
        if let Stepping::Friction(friction) = &system.stepping {
            text += &right_side(&friction.held, "held", "rate");
        }
        text += &step(&system.stepping);
    }
    text += &program.policy.as_ref().map_or_else(String::new, policy);
    text + &program.closed().map_or_else(String::new, closed)
}

/// Observations, in double precision, controls and bounds.
fn closed(interface: &Interface) -> String {
    let bound = |value: f64| match value {
        f64::INFINITY => "ca.inf".to_owned(),
        f64::NEG_INFINITY => "-ca.inf".to_owned(),
        _ => number(value),
    };
    let clipped = |name: &str, bounds: &[(f64, f64)]| {
        let column = |of: fn(&(f64, f64)) -> f64| list(bounds.iter().map(|b| bound(of(b))));
        format!("ca.fmin(ca.fmax({name}, ca.DM([{}])), ca.DM([{}]))", column(|b| b.0), column(|b| b.1))
    };
    let readings = interface.readings.iter().map(|o| expression(&DIALECT, o, interface.bounds.len()));
    let (width, control) = if interface.numbered.is_empty() {
        ("INPUTS", format!("    u = {}\n", clipped("action", &interface.controls)))
    } else {
        let row = |u: &Vec<f64>| format!("ca.DM([{}])", list(u.iter().map(|v| number(*v))));
        let rows = list(interface.numbered.iter().map(row));
        (
            "1",
            format!(
                "    rows = [{rows}]\n    u = rows[0]\n    for i, row in enumerate(rows[1:]):\n        \
                 u = ca.if_else(action > i + 0.5, row, u)\n"
            ),
        )
    };
    let function = |name: &str, argument: &str, width: &str, body: &str, value: &str| {
        format!(
            "\n\ndef _{name}():\n    {argument} = ca.SX.sym(\"{argument}\", {width})\n{body}    \
             return ca.Function(\"{name}\", [{argument}], [{value}])\n\n\n{name} = _{name}()\n"
        )
    };
    function("observe", "x", "STATES", "", &format!("ca.vertcat({})", readings.collect::<Vec<_>>().join(", ")))
        + &function("control", "action", width, &control, "u")
        + &function("clip", "x", "STATES", "", &clipped("x", &interface.bounds))
}

/// The function `name` of the sums of all equations, solved for the rates if they hold some.
fn right_side(system: &System, name: &str, target: &str) -> String {
    let lines = assignments(&DIALECT, system, target, &value, |i, l| format!("left[{i}, {l}]"));
    let (before, after) = if system.is_implicit() {
        ("    left = ca.SX.eye(STATES)\n", format!("    {target} = ca.solve(left, {target})\n"))
    } else {
        ("", String::new())
    };
    format!(
        "\n\ndef _{name}():\n    x, u = ca.SX.sym(\"x\", STATES), ca.SX.sym(\"u\", {})\n    \
         {target} = ca.SX.zeros(STATES)\n{before}{lines}{after}    \
         return ca.Function(\"{name}\", [x, u], [{target}], [\"x\", \"u\"], [\"{target}\"])\n\n\n{name} = _{name}()\n",
        system.controls.len()
    )
}

fn step(stepping: &Stepping) -> String {
    let body = match stepping {
        Stepping::Rk4 { substeps } => format!(
            "    h = DT / {substeps}
    for _ in range({substeps}):
        k1 = f(at, u)
        k2 = f(at + 0.5 * h * k1, u)
        k3 = f(at + 0.5 * h * k2, u)
        k4 = f(at + h * k3, u)
        at = at + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
"
        ),
        Stepping::SemiImplicitEuler { positions, substeps } => {
            let order: Vec<String> = positions.iter().map(ToString::to_string).collect();
            format!(
                "    h = DT / {substeps}
    for _ in range({substeps}):
        moved = at + h * f(at, u)
        for i in [{}]:
            moved[i] = at[i] + h * f(moved, u)[i]
        at = moved
",
                order.join(", ")
            )
        }
        Stepping::Friction(friction) => friction::casadi(friction),
        _ => "    at = at + DT * f(at, u)\n".to_owned(),
    };
    format!(
        "\n\ndef _F():\n    x, u = ca.MX.sym(\"x\", STATES), ca.MX.sym(\"u\", INPUTS)\n    at = x\n{body}    \
         return ca.Function(\"F\", [x, u], [at], [\"x\", \"u\"], [\"next\"])\n\n\nF = _F()\n"
    )
}

fn policy(network: &Network) -> String {
    let doubles = |values: &[f64]| format!("ca.DM([\n    {}\n])", list(values.iter().map(|v| format!("{v:?}"))));
    // Digits of single precision are those of another number in double precision.
    let floats = |values: &[f32]| {
        let digits = list(values.iter().map(|v| format!("{v:?}")));
        format!("np.array([\n    {digits}\n], dtype=np.float32).astype(float)")
    };
    let mut text = format!(
        "\n\n# The policy: a network between scaled observations and actions.\nCENTER = {}\nSCALE = {}\n",
        doubles(&network.center),
        doubles(&network.scale)
    );
    let layers = network.layers.iter().map(|layer| {
        let (weights, biases) = (floats(&layer.weights), floats(&layer.biases));
        format!("    (ca.DM({weights}.reshape({}, {}).T), ca.DM({biases})),\n", layer.inputs, layer.outputs)
    });
    text += &format!("LAYERS = [\n{}]\n", layers.collect::<String>());
    let head = match &network.head {
        Head::Squashed { low, high } => {
            text += &format!("LOW = {}\nHIGH = {}\n", doubles(low), doubles(high));
            "    action = ca.fmin(ca.fmax(LOW + 0.5 * (ca.tanh(at) + 1.0) * (HIGH - LOW), LOW), HIGH)\n".to_owned()
        }
        Head::Largest => format!(
            "    action, largest = ca.MX(0.0), at[0]\n    for i in range(1, {}):\n        \
             action = ca.if_else(at[i] > largest, float(i), action)\n        largest = ca.fmax(at[i], largest)\n",
            network.outputs()
        ),
    };
    text + &format!(
        "\n\ndef _policy():\n    o = ca.MX.sym(\"o\", {})\n    at = (o - CENTER) / SCALE\n    \
         for l, (weights, biases) in enumerate(LAYERS):\n        at = ca.mtimes(weights, at) + biases\n        \
         if l < len(LAYERS) - 1:\n            at = ca.fmax(at, 0.0)\n{head}    \
         return ca.Function(\"policy\", [o], [action], [\"o\"], [\"action\"])\n\n\npolicy = _policy()\n",
        network.observed()
    )
}
