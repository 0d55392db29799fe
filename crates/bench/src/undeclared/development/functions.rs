//! Functions with parameters inside: saturation, growth, reaction.

use crate::undeclared::System;

pub(super) fn systems() -> Vec<System> {
    vec![soft_spring(), chemostat(), budworm(), grazing(), diode(), planing()]
}

/// A spring that saturates.
fn soft_spring() -> System {
    System::new("soft-spring", 0.02, 150)
        .plain("x", -1.0, 1.0)
        .rate("v", 0, -2.0, 2.0)
        .input("u", -6.0, 6.0)
        .field(|x, u, d| {
            d[0] = x[1];
            d[1] = -12.0 * (x[0] / 0.4).tanh() - 0.5 * x[1] + u[0];
        })
        .truth(&["1 v", "-12 tanh(x/0.4); -0.5 v; 1 u"])
}

/// Biomass that grows on a substrate (Monod); d is the dilution.
fn chemostat() -> System {
    System::new("chemostat", 0.2, 100)
        .plain("b", 0.3, 2.0)
        .plain("s", 0.2, 3.0)
        .input("d", 0.1, 0.8)
        .field(|x, u, dot| {
            let growth = 1.2 * x[0] * x[1] / (0.6 + x[1]);
            dot[0] = growth - u[0] * x[0];
            dot[1] = u[0] * (4.0 - x[1]) - 1.5 * growth;
        })
        .truth(&["1.2 b*(s/(0.6+s)); -1 d*b", "4 d; -1 d*s; -1.8 b*(s/(0.6+s))"])
}

/// Logistic growth with predation that saturates (Ludwig's budworms), some of which are let go.
fn budworm() -> System {
    System::new("budworm", 0.1, 80)
        .plain("n", 0.3, 9.0)
        .input("q", 0.0, 0.5)
        .field(|x, u, d| d[0] = x[0] - 0.1 * x[0] * x[0] - 1.4 * x[0] * x[0] / (1.44 + x[0] * x[0]) + u[0])
        .truth(&["1 n; -0.1 n^2; -1.4 n^2/(1.2^2+n^2); 1 q"])
}

/// Prey and predator with a functional response of the second kind (Rosenzweig and MacArthur).
fn grazing() -> System {
    System::new("grazing", 0.25, 150)
        .plain("p", 0.2, 1.5)
        .plain("z", 0.1, 1.0)
        .field(|x, _, d| {
            let eaten = 1.3 * x[1] * x[0] / (0.5 + x[0]);
            d[0] = x[0] * (1.0 - x[0] / 1.6) - eaten;
            d[1] = 0.6 * eaten - 0.3 * x[1];
        })
        .truth(&["1 p; -0.625 p^2; -1.3 z*(p/(0.5+p))", "0.78 z*(p/(0.5+p)); -0.3 z"])
}

/// A capacitor that is charged through a resistor and discharged by a diode.
fn diode() -> System {
    System::new("diode", 0.01, 100)
        .plain("w", -0.5, 0.6)
        .input("e", -3.0, 8.0)
        .field(|x, u, d| d[0] = 5.0 * u[0] - 5.0 * x[0] - 0.02 * (x[0] / 0.09).exp())
        .truth(&["5 e; -5 w; -0.02 exp(w/0.09)"])
}

/// A boat whose drag grows with a power of its speed.
fn planing() -> System {
    System::new("planing", 0.1, 100)
        .plain("v", 1.0, 8.0)
        .input("t", 1.0, 9.0)
        .field(|x, u, d| d[0] = u[0] - 0.35 * x[0].powf(1.4))
        .truth(&["1 t; -0.35 exp(1.4*log(v))"])
}
