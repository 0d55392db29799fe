//! Functions with parameters inside.

use crate::undeclared::System;

pub(super) fn systems() -> Vec<System> {
    vec![amplifier(), enzyme(), toggle(), groove(), pipe(), ignition()]
}

/// A drive behind an amplifier that saturates.
fn amplifier() -> System {
    System::new("amplifier", 0.02, 100)
        .plain("w", -8.0, 8.0)
        .input("u", -5.0, 5.0)
        .field(|x, u, d| d[0] = -3.0 * x[0] + 40.0 * (u[0] / 2.0).tanh())
        .truth(&["-3 w; 40 tanh(u/2)"])
}

/// A substrate and its product (Michaelis and Menten); q is the feed.
fn enzyme() -> System {
    System::new("enzyme", 0.1, 100)
        .plain("s", 0.1, 4.0)
        .plain("p", 0.1, 2.0)
        .input("q", 0.2, 1.8)
        .field(|x, u, d| {
            let turned = 2.1 * x[0] / (0.9 + x[0]);
            d[0] = u[0] - turned;
            d[1] = turned - 0.7 * x[1];
        })
        .truth(&["1 q; -2.1 s/(0.9+s)", "2.1 s/(0.9+s); -0.7 p"])
}

/// Two genes that repress each other (Gardner, Cantor and Collins); u feeds the first.
fn toggle() -> System {
    System::new("toggle", 0.1, 100)
        .plain("g", 0.1, 3.0)
        .plain("h", 0.1, 3.0)
        .input("u", 0.0, 1.0)
        .field(|x, u, d| {
            let repressed = |v: f64, c: f64| c * c / (c * c + v * v);
            d[0] = 3.0 * repressed(x[1], 0.8) - x[0] + u[0];
            d[1] = 2.5 * repressed(x[0], 1.1) - x[1];
        })
        .truth(&["3 1; -3 h^2/(0.8^2+h^2); -1 g; 1 u", "2.5 1; -2.5 g^2/(1.1^2+g^2); -1 h"])
}

/// A particle in grooves.
fn groove() -> System {
    System::new("groove", 0.04, 120)
        .plain("x", -2.0, 2.0)
        .rate("v", 0, -2.0, 2.0)
        .input("u", -3.0, 3.0)
        .field(|x, u, d| {
            d[0] = x[1];
            d[1] = -4.0 * (1.7 * x[0]).sin() - 0.3 * x[1] + u[0];
        })
        .truth(&["1 v", "-4 sin(1.7*x); -0.3 v; 1 u"])
}

/// Turbulent flow through a smooth pipe (Blasius), driven by a pressure.
fn pipe() -> System {
    System::new("pipe", 0.1, 100)
        .plain("f", 0.3, 3.0)
        .input("p", 0.3, 3.0)
        .field(|x, u, d| d[0] = 2.0 * u[0] - 0.6 * x[0].powf(1.75))
        .truth(&["2 p; -0.6 exp(1.75*log(f))"])
}

/// A stirred tank whose reaction is the faster the warmer it is (Frank-Kamenetskii); u cools.
fn ignition() -> System {
    System::new("ignition", 0.05, 100)
        .plain("c", 0.3, 1.0)
        .plain("h", -0.2, 0.6)
        .input("u", -1.0, 1.0)
        .field(|x, u, d| {
            let reaction = 0.5 * x[0] * (x[1] / 0.35).exp();
            d[0] = 1.0 - x[0] - reaction;
            d[1] = 0.8 * reaction - 1.5 * x[1] + u[0];
        })
        .truth(&["1 1; -1 c; -0.5 c*exp(h/0.35)", "0.4 c*exp(h/0.35); -1.5 h; 1 u"])
}
