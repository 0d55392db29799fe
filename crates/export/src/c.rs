//! C99 without allocation.

use sindyna_sindy::export::Stepping;
use sindyna_sindy::{Expr, Function, export::System};

use super::code::{Coefficient, Dialect, assignments, expression, list, uses, value};
use super::friction;
use super::interface::Interface;
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
    end: ";",
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
    if program.closed().is_some() {
        text += CLOSED;
    }
    text += "*/\n\n#include <math.h>\n\n";
    text += &format!(
        "enum {{ STATES = {}, INPUTS = {} }};\n\n/* Control interval in seconds. */\nconst double sindyna_dt = {:?};\n",
        system.states.len(),
        system.controls.len(),
        system.dt
    );
    text += &helpers(system, program.readings());
    text += &equations(system, &Style::FILE);
    text += &program.policy.as_ref().map_or_else(String::new, policy);
    text + &program.closed().map_or_else(String::new, closed)
}

/// How the functions follow each other.
const CLOSED: &str = "   One step of equations and policy:
   sindyna_observe(x, o); sindyna_act(o, action); sindyna_control(action, u);
   sindyna_step(x, u, next); sindyna_clip(next);
";

fn prototypes(program: &Program) -> Vec<&'static str> {
    let rhs = "void sindyna_rhs(const double *x, const double *u, double *rate)";
    let step = "void sindyna_step(const double *x, const double *u, double *next)";
    let act = "void sindyna_act(const double *o, double *action)";
    let mut all = if program.system.stepping == Stepping::Map { vec![step] } else { vec![rhs, step] };
    all.extend(program.policy.as_ref().map(|_| act));
    if program.closed().is_some() {
        all.extend([
            "void sindyna_observe(const double *x, double *o)",
            "void sindyna_control(const double *action, double *u)",
            "void sindyna_clip(double *x)",
        ]);
    }
    all
}

/// How equations are written where they are not a file of their own.
pub(super) struct Style<'a> {
    /// What stands before a function.
    pub(super) linkage: &'a str,
    /// What a function is given first, and how that is handed on.
    pub(super) first: (&'a str, &'a str),
    /// The same of `step`.
    pub(super) first_of_step: &'a str,
    /// Statements that keep a compiler from warning of what both may leave unused.
    pub(super) unused: (&'a str, &'a str),
    /// The control interval.
    pub(super) dt: &'a str,
    /// Coefficients.
    pub(super) coefficient: Coefficient<'a>,
}

impl Style<'_> {
    const FILE: Self = Self {
        linkage: "",
        first: ("", ""),
        first_of_step: "",
        unused: ("", ""),
        dt: "sindyna_dt",
        coefficient: &value,
    };
}

/// Helpers that the terms of `system`, or the `others`, call.
pub(super) fn helpers(system: &System, others: &[Expr]) -> String {
    let mut text = String::new();
    if uses(system, others, Function::Sign) {
        text += "\nstatic double sign_of(double a) { return a > 0.0 ? 1.0 : a < 0.0 ? -1.0 : a * 0.0; }\n";
    }
    if uses(system, others, Function::PositivePart) {
        text += "\nstatic double positive_part(double a) { return a < 0.0 ? 0.0 : a; }\n";
    }
    text
}

/// The functions `sindyna_rhs` and `sindyna_step`.
pub(super) fn equations(system: &System, style: &Style<'_>) -> String {
    let Style { linkage, first: (_, pass), first_of_step, unused: (_, of_step), coefficient, .. } = style;
    if system.stepping == Stepping::Map {
        let lines = assignments(&DIALECT, system, "next", *coefficient, |i, l| format!("left[{i}][{l}]"));
        return format!(
            "\n/* The state one step later. next must not be x. */\n{linkage}void sindyna_step({first_of_step}const double *x, const double *u, double *next)\n{{\n{of_step}    (void)x;\n    (void)u;\n{lines}}}\n"
        );
    }
    // Where a step has rates of its own, nobody may call these.
    let rates = if matches!(system.stepping, Stepping::Friction(_)) && !linkage.is_empty() {
        String::new()
    } else {
        format!("\n/* The rate of every state. rate must not be x. */\n{linkage}{}", rates(system, "rhs", style))
    };
    let held = match &system.stepping {
        Stepping::Friction(friction) => {
            let of = "The same with the signs beside dry friction as further inputs.";
            format!("\n/* {of} */\nstatic {}", self::rates(&friction.held, "rates_held", style))
        }
        _ => String::new(),
    };
    rates + &held + &step(&system.stepping, style, pass)
}

