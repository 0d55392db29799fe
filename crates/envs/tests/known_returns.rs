//! Hand-written controllers score what they score in Gymnasium.

#![allow(clippy::float_cmp, reason = "exact numbers are compared on purpose")]

use sindyna_core::{Environment as _, Rng, Seed};

/// Mean and standard deviation of the return, and the mean length, over `episodes` episodes of `system`.
fn score(system: &str, episodes: u32, mut controller: impl FnMut(&[f64], usize, &mut Rng) -> f64) -> (f64, f64, f64) {
    let mut env = sindyna_envs::find(system).expect("a registered system").environment();
    let mut rng = Seed::new(0).numpy();
    let mut choices = Seed::new(0).stream("choices", 0);
    let (mut returns, mut steps) = (Vec::new(), 0_usize);
    for _ in 0..episodes {
        env.reset(&mut rng).expect("a simulation resets");
        let mut total = 0.0;
        for t in 0.. {
            let action = controller(env.observation(), t, &mut choices);
            let outcome = env.step(&[action], &mut rng).expect("a valid action");
            total += outcome.reward;
            steps += 1;
            if outcome.terminated || outcome.truncated {
                break;
            }
        }
        returns.push(total);
    }
    let n = f64::from(episodes);
    let mean = returns.iter().sum::<f64>() / n;
    let variance = returns.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / n;
    (mean, variance.sqrt(), steps as f64 / n)
}

/// −1 or 1, 1 at rest.
fn sign(v: f64) -> f64 {
    if v < 0.0 { -1.0 } else { 1.0 }
}

fn between(value: f64, low: f64, high: f64) {
    assert!((low..=high).contains(&value), "{value} is not in [{low}, {high}]");
}

#[test]
fn pushing_along_the_velocity_climbs_the_hill() {
    for (throttle, expected) in [(1.0, 89.4), (0.8, 92.9), (0.6, 95.6), (0.4, 97.0)] {
        let (mean, _, _) = score("mountain-car", 100, |o, _, _| throttle * sign(o[1]));
        between(mean, expected - 0.3, expected + 0.3);
    }
    let (_, deviation, length) = score("mountain-car", 100, |o, _, _| 0.4 * sign(o[1]));
    between(deviation, 0.0, 0.5);
    between(length, 170.0, 210.0);
}

#[test]
fn random_throttle_never_gets_there() {
    use rand::RngExt as _;
    // 999 steps at a mean of 0.1/3 each.
    let (mean, _, _) = score("mountain-car", 20, |_, _, rng| rng.random_range(-1.0..1.0));
    between(mean, -35.0, -31.5);
}

#[test]
fn random_pushes_keep_a_pole_up_for_22_steps_and_alternating_ones_for_38() {
    use rand::RngExt as _;
    // Standard deviations near 12 and 17, so standard errors near 0.1 and 0.4.
    let (mean, _, _) = score("cart-pole", 20_000, |_, _, rng| f64::from(rng.random_range(0..2_u8)));
    between(mean, 21.9, 22.7);
    let (mean, _, _) = score("cart-pole", 2000, |_, t, _| (t % 2) as f64);
    between(mean, 36.0, 39.0);
}

#[test]
fn state_feedback_balances_the_cart_pole() {
    let (mean, deviation, _) =
        score("cart-pole", 20, |o, _, _| f64::from(u8::from(0.3 * o[0] + 0.5 * o[1] + 10.0 * o[2] + 2.0 * o[3] > 0.0)));
    assert_eq!((mean, deviation), (500.0, 0.0));
}

#[test]
fn energy_pumping_swings_the_pendulum_up() {
    // Energy of the free pendulum, zero upright and still: ω²/2 + 15 (cos θ − 1).
    let (mean, _, _) = score("pendulum", 200, |o, _, _| {
        let (cos, sin, rate) = (o[0], o[1], o[2]);
        let angle = sin.atan2(cos);
        let energy = 0.5 * rate * rate + 15.0 * (cos - 1.0);
        if cos > 0.9 { -15.0 * angle - 4.0 * rate } else { -2.0 * sign(energy) * sign(rate) }
    });
    // Start states alone make ±90 of it: a standard error of 6.5.
    between(mean, -190.0, -135.0);
}

