//! `modelDescription.xml`.

use sindyna_sindy::Entry;
use sindyna_sindy::export::System;

use super::source::only_whole;
use crate::program::{PRODUCER, Program, harmless};

/// A variable with the value it begins with.
pub(super) struct Variable {
    name: String,
    description: String,
    role: Role,
    pub(super) start: f64,
}

/// What importers may do with a variable.
#[derive(Clone, Copy, PartialEq)]
enum Role {
    State,
    Input,
    Coefficient,
}

/// States, inputs and coefficients; the value reference of each is its place.
pub(super) fn variables(program: &Program) -> Vec<Variable> {
    let system = &program.system;
    let (n, k) = (system.states.len(), system.controls.len());
    let interface = program.interface.as_ref();
    let first = interface.and_then(|i| i.starts.first()).filter(|x| x.len() == n).cloned();
    let first = first.unwrap_or_else(|| vec![0.0; n]);
    let held = interface.map(|i| i.held.clone()).filter(|u| u.len() == k).unwrap_or_else(|| vec![0.0; k]);
    let mut all = Vec::new();
    let mut add = |name: &str, description: &str, role: Role, start: f64| {
        let name = unique(name, &all);
        all.push(Variable { name, description: description.to_owned(), role, start });
    };
    for (name, start) in system.states.iter().zip(first) {
        add(name, name, Role::State, start);
    }
    for (name, start) in system.controls.iter().zip(held) {
        add(name, name, Role::Input, start);
    }
    let entries = system.equations.iter().enumerate().flat_map(|(i, row)| row.iter().map(move |entry| (i, entry)));
    for (number, (i, entry)) in entries.enumerate() {
        add(&format!("c{number}"), &described(system, i, entry), Role::Coefficient, entry.coefficient);
    }
    all
}

/// What a coefficient stands before.
fn described(system: &System, i: usize, entry: &Entry) -> String {
    let names: Vec<String> = system.states.iter().chain(&system.controls).cloned().collect();
    let left = system.text.get(i).and_then(|text| text.split(" = ").next()).unwrap_or_default();
    let rate = entry.rate.map_or_else(String::new, |l| format!(", times the rate of {}", names[l]));
    format!("{left}: {}{rate}", system.terms[entry.term].pretty(&names))
}

/// `name` of letters, digits and `_` alone, unlike all others.
fn unique(name: &str, others: &[Variable]) -> String {
    let mut unique: String = name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
    if !unique.starts_with(|c: char| c.is_alphabetic() || c == '_') {
        unique.insert(0, '_');
    }
    while unique == "time" || others.iter().any(|other| other.name == unique) {
        unique.push('_');
    }
    unique
}

/// The document.
pub(super) fn write(program: &Program, identifier: &str, guid: &str, variables: &[Variable]) -> String {
    let system = &program.system;
    let name = program.interface.as_ref().map_or("model", |interface| &interface.name);
    let listed: String = variables.iter().enumerate().map(|(i, variable)| element(i, variable)).collect();
    let states = (1..=system.states.len()).map(|i| format!("      <Unknown index=\"{i}\" dependencies=\"\"/>\n"));
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"2.0\" modelName=\"{}\" guid=\"{guid}\" description=\"{}\" \
         generationTool=\"{} {}\" variableNamingConvention=\"flat\" numberOfEventIndicators=\"0\">\n  \
         <CoSimulation modelIdentifier=\"{identifier}\" canHandleVariableCommunicationStepSize=\"{}\" canNotUseMemoryManagementFunctions=\"true\" \
         canGetAndSetFMUstate=\"true\" canSerializeFMUstate=\"true\">\n    <SourceFiles>\n      <File name=\"model.c\"/>\n    </SourceFiles>\n  \
         </CoSimulation>\n  <DefaultExperiment startTime=\"0\" stepSize=\"{:?}\"/>\n  <ModelVariables>\n{listed}  </ModelVariables>\n  \
         <ModelStructure>\n    <Outputs>\n{}    </Outputs>\n  </ModelStructure>\n</fmiModelDescription>\n",
        escaped(name),
        escaped(&program.comments().join("; ")),
        PRODUCER,
        env!("CARGO_PKG_VERSION"),
        !only_whole(&system.stepping),
        system.dt,
        states.collect::<String>()
    )
}

fn element(reference: usize, variable: &Variable) -> String {
    let role = match variable.role {
        Role::State => "causality=\"output\" variability=\"continuous\" initial=\"exact\"",
        Role::Input => "causality=\"input\" variability=\"continuous\"",
        Role::Coefficient => "causality=\"parameter\" variability=\"tunable\"",
    };
    format!(
        "    <ScalarVariable name=\"{}\" valueReference=\"{reference}\" description=\"{}\" {role}>\n      <Real start=\"{:?}\"/>\n    </ScalarVariable>\n",
        variable.name,
        escaped(&variable.description),
        variable.start
    )
}

/// Text for an attribute; XML has no characters at the end of a plane.
fn escaped(text: &str) -> String {
    harmless(text)
        .replace(['\u{fffe}', '\u{ffff}'], "_")
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unlike_each_other_and_never_markup() {
        let mut all: Vec<Variable> = Vec::new();
        for (name, called) in [
            ("θ", "θ"),
            ("a-b", "a_b"),
            ("a b", "a_b_"),
            ("2x", "_2x"),
            ("", "_"),
            ("time", "time_"),
            ("\"/><x y=\"&\n", "____x_y____"),
        ] {
            let name = unique(name, &all);
            assert_eq!(name, called);
            all.push(Variable { name, description: String::new(), role: Role::State, start: 0.0 });
        }
        assert_eq!(escaped("a<\"&\u{b}\u{ffff}>"), "a&lt;&quot;&amp;__&gt;");
    }
}
