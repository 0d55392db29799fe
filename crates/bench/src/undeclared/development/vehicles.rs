//! A robot on two wheels and a boat.

use crate::undeclared::System;

pub(super) fn systems() -> Vec<System> {
    vec![differential_drive(), boat()]
}

/// Two driven wheels: force f forwards, torque t to turn.
fn differential_drive() -> System {
    System::new("differential-drive", 0.05, 80)
        .plain("x", -1.0, 1.0)
        .plain("y", -1.0, 1.0)
        .turning("th", -3.0, 3.0)
        .plain("v", -1.0, 2.0)
        .rate("w", 2, -1.0, 1.0)
        .input("f", -2.0, 2.0)
        .input("t", -3.0, 3.0)
        .field(|x, u, d| {
            d[0] = x[3] * x[2].cos();
            d[1] = x[3] * x[2].sin();
            d[2] = x[4];
            d[3] = -0.5 * x[3] + 1.2 * u[0];
            d[4] = -0.8 * x[4] + 1.5 * u[1];
        })
        .truth(&["1 v*cos(th)", "1 v*sin(th)", "1 w", "-0.5 v; 1.2 f", "-0.8 w; 1.5 t"])
}

/// Surge, sway and yaw of a boat with drag by the square of the speed.
fn boat() -> System {
    System::new("boat", 0.1, 80)
        .plain("s", -0.5, 2.0)
        .plain("q", -0.5, 0.5)
        .plain("r", -0.5, 0.5)
        .input("f", -1.0, 3.0)
        .input("n", -1.0, 1.0)
        .field(|x, u, d| {
            d[0] = 1.4 * x[1] * x[2] - 0.5 * x[0] * x[0].abs() + 0.8 * u[0];
            d[1] = -0.7 * x[0] * x[2] - 1.5 * x[1] * x[1].abs();
            d[2] = -0.9 * x[2] + 1.1 * u[1];
        })
        .truth(&["1.4 q*r; -0.5 s*abs(s); 0.8 f", "-0.7 s*r; -1.5 q*abs(q)", "-0.9 r; 1.1 n"])
}