/// Swing-up by energy shaping, then state feedback; θ = 0 is upright, E the energy of the pole about its hinge, 0 upright
/// and still.
///
/// The cart is accelerated by a = 4 E ω cos θ − 2 x − 2 v, of which the first term takes E to 0 (Ė = −m l cos θ a − c ω²);
/// F = a + m l (cos θ ω̇ − sin θ ω²) + b v makes the cart do so. Near the top the gains are those of the
/// discrete-time linear-quadratic regulator with weights (1, 0.1, 5, 0.1) on (x, v, θ, ω) and 0.05 on F (Riccati
/// recursion on the linearised system in NumPy, 5000 turns).
///
/// # References
/// Åström, Furuta (2000), Automatica 36(2), "Swinging up a pendulum by energy control".
fn swing_up(o: &[f64]) -> f64 {
    let (x, v, cos, sin, rate) = (o[0], o[1], o[2], o[3], o[4]);
    let angle = sin.atan2(cos);
    if angle.abs() < 0.6 && (angle + 0.15 * rate).abs() < 0.72 {
        return 3.156 * x + 3.848 * v + 30.131 * angle + 5.175 * rate;
    }
    let energy = 0.03 * rate * rate + 1.473 * (cos - 1.0);
    let push = 4.0 * energy * rate * cos - 2.0 * x - 2.0 * v;
    let turn = (1.473 * sin - 0.01 * rate - 0.15 * cos * push) / 0.06;
    push + 0.15 * (cos * turn - sin * rate * rate) + 0.1 * v
}

#[test]
fn energy_shaping_and_state_feedback_solve_the_swing_up() {
    let mark = sindyna_envs::find("cart-pole-swing-up").and_then(|s| s.protocol().solved_at).expect("it has a mark");
    let (mean, _, length) = score("cart-pole-swing-up", 200, |o, _, _| swing_up(o));
    between(mean, 202.0, 210.0);
    between(mark / mean, 0.8, 0.9);
    assert_eq!(length, 250.0, "it never leaves the track");

    // Who never catches the pole is far from the mark, and who does nothing earns nothing.
    let (mean, _, _) = score("cart-pole-swing-up", 20, |o, _, _| {
        let caught = swing_up(o);
        if o[2] > 0.8 { 0.0 } else { caught }
    });
    between(mean, 20.0, 0.6 * mark);
    let (mean, _, _) = score("cart-pole-swing-up", 20, |_, _, _| 0.0);
    between(mean, 0.0, 1.0);
}

#[test]
fn leaving_the_track_never_pays() {
    // At full force to one side the cart leaves within a second; the little that was earned is all there will be.
    let (mean, _, length) = score("cart-pole-swing-up", 20, |_, _, _| 10.0);
    between(length, 10.0, 40.0);
    between(mean, 0.0, 10.0);
}

#[test]
fn state_feedback_balances_the_inverted_pendulum() {
    let (mean, deviation, _) =
        score("inverted-pendulum", 20, |o, _, _| 0.5 * o[0] + 5.0 * (o[1] + 1.0 / 600.0) + 0.6 * o[2] + o[3]);
    assert_eq!((mean, deviation), (1000.0, 0.0));
}

#[test]
fn the_inverted_pendulum_falls_within_the_known_time() {
    use rand::RngExt as _;
    let (_, _, length) = score("inverted-pendulum", 2000, |_, _, rng| rng.random_range(-3.0..3.0));
    between(length, 5.6, 6.2);
    for (size, steps, slack) in [(3.0, 5.0, 0.1), (1.0, 10.0, 0.6), (0.1, 24.0, 2.0), (0.0, 26.0, 2.0)] {
        let (mean, _, length) = score("inverted-pendulum", 200, |_, t, _| if t % 2 == 0 { -size } else { size });
        between(length, steps - slack, steps + slack);
        assert!((mean - (length - 1.0)).abs() < 1e-9, "the step that ends the episode pays nothing");
    }
}
