//! A page to play with: equations and policy as JavaScript, a picture that moves, a slider for every coefficient, a push by the pointer.

use serde_json::json;
use sindyna_sindy::Entry;

use super::code::number;
use super::interface::Interface;
use super::javascript;
use super::program::Program;

const PAGE: &str = include_str!("page.html");
const SCRIPT: &str = include_str!("page.js");

/// One HTML file that needs nothing else.
pub(super) fn write(program: &Program, interface: &Interface) -> String {
    let model = javascript::module(program, &|k, _| format!("C[{k}]")).replace("export ", "");
    // Comments hold names, which could end a script where a comment does not.
    let model: String =
        model.lines().filter(|line| !line.starts_with("//")).map(|line| line.to_owned() + "\n").collect();
    let coefficients: Vec<String> = program.system.equations.iter().flatten().map(|e| number(e.coefficient)).collect();
    let parts = [
        ("TITLE", escaped(&interface.name)),
        ("EQUATIONS", program.system.text.iter().map(|line| escaped(line) + "\n").collect()),
        ("NOTES", escaped(&program.notes.join(" "))),
        ("MODEL", format!("const C = [{}];\n{model}{}", coefficients.join(", "), between(program, interface))),
        ("FACTS", for_script(&facts(program, interface).to_string())),
        ("SCRIPT", SCRIPT.to_owned()),
    ];
    parts.iter().fold(PAGE.to_owned(), |page, (name, text)| page.replace(&format!("{{{{{name}}}}}"), text))
}

/// What the script calls: the control in a state, and the state after it.
fn between(program: &Program, interface: &Interface) -> String {
    let control = match program.closed() {
        None => json!(interface.held).to_string(),
        Some(_) => "control(act(observe(x)))".to_owned(),
    };
    format!(
        "\n// The control that the policy chooses in a state.\nfunction chosen(x) {{\n    return {control};\n}}\n\
         \n// The state one control interval later, within the declared bounds.\nfunction next(x, u) {{\n    \
         x = step(x, u);\n    return [{}];\n}}\n",
        javascript::clipped("x", &interface.bounds)
    )
}

/// What the script has to know besides: start states, ranges of controls, what each coefficient stands before, what to draw.
fn facts(program: &Program, interface: &Interface) -> serde_json::Value {
    let system = &program.system;
    let names: Vec<String> = system.states.iter().chain(&system.controls).cloned().collect();
    let labelled = |(i, row): (usize, &Vec<Entry>)| {
        // A state that is the rate of another by declaration has nothing to be changed.
        let declared =
            matches!(&row[..], [one] if one.coefficient.to_bits() == 1.0_f64.to_bits() && one.rate.is_none());
        let name = |entry: &Entry| {
            let term = system.terms[entry.term].pretty(&names).to_string();
            match entry.rate.map(|l| format!("d{}/dt", names[l])) {
                None => term,
                Some(rate) if term == "1" => rate,
                Some(rate) => format!("{term} · {rate}"),
            }
        };
        let left = system.text.get(i).and_then(|text| text.split(" = ").next()).unwrap_or_default();
        row.iter().map(|entry| json!({"equation": left, "term": name(entry), "fixed": declared})).collect::<Vec<_>>()
    };
    let coefficients: Vec<_> = system.equations.iter().enumerate().flat_map(labelled).collect();
    let at = |name: &str| system.states.iter().position(|state| state == name);
    let shape = match (interface.name.as_str(), at("x"), at("θ")) {
        ("cart-pole" | "cart-pole-swing-up" | "inverted-pendulum", Some(x), Some(angle)) => {
            json!({"kind": "cart-pole", "x": x, "angle": angle})
        }
        ("pendulum", _, Some(angle)) => json!({"kind": "pendulum", "angle": angle}),
        ("mountain-car", Some(x), _) => json!({"kind": "car", "x": x}),
        _ => json!({"kind": "portrait"}),
    };
    json!({
        "starts": interface.starts, "controls": interface.controls, "held": interface.held, "names": interface.labels, "inputs": system.controls,
        "coefficients": coefficients, "shape": shape, "policy": program.closed().is_some(),
    })
}

/// Text for HTML.
fn escaped(text: &str) -> String {
    let text: String = text.chars().filter(|c| !c.is_control()).collect();
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// JSON within a script: nothing in it ends the script.
fn for_script(json: &str) -> String {
    json.replace('<', "\\u003c").replace('\u{2028}', "\\u2028").replace('\u{2029}', "\\u2029")
}
