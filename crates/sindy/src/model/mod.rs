//! The learned equations of motion: immutable, compiled, without any data.

mod actuators;
mod analysis;
mod document;
mod equations;
mod frame;
mod friction;
mod inputs;
mod inverse;
mod linearize;
mod parts;
mod right_side;
mod rubbed;
mod slopes;
mod start;
mod step;

pub use analysis::AnalysisError;
pub use document::ModelError;
pub(crate) use document::as_text;
pub use frame::Reading;
pub use friction::Joint;
pub use inputs::Inputs;
pub use parts::{Entry, Form, ModelParts};

use sindyna_core::Scheme;

use friction::Friction;
use right_side::RightSide;
use slopes::Shared;

use crate::expr::{Expr, Tape};

/// Identified equations of motion.
///
/// Implements [`Dynamics`](sindyna_core::Dynamics) over the task's state, whatever space the equations live in.
/// Its JSON form ([`Model::to_json`]) holds every digit.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    parts: ModelParts,
    terms: Vec<Expr>,
    tape: Tape,
    right: RightSide,
    /// Dry friction, if there is any and time is continuous.
    friction: Option<Friction>,
    /// The right-hand side without it.
    smooth: RightSide,
    /// Of a semi-implicit model the states whose rate is a state too, each after that state: the order of a step.
    positions: Vec<usize>,
    slopes: Shared,
}

impl Model {
    /// What the left-hand side of the equations is.
    #[must_use]
    pub fn form(&self) -> Form {
        self.parts.form
    }

    /// What it is made of.
    pub(crate) fn parts(&self) -> &ModelParts {
        &self.parts
    }

    /// Control interval \[s\].
    #[must_use]
    pub fn dt(&self) -> f64 {
        self.parts.dt
    }

    /// Names of the model's states.
    #[must_use]
    pub fn states(&self) -> &[String] {
        &self.parts.states
    }

    /// Names of the controls.
    #[must_use]
    pub fn controls(&self) -> &[String] {
        &self.parts.controls
    }

    /// Active terms, as functions of z = (state; control).
    #[must_use]
    pub fn terms(&self) -> &[Expr] {
        &self.terms
    }

    /// The summands of equation `i`; their terms are numbered as in [`Self::terms`].
    ///
    /// # Panics
    /// If there is no equation `i`.
    #[must_use]
    pub fn coefficients(&self, i: usize) -> &[Entry] {
        &self.parts.equations[i]
    }

    /// Per state: whether its equation says only that another state is its rate.
    #[must_use]
    pub fn kinematic(&self) -> &[bool] {
        &self.parts.kinematic
    }

    /// Of a semi-implicit model the states whose rate is a state too, each after that state: of a chain x, v, a with ẋ = v, v̇ = a first v, then x.
    #[must_use]
    pub fn positions(&self) -> &[usize] {
        &self.positions
    }

    /// How the model's states follow from the task's; `None` if they are the same.
    #[must_use]
    pub fn readings(&self) -> Option<&[Reading]> {
        self.parts.readings.as_deref()
    }

    /// Per state: what is added to it before the terms are computed.
    #[must_use]
    pub fn offsets(&self) -> &[f64] {
        &self.parts.offsets
    }

    /// [`Self::terms`] with the offsets written into them.
    #[must_use]
    pub fn shifted_terms(&self) -> Vec<Expr> {
        self.terms.iter().map(|term| term.shifted(&self.parts.offsets)).collect()
    }

    /// The offsets that are not zero, then the coefficients of the equations that are not kinematic, one equation after the other.
    pub(crate) fn fitted(&self) -> Vec<f64> {
        let offsets = self.parts.offsets.iter().copied().filter(|v| *v != 0.0);
        offsets.chain(self.fitted_rows().flatten().map(|e| e.coefficient)).collect()
    }

    fn fitted_rows(&self) -> impl Iterator<Item = &Vec<Entry>> {
        let rows = self.parts.equations.iter().zip(&self.parts.kinematic);
        rows.filter(|(_, kinematic)| !**kinematic).map(|(row, _)| row)
    }

