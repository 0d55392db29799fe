//! Systems of several joints with constants that are drawn, simulated by classical steps.

use ndarray::{Array2, Axis};
use rand::RngExt as _;
use rand_distr::StandardNormal;
use sindyna_core::{Kind, Rng, Seed, Spec, VectorField as _};
use sindyna_sindy::{Model, Recording};

/// Classical steps from sample to sample.
const PARTS: u32 = 5;

/// q̈ of q, q̇ and the input.
type Accelerations = Box<dyn Fn(&[f64], &[f64], f64) -> Vec<f64>>;

pub(crate) struct Mechanism {
    pub(crate) name: String,
    /// Whether each joint turns.
    turns: Vec<bool>,
    accelerations: Accelerations,
}

/// A chain of `links` in a plane, on a cart if there is one; angles are between links, or, with `absolute`, from the vertical.
pub(crate) fn chain(links: usize, cart: bool, absolute: bool, rng: &mut Rng) -> Mechanism {
    let mut drawn = |low: f64, high: f64| rng.random_range(low..high);
    let masses: Vec<f64> = (0..links).map(|_| drawn(0.5, 1.5)).collect();
    let lengths: Vec<f64> = (0..links).map(|_| drawn(0.5, 1.2)).collect();
    let cart_mass = drawn(1.0, 3.0);
    let first = usize::from(cart);
    let n = links + first;
    let damping: Vec<f64> = (0..n).map(|_| drawn(0.05, 0.3)).collect();
    let (driven, strength) = (if cart { 0 } else { links - 1 }, drawn(5.0, 15.0));
    // The centre of link i is half of it beyond the sum of those before it.
    let arm = |i: usize, k: usize| match k.cmp(&i) {
        std::cmp::Ordering::Less => lengths[k],
        std::cmp::Ordering::Equal => 0.5 * lengths[k],
        std::cmp::Ordering::Greater => 0.0,
    };
    let moment = |a: usize| (0..links).map(|i| masses[i] * arm(i, a)).sum::<f64>();
    let moments: Vec<f64> = (0..links).map(moment).collect();
    let inertia = |a: usize, b: usize| {
        let own = if a == b { masses[a] * lengths[a].powi(2) / 12.0 } else { 0.0 };
        own + (0..links).map(|i| masses[i] * arm(i, a) * arm(i, b)).sum::<f64>()
    };
    let inertias: Vec<Vec<f64>> = (0..links).map(|a| (0..links).map(|b| inertia(a, b)).collect()).collect();
    let total = cart_mass + masses.iter().sum::<f64>();
    // Sums of what comes before, for angles between links.
    let of_links = move |joints: &[f64]| -> Vec<f64> {
        let mut links = joints.to_vec();
        (first + 1..n).filter(|_| !absolute).for_each(|i| links[i] += links[i - 1]);
        links
    };
    let accelerations = move |q: &[f64], v: &[f64], u: f64| {
        let (phi, rate) = (of_links(q), of_links(v));
        let mut force: Vec<f64> = (0..n).map(|i| -damping[i] * v[i]).collect();
        force[driven] += strength * u;
        if !absolute {
            // A torque between two links acts on both.
            (first..n - 1).for_each(|i| force[i] -= force[i + 1]);
        }
        let mut mass = vec![0.0; n * n];
        if cart {
            mass[0] = total;
        }
        for a in 0..links {
            let i = a + first;
            force[i] += 9.81 * moments[a] * phi[i].sin();
            if cart {
                mass[i] = moments[a] * phi[i].cos();
                mass[i * n] = mass[i];
                force[0] += moments[a] * phi[i].sin() * rate[i].powi(2);
            }
            for (b, inertia) in inertias[a].iter().enumerate() {
                let j = b + first;
                mass[i * n + j] = inertia * (phi[i] - phi[j]).cos();
                force[i] -= inertia * (phi[i] - phi[j]).sin() * rate[j].powi(2);
            }
        }
        let mut found = solved(mass, force);
        (first + 1..n).rev().filter(|_| !absolute).for_each(|i| found[i] -= found[i - 1]);
        found
    };
    let of = if absolute { "angles from the vertical" } else { "angles between links" };
    let name = format!("{links} links{}, {of}", if cart { " on a cart" } else { "" });
    Mechanism { name, turns: (0..n).map(|i| i >= first).collect(), accelerations: Box::new(accelerations) }
}

