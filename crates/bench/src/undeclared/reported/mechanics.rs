//! Pendulums and friction.

use crate::undeclared::System;

pub(super) fn systems() -> Vec<System> {
    vec![double_pendulum(), coupled_pendula(), coulomb()]
}

/// Two points of 1 kg on rods of 1 m and 0.8 m, angles from hanging, a motor at each joint: the second one's torque acts back
/// on the first rod.
fn double_pendulum() -> System {
    System::new("double-pendulum", 0.02, 100)
        .turning("p", -2.0, 2.0)
        .turning("q", -2.0, 2.0)
        .rate("v", 0, -2.0, 2.0)
        .rate("w", 1, -2.0, 2.0)
        .input("s", -8.0, 8.0)
        .input("t", -4.0, 4.0)
        .field(|x, u, d| {
            let (sin, cos) = (x[0] - x[1]).sin_cos();
            let a = u[0] - u[1] - 0.8 * sin * x[3] * x[3] - 2.0 * 9.81 * x[0].sin();
            let b = u[1] + 0.8 * sin * x[2] * x[2] - 0.8 * 9.81 * x[1].sin();
            let determinant = 2.0 * 0.64 - 0.64 * cos * cos;
            d[0] = x[2];
            d[1] = x[3];
            d[2] = (0.64 * a - 0.8 * cos * b) / determinant;
            d[3] = (2.0 * b - 0.8 * cos * a) / determinant;
        })
        .truth(&[
            "1 v",
            "1 w",
            "0.5 s; -0.5 t; -0.4 sin(p - q)*w^2; -9.81 sin(p); -0.4 cos(p - q) @w",
            "1/0.64 t; 1/0.8 sin(p - q)*v^2; -9.81/0.8 sin(q); -1/0.8 cos(p - q) @v",
        ])
}

/// Two damped pendulums joined by a torsion spring, one of them driven.
fn coupled_pendula() -> System {
    System::new("coupled-pendula", 0.03, 100)
        .angle("p", -1.5, 1.5)
        .angle("q", -1.5, 1.5)
        .rate("v", 0, -2.0, 2.0)
        .rate("w", 1, -2.0, 2.0)
        .input("t", -4.0, 4.0)
        .field(|x, u, d| {
            let spring = 3.0 * (x[0] - x[1]);
            d[0] = x[2];
            d[1] = x[3];
            d[2] = -9.81 * x[0].sin() - 0.1 * x[2] - spring + u[0];
            d[3] = -9.81 * x[1].sin() - 0.1 * x[3] + spring;
        })
        .truth(&["1 v", "1 w", "-9.81 sin(p); -0.1 v; -3 p; 3 q; 1 t", "-9.81 sin(q); -0.1 w; 3 p; -3 q"])
}

/// A mass on a spring with dry friction. The friction jumps, so that steps across a jump are in error by about
/// the substep: hence their number.
fn coulomb() -> System {
    System::new("coulomb", 0.02, 100)
        .plain("x", -2.0, 2.0)
        .rate("v", 0, -3.0, 3.0)
        .input("u", -6.0, 6.0)
        .substeps(1000)
        .field(|x, u, d| {
            let direction = if x[1] == 0.0 { 0.0 } else { x[1].signum() };
            d[0] = x[1];
            d[1] = -9.0 * x[0] - 1.5 * direction + u[0];
        })
        .truth(&["1 v", "-9 x; -1.5 sign(v); 1 u"])
}
