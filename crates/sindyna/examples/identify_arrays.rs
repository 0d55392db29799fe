//! Identifies the equations of motion of a damped oscillator from arrays.

#![allow(clippy::print_stdout, reason = "printing is what it is for")]

use sindyna::identify::{Recording, Signals, arrays};
use sindyna::ndarray::Array2;

fn main() -> Result<(), sindyna::Error> {
    // Measured position and velocity of ẍ = −4 x − 0.2 ẋ, one row per sample, every 0.05 s.
    let (dt, omega) = (0.05, 3.99_f64.sqrt());
    let samples = Array2::from_shape_fn((200, 2), |(i, j)| {
        let t = dt * i as f64;
        let (decay, cos, sin) = ((-0.1 * t).exp(), (omega * t).cos(), (omega * t).sin());
        [decay * cos, decay * (-0.1 * cos - omega * sin)][j]
    });

    // Two states, of which `v` is the rate of `x`; no inputs.
    let signals = Signals::new(&["x", "v"], &[]).rate("v", "x")?;
    let found = arrays(&signals, dt, &[Recording::even(dt, samples, None)])?;

    for equation in &found.account.equations {
        println!("{}, RMS residual {:?}", equation.equation, equation.residual);
    }
    assert_eq!(found.equations()[1], "v\u{307} = −4 x − 0.2 v");
    Ok(())
}

#[cfg(test)]
#[test]
fn it_runs() {
    main().expect("the example runs");
}
