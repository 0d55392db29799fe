//! Parameters that bodies can have.

use nalgebra::{DMatrix, DVector, Matrix3, Matrix4, Vector3};

use crate::base::Base;
use crate::{Inertia, Tree};

/// Weight of the distance from the parameters of the file, beside a misfit of 1 where nothing is explained: it decides only what the data leave open.
const LEANING: f64 = 1e-7;

/// Weights of the barrier: the first, what each is of the one before, and the last.
const BARRIER: f64 = 1e-2;
const LESS: f64 = 0.2;
const LAST: f64 = 1e-17;

/// Newton steps for each weight, at most, and the decrement at which they end, as part of the weight.
const STEPS: usize = 50;
const CLOSE: f64 = 1e-4;

/// Part of an inertia by which that written lies inside of what bodies can have.
const MARGIN: f64 = 1e-7;

/// Part of an inertia or a friction of 1 that those of the file are at least, where the search begins.
const LEAST: f64 = 1e-3;

/// The parameters (13 n) of bodies of positive mass density, and with armature and friction of at least zero, whose base parameters are nearest to `values` (b) in the metric `information`,
/// and of those the ones nearest to the parameters of the file.
///
/// The problem is convex: ½ (C π − β)ᵀ H (C π − β) with a positive definite pseudo-inertia of each body. It is solved by Newton's method with the barrier −log det of pseudo-inertias.
///
/// # References
/// Wensing, Kim, Slotine (2018), IEEE Robotics and Automation Letters 3(1), §III; Boyd, Vandenberghe (2004), Convex Optimization, §11.3.
pub(crate) fn consistent(tree: &Tree, base: &Base, values: &[f64], information: &DMatrix<f64>) -> Vec<f64> {
    let problem = Problem::new(tree, base, values, information);
    let mut own = start(tree);
    let mut weight = BARRIER;
    while weight > LAST {
        for _ in 0..STEPS {
            let Some((slope, curvature)) = problem.derivatives(&own, weight) else { break };
            // Parameters of very different size.
            let scale = curvature.diagonal().map(|d| 1.0 / d.max(f64::MIN_POSITIVE).sqrt());
            let scaled = DMatrix::from_fn(own.len(), own.len(), |i, j| curvature[(i, j)] * scale[i] * scale[j]);
            let Some(step) = scaled.lu().solve(&-slope.component_mul(&scale)) else { break };
            let step = step.component_mul(&scale);
            let decrement = -slope.dot(&step);
            if decrement.is_nan() || decrement <= CLOSE * weight {
                break;
            }
            let here = problem.value(&own, weight);
            let halves = std::iter::successors(Some(1.0), |length| Some(0.5 * length)).take(60);
            let next = halves.map(|length| (length, &own + length * &step)).find(|(length, next)| {
                matches!((here, problem.value(next, weight)), (Some(here), Some(there)) if there <= here - 1e-4 * length * decrement)
            });
            let Some((_, next)) = next else { break };
            own = next;
        }
        weight *= LESS;
    }
    for (b, _) in tree.joints.iter().enumerate().filter(|(_, joint)| joint.is_massless) {
        own.rows_mut(10 * b, 10).fill(0.0);
    }
    for b in (0..tree.len()).filter(|b| !tree.joints[*b].is_massless) {
        // On the border digits decide whether there is such a body.
        let spread = own[10 * b + 4] + own[10 * b + 7] + own[10 * b + 9];
        [4, 7, 9].iter().for_each(|p| own[10 * b + p] += MARGIN * spread);
    }
    (&own + &problem.attached).iter().copied().collect()
}

/// What is minimised.
struct Problem {
    n: usize,
    /// Misfit A π − b, π the parameters without what is attached.
    rows: DMatrix<f64>,
    right: DVector<f64>,
    /// The parameters of the file, and the weight of the distance from each.
    given: DVector<f64>,
    leaning: DVector<f64>,
    attached: DVector<f64>,
}

impl Problem {
    fn new(tree: &Tree, base: &Base, values: &[f64], information: &DMatrix<f64>) -> Self {
        let n = tree.len();
        let mut combined = DMatrix::zeros(base.len(), 13 * n);
        for (i, combination) in base.combinations.iter().enumerate() {
            combination.iter().for_each(|(p, factor)| combined[(i, *p)] = *factor);
        }
        let goal = DVector::from_column_slice(values);
        let root = root_of(information);
        let whole = (&root * &goal).norm().max(f64::MIN_POSITIVE);
        let mut attached = DVector::zeros(13 * n);
        for (b, joint) in tree.joints.iter().enumerate() {
            attached.rows_mut(10 * b, 10).copy_from(&joint.attached.0);
        }
        let rows = &root * combined / whole;
        let right = &root * goal / whole - &rows * &attached;
        Self { n, rows, right, given: start(tree), leaning: scales(tree).map(|scale| LEANING / scale), attached }
    }