/// An arm that turns about the vertical with a pendulum at its end.
#[allow(dead_code, reason = "not every test asks for it")]
pub(crate) fn furuta(rng: &mut Rng) -> Mechanism {
    let mut drawn = |low: f64, high: f64| rng.random_range(low..high);
    let (own, p, c, g) = (drawn(0.5, 1.0), drawn(0.2, 0.5), drawn(0.1, 0.25), drawn(3.0, 6.0));
    let (d1, d2, strength) = (drawn(0.01, 0.1), drawn(0.01, 0.1), drawn(3.0, 6.0));
    let accelerations = move |q: &[f64], v: &[f64], u: f64| {
        let (s, k) = q[1].sin_cos();
        let f1 = strength * u - d1 * v[0] - 2.0 * p * s * k * v[0] * v[1] + c * s * v[1] * v[1];
        let f2 = g * s - d2 * v[1] + p * s * k * v[0] * v[0];
        solved(vec![own + p * s * s, c * k, c * k, p], vec![f1, f2])
    };
    Mechanism { name: "rotary pendulum".into(), turns: vec![true; 2], accelerations: Box::new(accelerations) }
}

/// A pendulum that swings to all sides: its bearing, and its angle from the vertical.
#[allow(dead_code, reason = "not every test asks for it")]
pub(crate) fn spherical(rng: &mut Rng) -> Mechanism {
    let mut drawn = |low: f64, high: f64| rng.random_range(low..high);
    let (own, p, g) = (drawn(0.1, 0.3), drawn(0.5, 1.5), drawn(3.0, 6.0));
    let (d1, d2, strength) = (drawn(0.01, 0.1), drawn(0.01, 0.1), drawn(3.0, 6.0));
    let accelerations = move |q: &[f64], v: &[f64], u: f64| {
        let (s, k) = q[1].sin_cos();
        let f1 = strength * u - d1 * v[0] - 2.0 * p * s * k * v[0] * v[1];
        let f2 = g * s - d2 * v[1] + p * s * k * v[0] * v[0];
        vec![f1 / (own + p * s * s), f2 / p]
    };
    Mechanism { name: "spherical pendulum".into(), turns: vec![true; 2], accelerations: Box::new(accelerations) }
}

impl Mechanism {
    /// Positions, then their rates; one input.
    pub(crate) fn spec(&self, dt: f64) -> Spec {
        let n = self.turns.len();
        let names: Vec<String> = (0..n).map(|i| format!("q{i}")).chain((0..n).map(|i| format!("v{i}"))).collect();
        let kind = |i: usize| match i.checked_sub(n) {
            Some(of) => Kind::RateOf(of),
            None if self.turns[i] => Kind::Angle,
            None => Kind::Plain,
        };
        let states: Vec<(&str, Kind)> = names.iter().enumerate().map(|(i, name)| (name.as_str(), kind(i))).collect();
        super::recorded::spec(&states, dt)
    }

