//! The Lagrangian of a mechanical system, linear in unknown parameters.

use std::collections::BTreeMap;

use super::{Input, Role};
use crate::expr::{Expr, Function};

/// L = ½ q̇ᵀM(q)q̇ − V(q) with Rayleigh damping and inputs: d/dt ∂L/∂q̇ − ∂L/∂q = f(q, q̇, u), linear in the [`Parameter`]s.
///
/// Entries of M and V are sums of waves: 1, sines and cosines of angles, of twice an angle, of sums and differences of two. One parameter of M
/// is a term of the equations of several joints at once.
#[derive(Debug, Clone)]
pub(crate) struct Lagrangian {
    /// Position and speed of each joint, as numbers of states.
    pub(crate) joints: Vec<(usize, usize)>,
    waves: Vec<Wave>,
    pub(crate) parameters: Vec<Parameter>,
}

/// sin k·q or cos k·q; k = 0 is the constant.
#[derive(Debug, Clone, PartialEq)]
struct Wave {
    /// k, per joint.
    multiples: Vec<i32>,
    is_sine: bool,
    expr: Expr,
}

/// One unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Parameter {
    /// Of wave w in M, row i and column j: w q̇ᵢ q̇ⱼ in the kinetic energy (half of it if i = j).
    Inertia(usize, usize, usize),
    /// Of wave w in V.
    Potential(usize),
    /// A constant force on joint i.
    Force(usize),
    /// A spring on joint i.
    Spring(usize),
    /// Viscous friction of joint i.
    Damping(usize),
    /// Viscous friction between joints i and j.
    Between(usize, usize),
    /// Drag −q̇ᵢ|q̇ᵢ|.
    Drag(usize),
    /// Dry friction −sign q̇ᵢ.
    Friction(usize),
    /// Input k on joint i.
    Input(usize, usize),
}

/// What a term of an equation multiplies: an acceleration, by its state, or nothing.
pub(crate) type Key = (Expr, Option<usize>);

impl Lagrangian {
    /// Of the variables `inputs`, of which `rates` says what is the rate of which. `None` unless there are two joints or more, one of which turns, and all states
    /// are positions and speeds of joints.
    pub(crate) fn new(inputs: &[Input], rates: &[Option<usize>]) -> Option<Self> {
        let joints: Vec<(usize, usize)> = rates.iter().enumerate().filter_map(|(q, v)| Some((q, (*v)?))).collect();
        let turns = |q: usize| matches!(inputs[q].role, Role::Angle | Role::Turning);
        let angles: Vec<usize> = (0..joints.len()).filter(|&i| turns(joints[i].0)).collect();
        let is_chain = joints.iter().any(|(_, v)| rates[*v].is_some());
        if joints.len() < 2 || angles.is_empty() || is_chain || 2 * joints.len() != rates.len() {
            return None;
        }
        let n_joints = joints.len();
        let mut waves = vec![Wave { multiples: vec![0; n_joints], is_sine: false, expr: Expr::Constant(1.0) }];
        let mut add = |multiples: Vec<i32>, of: &dyn Fn(Function) -> Expr| {
            for (function, is_sine) in [(Function::Sin, true), (Function::Cos, false)] {
                waves.push(Wave { multiples: multiples.clone(), is_sine, expr: of(function) });
            }
        };
        let angle = |i: usize| Expr::Variable(joints[i].0);
        let combined = |of: &[(usize, i32)]| {
            let mut multiples = vec![0; n_joints];
            of.iter().for_each(|(i, k)| multiples[*i] = *k);
            multiples
        };
        for &i in &angles {
            add(combined(&[(i, 1)]), &|f| Expr::wave(f, 1, angle(i)));
            add(combined(&[(i, 2)]), &|f| Expr::wave(f, 2, angle(i)));
        }
        for (at, &i) in angles.iter().enumerate() {
            for &j in &angles[at + 1..] {
                let (a, b) = (Box::new(angle(i)), Box::new(angle(j)));
                let (sum, difference) = (Expr::Add(a.clone(), b.clone()), Expr::Sub(a, b));
                add(combined(&[(i, 1), (j, 1)]), &|f| Expr::Call(f, Box::new(sum.clone())));
                add(combined(&[(i, 1), (j, -1)]), &|f| Expr::Call(f, Box::new(difference.clone())));
            }
        }
        let n_controls = inputs.len() - rates.len();
        let mut parameters = Vec::new();
        for i in 0..n_joints {
            for j in i..n_joints {
                parameters.extend((0..waves.len()).map(|w| Parameter::Inertia(w, i, j)));
            }
        }
        parameters.extend((1..waves.len()).map(Parameter::Potential));
        for i in 0..n_joints {
            parameters.extend([Parameter::Force(i), Parameter::Damping(i), Parameter::Drag(i), Parameter::Friction(i)]);
            if inputs[joints[i].0].role != Role::Turning {
                parameters.push(Parameter::Spring(i));
            }
            parameters.extend((i + 1..n_joints).map(|j| Parameter::Between(i, j)));
            parameters.extend((0..n_controls).map(|k| Parameter::Input(k, i)));
        }
        Some(Self { joints, waves, parameters })
    }

