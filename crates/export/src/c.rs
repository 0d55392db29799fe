//! C99 without allocation.

use sindyna_sindy::export::Stepping;
use sindyna_sindy::{Function, export::System};

use super::code::{Dialect, assignments, list, uses, value};
use super::network::{Head, Network};
use super::program::Program;

const DIALECT: Dialect = Dialect {
    call: |function, a| match function {
        Function::Abs => format!("fabs({a})"),
        Function::Sign => format!("sign_of({a})"),
        Function::PositivePart => format!("positive_part({a})"),
        other => format!("{}({a})", other.name()),
    },
    power: |a, exponent| format!("pow({a}, {exponent}.0)"),
};

/// A file of C.
pub(super) fn write(program: &Program) -> String {
    let system = &program.system;
    let mut text = String::from("/* Written by sindyna export. */\n");
    for line in program.comments() {
        text += &format!("/* {line} */\n");
    }
    text += "/* Compile with a C99 compiler and link with -lm. Declare what you call:\n";
    text += &prototypes(program).iter().map(|p| format!("   {p};\n")).collect::<String>();
    text += "*/\n\n#include <math.h>\n\n";
    text += &format!(
        "enum {{ STATES = {}, INPUTS = {} }};\n\n/* Control interval in seconds. */\nconst double sindyna_dt = {:?};\n",
        system.states.len(),
        system.controls.len(),
        system.dt
    );
    if uses(system, Function::Sign) {
        text += "\nstatic double sign_of(double a) { return a > 0.0 ? 1.0 : a < 0.0 ? -1.0 : a * 0.0; }\n";
    }
    if uses(system, Function::PositivePart) {
        text += "\nstatic double positive_part(double a) { return a < 0.0 ? 0.0 : a; }\n";
    }
    text += &equations(system);
    text + &program.policy.as_ref().map_or_else(String::new, policy)
}

fn prototypes(program: &Program) -> Vec<&'static str> {
    let rhs = "void sindyna_rhs(const double *x, const double *u, double *rate)";
    let step = "void sindyna_step(const double *x, const double *u, double *next)";
    let act = "void sindyna_act(const double *o, double *action)";
    let mut all = if program.system.stepping == Stepping::Map { vec![step] } else { vec![rhs, step] };
    all.extend(program.policy.as_ref().map(|_| act));
    all
}

fn equations(system: &System) -> String {
    if system.stepping == Stepping::Map {
        let lines = assignments(&DIALECT, system, "next", &value, |i, l| format!("left[{i}][{l}]"));
        return format!(
            "\n/* The state one step later. next must not be x. */\nvoid sindyna_step(const double *x, const double *u, double *next)\n{{\n    (void)x;\n    (void)u;\n{lines}}}\n"
        );
    }
    let lines = assignments(&DIALECT, system, "rate", &value, |i, l| format!("left[{i}][{l}]"));
    let (before, after) = if system.is_implicit() { (COUPLING, SOLVE) } else { ("", "") };
    format!(
        "\n/* The rate of every state. rate must not be x. */\nvoid sindyna_rhs(const double *x, const double *u, double *rate)\n{{\n{before}    (void)x;\n    (void)u;\n{lines}{after}}}\n{}",
        step(&system.stepping)
    )
}

const COUPLING: &str = "\
    double left[STATES][STATES];
    int i, j, k;
    for (i = 0; i < STATES; i++) {
        for (j = 0; j < STATES; j++) left[i][j] = i == j ? 1.0 : 0.0;
    }
";

/// Gaussian elimination with the largest pivot of each column.
const SOLVE: &str = "\
    for (k = 0; k < STATES; k++) {
        int pivot = k;
        double held;
        for (i = k + 1; i < STATES; i++) {
            if (fabs(left[i][k]) > fabs(left[pivot][k])) pivot = i;
        }
        held = rate[k]; rate[k] = rate[pivot]; rate[pivot] = held;
        for (j = 0; j < STATES; j++) {
            held = left[k][j]; left[k][j] = left[pivot][j]; left[pivot][j] = held;
        }
        for (i = k + 1; i < STATES; i++) {
            const double factor = left[i][k] / left[k][k];
            for (j = k; j < STATES; j++) left[i][j] -= factor * left[k][j];
            rate[i] -= factor * rate[k];
        }
    }
    for (k = STATES - 1; k >= 0; k--) {
        for (j = k + 1; j < STATES; j++) rate[k] -= left[k][j] * rate[j];
        rate[k] /= left[k][k];
    }
";

