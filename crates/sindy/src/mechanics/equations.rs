//! Equations of motion as functions of parameters.

use nalgebra::{DMatrix, DVector};
use rand_distr::{Distribution as _, StandardNormal};
use sindyna_core::{Scheme, Seed};

use crate::Expr;
use crate::library::{Key, Lagrangian, Term};
use crate::model::{Form, Model};
use crate::names::symbols;
use crate::regression::{Space, Summands, of_equations};

/// Sets of coefficients that are drawn.
const DRAWS: usize = 64;

/// Step by which derivatives of coefficients are taken, as part of the largest parameter.
const NUDGE: f64 = 1e-6;

/// The equations of a Lagrangian with some of its parameters: coefficients are ratios of sums of these.
#[derive(Debug, Clone)]
pub(crate) struct Equations {
    /// Numbers of the parameters in the Lagrangian; the first one is the unit and stays as it is.
    pub(crate) chosen: Vec<usize>,
    /// Per coefficient of the model, in its order: what is divided, and by what, as (place among the chosen, factor).
    ratios: Vec<(Combination, usize)>,
    /// Inertia of each joint by itself.
    inertias: Vec<Combination>,
    /// The model with all coefficients 1.
    pub(crate) model: Model,
    pub(crate) terms: Vec<Term>,
    /// Per state: its terms.
    pub(crate) supports: Vec<Vec<usize>>,
}

/// A sum of parameters: (place among the chosen, factor).
type Combination = Vec<(usize, f64)>;

fn sum(of: &Combination, theta: &[f64]) -> f64 {
    of.iter().map(|(place, factor)| factor * theta[*place]).sum()
}

/// The same with each parameter once, without those that cancel.
fn added_up(of: Combination) -> Combination {
    let mut all: Combination = Vec::new();
    for (place, factor) in of {
        match all.iter_mut().find(|(known, _)| *known == place) {
            Some((_, sum)) => *sum += factor,
            None => all.push((place, factor)),
        }
    }
    all.retain(|(_, factor)| *factor != 0.0);
    all
}

impl Equations {
    /// The equations of `lagrangian` with the parameters `chosen`, in a model of `space` whose steps take `dt` \[s\]; positions with `rates` may be of no joint. `None` if a joint has no inertia.
    pub(crate) fn new(
        lagrangian: &Lagrangian,
        chosen: &[usize],
        (space, rates): (&Space, &[Option<usize>]),
        dt: f64,
    ) -> Option<Self> {
        let speeds: Vec<usize> = lagrangian.joints.iter().map(|(_, v)| *v).collect();
        let mut rows: Vec<Vec<(Key, Combination)>> = vec![Vec::new(); speeds.len()];
        let mut inertias: Vec<Combination> = vec![Vec::new(); speeds.len()];
        for (place, &p) in chosen.iter().enumerate() {
            for (row, key, factor) in lagrangian.summands(p) {
                if key.1 == Some(speeds[row]) && key.0.is_one() {
                    inertias[row].push((place, factor));
                    continue;
                }
                match rows[row].iter_mut().find(|(known, _)| *known == key) {
                    Some((_, sum)) => sum.push((place, factor)),
                    None => rows[row].push((key, vec![(place, factor)])),
                }
            }
        }
        if inertias.iter().any(Vec::is_empty) {
            return None;
        }
        let names: Vec<String> = space.states.iter().chain(&space.controls).cloned().collect();
        let names = symbols(&names);
        let mut terms: Vec<Term> = Vec::new();
        let mut place = |(expr, rate): &Key| {
            let known = terms.iter().position(|t| t.expr == *expr && t.rate == *rate);
            known.unwrap_or_else(|| {
                let name = expr.display(&names).to_string();
                terms.push(Term { name, expr: expr.clone(), complexity: 2, rate: *rate, shape: None });
                terms.len() - 1
            })
        };
        let n = space.states.len();
        let (mut supports, mut ratios) = (vec![Vec::new(); n], Vec::new());
        for (state, support) in supports.iter_mut().enumerate() {
            if let Some(rate) = rates[state] {
                *support = vec![place(&(Expr::Variable(rate), None))];
            } else if let Some(joint) = speeds.iter().position(|v| *v == state) {
                // Sums that cancel whatever the parameters are have no term.
                for (key, sum) in rows[joint].drain(..) {
                    let sum = added_up(sum);
                    if !sum.is_empty() {
                        support.push(place(&key));
                        ratios.push((sum, joint));
                    }
                }
            }
        }
        let ones: Vec<Vec<f64>> = supports.iter().map(|s| vec![1.0; s.len()]).collect();
        let equations: Vec<Summands<'_>> = supports.iter().zip(&ones).map(|(s, c)| (&s[..], &c[..])).collect();
        let form = Form::Continuous(Scheme::Rk4 { substeps: 1 });
        let model = of_equations(space.clone(), &terms, &equations, form, dt).ok()?;
        Some(Self { chosen: chosen.to_vec(), ratios, inertias, model, terms, supports })
    }