    /// Parameters one of which may be the unit of all others: the first input on each joint; without inputs the constant inertia of each.
    pub(crate) fn units(&self) -> Vec<usize> {
        let of = |wanted: &dyn Fn(&Parameter) -> bool| {
            (0..self.parameters.len()).filter(|&p| wanted(&self.parameters[p])).collect::<Vec<_>>()
        };
        let inputs = of(&|p| matches!(p, Parameter::Input(0, _)));
        if inputs.is_empty() { of(&|p| matches!(p, Parameter::Inertia(0, i, j) if i == j)) } else { inputs }
    }

    /// The parameters beside `unit`; an input acts on one joint alone.
    pub(crate) fn others(&self, unit: usize) -> Vec<usize> {
        let is_same = |p: &Parameter| matches!((p, &self.parameters[unit]), (Parameter::Input(k, _), Parameter::Input(l, _)) if k == l);
        (0..self.parameters.len()).filter(|&p| p != unit && !is_same(&self.parameters[p])).collect()
    }

    /// The momenta ∂L/∂q̇ of parameter p with coefficient 1: (joint, expression).
    pub(crate) fn momenta(&self, p: usize) -> Vec<(usize, Expr)> {
        let Parameter::Inertia(w, i, j) = self.parameters[p] else { return Vec::new() };
        let of = |row: usize, other: usize| (row, self.speed(other).times(self.waves[w].expr.clone()));
        if i == j { vec![of(i, i)] } else { vec![of(i, j), of(j, i)] }
    }

    /// What changes the momenta, ∂L/∂q + f, of parameter p with coefficient 1: (joint, expression, factor).
    pub(crate) fn forces(&self, p: usize) -> Vec<(usize, Expr, f64)> {
        let one = |row: usize, expr: Expr, factor: f64| vec![(row, expr, factor)];
        match self.parameters[p] {
            Parameter::Inertia(w, i, j) => {
                let half = if i == j { 0.5 } else { 1.0 };
                let along = |(row, wave, k): (usize, usize, f64)| {
                    (row, self.product(i, j).times(self.waves[wave].expr.clone()), half * k)
                };
                self.slopes(w).into_iter().map(along).collect()
            }
            Parameter::Potential(w) => {
                self.slopes(w).into_iter().map(|(row, wave, k)| (row, self.waves[wave].expr.clone(), -k)).collect()
            }
            Parameter::Force(i) => one(i, Expr::Constant(1.0), 1.0),
            Parameter::Spring(i) => one(i, Expr::Variable(self.joints[i].0), -1.0),
            Parameter::Damping(i) => one(i, self.speed(i), -1.0),
            Parameter::Between(i, j) => {
                vec![
                    (i, self.speed(i), -1.0),
                    (i, self.speed(j), 1.0),
                    (j, self.speed(j), -1.0),
                    (j, self.speed(i), 1.0),
                ]
            }
            Parameter::Drag(i) => one(i, self.speed(i).times(Expr::Call(Function::Abs, Box::new(self.speed(i)))), -1.0),
            Parameter::Friction(i) => one(i, Expr::Call(Function::Sign, Box::new(self.speed(i))), -1.0),
            Parameter::Input(k, i) => one(i, Expr::Variable(2 * self.joints.len() + k), 1.0),
        }
    }

