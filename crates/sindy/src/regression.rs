//! From rows to a triangle, and from fits to a model.

use ndarray::{Array2, ArrayView2};
use serde::{Deserialize, Serialize};

use crate::expr::Tape;
use crate::library::Term;
use crate::model::{Entry, Form, Model, ModelError, ModelParts, Reading};
use crate::names::symbols;
use crate::solve::Selected;
use crate::{Triangle, TriangleError};

/// A term or target that is not finite on some row.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{what} is {value} in row {row}")]
pub(crate) struct NotFinite {
    what: String,
    value: f64,
    row: usize,
}

/// Rows evaluated at once.
const BLOCK: usize = 512;

/// The triangle of [Θ(z) | targets]; z is (N, n + k), targets (N, any number).
pub(crate) fn design(
    terms: &[Term],
    z: ArrayView2<'_, f64>,
    targets: ArrayView2<'_, f64>,
) -> Result<Triangle, NotFinite> {
    let tape = Tape::new(z.ncols(), terms.iter().map(|t| &t.expr));
    let mut registers = vec![0.0; tape.n_registers()];
    let width = terms.len() + targets.ncols();
    let mut triangle = Triangle::new(width);
    for first in (0..z.nrows()).step_by(BLOCK) {
        let mut block = Array2::zeros((BLOCK.min(z.nrows() - first), width));
        for (i, mut row) in block.rows_mut().into_iter().enumerate() {
            for (register, value) in registers.iter_mut().zip(z.row(first + i)) {
                *register = *value;
            }
            tape.run(&mut registers);
            for (slot, &register) in row.iter_mut().zip(tape.outputs()) {
                *slot = registers[register as usize];
            }
            for (slot, target) in row.iter_mut().skip(terms.len()).zip(targets.row(first + i)) {
                *slot = *target;
            }
        }
        triangle.push(block.view()).map_err(|e| match e {
            TriangleError::NotFinite { row, column, value } => {
                let what =
                    terms.get(column).map_or_else(|| "a target".to_owned(), |t| format!("the term `{}`", t.name));
                NotFinite { what, value, row: first + row }
            }
            TriangleError::Width { .. } => unreachable!("the block was made for the triangle"),
        })?;
    }
    Ok(triangle)
}

/// The space a model lives in.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Space {
    pub(crate) states: Vec<String>,
    pub(crate) controls: Vec<String>,
    pub(crate) readings: Option<Vec<Reading>>,
    pub(crate) kinematic: Vec<bool>,
}

/// Terms of one equation and their coefficients.
pub(crate) type Summands<'a> = (&'a [usize], &'a [f64]);

/// The model of `fits`, one per state, over the terms in use.
pub(crate) fn model(space: Space, terms: &[Term], fits: &[Selected], form: Form, dt: f64) -> Result<Model, ModelError> {
    let equations: Vec<Summands<'_>> = fits.iter().map(|f| (&f.support[..], &f.coefficients[..])).collect();
    of_equations(space, terms, &equations, form, dt)
}

/// The model of `equations`, one per state, over the terms in use.
pub(crate) fn of_equations(
    space: Space,
    terms: &[Term],
    equations: &[Summands<'_>],
    form: Form,
    dt: f64,
) -> Result<Model, ModelError> {
    let mut active: Vec<usize> = equations.iter().flat_map(|(support, _)| support.iter().copied()).collect();
    active.sort_unstable();
    active.dedup();
    let names: Vec<String> = space.states.iter().chain(&space.controls).cloned().collect();
    let symbols = symbols(&names);
    let place = |j: &usize| active.partition_point(|a| a < j);
    let entry = |(j, c): (&usize, &f64)| Entry { term: place(j), coefficient: *c, rate: terms[*j].rate };
    let equation = |(support, xi): &Summands<'_>| support.iter().zip(*xi).map(entry).collect::<Vec<_>>();
    Model::new(ModelParts {
        form,
        dt,
        terms: active.iter().map(|&j| terms[j].expr.display(&symbols).to_string()).collect(),
        equations: equations.iter().map(equation).collect(),
        n_features: terms.len(),
        states: space.states,
        controls: space.controls,
        readings: space.readings,
        offsets: vec![0.0; space.kinematic.len()],
        kinematic: space.kinematic,
    })
}
