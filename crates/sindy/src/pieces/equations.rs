//! Equations of motion as functions of parameters.

use crate::Expr;
use crate::library::{Key, Lagrangian, Term};
use crate::model::{Form, Model};
use crate::names::symbols;
use crate::regression::{Space, Summands, of_equations};
use sindyna_core::Scheme;

/// The equations of a Lagrangian with some of its parameters: coefficients are ratios of sums of these.
#[derive(Debug, Clone)]
pub(super) struct Equations {
    /// Numbers of the parameters in the Lagrangian; the first one is the unit and stays 1.
    pub(super) chosen: Vec<usize>,
    /// Per coefficient of the model, in its order: what is divided, and by what, as (place among the chosen, factor).
    ratios: Vec<(Combination, usize)>,
    /// Inertia of each joint by itself.
    inertias: Vec<Combination>,
    /// The model with all coefficients 1.
    pub(super) model: Model,
    pub(super) terms: Vec<Term>,
    /// Per state: its terms.
    pub(super) supports: Vec<Vec<usize>>,
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
    /// The equations of `lagrangian` with the parameters `chosen`, in a model of `space` whose steps take `dt` \[s\]. `None` if a joint has no inertia.
    pub(super) fn new(lagrangian: &Lagrangian, chosen: &[usize], space: &Space, dt: f64) -> Option<Self> {
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
            if let Some(position) = lagrangian.joints.iter().position(|(q, _)| *q == state) {
                *support = vec![place(&(Expr::Variable(speeds[position]), None))];
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
    pub(super) fn coefficients(&self, theta: &[f64]) -> Option<Vec<f64>> {
        let inertias: Vec<f64> = self.inertias.iter().map(|of| sum(of, theta)).collect();
        let all: Vec<f64> = self.ratios.iter().map(|(of, joint)| -sum(of, theta) / inertias[*joint]).collect();
        (inertias.iter().all(|m| *m > 0.0) && all.iter().all(|c| c.is_finite())).then_some(all)
    }

    /// The model at the parameters `theta`.
    pub(super) fn at(&self, theta: &[f64]) -> Option<Model> {
        self.model.with_coefficients(&self.coefficients(theta)?)
    }
}
