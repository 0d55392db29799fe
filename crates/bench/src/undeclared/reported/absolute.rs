//! States far from zero.

use crate::undeclared::System;

pub(super) fn systems() -> Vec<System> {
    vec![rooms(), generator(), lake(), sled(), mixer()]
}

/// Two rooms \[K\] with a wall between them; outside it is 278 K.
fn rooms() -> System {
    System::new("two-rooms", 60.0, 90)
        .plain("a", 284.0, 296.0)
        .plain("b", 284.0, 296.0)
        .input("p", 0.0, 1.0)
        .input("r", 0.0, 1.0)
        .field(|x, u, d| {
            d[0] = 0.004 * (x[1] - x[0]) - 0.001 * (x[0] - 278.0) + 0.02 * u[0];
            d[1] = 0.003 * (x[0] - x[1]) - 0.0015 * (x[1] - 278.0) + 0.025 * u[1];
        })
        .truth(&["0.278 1; -0.005 a; 0.004 b; 0.02 p", "0.417 1; 0.003 a; -0.0045 b; 0.025 r"])
}

/// A generator near 314 rad/s with a turbine behind a valve.
fn generator() -> System {
    System::new("generator", 0.1, 80)
        .plain("w", 309.0, 319.0)
        .plain("m", -2.0, 2.0)
        .input("g", -4.0, 4.0)
        .field(|x, u, d| {
            d[0] = 2.0 * x[1] - 0.3 * (x[0] - 314.0);
            d[1] = 1.6 * (u[0] - x[1]) - 0.25 * (x[0] - 314.0);
        })
        .truth(&["94.2 1; -0.3 w; 2 m", "78.5 1; -0.25 w; -1.6 m; 1.6 g"])
}

/// The level of a lake above the sea \[m\] and of the reservoir below, which is filled through a channel.
fn lake() -> System {
    System::new("lake", 3600.0, 90)
        .plain("h", 429.0, 433.0)
        .plain("k", 424.0, 428.0)
        .input("q", 0.0, 3.0)
        .field(|x, u, d| {
            d[0] = 1e-4 * u[0] - 3e-5 * (x[0] - x[1]);
            d[1] = 2e-5 * (x[0] - x[1]) - 4e-5 * (x[1] - 424.0);
        })
        .truth(&["-3e-5 h; 3e-5 k; 1e-4 q", "0.01696 1; 2e-5 h; -6e-5 k"])
}

/// A sled \[mm\] between springs that hold it 25 mm from a wall.
fn sled() -> System {
    System::new("sled", 0.01, 80)
        .plain("y", 20.0, 30.0)
        .rate("v", 0, -60.0, 60.0)
        .input("c", -600.0, 600.0)
        .field(|x, u, d| {
            d[0] = x[1];
            d[1] = -90.0 * (x[0] - 25.0) - 3.0 * x[1] + u[0];
        })
        .truth(&["1 v", "2250 1; -90 y; -3 v; 1 c"])
}

/// Temperature \[K\] and concentration of a mixed tank into which a hot solution flows.
fn mixer() -> System {
    System::new("mixer", 4.0, 90)
        .plain("t", 310.0, 330.0)
        .plain("c", 0.5, 2.0)
        .input("q", 0.0, 0.03)
        .field(|x, u, d| {
            d[0] = u[0] * (360.0 - x[0]) - 0.01 * (x[0] - 300.0);
            d[1] = u[0] * (4.0 - x[1]) - 0.02 * x[1];
        })
        .truth(&["3 1; -0.01 t; 360 q; -1 q*t", "4 q; -1 c*q; -0.02 c"])
}