    /// The equations of all joints with coefficients `of` (parameter, value), each solved for the constant part of its own inertia: q̈ᵢ = Σ coefficient · term.
    /// `None` if a joint has no inertia.
    pub(crate) fn equations(&self, of: &[(usize, f64)]) -> Option<Vec<Vec<(Key, f64)>>> {
        let mut rows: Vec<Summands> = vec![Summands::default(); self.joints.len()];
        for &(p, value) in of {
            if let Parameter::Inertia(w, i, j) = self.parameters[p] {
                let mut momentum = |row: usize, other: usize| {
                    let wave = &self.waves[w].expr;
                    rows[row].add((wave.clone(), Some(self.joints[other].1)), value);
                    for (m, wave, k) in self.slopes(w) {
                        rows[row].add((self.product(m, other).times(self.waves[wave].expr.clone()), None), value * k);
                    }
                };
                momentum(i, j);
                if i != j {
                    momentum(j, i);
                }
            }
            for (row, expr, factor) in self.forces(p) {
                rows[row].add((expr, None), -value * factor);
            }
        }
        rows.into_iter().zip(&self.joints).map(|(row, (_, speed))| row.solved_for(*speed)).collect()
    }

    /// ∂w/∂qₘ of every joint m for which it is not zero, as (m, wave, factor).
    fn slopes(&self, w: usize) -> Vec<(usize, usize, f64)> {
        let Wave { multiples, is_sine, .. } = &self.waves[w];
        let is_slope = |other: &Wave| other.multiples == *multiples && other.is_sine != *is_sine;
        let Some(slope) = self.waves.iter().position(is_slope) else { return Vec::new() };
        let sign = if *is_sine { 1.0 } else { -1.0 };
        let along = |(m, k): (usize, &i32)| (*k != 0).then(|| (m, slope, sign * f64::from(*k)));
        multiples.iter().enumerate().filter_map(along).collect()
    }

    fn speed(&self, i: usize) -> Expr {
        Expr::Variable(self.joints[i].1)
    }

    /// q̇ᵢ q̇ⱼ, the smaller number of a state first.
    fn product(&self, i: usize, j: usize) -> Expr {
        let (a, b) = (self.joints[i].1.min(self.joints[j].1), self.joints[i].1.max(self.joints[j].1));
        if a == b { Expr::Variable(a).to_power(2) } else { Expr::Variable(a).times(Expr::Variable(b)) }
    }
}

/// Part of what was added up below which a sum is zero.
const NOTHING: f64 = 1e-9;

/// Summands of the equation of a joint, those of one term added up: their sum and the sum of their magnitudes.
#[derive(Debug, Clone, Default)]
struct Summands(BTreeMap<String, (Key, f64, f64)>);

impl Summands {
    fn add(&mut self, key: Key, value: f64) {
        let name = format!("{key:?}");
        let entry = self.0.entry(name).or_insert((key, 0.0, 0.0));
        entry.1 += value;
        entry.2 += value.abs();
    }

    /// 0 = Σ as v̇ = Σ for the state `speed`.
    fn solved_for(self, speed: usize) -> Option<Vec<(Key, f64)>> {
        let own = |key: &Key| key.1 == Some(speed) && key.0.is_one();
        let inertia = self.0.values().find(|(key, ..)| own(key))?.1;
        if inertia == 0.0 {
            return None;
        }
        let left = self.0.into_values().filter(|(key, sum, size)| !own(key) && sum.abs() > NOTHING * size);
        Some(left.map(|(key, sum, _)| (key, -sum / inertia)).collect())
    }
}