    /// The coefficients of the model, in its order, at the parameters `theta`; `None` where an inertia is not positive.
    pub(crate) fn coefficients(&self, theta: &[f64]) -> Option<Vec<f64>> {
        let inertias: Vec<f64> = self.inertias.iter().map(|of| sum(of, theta)).collect();
        let all: Vec<f64> = self.ratios.iter().map(|(of, joint)| -sum(of, theta) / inertias[*joint]).collect();
        (inertias.iter().all(|m| *m > 0.0) && all.iter().all(|c| c.is_finite())).then_some(all)
    }

    /// The model at the parameters `theta`.
    pub(crate) fn at(&self, theta: &[f64]) -> Option<Model> {
        self.model.with_coefficients(&self.coefficients(theta)?)
    }

    /// ∂ξ/∂θ of the coefficients by the parameters beside the unit.
    pub(crate) fn slopes(&self, theta: &[f64]) -> Option<DMatrix<f64>> {
        let base = self.coefficients(theta)?;
        let step = NUDGE * theta.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let mut slopes = DMatrix::zeros(base.len(), theta.len() - 1);
        for j in 1..theta.len() {
            let mut moved = theta.to_vec();
            moved[j] += step;
            let moved = self.coefficients(&moved)?;
            (0..base.len()).for_each(|i| slopes[(i, j - 1)] = (moved[i] - base[i]) / step);
        }
        Some(slopes)
    }

    /// Coefficients of parameters drawn from their normal distribution.
    pub(crate) fn drawn(&self, theta: &[f64], covariance: &DMatrix<f64>) -> Vec<Vec<f64>> {
        let eigen = covariance.clone().symmetric_eigen();
        let mut rng = Seed::new(0).stream("coefficients", 0);
        let draw = |_| {
            let z = DVector::from_fn(theta.len() - 1, |i, _| {
                let normal: f64 = StandardNormal.sample(&mut rng);
                normal * eigen.eigenvalues[i].max(0.0).sqrt()
            });
            let change = &eigen.eigenvectors * z;
            let moved: Vec<f64> =
                theta.iter().enumerate().map(|(j, v)| if j == 0 { *v } else { v + change[j - 1] }).collect();
            self.coefficients(&moved)
        };
        let all: Vec<Vec<f64>> = (0..DRAWS).filter_map(draw).collect();
        if all.is_empty() { self.coefficients(theta).into_iter().collect() } else { all }
    }
}

/// The condition number of the correlations of the parameters.
pub(crate) fn condition(covariance: &DMatrix<f64>) -> f64 {
    let scale: Vec<f64> = covariance.diagonal().iter().map(|v| 1.0 / v.sqrt()).collect();
    let scaled = DMatrix::from_fn(scale.len(), scale.len(), |i, j| scale[i] * covariance[(i, j)] * scale[j]);
    let values = scaled.symmetric_eigen().eigenvalues;
    (values.max() / values.min().max(f64::MIN_POSITIVE)).sqrt()
}
