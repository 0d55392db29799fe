//! A motor.

use crate::undeclared::System;

pub(super) fn systems() -> Vec<System> {
    vec![dc_motor()]
}

/// A small direct-current motor: 1 Ω, 10 mH, 0.05 V·s, 1e-4 kg·m², viscous friction of 1e-4 N·m·s.
fn dc_motor() -> System {
    System::new("dc-motor", 0.002, 100)
        .turning("th", -3.0, 3.0)
        .rate("w", 0, -100.0, 100.0)
        .plain("i", -3.0, 3.0)
        .input("e", -12.0, 12.0)
        .field(|x, u, d| {
            d[0] = x[1];
            d[1] = 500.0 * x[2] - x[1];
            d[2] = 100.0 * (u[0] - x[2] - 0.05 * x[1]);
        })
        .truth(&["1 w", "500 i; -1 w", "100 e; -100 i; -5 w"])
}
