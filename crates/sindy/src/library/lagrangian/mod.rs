//! The Lagrangian of a mechanical system, linear in unknown parameters.

use std::collections::BTreeMap;

use sindyna_core::number::significant;

use super::{Input, Role};
use crate::expr::{Expr, Function};

mod arrangements;
mod wave;

use wave::{Wave, Waves};

/// L = ½ q̇ᵀM(q)q̇ − V(q) with Rayleigh damping and inputs: d/dt ∂L/∂q̇ − ∂L/∂q = f(q, q̇, u), linear in the [`Parameter`]s.
///
/// Entries of M and V are sums of waves: 1, sines and cosines of sums of angles. Velocities are those of links, sums of those of joints. One parameter of M
/// is a term of the equations of several joints at once.
#[derive(Debug, Clone)]
pub(crate) struct Lagrangian {
    /// Position and speed of each joint, as numbers of states.
    pub(crate) joints: Vec<(usize, usize)>,
    n_states: usize,
    /// φ = S q, row by row.
    links: Vec<Vec<i32>>,
    waves: Vec<Wave>,
    pub(crate) parameters: Vec<Parameter>,
}

/// The joints of a system.
#[derive(Debug, Clone)]
pub(crate) struct Joints {
    /// Position and speed of each, as numbers of states.
    pairs: Vec<(usize, usize)>,
    /// What the position of each is declared to be.
    roles: Vec<Role>,
    n_states: usize,
    n_controls: usize,
}

impl Joints {
    /// Of the variables `inputs`, of which `rates` says what is the rate of which; those of the states `still` never move. `None` unless two joints or more move
    /// and all states are positions and speeds of joints.
    pub(crate) fn new(inputs: &[Input], rates: &[Option<usize>], still: &[usize]) -> Option<Self> {
        Self::any(inputs, rates, still).filter(|joints| joints.pairs.len() > 1)
    }

    /// The same of one joint or more.
    pub(crate) fn any(inputs: &[Input], rates: &[Option<usize>], still: &[usize]) -> Option<Self> {
        let all: Vec<(usize, usize)> = rates.iter().enumerate().filter_map(|(q, v)| Some((q, (*v)?))).collect();
        let is_chain = all.iter().any(|(_, v)| rates[*v].is_some());
        let pairs: Vec<(usize, usize)> =
            all.iter().copied().filter(|(q, v)| !(still.contains(q) && still.contains(v))).collect();
        if is_chain || pairs.is_empty() || 2 * all.len() != rates.len() {
            return None;
        }
        let roles = pairs.iter().map(|(q, _)| inputs[*q].role).collect();
        Some(Self { pairs, roles, n_states: rates.len(), n_controls: inputs.len() - rates.len() })
    }

    /// Position and speed of each, as numbers of states.
    pub(crate) fn pairs(&self) -> impl Iterator<Item = (usize, usize)> {
        self.pairs.iter().copied()
    }

    /// The speed of each, as numbers of states.
    pub(crate) fn speeds(&self) -> Vec<usize> {
        self.pairs.iter().map(|(_, v)| *v).collect()
    }

    /// Whether joint `i` is declared to turn.
    fn turns(&self, i: usize) -> bool {
        matches!(self.roles[i], Role::Angle | Role::Turning)
    }

    /// The joints that are declared to turn.
    pub(crate) fn angles(&self) -> Vec<usize> {
        (0..self.pairs.len()).filter(|&i| self.turns(i)).collect()
    }

    /// Springs, friction, constant forces and inputs.
    fn forces(&self) -> Vec<Parameter> {
        let n = self.pairs.len();
        let mut parameters = Vec::new();
        for i in 0..n {
            parameters.extend([Parameter::Force(i), Parameter::Damping(i), Parameter::Drag(i), Parameter::Friction(i)]);
            if self.roles[i] != Role::Turning {
                parameters.push(Parameter::Spring(i));
            }
            parameters.extend((i + 1..n).map(|j| Parameter::Between(i, j)));
            parameters.extend((0..self.n_controls).map(|k| Parameter::Input(k, i)));
        }
        parameters
    }
}