    /// The same model with other coefficients, in the order of [`Self::fitted`].
    pub(crate) fn with_fitted(&self, xi: &[f64]) -> Self {
        let mut model = self.clone();
        let mut xi = xi.iter();
        for (offset, value) in model.parts.offsets.iter_mut().filter(|v| **v != 0.0).zip(&mut xi) {
            *offset = *value;
        }
        let rows = model.parts.equations.iter_mut().zip(&self.parts.kinematic);
        let entries = rows.filter(|(_, kinematic)| !**kinematic).flat_map(|(row, _)| row.iter_mut());
        for (entry, value) in entries.zip(xi) {
            entry.coefficient = *value;
        }
        model.right = RightSide::new(&model.parts.equations, self.tape.outputs());
        let smooth = |friction: &Friction| {
            let equations = Friction::without(&model.parts.equations, &self.terms);
            (
                friction.with_coefficients(&model.parts.equations, &self.terms),
                RightSide::new(&equations, self.tape.outputs()),
            )
        };
        (model.friction, model.smooth) = match self.friction.as_ref().map(smooth) {
            Some((friction, smooth)) => (Some(friction), smooth),
            None => (None, model.right.clone()),
        };
        model
    }

    /// The same model with the coefficients `values`: those of the equations that are not kinematic, one equation after the other, in the order of
    /// [`Self::coefficients`]. `None` if there are not as many.
    #[must_use]
    pub fn with_coefficients(&self, values: &[f64]) -> Option<Self> {
        let mut xi: Vec<f64> = self.parts.offsets.iter().copied().filter(|v| *v != 0.0).collect();
        xi.extend(values);
        (xi.len() == self.fitted().len()).then(|| self.with_fitted(&xi))
    }

    /// The same equations stepped in another way.
    pub(crate) fn with_form(&self, form: Form) -> Self {
        Self { parts: ModelParts { form, ..self.parts.clone() }, ..self.clone() }
    }

    /// The same equations over control intervals of `dt` \[s\], in steps about as long as before; `None` where only what one interval leads to is known.
    #[must_use]
    pub fn over_intervals(&self, dt: f64) -> Option<Self> {
        let times = dt / self.parts.dt;
        let parts = |substeps: usize| (times * substeps.max(1) as f64).round().max(1.0) as usize;
        let form = match self.parts.form {
            form if (times - 1.0).abs() < 1e-6 => form,
            Form::Continuous(Scheme::Rk4 { substeps }) => Form::Continuous(Scheme::Rk4 { substeps: parts(substeps) }),
            Form::SemiImplicit { substeps } => Form::SemiImplicit { substeps: parts(substeps) },
            Form::Increment | Form::Discrete | Form::Continuous(_) => return None,
        };
        Some(Self { parts: ModelParts { form, dt, ..self.parts.clone() }, ..self.clone() })
    }

    /// The same model with other offsets of its states (n).
    pub(crate) fn with_offsets(mut self, offsets: &[f64]) -> Self {
        self.parts.offsets.copy_from_slice(offsets);
        self
    }

    /// States times candidate terms: the paper's P.
    #[must_use]
    pub fn parameters(&self) -> usize {
        self.parts.states.len() * self.parts.n_features
    }

    /// Fitted coefficients and offsets that are not zero; rows of states whose rate is a state too are not counted.
    #[must_use]
    pub fn nonzero(&self) -> usize {
        self.fitted().len()
    }

    /// Coefficients that are not zero in the paper's counting, its P′: those of x⁺ = Θ Ξᵀ (of ẋ for continuous schemes),
    /// kinematic rows included.
    #[must_use]
    pub fn nonzero_paper(&self) -> usize {
        let written: usize = self.parts.equations.iter().map(Vec::len).sum();
        if matches!(self.parts.form, Form::Discrete) {
            return written;
        }
        // x⁺ = x + Δt Θ Ξᵀ: the state itself is one more term, unless its row has it already.
        let has_own = |i: &usize| self.parts.equations[*i].iter().any(|e| self.terms[e.term] == Expr::Variable(*i));
        written + (0..self.parts.states.len()).filter(|i| !has_own(i)).count()
    }
}