    fn step(&self, x: &[f64], u: f64, dt: f64) -> Vec<f64> {
        let n = self.turns.len();
        let h = dt / f64::from(PARTS);
        let rates = |x: &[f64]| [x[n..].to_vec(), (self.accelerations)(&x[..n], &x[n..], u)].concat();
        let mut x = x.to_vec();
        for _ in 0..PARTS {
            let moved = |k: &[f64], c: f64| -> Vec<f64> { x.iter().zip(k).map(|(x, k)| x + c * k).collect() };
            let k1 = rates(&x);
            let k2 = rates(&moved(&k1, 0.5 * h));
            let k3 = rates(&moved(&k2, 0.5 * h));
            let k4 = rates(&moved(&k3, h));
            x = (0..2 * n).map(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])).collect();
        }
        x
    }

    /// Recordings of six steps each, from starts and under inputs that are drawn.
    #[allow(dead_code, reason = "not every test asks for it")]
    pub(crate) fn recordings(&self, steps: usize, dt: f64, rng: &mut Rng) -> Vec<Recording> {
        let exact = |(x, u)| Recording::even(dt, x, Some(u));
        self.rollouts(steps / 6, (6, 1), dt, rng).into_iter().map(exact).collect()
    }

    /// So many recordings of `steps` steps, inputs held for `held` of them, with errors of the part `noise` of the spread of each channel.
    #[allow(dead_code, reason = "not every test asks for it")]
    pub(crate) fn noisy_recordings(
        &self,
        (count, steps, held): (usize, usize, usize),
        dt: f64,
        noise: f64,
        rng: &mut Rng,
    ) -> Vec<Recording> {
        let rollouts = self.rollouts(count, (steps, held), dt, rng);
        let views: Vec<_> = rollouts.iter().map(|(x, _)| x.view()).collect();
        let all = ndarray::concatenate(Axis(0), &views).expect("as many states in each");
        let spread = all.std_axis(Axis(0), 0.0);
        let with_noise = |(mut x, u): (Array2<f64>, Array2<f64>)| {
            for (x, spread) in x.iter_mut().zip(spread.iter().cycle()) {
                *x += noise * spread * rng.sample::<f64, _>(StandardNormal);
            }
            Recording::even(dt, x, Some(u))
        };
        rollouts.into_iter().map(with_noise).collect()
    }

    /// States and inputs of so many rollouts of `steps` steps.
    fn rollouts(
        &self,
        count: usize,
        (steps, held): (usize, usize),
        dt: f64,
        rng: &mut Rng,
    ) -> Vec<(Array2<f64>, Array2<f64>)> {
        let n = self.turns.len();
        (0..count)
            .map(|_| {
                let start: Vec<f64> = (0..2 * n)
                    .map(|i| if i < n && !self.turns[i] { 0.3 } else { 1.0 } * rng.random_range(-1.0..1.0))
                    .collect();
                let pushes: Vec<f64> = (0..steps.div_ceil(held)).map(|_| rng.random_range(-1.0..1.0)).collect();
                let u: Vec<f64> = (0..steps).map(|t| pushes[t / held]).collect();
                let mut x = Array2::zeros((steps + 1, 2 * n));
                x.row_mut(0).assign(&ndarray::aview1(&start));
                for (t, push) in u.iter().enumerate() {
                    let next = self.step(&x.row(t).to_vec(), *push, dt);
                    x.row_mut(t + 1).assign(&ndarray::aview1(&next));
                }
                (x, Array2::from_shape_vec((steps, 1), u).expect("a column"))
            })
            .collect()
    }

    /// The largest difference of the accelerations of `model` from the true ones over ±3 rad, as part of their spread.
    pub(crate) fn deviation(&self, model: &Model) -> f64 {
        let n = self.turns.len();
        let mut rng = Seed::new(0).stream("places", 0);
        let mut both: Vec<Vec<(f64, f64)>> = vec![Vec::new(); n];
        for _ in 0..300 {
            let x: Vec<f64> = (0..2 * n).map(|_| rng.random_range(-3.0..3.0)).collect();
            let u = rng.random_range(-1.0..1.0);
            let truth = (self.accelerations)(&x[..n], &x[n..], u);
            let mut found = vec![0.0; 2 * n];
            model.eval(&x, &[u], &mut found);
            (0..n).for_each(|i| both[i].push((truth[i], found[n + i])));
        }
        let worst = |of: &Vec<(f64, f64)>| {
            let mean = of.iter().map(|(t, _)| t).sum::<f64>() / of.len() as f64;
            let spread = (of.iter().map(|(t, _)| (t - mean).powi(2)).sum::<f64>() / of.len() as f64).sqrt();
            of.iter().map(|(t, f)| (t - f).abs()).fold(0.0, f64::max) / spread
        };
        both.iter().map(worst).fold(0.0, f64::max)
    }
}

/// M⁻¹ f by Gauss's elimination.
fn solved(mut m: Vec<f64>, mut f: Vec<f64>) -> Vec<f64> {
    let n = f.len();
    for k in 0..n {
        let best = (k..n).max_by(|&i, &j| m[i * n + k].abs().total_cmp(&m[j * n + k].abs())).expect("a row");
        f.swap(k, best);
        (0..n).for_each(|j| m.swap(k * n + j, best * n + j));
        for i in k + 1..n {
            let by = m[i * n + k] / m[k * n + k];
            f[i] -= by * f[k];
            (k..n).for_each(|j| m[i * n + j] -= by * m[k * n + j]);
        }
    }
    for i in (0..n).rev() {
        f[i] = (f[i] - (i + 1..n).map(|j| m[i * n + j] * f[j]).sum::<f64>()) / m[i * n + i];
    }
    f
}
