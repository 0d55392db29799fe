//! Oscillators and strange attractors.

use crate::undeclared::System;

pub(super) fn systems() -> Vec<System> {
    vec![van_der_pol(), lorenz(), rossler(), duffing()]
}

/// Van der Pol's oscillator with μ = 2.
fn van_der_pol() -> System {
    System::new("van-der-pol", 0.05, 100)
        .plain("x", -2.0, 2.0)
        .rate("v", 0, -2.0, 2.0)
        .input("u", -1.5, 1.5)
        .field(|x, u, d| {
            d[0] = x[1];
            d[1] = 2.0 * (1.0 - x[0] * x[0]) * x[1] - x[0] + u[0];
        })
        .truth(&["1 v", "2 v; -2 x^2*v; -1 x; 1 u"])
}

/// Lorenz (1963) with an input on x.
fn lorenz() -> System {
    System::new("lorenz", 0.02, 100)
        .plain("x", -15.0, 15.0)
        .plain("y", -15.0, 15.0)
        .plain("z", 10.0, 40.0)
        .input("u", -30.0, 30.0)
        .field(|x, u, d| {
            d[0] = 10.0 * (x[1] - x[0]) + u[0];
            d[1] = x[0] * (28.0 - x[2]) - x[1];
            d[2] = x[0] * x[1] - 8.0 / 3.0 * x[2];
        })
        .truth(&["-10 x; 10 y; 1 u", "28 x; -1 x*z; -1 y", "1 x*y; -8/3 z"])
}

/// Rössler (1976).
fn rossler() -> System {
    System::new("rossler", 0.1, 100)
        .plain("x", -8.0, 8.0)
        .plain("y", -8.0, 8.0)
        .plain("z", 0.0, 2.0)
        .field(|x, _, d| {
            d[0] = -x[1] - x[2];
            d[1] = x[0] + 0.2 * x[1];
            d[2] = 0.2 + x[2] * (x[0] - 5.7);
        })
        .truth(&["-1 y; -1 z", "1 x; 0.2 y", "0.2 1; 1 x*z; -5.7 z"])
}

/// Duffing's oscillator between two wells.
fn duffing() -> System {
    System::new("duffing", 0.1, 100)
        .plain("x", -1.5, 1.5)
        .rate("v", 0, -1.0, 1.0)
        .input("u", -1.0, 1.0)
        .field(|x, u, d| {
            d[0] = x[1];
            d[1] = x[0] - x[0].powi(3) - 0.3 * x[1] + u[0];
        })
        .truth(&["1 v", "1 x; -1 x^3; -0.3 v; 1 u"])
}