/// A function of the rates.
fn rates(system: &System, name: &str, style: &Style<'_>) -> String {
    let Style { first: (first, _), unused: (unused, _), coefficient, .. } = style;
    let lines = assignments(&DIALECT, system, "rate", *coefficient, |i, l| format!("left[{i}][{l}]"));
    let (before, after) = if system.is_implicit() { (COUPLING, SOLVE) } else { ("", "") };
    format!(
        "void sindyna_{name}({first}const double *x, const double *u, double *rate)\n{{\n{before}{unused}    (void)x;\n    (void)u;\n{lines}{after}}}\n"
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

fn step(stepping: &Stepping, style: &Style<'_>, pass: &str) -> String {
    let (dt, linkage, first) = (style.dt, style.linkage, style.first_of_step);
    let body = match stepping {
        Stepping::Rk4 { substeps } => format!(
            "    double k1[STATES], k2[STATES], k3[STATES], k4[STATES], at[STATES];
    const double h = {dt} / {substeps};
    int part, i;
    for (i = 0; i < STATES; i++) next[i] = x[i];
    for (part = 0; part < {substeps}; part++) {{
        sindyna_rhs({pass}next, u, k1);
        for (i = 0; i < STATES; i++) at[i] = next[i] + 0.5 * h * k1[i];
        sindyna_rhs({pass}at, u, k2);
        for (i = 0; i < STATES; i++) at[i] = next[i] + 0.5 * h * k2[i];
        sindyna_rhs({pass}at, u, k3);
        for (i = 0; i < STATES; i++) at[i] = next[i] + h * k3[i];
        sindyna_rhs({pass}at, u, k4);
        for (i = 0; i < STATES; i++) next[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
    }}
"
        ),
        Stepping::SemiImplicitEuler { positions, substeps } => {
            let moved: String = positions
                .iter()
                .map(|i| {
                    format!(
                        "        sindyna_rhs({pass}moved, u, rate);\n        moved[{i}] = next[{i}] + h * rate[{i}];\n"
                    )
                })
                .collect();
            format!(
                "    double rate[STATES], moved[STATES];
    const double h = {dt} / {substeps};
    int part, i;
    for (i = 0; i < STATES; i++) next[i] = x[i];
    for (part = 0; part < {substeps}; part++) {{
        sindyna_rhs({pass}next, u, rate);
        for (i = 0; i < STATES; i++) moved[i] = next[i] + h * rate[i];
{moved}        for (i = 0; i < STATES; i++) next[i] = moved[i];
    }}
"
            )
        }
        Stepping::Friction(friction) => friction::c(friction, dt, pass),
        _ => format!(
            "    double rate[STATES];
    int i;
    sindyna_rhs({pass}x, u, rate);
    for (i = 0; i < STATES; i++) next[i] = x[i] + {dt} * rate[i];
"
        ),
    };
    format!(
        "\n/* The state one control interval later. next must not be x. */\n{linkage}void sindyna_step({first}const double *x, const double *u, double *next)\n{{\n{body}}}\n"
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
            let n = network.outputs();
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

/// Observations, controls and bounds.
fn closed(interface: &Interface) -> String {
    let shown = if interface.rounded { "(float)" } else { "" };
    let n = interface.bounds.len();
    let readings = interface.readings.iter().enumerate();
    let readings: String =
        readings.map(|(i, o)| format!("    o[{i}] = {shown}{};\n", expression(&DIALECT, o, n))).collect();
    let control = if interface.numbered.is_empty() {
        let clipped = |(i, (low, high)): (usize, &(f64, f64))| clip("u", "action", i, *low, *high);
        interface.controls.iter().enumerate().map(clipped).collect::<String>()
    } else {
        let last = interface.numbered.len() - 1;
        let row = |u: &Vec<f64>| format!("{{ {} }}", list(u.iter().map(|v| format!("{v:?}"))));
        let rows: Vec<String> = interface.numbered.iter().map(row).collect();
        format!(
            "    static const double controls[{}][INPUTS] = {{\n        {}\n    }};\n    \
             const int number = action[0] > 0.0 ? action[0] < {last}.0 ? (int)action[0] : {last} : 0;\n    int i;\n    \
             for (i = 0; i < INPUTS; i++) u[i] = controls[number][i];\n",
            rows.len(),
            rows.join(",\n        ")
        )
    };
    let bounds = interface.bounds.iter().enumerate();
    let bounds: String = bounds.map(|(i, (low, high))| clip("x", "x", i, *low, *high)).collect();
    format!(
        "\n/* What the policy observes of a state. */\nvoid sindyna_observe(const double *x, double *o)\n{{\n{readings}}}\n\
         \n/* The control that an action puts on the system. */\nvoid sindyna_control(const double *action, double *u)\n{{\n{control}}}\n\
         \n/* Keeps a state within its declared bounds, as it was while the policy was trained. */\nvoid sindyna_clip(double *x)\n{{\n    (void)x;\n{bounds}}}\n"
    )
}

/// `to` is `from` between `low` and `high`; a NaN stays one.
pub(super) fn clip(to: &str, from: &str, i: usize, low: f64, high: f64) -> String {
    let mut value = format!("{from}[{i}]");
    if high.is_finite() {
        value = format!("{from}[{i}] > {high:?} ? {high:?} : {value}");
    }
    if low.is_finite() {
        value = format!("{from}[{i}] < {low:?} ? {low:?} : {value}");
    }
    if to == from && !low.is_finite() && !high.is_finite() {
        return String::new();
    }
    format!("    {to}[{i}] = {value};\n")
}
