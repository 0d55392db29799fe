//! Identifies the equations of motion of a pendulum from a CSV file and writes them as a Python module.

#![allow(clippy::print_stdout, reason = "printing is what it is for")]

use sindyna::identify;
use sindyna::logs::{Log, LogOptions};

fn main() -> Result<(), sindyna::Error> {
    // The header is `t,th [rad],w [rad/s],u [N·m]`: two states, of which one is an angle, and an input.
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/logs/pendulum.csv");
    let log = Log::read(path, &LogOptions::new(["th", "w"]).with_inputs(["u"]).with_angles(["th"]))?;
    for note in &log.notes {
        println!("note: {note}");
    }

    let found = identify::log(&log)?;
    for term in &found.account.equations[1].terms {
        println!("{:>8}  {:.6} ± {:.1e}", term.term, term.coefficient, term.standard_error.unwrap_or(f64::NAN));
    }
    println!("residuals at the noise floor: {:?}", found.is_explained());

    // `rhs` and `step` as Python functions that need NumPy alone.
    let module = identify::export::python(&(&found.model).into(), &[]).expect("these terms have a Python form");
    assert!(module.contains("def step") && found.equations()[1].contains("15 sin th"));
    Ok(())
}

#[cfg(test)]
#[test]
fn it_runs() {
    main().expect("the example runs");
}