/// One unknown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Parameter {
    /// Of wave w in M, row i and column j: w φ̇ᵢ φ̇ⱼ in the kinetic energy (half of it if i = j).
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
    /// Dry friction of a joint i that slides more slowly than about a speed w: −e^(−(q̇ᵢ/w)²) sign q̇ᵢ (Stribeck).
    SlowFriction(usize, f64),
    /// Input k on joint i.
    Input(usize, usize),
}

/// What a term of an equation multiplies: an acceleration, by its state, or nothing.
pub(crate) type Key = (Expr, Option<usize>);

impl Lagrangian {
    /// With waves of so many of the angles, of twice an angle, of sums and differences of two in every entry, for all choices of these angles: what turns about the vertical changes nothing by its own angle.
    pub(crate) fn of_some_angles(joints: &Joints, count: usize) -> Vec<Self> {
        let all = joints.angles();
        let chosen = |mask: &u32| (0..all.len()).filter(|i| mask >> i & 1 == 1).map(|i| all[i]).collect::<Vec<_>>();
        let masks = (0..1_u32 << all.len().min(16)).filter(|mask| mask.count_ones() as usize == count);
        masks.map(|mask| Self::of_angles(joints, &chosen(&mask))).collect()
    }

    fn of_angles(joints: &Joints, angles: &[usize]) -> Self {
        let n = joints.pairs.len();
        let combined = |of: &[(usize, i32)]| {
            let mut multiples = vec![0; n];
            of.iter().for_each(|(i, k)| multiples[*i] = *k);
            multiples
        };
        let mut waves = Waves::new(joints.pairs.iter().map(|(q, _)| *q).collect());
        for &i in angles {
            waves.of(&combined(&[(i, 1)]));
            waves.of(&combined(&[(i, 2)]));
        }
        for (at, &i) in angles.iter().enumerate() {
            for &j in &angles[at + 1..] {
                waves.of(&combined(&[(i, 1), (j, 1)]));
                waves.of(&combined(&[(i, 1), (j, -1)]));
            }
        }
        let mut parameters = Vec::new();
        for i in 0..n {
            for j in i..n {
                parameters.extend((0..waves.all.len()).map(|w| Parameter::Inertia(w, i, j)));
            }
        }
        parameters.extend((1..waves.all.len()).map(Parameter::Potential));
        parameters.extend(joints.forces());
        let links = (0..n).map(|i| combined(&[(i, 1)])).collect();
        Self::with(joints, links, waves, parameters)
    }