fn step(stepping: &Stepping) -> String {
    let body = match stepping {
        Stepping::Rk4 { substeps } => format!(
            "    double k1[STATES], k2[STATES], k3[STATES], k4[STATES], at[STATES];
    const double h = sindyna_dt / {substeps};
    int part, i;
    for (i = 0; i < STATES; i++) next[i] = x[i];
    for (part = 0; part < {substeps}; part++) {{
        sindyna_rhs(next, u, k1);
        for (i = 0; i < STATES; i++) at[i] = next[i] + 0.5 * h * k1[i];
        sindyna_rhs(at, u, k2);
        for (i = 0; i < STATES; i++) at[i] = next[i] + 0.5 * h * k2[i];
        sindyna_rhs(at, u, k3);
        for (i = 0; i < STATES; i++) at[i] = next[i] + h * k3[i];
        sindyna_rhs(at, u, k4);
        for (i = 0; i < STATES; i++) next[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
    }}
"
        ),
        Stepping::SemiImplicitEuler { positions, substeps } => {
            let moved: String = positions
                .iter()
                .map(|i| {
                    format!("        sindyna_rhs(moved, u, rate);\n        moved[{i}] = next[{i}] + h * rate[{i}];\n")
                })
                .collect();
            format!(
                "    double rate[STATES], moved[STATES];
    const double h = sindyna_dt / {substeps};
    int part, i;
    for (i = 0; i < STATES; i++) next[i] = x[i];
    for (part = 0; part < {substeps}; part++) {{
        sindyna_rhs(next, u, rate);
        for (i = 0; i < STATES; i++) moved[i] = next[i] + h * rate[i];
{moved}        for (i = 0; i < STATES; i++) next[i] = moved[i];
    }}
"
            )
        }
        _ => "    double rate[STATES];
    int i;
    sindyna_rhs(x, u, rate);
    for (i = 0; i < STATES; i++) next[i] = x[i] + sindyna_dt * rate[i];
"
        .to_owned(),
    };
    format!(
        "\n/* The state one control interval later. next must not be x. */\nvoid sindyna_step(const double *x, const double *u, double *next)\n{{\n{body}}}\n"
    )
}

fn policy(network: &Network) -> String {
    let doubles = |name: &str, values: &[f64]| {
        format!(
            "static const double {name}[{}] = {{\n    {}\n}};\n",
            values.len(),
            list(values.iter().map(|v| format!("{v:?}")))
        )
    };
    let floats = |name: String, values: &[f32]| {
        format!(
            "static const float {name}[{}] = {{\n    {}\n}};\n",
            values.len(),
            list(values.iter().map(|v| format!("{v:?}f")))
        )
    };
    let (m, widest) = (network.observed(), network.widest());
    let mut text = "\n/* The policy: a network between scaled observations and actions. */\n".to_owned();
    text += &(doubles("center", &network.center) + &doubles("scale", &network.scale));
    for (l, layer) in network.layers.iter().enumerate() {
        text += &(floats(format!("weights_{l}"), &layer.weights) + &floats(format!("biases_{l}"), &layer.biases));
    }
    text += "
static void layer(const float *weights, const float *biases, int inputs, int outputs, int is_last, const float *in, float *out)
{
    int i, j;
    for (j = 0; j < outputs; j++) {
        double sum = biases[j];
        for (i = 0; i < inputs; i++) sum += (double)in[i] * weights[i * outputs + j];
        out[j] = (float)(is_last || sum > 0.0 ? sum : 0.0);
    }
}
";
    let last = network.layers.len().saturating_sub(1);
    let calls: String = network
        .layers
        .iter()
        .enumerate()
        .map(|(l, layer)| {
            let (from, to) = if l.is_multiple_of(2) { ("a", "b") } else { ("b", "a") };
            let is_last = i32::from(l == last);
            format!(
                "    layer(weights_{l}, biases_{l}, {}, {}, {is_last}, {from}, {to});\n",
                layer.inputs, layer.outputs
            )
        })
        .collect();
    let out = if last.is_multiple_of(2) { "b" } else { "a" };
    let (what, head) = match &network.head {
        Head::Squashed { low, high } => {
            text += &(doubles("low", low) + &doubles("high", high));
            let k = low.len();
            (
                "The action for an observation.",
                format!(
                    "    for (i = 0; i < {k}; i++) {{\n        const double value = low[i] + 0.5 * (tanh((double){out}[i]) + 1.0) * (high[i] - low[i]);\n        action[i] = value < low[i] ? low[i] : value > high[i] ? high[i] : value;\n    }}\n"
                ),
            )
        }
        Head::Largest => {
            let n = network.layers.last().map_or(0, |layer| layer.outputs);
            (
                "The number of the action for an observation.",
                format!(
                    "    action[0] = 0.0;\n    for (i = 1; i < {n}; i++) {{\n        if ({out}[i] > {out}[(int)action[0]]) action[0] = i;\n    }}\n"
                ),
            )
        }
    };
    text + &format!(
        "\n/* {what} */\nvoid sindyna_act(const double *o, double *action)\n{{\n    float a[{widest}], b[{widest}];\n    int i;\n    for (i = 0; i < {m}; i++) a[i] = (float)((o[i] - center[i]) / scale[i]);\n{calls}{head}}}\n"
    )
}
