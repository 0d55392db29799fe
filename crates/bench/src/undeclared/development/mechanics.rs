//! Pendulums, cranes, springs and tops.

use crate::undeclared::System;

pub(super) fn systems() -> Vec<System> {
    vec![dragged_pendulum(), crane(), furuta(), spring_chain(), top()]
}

/// A pendulum with drag that grows with the square of its rate.
fn dragged_pendulum() -> System {
    System::new("dragged-pendulum", 0.05, 80)
        .turning("th", -2.0, 2.0)
        .rate("w", 0, -3.0, 3.0)
        .input("t", -5.0, 5.0)
        .field(|x, u, d| {
            d[0] = x[1];
            d[1] = -9.81 * x[0].sin() - 0.3 * x[1] * x[1].abs() + 2.0 * u[0];
        })
        .truth(&["1 w", "-9.81 sin(th); -0.3 w*abs(w); 2 t"])
}

/// A load of 0.5 kg on 0.8 m of rope below a trolley of 1 kg that rubs; th = 0 hanging.
fn crane() -> System {
    System::new("crane", 0.04, 80)
        .plain("x", -0.5, 0.5)
        .turning("th", -1.2, 1.2)
        .rate("v", 0, -0.5, 0.5)
        .rate("w", 1, -2.0, 2.0)
        .input("f", -8.0, 8.0)
        .field(|x, u, d| {
            let (sin, cos) = x[1].sin_cos();
            let push = u[0] - 0.6 * x[2] + 0.4 * sin * x[3] * x[3];
            d[0] = x[2];
            d[1] = x[3];
            d[2] = (push + 0.5 * 9.81 * sin * cos) / (1.5 - 0.5 * cos * cos);
            d[3] = -(9.81 * sin + cos * d[2]) / 0.8;
        })
        .truth(&[
            "1 v",
            "1 w",
            "1/1.5 f; -0.6/1.5 v; 0.4/1.5 sin(th)*w^2; -0.4/1.5 cos(th) @w",
            "-9.81/0.8 sin(th); -1/0.8 cos(th) @v",
        ])
}

/// A pole hanging from a driven arm: arm inertia 2, pole 1, coupling 0.8, all with viscous friction.
fn furuta() -> System {
    System::new("furuta-hanging", 0.03, 80)
        .turning("ph", -1.0, 1.0)
        .turning("th", -2.0, 2.0)
        .rate("r", 0, -2.0, 2.0)
        .rate("w", 1, -2.0, 2.0)
        .input("t", -6.0, 6.0)
        .field(|x, u, d| {
            let (sin, cos) = x[1].sin_cos();
            let (arm, pole) = (x[2], x[3]);
            let a = u[0] - 0.4 * arm - 2.0 * sin * cos * arm * pole + 0.8 * sin * pole * pole;
            let b = -10.0 * sin - 0.2 * pole + sin * cos * arm * arm;
            let (inertia, coupling) = (2.0 + sin * sin, 0.8 * cos);
            let determinant = inertia - coupling * coupling;
            d[0] = arm;
            d[1] = pole;
            d[2] = (a - coupling * b) / determinant;
            d[3] = (inertia * b - coupling * a) / determinant;
        })
        .truth(&[
            "1 r",
            "1 w",
            "0.5 t; -0.2 r; -1 sin(th)*cos(th)*r*w; 0.4 sin(th)*w^2; -0.5 sin(th)^2 @r; -0.4 cos(th) @w",
            "-10 sin(th); -0.2 w; 1 sin(th)*cos(th)*r^2; -0.8 cos(th) @r",
        ])
}

/// Two masses in a row; the spring to the wall stiffens.
fn spring_chain() -> System {
    System::new("spring-chain", 0.1, 80)
        .plain("x", -1.5, 1.5)
        .plain("y", -1.5, 1.5)
        .rate("v", 0, -1.0, 1.0)
        .rate("w", 1, -1.0, 1.0)
        .input("f", -2.0, 2.0)
        .field(|x, u, d| {
            d[0] = x[2];
            d[1] = x[3];
            d[2] = -3.0 * x[0] - 0.8 * x[0].powi(3) + 2.0 * x[1] - 0.2 * x[2];
            d[3] = 2.0 * x[0] - 2.0 * x[1] - 0.1 * x[3] + u[0];
        })
        .truth(&["1 v", "1 w", "-3 x; -0.8 x^3; 2 y; -0.2 v", "2 x; -2 y; -0.1 w; 1 f"])
}

/// Euler's equations of a rigid body with inertias 1, 2 and 2.5 and three torques.
fn top() -> System {
    System::new("rigid-body", 0.05, 80)
        .plain("p", -2.0, 2.0)
        .plain("q", -2.0, 2.0)
        .plain("r", -2.0, 2.0)
        .input("a", -1.0, 1.0)
        .input("b", -1.0, 1.0)
        .input("c", -1.0, 1.0)
        .field(|x, u, d| {
            d[0] = -0.5 * x[1] * x[2] + u[0];
            d[1] = (1.5 * x[2] * x[0] + u[1]) / 2.0;
            d[2] = (-x[0] * x[1] + u[2]) / 2.5;
        })
        .truth(&["-0.5 q*r; 1 a", "0.75 p*r; 0.5 b", "-0.4 p*q; 0.4 c"])
}