    fn with(joints: &Joints, links: Vec<Vec<i32>>, waves: Waves, parameters: Vec<Parameter>) -> Self {
        Self { joints: joints.pairs.clone(), n_states: joints.n_states, links, waves: waves.all, parameters }
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

    /// How far-fetched parameter p is: the complexity of what it multiplies.
    pub(crate) fn complexity(&self, p: usize) -> f64 {
        let of = |(_, (expr, _), _): &(usize, Key, f64)| super::complexity(expr, &[]);
        f64::from(self.summands(p).iter().map(of).min().unwrap_or(0))
    }

    /// Whether parameter p takes energy out of the system, which a negative one would bring in.
    pub(crate) fn dissipates(&self, p: usize) -> bool {
        use Parameter::{Between, Damping, Drag, Friction, SlowFriction};
        matches!(self.parameters[p], Damping(_) | Between(..) | Drag(_) | Friction(_) | SlowFriction(..))
    }

    /// The symmetric K of Σ Kₐᵦ q̇ₐ q̇ᵦ/2 that φ̇ᵢ φ̇ⱼ is (half of it if i = j): the entries that are not zero.
    fn metric(&self, i: usize, j: usize) -> Vec<(usize, usize, f64)> {
        let n = self.joints.len();
        let (one, other) = (&self.links[i], &self.links[j]);
        let entry = |(a, b): (usize, usize)| {
            let k = if i == j { one[a] * one[b] } else { one[a] * other[b] + one[b] * other[a] };
            (k != 0).then(|| (a, b, f64::from(k)))
        };
        (0..n).flat_map(|a| (0..n).map(move |b| (a, b))).filter_map(entry).collect()
    }

    /// Whether every wave comes as sine and cosine together, as where the zero of an angle is off.
    pub(crate) fn is_tilted(&self, of: &[(usize, f64)]) -> bool {
        let wave = |p: usize| match self.parameters[p] {
            Parameter::Inertia(w, i, j) if w > 0 => Some((Some((i, j)), &self.waves[w])),
            Parameter::Potential(w) => Some((None, &self.waves[w])),
            _ => None,
        };
        let used: Vec<_> = of.iter().filter_map(|(p, _)| wave(*p)).collect();
        let is_paired = |(place, one): &(Option<(usize, usize)>, &Wave)| {
            let is_other = |other: &Wave| other.multiples == one.multiples && other.is_sine != one.is_sine;
            used.iter().any(|(at, other)| at == place && is_other(other))
        };
        !used.is_empty() && used.iter().all(is_paired)
    }

    /// The momenta ∂L/∂q̇ of parameter p with coefficient 1: (joint, expression, factor).
    pub(crate) fn momenta(&self, p: usize) -> Vec<(usize, Expr, f64)> {
        let Parameter::Inertia(w, i, j) = self.parameters[p] else { return Vec::new() };
        let of = |(row, other, k)| (row, self.speed(other).times(self.waves[w].expr.clone()), k);
        self.metric(i, j).into_iter().map(of).collect()
    }

    /// What changes the momenta, ∂L/∂q + f, of parameter p with coefficient 1: (joint, expression, factor).
    pub(crate) fn forces(&self, p: usize) -> Vec<(usize, Expr, f64)> {
        let one = |row: usize, expr: Expr, factor: f64| vec![(row, expr, factor)];
        match self.parameters[p] {
            Parameter::Inertia(w, i, j) => {
                let metric = self.metric(i, j);
                let along = |(row, wave, slope): (usize, usize, f64)| {
                    let product = |(a, b, k): &(usize, usize, f64)| {
                        let expr = self.product(*a, *b).times(self.waves[wave].expr.clone());
                        (row, expr, 0.5 * k * slope)
                    };
                    metric.iter().map(product).collect::<Vec<_>>()
                };
                self.slopes(w).into_iter().flat_map(along).collect()
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
            Parameter::SlowFriction(i, w) => {
                let part = Expr::Div(Box::new(self.speed(i)), Box::new(Expr::Constant(w)));
                let bell = Expr::Call(Function::Exp, Box::new(Expr::Neg(Box::new(part.to_power(2)))));
                one(i, Expr::Call(Function::Sign, Box::new(self.speed(i))).times(bell), -1.0)
            }
            Parameter::Input(k, i) => one(i, Expr::Variable(self.n_states + k), 1.0),
        }
    }

    /// The same with friction that grows at low speeds: each joint's below the `parts` of its speed (RMS).
    pub(crate) fn slow_friction(mut self, speeds: &[f64], parts: &[f64]) -> Self {
        for (i, speed) in speeds.iter().enumerate().filter(|(_, speed)| **speed > 0.0) {
            // Digits that say more than is known are not printed.
            let rounded = |part: &f64| significant(part * speed, 2).parse().unwrap_or(part * speed);
            self.parameters.extend(parts.iter().map(|part| Parameter::SlowFriction(i, rounded(part))));
        }
        self
    }

    /// d/dt ∂L/∂q̇ − ∂L/∂q − f of parameter p with coefficient 1: (joint, term, factor).
    pub(crate) fn summands(&self, p: usize) -> Vec<(usize, Key, f64)> {
        let mut all = Vec::new();
        if let Parameter::Inertia(w, i, j) = self.parameters[p] {
            for (row, other, k) in self.metric(i, j) {
                all.push((row, (self.waves[w].expr.clone(), Some(self.joints[other].1)), k));
                for (m, wave, slope) in self.slopes(w) {
                    let expr = self.product(m, other).times(self.waves[wave].expr.clone());
                    all.push((row, (expr, None), k * slope));
                }
            }
        }
        all.extend(self.forces(p).into_iter().map(|(row, expr, factor)| (row, (expr, None), -factor)));
        all
    }

    /// The equations of all joints with coefficients `of` (parameter, value), each solved for the constant part of its own inertia: q̈ᵢ = Σ coefficient · term.
    /// `None` if a joint has no inertia.
    pub(crate) fn equations(&self, of: &[(usize, f64)]) -> Option<Vec<Vec<(Key, f64)>>> {
        let mut rows: Vec<Summands> = vec![Summands::default(); self.joints.len()];
        for &(p, value) in of {
            for (row, key, factor) in self.summands(p) {
                rows[row].add(key, value * factor);
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
