//! The systems of `sindyna_envs` that have no part in any tuning of the defaults.

use std::sync::Arc;

use sindyna_core::VectorField;

use crate::undeclared::System;

pub(super) fn systems() -> Vec<System> {
    vec![swing_up(), driven_pendulum(), van_der_pol(), lorenz(), lotka_volterra(), two_link_arm(), rotary_pendulum()]
}

/// The right-hand side of the system called `name`.
fn rates(name: &str) -> Arc<dyn VectorField> {
    sindyna_envs::find(name).or_else(|| sindyna_envs::find_field(name)).expect("the laboratory has this system").rates()
}

fn swing_up() -> System {
    System::new("lab-cart-pole-swing-up", 0.04, 80)
        .plain("x", -0.5, 0.5)
        .rate("v", 0, -1.0, 1.0)
        .turning("th", -3.0, 3.0)
        .rate("w", 2, -2.0, 2.0)
        .input("f", -10.0, 10.0)
        .shared(rates("cart-pole-swing-up"))
        .truth(&[
            "1 v",
            "1 f; -0.1 v; 0.15 sin(th)*w^2; -0.15 cos(th) @w",
            "1 w",
            "1.473/0.06 sin(th); -0.01/0.06 w; -0.15/0.06 cos(th) @v",
        ])
}

fn driven_pendulum() -> System {
    System::new("lab-driven-pendulum", 0.05, 100)
        .turning("th", -2.0, 2.0)
        .rate("w", 0, -2.0, 2.0)
        .input("u", -5.0, 5.0)
        .shared(rates("driven-pendulum"))
        .truth(&["1 w", "-9.81 sin(th); -0.2 w; 1 u"])
}

fn van_der_pol() -> System {
    System::new("lab-van-der-pol", 0.05, 100)
        .plain("x", -2.0, 2.0)
        .rate("v", 0, -2.0, 2.0)
        .input("u", -1.0, 1.0)
        .shared(rates("van-der-pol"))
        .truth(&["1 v", "1 v; -1 x^2*v; -1 x; 1 u"])
}

fn lorenz() -> System {
    System::new("lab-lorenz", 0.01, 100)
        .plain("x", -15.0, 15.0)
        .plain("y", -15.0, 15.0)
        .plain("z", 10.0, 40.0)
        .input("u", -50.0, 50.0)
        .shared(rates("lorenz"))
        .truth(&["-10 x; 10 y; 1 u", "28 x; -1 y; -1 x*z", "-8/3 z; 1 x*y"])
}

fn lotka_volterra() -> System {
    System::new("lab-lotka-volterra", 0.1, 100)
        .plain("x", 50.0, 150.0)
        .plain("y", 15.0, 35.0)
        .input("u", -2.0, 2.0)
        .shared(rates("lotka-volterra"))
        .truth(&["0.5 x; -0.025 x*y", "-0.5 y; 0.005 x*y; 1 u"])
}

fn two_link_arm() -> System {
    System::new("lab-two-link-arm", 0.02, 100)
        .turning("p", -1.5, 1.5)
        .turning("q", -1.5, 1.5)
        .rate("v", 0, -1.0, 1.0)
        .rate("w", 1, -1.0, 1.0)
        .input("s", -6.0, 6.0)
        .input("t", -1.5, 1.5)
        .substeps(150)
        .shared(rates("two-link-arm"))
        .truth(&[
            "1 v",
            "1 w",
            "1/0.178 s; -0.05/0.178 v; 0.072/0.178 sin(q)*v*w; 0.036/0.178 sin(q)*w^2; -4.7088/0.178 sin(p); \
             -0.8829/0.178 sin(p + q); -0.072/0.178 cos(q) @v; -0.018/0.178 1 @w; -0.036/0.178 cos(q) @w",
            "1/0.018 t; -0.02/0.018 w; -2 sin(q)*v^2; -0.8829/0.018 sin(p + q); -1 1 @v; -2 cos(q) @v",
        ])
}

fn rotary_pendulum() -> System {
    System::new("lab-rotary-pendulum", 0.01, 100)
        .turning("ph", -1.0, 1.0)
        .turning("th", -3.0, 3.0)
        .rate("r", 0, -2.0, 2.0)
        .rate("w", 1, -2.0, 2.0)
        .input("u", -50.0, 50.0)
        .shared(rates("rotary-pendulum"))
        .truth(&[
            "1 r",
            "1 w",
            "1/0.402192 u; -1.5/0.402192 r; -0.266256/0.402192 sin(th)*cos(th)*r*w; 0.13158/0.402192 sin(th)*w^2; \
             -0.133128/0.402192 sin(th)^2 @r; -0.13158/0.402192 cos(th) @w",
            "15.1859076/0.133128 sin(th); -0.5/0.133128 w; 1 sin(th)*cos(th)*r^2; -0.13158/0.133128 cos(th) @r",
        ])
}
