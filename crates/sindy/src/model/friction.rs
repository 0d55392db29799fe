//! The dry friction among the equations of a model.

use super::parts::Entry;
use crate::expr::{Expr, Function, Tape};

/// The dry friction of a model whose time is continuous: v̇ = f(x, u) − F(x, u) sign v in the equations of some states v, with F ≥ 0.
///
/// A step of length h is one of Runge–Kutta in which every sign is what it is at the beginning, 0 at rest. Where a speed changes its sign on the way, or is
/// at rest, friction exchanges another impulse s with it, of the size that stops it if that is within the bounds: v⁺ = v + D s with |s − h F sign v| ≤ h F, D the inverse of the matrix of
/// masses, and x⁺ = x + h/2 D s for what v is the rate of. So friction holds what is pushed by less than F, and no speed creeps.
///
/// # References
/// Acary, Brogliato (2008), Numerical Methods for Nonsmooth Dynamical Systems, §10 (time stepping), §12.4 (projected Gauss–Seidel).
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Friction {
    pub(super) joints: Vec<Joint>,
    /// The coefficient, the register of F and the joint of each summand.
    pub(super) summands: Vec<(f64, u32, usize)>,
}

/// A state with dry friction.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// The state.
    pub speed: usize,
    /// The states whose rate it is.
    pub positions: Vec<usize>,
}

/// Joints, and terms and equations over signs that are given.
pub(crate) type Given = (Vec<Joint>, Vec<Expr>, Vec<Vec<Entry>>);

/// What multiplies sign(variable `v`) in `expr`; `None` if it is no such product.
fn beside_sign(expr: &Expr, v: usize) -> Option<Expr> {
    match expr {
        Expr::Call(Function::Sign, inner) if **inner == Expr::Variable(v) => Some(Expr::Constant(1.0)),
        Expr::Neg(a) => Some(Expr::Neg(Box::new(beside_sign(a, v)?))),
        Expr::Mul(a, b) => {
            let times = |rest: Expr, other: &Expr| Expr::Mul(Box::new(rest), Box::new(other.clone()));
            beside_sign(a, v).map(|rest| times(rest, b)).or_else(|| beside_sign(b, v).map(|rest| times(rest, a)))
        }
        Expr::Div(a, b) => Some(Expr::Div(Box::new(beside_sign(a, v)?), b.clone())),
        _ => None,
    }
}

/// The factor F of `entry` in the equation of state `i`, if it is dry friction.
fn factor(terms: &[Expr], entry: &Entry, i: usize) -> Option<Expr> {
    entry.rate.is_none().then(|| beside_sign(&terms[entry.term], i)).flatten()
}

impl Friction {
    /// The dry friction among `equations` over `terms`, whose factors are added to `tape`; `None` if there is none.
    pub(super) fn among(equations: &[Vec<Entry>], terms: &[Expr], tape: &mut Tape) -> Option<Self> {
        let mut joints: Vec<Joint> = Vec::new();
        let mut summands = Vec::new();
        for (i, row) in equations.iter().enumerate() {
            for entry in row {
                let Some(factor) = factor(terms, entry, i) else { continue };
                if joints.last().is_none_or(|j| j.speed != i) {
                    let is_rate = |p: &usize| matches!(equations[*p][..], [Entry { term, coefficient: 1.0, rate: None }] if terms[term] == Expr::Variable(i));
                    joints.push(Joint { speed: i, positions: (0..equations.len()).filter(is_rate).collect() });
                }
                tape.extend([&factor]);
                let register = tape.outputs().last().copied().unwrap_or_default();
                summands.push((entry.coefficient, register, joints.len() - 1));
            }
        }
        (!joints.is_empty()).then_some(Self { joints, summands })
    }

    /// The same with the coefficients of `equations`.
    pub(super) fn with_coefficients(&self, equations: &[Vec<Entry>], terms: &[Expr]) -> Self {
        let rubs = |(i, row): (usize, &Vec<Entry>)| {
            row.iter().filter(|e| factor(terms, e, i).is_some()).map(|e| e.coefficient).collect::<Vec<_>>()
        };
        let coefficients = equations.iter().enumerate().flat_map(rubs);
        let summands = self.summands.iter().zip(coefficients).map(|((_, register, joint), c)| (c, *register, *joint));
        Self { joints: self.joints.clone(), summands: summands.collect() }
    }

    /// `equations` without dry friction.
    pub(super) fn without(equations: &[Vec<Entry>], terms: &[Expr]) -> Vec<Vec<Entry>> {
        let smooth =
            |(i, row): (usize, &Vec<Entry>)| row.iter().filter(|e| factor(terms, e, i).is_none()).copied().collect();
        equations.iter().enumerate().map(smooth).collect()
    }

    /// The joints, and terms and `equations` in which the sign beside friction in joint j is variable number `signs` + j.
    pub(super) fn with_signs(&self, equations: &[Vec<Entry>], terms: &[Expr], signs: usize) -> Given {
        let (mut terms, mut equations) = (terms.to_vec(), equations.to_vec());
        for (j, joint) in self.joints.iter().enumerate() {
            for entry in &mut equations[joint.speed] {
                let Some(factor) = factor(&terms, entry, joint.speed) else { continue };
                entry.term = terms.len();
                terms.push(factor.times(Expr::Variable(signs + j)));
            }
        }
        (self.joints.clone(), terms, equations)
    }

    /// Adds −F times the sign given for each joint to `sums`.
    pub(super) fn add(&self, registers: &[f64], signs: &[f64], sums: &mut [f64]) {
        for (c, register, joint) in &self.summands {
            sums[self.joints[*joint].speed] += c * registers[*register as usize] * signs[*joint];
        }
    }
}
