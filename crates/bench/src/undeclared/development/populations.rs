//! Epidemics and predators.

use crate::undeclared::System;

pub(super) fn systems() -> Vec<System> {
    vec![sir(), holling()]
}

/// Susceptible and infected shares of a population, some of it vaccinated.
fn sir() -> System {
    System::new("sir", 0.5, 60)
        .plain("s", 0.5, 1.0)
        .plain("i", 0.02, 0.3)
        .input("c", 0.0, 0.1)
        .field(|x, u, d| {
            d[0] = -0.6 * x[0] * x[1] - u[0] * x[0];
            d[1] = 0.6 * x[0] * x[1] - 0.2 * x[1];
        })
        .truth(&["-0.6 s*i; -1 c*s", "0.6 s*i; -0.2 i"])
}

/// Rosenzweig and MacArthur (1963): predators that can eat only so much (Holling's second response).
fn holling() -> System {
    System::new("holling", 0.3, 80)
        .plain("n", 0.3, 3.0)
        .plain("p", 0.3, 2.0)
        .input("c", -0.1, 0.1)
        .field(|x, u, d| {
            let eaten = x[0] * x[1] / (1.0 + x[0]);
            d[0] = x[0] - 0.25 * x[0] * x[0] - 1.2 * eaten;
            d[1] = 0.8 * eaten - 0.4 * x[1] + u[0];
        })
        .truth(&["1 n; -0.25 n^2; -1.2 p*(n/(1 + n))", "0.8 p*(n/(1 + n)); -0.4 p; 1 c"])
}
