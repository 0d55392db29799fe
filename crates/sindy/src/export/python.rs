//! Python modules that need nothing but NumPy.

use super::expression::{mark_variables, number, numpy};
use super::identifiers::identifiers;
use super::{Friction, Stepping, System, friction};
use crate::expr::Tie;
use crate::{Entry, ModelError};

/// Columns of a line of code.
const WIDTH: usize = 100;

/// A Python module with the equations of `system`: `rhs(x, u)` gives ẋ (Δx/Δt for increments; a map has none),
/// `step(x, u)` the state one control interval later, both over any leading axes. `notes` are lines for its docstring.
///
/// # Errors
/// [`ModelError`] for a system whose lists do not fit each other.
///
/// # Examples
/// ```
/// use sindyna_sindy::{Model, export};
///
/// let model = Model::from_json(
///     r#"{"format": 2, "form": "discrete", "dt": 1.0, "states": ["x"], "controls": ["u"], "terms": ["x*(1-x)", "u"],
///         "equations": [[{"term": 0, "coefficient": 3.7}, {"term": 1, "coefficient": 0.5}]], "kinematic": [false], "n_features": 2}"#,
/// )?;
/// let module = export::python(&export::System::from(&model), &[])?;
/// assert!(module.contains("out[..., 0] = 3.7 * x * (1.0 - x) + 0.5 * u"), "{module}");
/// # Ok::<(), sindyna_sindy::ModelError>(())
/// ```
pub fn python(system: &System, notes: &[String]) -> Result<String, ModelError> {
    system.check()?;
    let writer = Writer { system, names: identifiers(&[&system.states[..], &system.controls[..]].concat()) };
    let functions = match &system.stepping {
        Stepping::Map => writer.right_side("step", "The state one step later."),
        stepping => {
            let what = match stepping {
                Stepping::Increment => "Δx/Δt over one control interval, with u held.",
                _ => "ẋ, the rate of every state.",
            };
            let rates = writer.right_side("rhs", what) + "\n\n";
            match stepping {
                Stepping::Friction(friction) => rates + &writer.friction(friction),
                _ => rates + &writer.step(stepping),
            }
        }
    };
    Ok([writer.head(notes), writer.arguments(), functions].join("\n\n"))
}

struct Writer<'a> {
    system: &'a System,
    /// Variables of the states, then of the controls.
    names: Vec<String>,
}

