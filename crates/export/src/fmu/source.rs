//! The C of an FMU.

use sindyna_sindy::export::Stepping;

use crate::c::{self, Style};
use crate::code::{list, number};
use crate::program::Program;

const FMI: &str = include_str!("fmi2.c");

/// One file without headers of its own; `start` are the values of all variables at the beginning.
pub(super) fn write(program: &Program, guid: &str, start: &[f64]) -> String {
    let system = &program.system;
    let coefficients = system.equations.iter().map(Vec::len).sum::<usize>();
    let mut text = String::from("/* Written by sindyna export. */\n");
    text += &program.comments().iter().map(|line| format!("/* {line} */\n")).collect::<String>();
    text += &format!(
        "\n#include <math.h>\n#include <stdlib.h>\n#include <string.h>\n\n\
         enum {{ STATES = {}, INPUTS = {}, COEFFICIENTS = {coefficients}, ONLY_WHOLE = {} }};\n\n\
         /* Control interval in seconds. */\n#define DT {:?}\n#define GUID \"{guid}\"\n\n\
         static const double start[STATES + INPUTS + COEFFICIENTS] = {{\n    {}\n}};\n",
        system.states.len(),
        system.controls.len(),
        i32::from(only_whole(&system.stepping)),
        system.dt,
        list(start.iter().map(|v| number(*v)))
    );
    let style = Style {
        linkage: "static ",
        first: ("const double *c, ", "c, "),
        first_of_step: "const double *c, double dt, ",
        unused: ("    (void)c;\n", "    (void)c;\n    (void)dt;\n"),
        dt: "dt",
        coefficient: &|k, _| format!("c[{k}]"),
    };
    text += &(c::helpers(system, &[]) + &c::equations(system, &style));
    let clipped = |name: &str, bounds: &[(f64, f64)]| {
        let each = bounds.iter().enumerate();
        each.map(|(i, (low, high))| c::clip(name, name, i, *low, *high)).collect::<String>()
    };
    let (states, controls) = match program.closed() {
        Some(interface) => (clipped("x", &interface.bounds), clipped("u", &interface.controls)),
        None => (String::new(), String::new()),
    };
    text += &format!(
        "\n/* Declared bounds, as they were while a policy was trained. */\n\
         static void clip_control(double *u)\n{{\n    (void)u;\n{controls}}}\n\
         static void clip_state(double *x)\n{{\n    (void)x;\n{states}}}\n"
    );
    text + FMI
}

/// Whether the equations know steps of the control interval alone.
pub(super) fn only_whole(stepping: &Stepping) -> bool {
    matches!(stepping, Stepping::Map | Stepping::Increment)
}
