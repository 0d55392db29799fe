//! What the reward of a step costs, to second order.

use ndarray::{Array1, Array2, s};

use super::plant::Plant;
use super::small::without_negative;

/// Gradient (n + k) and Hessian (n + k, n + k), without what bends down, of −r over y = (x; u), for a step x⁺ ≈ A x + B u from x under u to `next`; by differences of
/// `width` scales.
pub(super) fn costs(
    plant: &Plant,
    (x, u, next): (&[f64], &[f64], &[f64]),
    (a, b): (&Array2<f64>, &Array2<f64>),
    width: f64,
) -> (Array1<f64>, Array2<f64>) {
    let (n, k) = plant.dims();
    let (g, h) = of_reward(plant, (x, u, next), width);
    // z = (x; u; x⁺), of which the last is A x + B u.
    let mut through = Array2::zeros((2 * n + k, n + k));
    (0..n + k).for_each(|i| through[[i, i]] = 1.0);
    through.slice_mut(s![n + k.., ..n]).assign(a);
    through.slice_mut(s![n + k.., n..]).assign(b);
    (through.t().dot(&g) * -1.0, without_negative(&(through.t().dot(&h).dot(&through) * -1.0)))
}

/// Gradient and Hessian of r over z = (x; u; x⁺), by central differences. Values of z on which r does not depend cost two evaluations each.
fn of_reward(plant: &Plant, (x, u, next): (&[f64], &[f64], &[f64]), width: f64) -> (Array1<f64>, Array2<f64>) {
    let (n, k) = plant.dims();
    let size = 2 * n + k;
    let mut z = [x, u, next].concat();
    let reward = |z: &[f64]| plant.reward(&z[..n], &z[n..n + k], &z[n + k..]);
    let step = |i: usize| {
        width
            * match i {
                i if i < n => plant.scales[i],
                i if i < n + k => plant.half(i - n),
                i => plant.scales[i - n - k],
            }
    };
    let middle = reward(&z);
    let (mut g, mut h) = (Array1::zeros(size), Array2::zeros((size, size)));
    let mut active = Vec::new();
    for i in 0..size {
        let (at, d) = (z[i], step(i));
        z[i] = at + d;
        let above = reward(&z);
        z[i] = at - d;
        let below = reward(&z);
        z[i] = at;
        if above - middle == 0.0 && below - middle == 0.0 {
            continue;
        }
        g[i] = (above - below) / (2.0 * d);
        h[[i, i]] = (above - 2.0 * middle + below) / (d * d);
        active.push((i, at, d));
    }
    for (p, &(i, zi, di)) in active.iter().enumerate() {
        for &(j, zj, dj) in &active[..p] {
            let mut at = |si: f64, sj: f64| {
                (z[i], z[j]) = (zi + si * di, zj + sj * dj);
                let value = reward(&z);
                (z[i], z[j]) = (zi, zj);
                value
            };
            let mixed = (at(1.0, 1.0) - at(1.0, -1.0) - at(-1.0, 1.0) + at(-1.0, -1.0)) / (4.0 * di * dj);
            (h[[i, j]], h[[j, i]]) = (mixed, mixed);
        }
    }
    (g, h)
}
