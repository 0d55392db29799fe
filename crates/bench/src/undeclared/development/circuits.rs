//! Converters, magnets and tanks.

use crate::undeclared::System;

pub(super) fn systems() -> Vec<System> {
    vec![boost(), solenoid(), tanks()]
}

/// A boost converter averaged over its switching: 24 V, 1 mH, 0.5 mF, 20 Ω; d is the duty.
fn boost() -> System {
    System::new("boost-converter", 2e-4, 100)
        .plain("i", 0.0, 6.0)
        .plain("v", 20.0, 60.0)
        .input("d", 0.1, 0.7)
        .field(|x, u, dot| {
            dot[0] = (24.0 - (1.0 - u[0]) * x[1]) / 1e-3;
            dot[1] = ((1.0 - u[0]) * x[0] - x[1] / 20.0) / 5e-4;
        })
        .truth(&["24000 1; -1000 v; 1000 d*v", "2000 i; -2000 d*i; -100 v"])
}

/// A plunger on a spring, pulled by the square of a coil's current, whose motion induces a voltage.
fn solenoid() -> System {
    System::new("solenoid", 0.005, 80)
        .plain("x", -0.5, 0.5)
        .rate("v", 0, -3.0, 3.0)
        .plain("i", -1.0, 1.0)
        .input("e", -6.0, 6.0)
        .field(|x, u, d| {
            d[0] = x[1];
            d[1] = -100.0 * x[0] - 2.0 * x[1] + 25.0 * x[2] * x[2];
            d[2] = -40.0 * x[2] - 5.0 * x[2] * x[1] + 20.0 * u[0];
        })
        .truth(&["1 v", "-100 x; -2 v; 25 i^2", "-40 i; -5 i*v; 20 e"])
}

/// Two tanks, the first emptying into the second (Torricelli).
fn tanks() -> System {
    System::new("two-tanks", 2.0, 60)
        .plain("h", 0.2, 1.0)
        .plain("k", 0.2, 1.0)
        .input("q", 0.02, 0.1)
        .field(|x, u, d| {
            d[0] = u[0] - 0.06 * x[0].sqrt();
            d[1] = 0.06 * x[0].sqrt() - 0.05 * x[1].sqrt();
        })
        .truth(&["1 q; -0.06 sqrt(h)", "0.06 sqrt(h); -0.05 sqrt(k)"])
}