impl Writer<'_> {
    fn n(&self) -> usize {
        self.system.states.len()
    }

    /// Docstring, import and constants.
    fn head(&self, notes: &[String]) -> String {
        let (n, k) = (self.n(), self.system.controls.len());
        let equations: Vec<String> = self.system.text.iter().map(|e| format!("    {}", plain(e))).collect();
        let functions = match self.system.stepping {
            Stepping::Map => "step(x, u) gives the next state",
            Stepping::Increment => "rhs(x, u) gives Δx/Δt, step(x, u) the state one control interval later",
            _ => "rhs(x, u) gives ẋ, step(x, u) the state one control interval later",
        };
        let notes: String = notes.iter().map(|note| plain(note) + "\n").collect();
        let notes = if notes.is_empty() { notes } else { notes + "\n" };
        format!(
            "\"\"\"Equations of motion, found by sindyna.\n\n{}\n\n{notes}{functions}.\nx is (..., {n}) in the order of \
             STATES, u is (..., {k}) in the order of INPUTS; leading axes broadcast.\nDT is the control interval in \
             seconds. Nothing but NumPy is needed.\n\"\"\"\n\nimport numpy as np\n\nSTATES = {}\nINPUTS = {}\nDT = {}\n",
            equations.join("\n"),
            tuple(&self.system.states),
            tuple(&self.system.controls),
            number(self.system.dt),
        )
    }

    /// The function that checks x and u.
    fn arguments(&self) -> String {
        let (n, k) = (self.n(), self.system.controls.len());
        let check = |name: &str, width: usize| {
            format!(
                "    {name} = np.asarray({name}, dtype=float)\n    if {name}.ndim == 0 or {name}.shape[-1] != {width}:\n        \
                 raise ValueError(f\"{name} must have shape (..., {width}), got {{{name}.shape}}\")\n"
            )
        };
        let (control, shape) = match k {
            0 => (String::new(), "x.shape[:-1]".to_owned()),
            _ => (check("u", k), "np.broadcast_shapes(x.shape[:-1], u.shape[:-1])".to_owned()),
        };
        format!(
            "def _arguments(x, u):\n    \"\"\"x and u as arrays, and room for one number per state.\"\"\"\n{}{control}    \
             return x, u, np.zeros({shape} + ({n},))\n",
            check("x", n)
        )
    }

    /// The parameters of a function.
    fn parameters(&self) -> &'static str {
        if self.system.controls.is_empty() { "x, u=None" } else { "x, u" }
    }

    /// The function `name` that computes the sums of all equations, and solves them for the rates if they hold some.
    fn right_side(&self, name: &str, what: &str) -> String {
        let head = format!("def {name}({}):\n    \"\"\"{what}\"\"\"\n", self.parameters());
        head + "    state, control, out = _arguments(x, u)\n" + &self.sums()
    }

    /// Rates over signs that are given, and a step with dry friction made of them.
    fn friction(&self, friction: &Friction) -> String {
        let system = &friction.held;
        let held = Writer { system, names: identifiers(&[&system.states[..], &system.controls[..]].concat()) };
        let rates = format!(
            "def _rates(state, control):\n    \"\"\"The same rates with the signs beside friction as further inputs.\"\"\"\n    \
             out = np.zeros(state.shape)\n{}\n\n",
            held.sums()
        );
        rates + &friction::python(friction, self.system.controls.len(), self.parameters())
    }

    /// The body of a function of `state`, `control` and `out`, zeros, that returns what the sums are.
    fn sums(&self) -> String {
        let n = self.n();
        let mut code = String::new();
        let mut used = vec![false; self.names.len()];
        for entry in self.system.equations.iter().flatten() {
            mark_variables(&self.system.terms[entry.term], &mut used);
        }
        for (i, name) in self.names.iter().enumerate().filter(|(i, _)| used[*i]) {
            code += &match i.checked_sub(n) {
                None => format!("    {name} = state[..., {i}]\n"),
                Some(i) => format!("    {name} = control[..., {i}]\n"),
            };
        }
        for (i, row) in self.system.equations.iter().enumerate() {
            let free: Vec<&Entry> = row.iter().filter(|e| e.rate.is_none()).collect();
            if !free.is_empty() {
                code += &self.assign(&format!("out[..., {i}]"), &free);
            }
        }
        if !self.system.is_implicit() {
            return code + "    return out\n";
        }
        code += &format!(
            "    # Terms that multiply a rate: (1 - coupling) · rates = out.\n    coupling = np.zeros(out.shape + ({n},))\n"
        );
        for (i, row) in self.system.equations.iter().enumerate() {
            for l in 0..n {
                let coupled: Vec<&Entry> = row.iter().filter(|e| e.rate == Some(l)).collect();
                if !coupled.is_empty() {
                    code += &self.assign(&format!("coupling[..., {i}, {l}]"), &coupled);
                }
            }
        }
        code + &format!("    return np.linalg.solve(np.eye({n}) - coupling, out[..., np.newaxis])[..., 0]\n")
    }

    /// The line (or lines) `target = sum of entries`.
    fn assign(&self, target: &str, entries: &[&Entry]) -> String {
        let summands: Vec<String> = entries.iter().enumerate().map(|(at, entry)| self.summand(at, entry)).collect();
        let line = format!("    {target} = {}\n", summands.join(" "));
        if line.chars().count() <= WIDTH {
            return line;
        }
        let lines: String = summands.iter().map(|s| format!("        {s}\n")).collect();
        format!("    {target} = (\n{lines}    )\n")
    }

    /// Summand number `at` of a sum, with its sign.
    fn summand(&self, at: usize, entry: &Entry) -> String {
        let (c, term) = (entry.coefficient, &self.system.terms[entry.term]);
        let sign = match (at, c < 0.0) {
            (0, false) => "",
            (0, true) => "-",
            (_, false) => "+ ",
            (_, true) => "- ",
        };
        let factor = || numpy(term, &self.names, Tie::Product);
        match (term.is_one(), c.abs().to_bits() == 1_f64.to_bits()) {
            (true, _) => format!("{sign}{}", number(c.abs())),
            (false, true) => format!("{sign}{}", factor()),
            (false, false) => format!("{sign}{} * {}", number(c.abs()), factor()),
        }
    }

    /// The function `step` for equations of rates.
    fn step(&self, stepping: &Stepping) -> String {
        let body = match stepping {
            Stepping::Rk4 { substeps } => format!(
                "    h = DT / {substeps}\n    for _ in range({substeps}):\n        k1 = rhs(x, u)\n        \
                 k2 = rhs(x + 0.5 * h * k1, u)\n        k3 = rhs(x + 0.5 * h * k2, u)\n        \
                 k4 = rhs(x + h * k3, u)\n        x = x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)\n    return x\n"
            ),
            Stepping::SemiImplicitEuler { positions, substeps } => {
                let order: Vec<String> = positions.iter().map(usize::to_string).collect();
                format!(
                    "    h = DT / {substeps}\n    for _ in range({substeps}):\n        moved = x + h * rhs(x, u)\n        for i in [{}]:\n            \
                     moved[..., i] = x[..., i] + h * rhs(moved, u)[..., i]\n        x = moved\n    return x\n",
                    order.join(", ")
                )
            }
            _ => "    return x + DT * rhs(x, u)\n".to_owned(),
        };
        let how = match stepping {
            Stepping::Rk4 { .. } => ": classical Runge-Kutta, u held",
            Stepping::SemiImplicitEuler { .. } => ": rates first, then positions by the new rates, u held",
            Stepping::Euler => ": one Euler step, u held",
            _ => "",
        };
        format!(
            "def step({}):\n    \"\"\"The state one control interval later{how}.\"\"\"\n    x = np.asarray(x, \
             dtype=float)\n{body}",
            self.parameters()
        )
    }
}

/// `text` as it can stand in a docstring.
fn plain(text: &str) -> String {
    text.replace(char::is_control, " ").replace('\\', "\\\\").replace('"', "\\\"")
}

/// A tuple of strings. What JSON quotes Python reads.
fn tuple(names: &[String]) -> String {
    let quoted: Vec<String> = names.iter().map(|n| serde_json::Value::from(n.as_str()).to_string()).collect();
    match &quoted[..] {
        [one] => format!("({one},)"),
        _ => format!("({})", quoted.join(", ")),
    }
}
