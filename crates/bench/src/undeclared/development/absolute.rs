//! States far from zero: temperatures in kelvins, altitudes, line pressures.

use crate::undeclared::System;

pub(super) fn systems() -> Vec<System> {
    vec![plate(), tethered(), bath(), accumulator()]
}

/// A heated plate and a probe on it \[K\], in a room of 293 K.
fn plate() -> System {
    System::new("plate", 2.0, 100)
        .plain("h", 288.0, 303.0)
        .plain("p", 288.0, 298.0)
        .input("u", 0.0, 1.0)
        .field(|x, u, d| {
            d[0] = 1.2 * u[0] - 0.03 * (x[0] - x[1]) - 0.01 * (x[0] - 293.0);
            d[1] = 0.02 * (x[0] - x[1]) - 0.01 * (x[1] - 293.0);
        })
        .truth(&["2.93 1; -0.04 h; 0.03 p; 1.2 u", "2.93 1; 0.02 h; -0.03 p"])
}

/// A tethered balloon 120 m above the ground, with linear drag.
fn tethered() -> System {
    System::new("tethered-balloon", 0.1, 80)
        .plain("z", 115.0, 125.0)
        .rate("v", 0, -3.0, 3.0)
        .input("f", -6.0, 6.0)
        .field(|x, u, d| {
            d[0] = x[1];
            d[1] = -1.5 * (x[0] - 120.0) - 0.4 * x[1] + u[0];
        })
        .truth(&["1 v", "180 1; -1.5 z; -0.4 v; 1 f"])
}

/// A bath at about 310 K into which water of 350 K flows.
fn bath() -> System {
    System::new("bath", 5.0, 80)
        .plain("t", 300.0, 320.0)
        .input("q", 0.0, 0.02)
        .field(|x, u, d| d[0] = u[0] * (350.0 - x[0]) - 0.008 * (x[0] - 295.0))
        .truth(&["2.36 1; -0.008 t; 350 q; -1 q*t"])
}

/// A vessel \[kPa\] that leaks into the air, and a membrane in it \[mm\].
fn accumulator() -> System {
    System::new("accumulator", 0.05, 80)
        .plain("p", 101.0, 140.0)
        .plain("y", -1.0, 2.0)
        .rate("v", 1, -10.0, 10.0)
        .input("q", 0.0, 60.0)
        .field(|x, u, d| {
            d[0] = u[0] - 1.5 * (x[0] - 101.0);
            d[1] = x[2];
            d[2] = 3.0 * (x[0] - 101.0) - 40.0 * x[1] - 2.0 * x[2];
        })
        .truth(&["151.5 1; -1.5 p; 1 q", "1 v", "-303 1; 3 p; -40 y; -2 v"])
}