    /// `None` outside of what bodies can have.
    fn value(&self, own: &DVector<f64>, weight: f64) -> Option<f64> {
        let misfit = &self.rows * own - &self.right;
        let leaning = (own - &self.given).component_mul(&self.leaning);
        let mut barrier = 0.0;
        for b in 0..self.n {
            let factor = body(own, b).pseudo().cholesky()?;
            barrier -= 2.0 * factor.l().diagonal().iter().map(|d| d.ln()).sum::<f64>();
        }
        for value in own.rows(10 * self.n, 3 * self.n).iter() {
            if *value <= 0.0 {
                return None;
            }
            barrier -= value.ln();
        }
        Some(0.5 * (misfit.norm_squared() + leaning.norm_squared()) + weight * barrier)
    }

    /// The gradient and the matrix of second derivatives.
    fn derivatives(&self, own: &DVector<f64>, weight: f64) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let leaning = self.leaning.component_mul(&self.leaning);
        let mut slope =
            self.rows.transpose() * (&self.rows * own - &self.right) + (own - &self.given).component_mul(&leaning);
        let mut curvature = self.rows.transpose() * &self.rows + DMatrix::from_diagonal(&leaning);
        for b in 0..self.n {
            let inverse = body(own, b).pseudo().cholesky()?.inverse();
            let units: Vec<Matrix4<f64>> = (0..10).map(|p| inverse * unit(p)).collect();
            for (p, one) in units.iter().enumerate() {
                slope[10 * b + p] -= weight * one.trace();
                for (r, other) in units.iter().enumerate() {
                    curvature[(10 * b + p, 10 * b + r)] += weight * (one * other).trace();
                }
            }
        }
        for p in 10 * self.n..13 * self.n {
            slope[p] -= weight / own[p];
            curvature[(p, p)] += weight / (own[p] * own[p]);
        }
        Some((slope, curvature))
    }
}

fn body(own: &DVector<f64>, b: usize) -> Inertia {
    let mut inertia = Inertia::default();
    inertia.0.copy_from(&own.rows(10 * b, 10));
    inertia
}

/// The pseudo-inertia of a parameter of 1.
fn unit(p: usize) -> Matrix4<f64> {
    let mut inertia = Inertia::default();
    inertia.0[p] = 1.0;
    inertia.pseudo()
}

/// A with Aᵀ A the symmetric `of`.
fn root_of(of: &DMatrix<f64>) -> DMatrix<f64> {
    // Columns of length 1 first: parameters are of very different size.
    let scale = of.diagonal().map(|d| if d > 0.0 { 1.0 / d.sqrt() } else { 1.0 });
    let scaled = DMatrix::from_fn(of.nrows(), of.ncols(), |i, j| of[(i, j)] * scale[i] * scale[j]);
    let eigen = scaled.symmetric_eigen();
    let sizes = eigen.eigenvalues.map(|v| v.max(0.0).sqrt());
    DMatrix::from_diagonal(&sizes) * eigen.eigenvectors.transpose() * DMatrix::from_diagonal(&scale.map(|s| 1.0 / s))
}

/// The bodies of the file, or small spheres where it has none that there can be.
fn start(tree: &Tree) -> DVector<f64> {
    let sphere = Inertia::new(1.0, Vector3::zeros(), 0.01 * Matrix3::identity());
    let given = |joint: &crate::Joint| if joint.inertia.is_consistent() { joint.inertia } else { sphere };
    let bodies = tree.joints.iter().flat_map(|j| given(j).0.iter().copied().collect::<Vec<f64>>());
    let joints =
        [|j: &crate::Joint| j.own.armature, |j: &crate::Joint| j.own.damping, |j: &crate::Joint| j.own.friction];
    let joints = joints.into_iter().flat_map(|of| tree.joints.iter().map(move |j| of(j).max(LEAST)));
    DVector::from_iterator(13 * tree.len(), bodies.chain(joints))
}

/// The size of each parameter (13 n).
fn scales(tree: &Tree) -> DVector<f64> {
    let first = start(tree);
    let n = tree.len();
    let mut all = DVector::from_element(13 * n, 1.0);
    for b in 0..n {
        let own = body(&first, b);
        let mass = own.mass();
        let reach = (own.about_com().trace() / mass + own.com().norm_squared()).sqrt();
        for p in 0..10 {
            all[10 * b + p] = match p {
                0 => mass,
                1..=3 => mass * reach,
                _ => mass * reach * reach,
            };
        }
        all[10 * n + b] = mass * reach * reach;
    }
    all
}
