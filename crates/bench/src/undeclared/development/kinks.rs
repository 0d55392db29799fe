//! Stops, clearances, dead zones and other kinks.

use crate::undeclared::System;

pub(super) fn systems() -> Vec<System> {
    vec![bumper(), clearance(), valve(), clipped(), weir(), chua()]
}

/// The part of `x` beyond ±`c`.
fn beyond(x: f64, c: f64) -> f64 {
    (x - c).max(0.0) - (-c - x).max(0.0)
}

/// A mass on a spring that meets a second spring on one side.
fn bumper() -> System {
    System::new("bumper", 0.04, 120)
        .plain("x", -1.0, 1.0)
        .rate("v", 0, -2.0, 2.0)
        .input("u", -3.0, 3.0)
        .field(|x, u, d| {
            d[0] = x[1];
            d[1] = -2.0 * x[0] - 20.0 * (x[0] - 0.4).max(0.0) - 0.3 * x[1] + u[0];
        })
        .truth(&["1 v", "-2 x; -20 max(x-0.4,0); -0.3 v; 1 u"])
}

/// A mass between two springs that it does not reach from the middle.
fn clearance() -> System {
    System::new("clearance", 0.04, 120)
        .plain("x", -1.0, 1.0)
        .rate("v", 0, -2.0, 2.0)
        .input("u", -3.0, 3.0)
        .field(|x, u, d| {
            d[0] = x[1];
            d[1] = -15.0 * beyond(x[0], 0.3) - 0.4 * x[1] + u[0];
        })
        .truth(&["1 v", "-15 (max(x-0.3,0)-max(-0.3-x,0)); -0.4 v; 1 u"])
}

/// A cylinder behind a proportional valve with overlap.
fn valve() -> System {
    System::new("valve", 0.03, 100)
        .plain("w", -3.0, 3.0)
        .input("u", -2.0, 2.0)
        .field(|x, u, d| d[0] = -2.5 * x[0] + 9.0 * beyond(u[0], 0.45))
        .truth(&["-2.5 w; 9 (max(u-0.45,0)-max(-0.45-u,0))"])
}

/// A motor whose supply clips.
fn clipped() -> System {
    System::new("clipped", 0.03, 100)
        .plain("w", -6.0, 6.0)
        .input("u", -2.0, 2.0)
        .field(|x, u, d| d[0] = -3.0 * x[0] + 16.0 * u[0].clamp(-0.9, 0.9))
        .truth(&["-3 w; 16 u; -16 (max(u-0.9,0)-max(-0.9-u,0))"])
}

/// A tank that is drained through a pipe and flows over a weir.
fn weir() -> System {
    System::new("weir", 0.2, 100)
        .plain("h", 0.1, 1.5)
        .input("q", 0.0, 1.5)
        .field(|x, u, d| d[0] = 0.8 * u[0] - 0.35 * x[0] - 1.7 * (x[0] - 0.8).max(0.0))
        .truth(&["0.8 q; -0.35 h; -1.7 max(h-0.8,0)"])
}

/// Chua's circuit, with its double scroll.
fn chua() -> System {
    System::new("chua", 0.05, 150)
        .plain("x", -2.0, 2.0)
        .plain("y", -0.4, 0.4)
        .plain("z", -3.0, 3.0)
        .field(|x, _, d| {
            let diode = -0.714 * x[0] - 0.5 * (-1.143 + 0.714) * ((x[0] - 1.0).abs() - (x[0] + 1.0).abs());
            d[0] = 15.6 * (x[1] - x[0] - diode);
            d[1] = x[0] - x[1] + x[2];
            d[2] = -28.0 * x[1];
        })
        .truth(&["15.6 y; 2.2308 x; -6.6924 (max(x-1,0)-max(-1-x,0))", "1 x; -1 y; 1 z", "-28 y"])
}
