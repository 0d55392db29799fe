//! From rows to a triangle, and from fits to a model.

use ndarray::{ArrayView2, ShapeBuilder as _, s};
use serde::{Deserialize, Serialize};

use crate::expr::Tape;
use crate::library::Term;
use crate::model::{Entry, Form, Model, ModelError, ModelParts, Reading};
use crate::names::symbols;
use crate::solve::{Reflected, Selected};
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

/// Rows whose terms are computed side by side: of any number of terms, and of a few.
const LANES: usize = 8;
const NARROW_LANES: usize = 32;

/// Columns up to which reflections one by one are the faster way to a triangle (docs/notes/2026-11-26-speed-of-a-fit.md).
const NARROW: usize = 40;

/// Rows that reflections take at once: these columns fit the nearest cache.
const NARROW_BLOCK: usize = 256;

/// The triangle of [Θ(z) | targets]; z is (N, n + k), targets (N, any number).
pub(crate) fn design(
    terms: &[Term],
    z: ArrayView2<'_, f64>,
    targets: ArrayView2<'_, f64>,
) -> Result<Triangle, NotFinite> {
    let width = terms.len() + targets.ncols();
    let mut triangle = Triangle::new(width);
    let mut found = Ok(());
    in_blocks::<LANES>(terms, z, targets, BLOCK, |first, numbers| {
        let rows = numbers.len() / width;
        let block = ArrayView2::from_shape((rows, width).f(), &*numbers).expect("there are as many numbers");
        found = triangle.push(block).map_err(|e| match e {
            TriangleError::NotFinite { row, column, value } => {
                let what =
                    terms.get(column).map_or_else(|| "a target".to_owned(), |t| format!("the term `{}`", t.name));
                NotFinite { what, value, row: first + row }
            }
            TriangleError::Width { .. } => unreachable!("the block was made for the triangle"),
        });
        found.is_ok()
    });
    found.map(|()| triangle)
}

/// The same to rounding, sooner where columns are few.
pub(crate) fn narrow_design(
    terms: &[Term],
    z: ArrayView2<'_, f64>,
    targets: ArrayView2<'_, f64>,
) -> Result<Triangle, NotFinite> {
    let width = terms.len() + targets.ncols();
    if width > NARROW || z.nrows() < width {
        return design(terms, z, targets);
    }
    let mut factor = Reflected::new(width, 0, 0.0);
    in_blocks::<NARROW_LANES>(terms, z, targets, NARROW_BLOCK, |_, numbers| {
        factor.absorb(numbers);
        true
    });
    // The other way says which number it is that is not finite.
    Triangle::of_factor(&factor, z.nrows()).map_or_else(|| design(terms, z, targets), Ok)
}

/// Hands on rows of [Θ(z) | targets], `size` at a time, column after column, with the number of the first, as long as `go_on` says so.
fn in_blocks<const L: usize>(
    terms: &[Term],
    z: ArrayView2<'_, f64>,
    targets: ArrayView2<'_, f64>,
    size: usize,
    mut go_on: impl FnMut(usize, &mut [f64]) -> bool,
) {
    let tape = Tape::new(z.ncols(), terms.iter().map(|t| &t.expr));
    let mut registers = vec![[0.0; L]; tape.n_registers()];
    let m = z.ncols();
    let z = z.as_standard_layout();
    let values = z.as_slice().expect("standard layout was made");
    let width = terms.len() + targets.ncols();
    let mut numbers = vec![0.0; size.min(z.nrows()) * width];
    for first in (0..z.nrows()).step_by(size) {
        let rows = size.min(z.nrows() - first);
        let numbers = &mut numbers[..rows * width];
        for start in (0..rows).step_by(L) {
            let count = L.min(rows - start);
            let values = &values[(first + start) * m..][..count * m];
            for (j, register) in registers.iter_mut().take(m).enumerate() {
                for l in 0..count {
                    register[l] = values[l * m + j];
                }
            }
            tape.run_first(&mut registers, tape.n_ops());
            for (column, &register) in numbers.chunks_exact_mut(rows).zip(tape.outputs()) {
                column[start..start + count].copy_from_slice(&registers[register as usize][..count]);
            }
        }
        let known = targets.slice(s![first..first + rows, ..]);
        for (column, target) in numbers.chunks_exact_mut(rows).skip(terms.len()).zip(known.columns()) {
            column.iter_mut().zip(target).for_each(|(slot, v)| *slot = *v);
        }
        if !go_on(first, numbers) {
            break;
        }
    }
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
