//! Attractors and excitable cells.

use crate::undeclared::System;

pub(super) fn systems() -> Vec<System> {
    vec![fitzhugh_nagumo(), chua(), halvorsen(), thomas()]
}

/// FitzHugh (1961): a nerve cell with a current.
fn fitzhugh_nagumo() -> System {
    System::new("fitzhugh-nagumo", 0.2, 100)
        .plain("v", -2.0, 2.0)
        .plain("w", -1.0, 1.5)
        .input("i", -0.5, 1.5)
        .field(|x, u, d| {
            d[0] = x[0] - x[0].powi(3) / 3.0 - x[1] + u[0];
            d[1] = 0.08 * (x[0] + 0.7 - 0.8 * x[1]);
        })
        .truth(&["1 v; -1/3 v^3; -1 w; 1 i", "0.08 v; 0.056 1; -0.064 w"])
}

/// Chua's circuit with a cubic nonlinearity.
fn chua() -> System {
    System::new("chua-cubic", 0.05, 100)
        .plain("x", -0.6, 0.6)
        .plain("y", -0.2, 0.2)
        .plain("z", -0.6, 0.6)
        .field(|x, _, d| {
            d[0] = 10.0 * (x[1] - x[0].powi(3) + 0.143 * x[0]);
            d[1] = x[0] - x[1] + x[2];
            d[2] = -16.0 * x[1];
        })
        .truth(&["10 y; -10 x^3; 1.43 x", "1 x; -1 y; 1 z", "-16 y"])
}

/// Halvorsen's cyclically symmetric attractor.
fn halvorsen() -> System {
    System::new("halvorsen", 0.02, 100)
        .plain("x", -5.0, 2.0)
        .plain("y", -5.0, 2.0)
        .plain("z", -5.0, 2.0)
        .field(|x, _, d| {
            for i in 0..3 {
                let (own, next, last) = (x[i], x[(i + 1) % 3], x[(i + 2) % 3]);
                d[i] = -1.89 * own - 4.0 * next - 4.0 * last - next * next;
            }
        })
        .truth(&["-1.89 x; -4 y; -4 z; -1 y^2", "-1.89 y; -4 z; -4 x; -1 z^2", "-1.89 z; -4 x; -4 y; -1 x^2"])
}

/// Thomas (1999): sines of positions.
fn thomas() -> System {
    System::new("thomas", 0.2, 100)
        .plain("x", -3.0, 3.0)
        .plain("y", -3.0, 3.0)
        .plain("z", -3.0, 3.0)
        .field(|x, _, d| {
            for i in 0..3 {
                d[i] = x[(i + 1) % 3].sin() - 0.19 * x[i];
            }
        })
        .truth(&["1 sin(y); -0.19 x", "1 sin(z); -0.19 y", "1 sin(x); -0.19 z"])
}
