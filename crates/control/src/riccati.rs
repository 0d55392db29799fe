//! The gain that is best under quadratic costs.

use faer::linalg::solvers::Solve as _;
use faer::{Mat, MatRef, Side};
use ndarray::Array2;
use sindyna_core::Spec;

use crate::matrix::{inner, largest, outer};
use crate::{ControlError, Linear};

/// Doublings, at most: 2⁵⁰ steps. What is stabilisable converges in about ten.
const DOUBLINGS: usize = 50;

/// Change of the value, as part of it, at which doubling has converged.
const CONVERGED: f64 = 1e-13;

/// What a step costs: Σ `state`ᵢ (x − x₀)ᵢ² + Σ `control`ⱼ (u − u₀)ⱼ².
#[derive(Debug, Clone, PartialEq)]
pub struct Costs {
    /// Diagonal of Q (n), positive.
    pub state: Vec<f64>,
    /// Diagonal of R (k), positive.
    pub control: Vec<f64>,
}

impl Costs {
    /// 1/scale² for every channel of `spec`: a state or control at its typical magnitude costs one.
    ///
    /// # References
    /// Bryson, Ho (1975), *Applied Optimal Control*, §5.2, "Bryson's rule".
    #[must_use]
    pub fn of_scales(spec: &Spec) -> Self {
        let inverse_square = |c: &sindyna_core::Channel| (c.prior.scale * c.prior.scale).recip();
        Self {
            state: spec.state.iter().map(inverse_square).collect(),
            control: spec.control.iter().map(inverse_square).collect(),
        }
    }
}

/// u − u₀ = −K (x − x₀), and what it is worth.
#[derive(Debug, Clone, PartialEq)]
pub struct Regulator {
    /// K (k, n).
    pub gain: Array2<f64>,
    /// P (n, n): (x − x₀)ᵀ P (x − x₀) is the cost of all that comes after x.
    pub value: Array2<f64>,
    /// Largest magnitude of an eigenvalue of A − B K: below 1, and the smaller, the faster is the return to rest.
    pub spectral_radius: f64,
}

/// The gain K of least Σ xᵀQx + uᵀRu over all time, for x⁺ = A x + B u:
///
/// K = (R + BᵀPB)⁻¹ BᵀPA with P = Q + AᵀPA − AᵀPB (R + BᵀPB)⁻¹ BᵀPA.
///
/// P is found by structure-preserving doubling, in which round i holds the value of 2ⁱ steps:
/// A ← A W⁻¹ A, G ← G + A W⁻¹ G Aᵀ, H ← H + Aᵀ H W⁻¹ A with W = I + G H, from G = B R⁻¹ Bᵀ and H = Q; H goes to P. Costs
/// are positive, so every state is seen and the limit is the stabilising one, where there is one.
///
/// # Errors
/// [`ControlError`] for shapes that do not fit, costs that are not positive, and pairs (A, B) that no gain stabilises.
///
/// # References
/// Anderson (1978), Int. J. Control 28(2), "Second-order convergent algorithms for the steady-state Riccati equation". Chu,
/// Fan, Lin, Wang (2004), Int. J. Control 77(8), doi:10.1080/00207170410001714988, algorithm 3.1.
pub fn regulate(linear: &Linear, costs: &Costs) -> Result<Regulator, ControlError> {
    check(linear, costs)?;
    let (n, k) = linear.b.dim();
    let mut all = Array2::zeros((n + k, n + k));
    costs.state.iter().chain(&costs.control).enumerate().for_each(|(i, cost)| all[[i, i]] = *cost);
    regulate_coupled(linear, &all)
}

/// The same for costs yᵀHy of y = (x − x₀; u − u₀), with H = \[Q S; Sᵀ R\] (n + k, n + k) positive definite: with u = v − R⁻¹Sᵀx the costs of v are not coupled to those
/// of x.
///
/// # References
/// Anderson, Moore (1990), Optimal Control: Linear Quadratic Methods, §3.4.
pub(crate) fn regulate_coupled(linear: &Linear, costs: &Array2<f64>) -> Result<Regulator, ControlError> {
    let (a, b) = (inner(linear.a.view()), inner(linear.b.view()));
    let (n, k) = (a.nrows(), b.ncols());
    let all = inner(costs.view());
    let (q, s, r) = (all.submatrix(0, 0, n, n), all.submatrix(0, n, n, k), all.submatrix(n, n, k, k));
    let not_stable = ControlError::NotStabilisable { doublings: DOUBLINGS };
    let factor = r.llt(Side::Lower).map_err(|_| not_stable.clone())?;
    let first = factor.solve(s.transpose());
    let (uncoupled, q) = (&a - &b * &first, q - s * &first);
    let p = doubled(uncoupled.as_ref(), &b * factor.solve(b.transpose()), q)?;
    let gain = (r + b.transpose() * &p * &b).partial_piv_lu().solve(b.transpose() * &p * &uncoupled) + first;
    let closed = &a - &b * &gain;
    let eigenvalues = closed.eigenvalues().map_err(|_| not_stable.clone())?;
    let spectral_radius = eigenvalues.iter().map(|z| z.re.hypot(z.im)).fold(0.0, f64::max);
    if spectral_radius < 1.0 {
        Ok(Regulator { gain: outer(gain.as_ref()), value: outer(p.as_ref()), spectral_radius })
    } else {
        Err(not_stable)
    }
}

/// The limit of the doubling.
fn doubled(a: MatRef<'_, f64>, mut g: Mat<f64>, mut h: Mat<f64>) -> Result<Mat<f64>, ControlError> {
    let n = a.nrows();
    let mut a = a.to_owned();
    for doublings in 1..=DOUBLINGS {
        let w = (Mat::<f64>::identity(n, n) + &g * &h).partial_piv_lu();
        let (wa, wg) = (w.solve(&a), w.solve(&g));
        let more = a.transpose() * &h * &wa;
        g += &a * wg * a.transpose();
        h += &more;
        a = &a * wa;
        let (change, size) = (largest(more.as_ref()), largest(h.as_ref()));
        if !size.is_finite() {
            return Err(ControlError::NotStabilisable { doublings });
        }
        if change <= CONVERGED * size {
            return Ok(h);
        }
    }
    Err(ControlError::NotStabilisable { doublings: DOUBLINGS })
}

fn check(linear: &Linear, costs: &Costs) -> Result<(), ControlError> {
    let (n, k) = (costs.state.len(), costs.control.len());
    for (what, matrix, expected) in [("A", &linear.a, (n, n)), ("B", &linear.b, (n, k))] {
        if matrix.dim() != expected {
            return Err(ControlError::Shape { what, expected, got: matrix.dim() });
        }
    }
    for (what, costs) in [("state", &costs.state), ("control", &costs.control)] {
        if let Some(index) = costs.iter().position(|c| !(c.is_finite() && *c > 0.0)) {
            return Err(ControlError::Cost { what, index, value: costs[index] });
        }
    }
    Ok(())
}
