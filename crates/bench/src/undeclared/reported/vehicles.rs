//! A quadrotor and a car.

use crate::undeclared::System;

pub(super) fn systems() -> Vec<System> {
    vec![quadrotor(), bicycle()]
}

/// A quadrotor of 0.5 kg in a vertical plane: thrust f, moment m on an inertia of 0.01 kg·m².
fn quadrotor() -> System {
    System::new("quadrotor", 0.02, 60)
        .plain("x", -1.0, 1.0)
        .plain("z", -1.0, 1.0)
        .turning("th", -1.0, 1.0)
        .rate("vx", 0, -1.0, 1.0)
        .rate("vz", 1, -1.0, 1.0)
        .rate("w", 2, -1.0, 1.0)
        .input("f", 1.0, 9.0)
        .input("m", -0.08, 0.08)
        .field(|x, u, d| {
            d[..3].copy_from_slice(&x[3..]);
            d[3] = -2.0 * u[0] * x[2].sin();
            d[4] = 2.0 * u[0] * x[2].cos() - 9.81;
            d[5] = 100.0 * u[1];
        })
        .truth(&["1 vx", "1 vz", "1 w", "-2 f*sin(th)", "2 f*cos(th); -9.81 1", "100 m"])
}

/// A car of 2 m between its axles (kinematic bicycle): acceleration a, steering d.
fn bicycle() -> System {
    System::new("bicycle", 0.05, 100)
        .plain("x", -2.0, 2.0)
        .plain("y", -2.0, 2.0)
        .turning("th", -3.0, 3.0)
        .plain("v", 1.0, 5.0)
        .input("a", -3.0, 3.0)
        .input("d", -0.6, 0.6)
        .field(|x, u, d| {
            d[0] = x[3] * x[2].cos();
            d[1] = x[3] * x[2].sin();
            d[2] = 0.5 * x[3] * u[1].tan();
            d[3] = u[0] - 0.1 * x[3];
        })
        .truth(&["1 v*cos(th)", "1 v*sin(th)", "0.5 v*tan(d)", "1 a; -0.1 v"])
}
