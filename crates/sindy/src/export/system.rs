//! What an exporter has to know of a model. The only place of the exporters that looks into one.

use sindyna_core::Scheme;

use crate::expr::Expr;
use crate::model::Joint;
use crate::{Entry, Form, Model, ModelError};

/// How one control interval is made of the equations.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Stepping {
    /// The equations give the next state.
    Map,
    /// The equations give Δx/Δt.
    Increment,
    /// The equations give ẋ, followed for one interval.
    Euler,
    /// The equations give ẋ; what is no position moves first, then each position by what its rate has become.
    SemiImplicitEuler {
        /// The positions, each after the state that is its rate.
        positions: Vec<usize>,
        /// Equal parts of the interval.
        substeps: usize,
    },
    /// The equations give ẋ, stepped by the classical Runge–Kutta scheme.
    Rk4 {
        /// Equal parts of the interval.
        substeps: usize,
    },
    /// The same with dry friction that holds.
    Friction(Box<Friction>),
}

/// Dry friction: the signs beside it are held in a step of classical Runge–Kutta, and where a speed turns or rests, parts of them, −1 to 1, are looked for that
/// stop it (projected Gauss–Seidel over at most [`Self::SWEEPS`] sweeps).
#[derive(Debug, Clone, PartialEq)]
pub struct Friction {
    /// Equal parts of the interval.
    pub substeps: usize,
    /// The states with dry friction.
    pub joints: Vec<Joint>,
    /// The same equations with the signs beside friction as further controls, one for each joint after those of the system.
    pub held: System,
}

impl Friction {
    /// Sweeps over the joints, at most.
    pub const SWEEPS: usize = 50;
    /// Change of the part of friction that acts below which all parts are settled.
    pub const SETTLED: f64 = 1e-13;

    /// Each position that moves with a joint, after the joint's number.
    pub fn positions(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.joints.iter().enumerate().flat_map(|(j, joint)| joint.positions.iter().map(move |p| (j, *p)))
    }

    /// The states that are speeds.
    pub fn speeds(&self) -> impl Iterator<Item = usize> + '_ {
        self.joints.iter().map(|joint| joint.speed)
    }
}

/// Equations of motion, ready to be written in another language.
#[derive(Debug, Clone, PartialEq)]
pub struct System {
    /// Names of the states (n).
    pub states: Vec<String>,
    /// Names of the controls (k).
    pub controls: Vec<String>,
    /// Control interval \[s\].
    pub dt: f64,
    /// Terms, as functions of z = (state; control).
    pub terms: Vec<Expr>,
    /// One sum per state.
    pub equations: Vec<Vec<Entry>>,
    /// What the sums are, and how a step is made of them.
    pub stepping: Stepping,
    /// The equations as people read them, one per state.
    pub text: Vec<String>,
}

impl System {
    /// Whether an equation holds rates of other states.
    #[must_use]
    pub fn is_implicit(&self) -> bool {
        self.equations.iter().flatten().any(|entry| entry.rate.is_some())
    }

    /// Refuses lists that do not fit each other.
    pub(super) fn check(&self) -> Result<(), ModelError> {
        let n = self.states.len();
        let shape = |what, got| if got == n { Ok(()) } else { Err(ModelError::Shape { what, expected: n, got }) };
        shape("equations", self.equations.len())?;
        shape("equations as text", self.text.len())?;
        let below =
            |what, index, count| if index < count { Ok(()) } else { Err(ModelError::NoSuch { what, index, count }) };
        if let Stepping::SemiImplicitEuler { positions, .. } = &self.stepping {
            positions.iter().try_for_each(|&i| below("position", i, n))?;
        }
        if let Stepping::Friction(friction) = &self.stepping {
            friction.speeds().try_for_each(|i| below("speed", i, n))?;
            friction.positions().try_for_each(|(_, i)| below("position", i, n))?;
            shape("states beside friction", friction.held.states.len())?;
            let (expected, got) = (self.controls.len() + friction.joints.len(), friction.held.controls.len());
            if got != expected {
                return Err(ModelError::Shape { what: "controls and signs", expected, got });
            }
            friction.held.check()?;
        }
        for entry in self.equations.iter().flatten() {
            below("term", entry.term, self.terms.len())?;
            below("rate of state", entry.rate.unwrap_or(0), n)?;
            if !entry.coefficient.is_finite() {
                return Err(ModelError::BadNumber { what: "a coefficient", value: entry.coefficient });
            }
        }
        let variables = n + self.controls.len();
        self.terms.iter().filter_map(Expr::max_variable).try_for_each(|v| below("variable", v, variables))
    }
}

/// The equations in the model's own space.
impl From<&Model> for System {
    fn from(model: &Model) -> Self {
        let system = Self {
            states: model.states().to_vec(),
            controls: model.controls().to_vec(),
            dt: model.dt(),
            terms: model.shifted_terms(),
            equations: (0..model.states().len()).map(|i| model.coefficients(i).to_vec()).collect(),
            stepping: match model.form() {
                Form::Discrete => Stepping::Map,
                Form::Increment => Stepping::Increment,
                Form::SemiImplicit { substeps } => {
                    Stepping::SemiImplicitEuler { positions: model.positions().to_vec(), substeps: substeps.max(1) }
                }
                Form::Continuous(Scheme::Euler) => Stepping::Euler,
                Form::Continuous(Scheme::Rk4 { substeps }) => Stepping::Rk4 { substeps },
            },
            text: model.equations(),
        };
        match (model.with_signs(), &system.stepping) {
            (Some((joints, terms, equations)), Stepping::Rk4 { substeps }) => {
                let signs = joints.iter().map(|joint| format!("sign of {}", system.states[joint.speed]));
                let controls = system.controls.iter().cloned().chain(signs).collect();
                let held = Self { controls, terms, equations, ..system.clone() };
                Self {
                    stepping: Stepping::Friction(Box::new(Friction { substeps: *substeps, joints, held })),
                    ..system
                }
            }
            _ => system,
        }
    }
}
