//! Identification from plain arrays, with no task around: PySINDy's `SINDy` and `DiscreteSINDy`.

use ndarray::{Array2, ArrayView2, Axis, CowArray, Ix2, concatenate, s};

use crate::differentiate::{Differentiator, TooShort};
use crate::identify::{SolverChoice, Target};
use crate::library::LibraryError;
use crate::library::Term;
use crate::model::{Form, Model, ModelError};
use crate::names::symbols;
use crate::regression::{Space, model, narrow_design};
use crate::solve::{Selected, Selection, SparseFit};
use crate::triangle::all_finite;
use crate::{Library, Triangle, Watch};

/// One trajectory of uniform samples.
#[derive(Debug, Clone, Copy)]
pub struct Trajectory<'a> {
    /// States (T, n).
    pub x: ArrayView2<'a, f64>,
    /// Controls (T, k); for differences between samples (T − 1, k) will do. `None` for a system without any.
    pub u: Option<ArrayView2<'a, f64>>,
    /// Derivatives (T, n) where they are known, otherwise they are estimated; for maps the next states (T, n), otherwise those of the next samples.
    pub x_dot: Option<ArrayView2<'a, f64>>,
}

impl<'a> Trajectory<'a> {
    /// A trajectory of states alone.
    #[must_use]
    pub fn new(x: ArrayView2<'a, f64>) -> Self {
        Self { x, u: None, x_dot: None }
    }

    /// The same with controls.
    #[must_use]
    pub fn with_controls(self, u: ArrayView2<'a, f64>) -> Self {
        Self { u: Some(u), ..self }
    }

    /// The same with known derivatives.
    #[must_use]
    pub fn with_derivatives(self, x_dot: ArrayView2<'a, f64>) -> Self {
        Self { x_dot: Some(x_dot), ..self }
    }
}

/// Why nothing was identified.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SindyError {
    /// Arrays that do not fit each other.
    #[error("trajectory {trajectory}: {what}: expected {expected}, got {got}")]
    Shape {
        /// Which trajectory.
        trajectory: usize,
        /// What was counted.
        what: &'static str,
        /// Number wanted.
        expected: usize,
        /// Number found.
        got: usize,
    },
    /// A sample that is NaN or infinite.
    #[error("trajectory {trajectory}: {what} is {value} in row {row}, column {column}")]
    NotFinite {
        /// Which trajectory.
        trajectory: usize,
        /// States, controls or derivatives.
        what: &'static str,
        /// Row.
        row: usize,
        /// Column.
        column: usize,
        /// The value found.
        value: f64,
    },
    /// A time step that is no time.
    #[error("the time step must be finite and > 0, got {dt}")]
    TimeStep {
        /// The value it was given.
        dt: f64,
    },
    /// No trajectory, or none with a usable row.
    #[error("there are no samples")]
    Empty,
    /// A trajectory with too few samples.
    #[error("trajectory {trajectory}: {source}")]
    TooShort {
        /// Which trajectory.
        trajectory: usize,
        /// How many are needed.
        source: TooShort,
    },
    /// The library does not fit the variables.
    #[error(transparent)]
    Library(#[from] LibraryError),
    /// A term that is not finite on the data.
    #[error("{reason}")]
    Term {
        /// Which term, and where.
        reason: String,
    },
    /// The solver left the finite numbers.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// It was told to stop.
    #[error("interrupted before the equations were found")]
    Interrupted,
}

/// Part of the largest target that rounding leaves: terms that explain no more are none.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Identification from arrays: a library, a target and a solver.
///
/// # Examples
/// ```
/// use ndarray::Array2;
/// use sindyna_sindy::{Library, Sindy, SolverChoice, Stlsq, Target, Trajectory};
///
/// let x = Array2::from_shape_fn((200, 1), |(i, _)| (-2.0 * 0.01 * i as f64).exp());
/// let sindy = Sindy::new(Library::polynomial(2), "continuous".parse()?, SolverChoice::Stlsq(Stlsq::default()));
/// let fit = sindy.fit(&[Trajectory::new(x.view())], 0.01)?;
/// assert!((fit.coefficients[[0, 1]] + 2.0).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Sindy {
    library: Library,
    target: Target,
    solver: SolverChoice,
}

/// What [`Sindy::fit`] found.
#[derive(Debug, Clone)]
pub struct SindyFit {
    /// Names of the terms, in PySINDy's notation.
    pub names: Vec<String>,
    /// Ξ (n, F).
    pub coefficients: Array2<f64>,
    /// The derivative (or next state, or increment) the terms were fitted to (N, n).
    pub targets: Array2<f64>,
    /// The account of each equation.
    pub equations: Vec<Selected>,
    /// The triangle of [Θ | targets], for more solvers.
    pub triangle: Triangle,
    /// The equations, ready to step.
    pub model: Model,
}

impl Sindy {
    /// Explains `target` by terms of `library` with `solver`. Variables are called x0, x1, …, u0, u1, ….
    #[must_use]
    pub fn new(library: Library, target: Target, solver: SolverChoice) -> Self {
        Self { library, target, solver }
    }

    /// Identifies the equations behind `trajectories` of samples `dt` \[s\] apart. Nothing crosses from one to the next.
    ///
    /// # Errors
    /// [`SindyError`] for arrays that do not fit, numbers that are not finite, or too short trajectories.
    pub fn fit(&self, trajectories: &[Trajectory<'_>], dt: f64) -> Result<SindyFit, SindyError> {
        self.fit_watched(trajectories, dt, &Watch::default())
    }

    /// The same, followed by `watch`, which may end it.
    ///
    /// # Errors
    /// As [`Self::fit`]; [`SindyError::Interrupted`] if `watch` did.
    pub fn fit_watched(
        &self,
        trajectories: &[Trajectory<'_>],
        dt: f64,
        watch: &Watch<'_>,
    ) -> Result<SindyFit, SindyError> {
        let (regressed, targets) = self.regressed(trajectories, dt, watch)?;
        let model = regressed.model()?;
        let coefficients = regressed.coefficients();
        let Regressed { terms, equations, triangle, .. } = regressed;
        let names = terms.into_iter().map(|t| t.name).collect();
        Ok(SindyFit { names, coefficients, targets: targets.into_owned(), equations, triangle, model })
    }

    /// The equations behind `trajectories` alone, without a model that can be stepped: [`Regressed::model`] makes it.
    ///
    /// # Errors
    /// As [`Self::fit_watched`].
    pub fn regress_watched(
        &self,
        trajectories: &[Trajectory<'_>],
        dt: f64,
        watch: &Watch<'_>,
    ) -> Result<Regressed, SindyError> {
        Ok(self.regressed(trajectories, dt, watch)?.0)
    }

    /// The equations and what they were fitted to.
    fn regressed<'a>(
        &self,
        trajectories: &[Trajectory<'a>],
        dt: f64,
        watch: &Watch<'_>,
    ) -> Result<(Regressed, Rows<'a>), SindyError> {
        if !(dt.is_finite() && dt > 0.0) {
            return Err(SindyError::TimeStep { dt });
        }
        let first = trajectories.first().ok_or(SindyError::Empty)?;
        let (n, k) = (first.x.ncols(), first.u.map_or(0, |u| u.ncols()));
        let (mut z, mut targets) = (Vec::new(), Vec::new());
        for (index, trajectory) in trajectories.iter().enumerate() {
            check(index, trajectory, n, k, &self.target)?;
            let (rows, explained) = self.rows(index, trajectory, dt)?;
            z.push(rows);
            targets.push(explained);
        }
        let (z, targets) = (stacked(z), stacked(targets));
        if z.nrows() == 0 {
            return Err(SindyError::Empty);
        }
        let states: Vec<String> = (0..n).map(|i| format!("x{i}")).collect();
        let controls: Vec<String> = (0..k).map(|i| format!("u{i}")).collect();
        let names: Vec<String> = states.iter().chain(&controls).cloned().collect();
        let terms = self.library.terms(&symbols(&names))?;
        let triangle =
            narrow_design(&terms, z.view(), targets.view()).map_err(|e| SindyError::Term { reason: e.to_string() })?;
        let complexity: Vec<u32> = terms.iter().map(|t| t.complexity).collect();
        let floors: Vec<f64> = largest(targets.view()).iter().map(|v| ROUNDING * v).collect();
        let columns = terms.len()..terms.len() + n;
        let equations: Vec<Selected> = match &self.solver {
            SolverChoice::Stlsq(solver) => {
                let fits = solver.solve_all(&triangle, terms.len(), columns.clone());
                let account = |((fit, target), floor): ((SparseFit, usize), &f64)| Selected {
                    converged: fit.converged,
                    ..Selected::dense(&triangle, target, &fit.coefficients, *floor)
                };
                fits.into_iter().zip(columns).zip(&floors).map(account).collect()
            }
            solver => {
                let selection = |floor: &f64| Selection { floor: *floor, complexity: &complexity, region: None };
                let of = |(target, floor)| solver.solve_while(&triangle, target, selection(floor), watch.asks());
                columns.zip(&floors).map(of).collect()
            }
        };
        if !watch.go_on() {
            return Err(SindyError::Interrupted);
        }
        if let Some(value) = equations.iter().flat_map(|e| &e.coefficients).copied().find(|c| !c.is_finite()) {
            return Err(ModelError::BadNumber { what: "a coefficient", value }.into());
        }
        let n_rows = targets.nrows();
        let regressed =
            Regressed { terms, equations, triangle, n_rows, states, controls, form: self.target.form(), dt };
        Ok((regressed, targets))
    }

    /// (z, targets) of one trajectory.
    fn rows<'a>(&self, index: usize, trajectory: &Trajectory<'a>, dt: f64) -> Result<(Rows<'a>, Rows<'a>), SindyError> {
        let x = trajectory.x;
        let t = x.nrows();
        let (states, targets): (Rows<'a>, Rows<'a>) = match (&self.target, trajectory.x_dot) {
            (Target::Continuous { .. }, Some(x_dot)) => (x.into(), x_dot.into()),
            (Target::Continuous { differentiator: Differentiator::Finite(finite), .. }, None) => {
                let too_short = |source| SindyError::TooShort { trajectory: index, source };
                (x.into(), finite.differentiate(x, dt).map_err(too_short)?.into())
            }
            (Target::Continuous { differentiator, .. }, None) => {
                let too_short = |source| SindyError::TooShort { trajectory: index, source };
                let result = differentiator.differentiate(x, dt).map_err(too_short)?;
                (result.x.into(), result.x_dot.into())
            }
            (Target::Discrete, Some(next)) => (x.into(), next.into()),
            (target, _) => {
                let last = t.saturating_sub(1);
                let (now, next) = (x.slice_move(s![..last, ..]), x.slice_move(s![t.min(1).., ..]));
                let targets = match target {
                    Target::Discrete => next.into(),
                    _ => ((&next - &now) / dt).into(),
                };
                (now.into(), targets)
            }
        };
        let z = match trajectory.u {
            Some(u) if u.ncols() > 0 => concatenate![Axis(1), states, u.slice(s![..states.nrows(), ..])].into(),
            _ => states,
        };
        Ok((z, targets))
    }
}

/// The largest magnitude in each column.
fn largest(values: ArrayView2<'_, f64>) -> Vec<f64> {
    /// Rows that are looked at side by side.
    const LANES: usize = 8;
    let n = values.ncols();
    let mut found = vec![0.0_f64; n * LANES];
    let larger = |slot: &mut f64, v: &f64| *slot = if v.abs() > *slot { v.abs() } else { *slot };
    match values.as_slice() {
        Some(values) if n > 0 => {
            for rows in values.chunks(n * LANES) {
                found.iter_mut().zip(rows).for_each(|(slot, v)| larger(slot, v));
            }
        }
        _ => values.rows().into_iter().for_each(|row| found.iter_mut().zip(row).for_each(|(slot, v)| larger(slot, v))),
    }
    (0..n).map(|i| found.iter().skip(i).step_by(n).copied().fold(0.0, f64::max)).collect()
}

/// Rows of data, copied only where they have to be.
type Rows<'a> = CowArray<'a, f64, Ix2>;

/// One below the other.
fn stacked(mut parts: Vec<Rows<'_>>) -> Rows<'_> {
    if parts.len() == 1
        && let Some(only) = parts.pop()
    {
        return only;
    }
    let views: Vec<ArrayView2<'_, f64>> = parts.iter().map(|rows| rows.view()).collect();
    concatenate(Axis(0), &views).expect("widths were checked").into()
}

/// What [`Sindy::regress_watched`] found: equations over the terms of a library.
#[derive(Debug, Clone)]
pub struct Regressed {
    terms: Vec<Term>,
    equations: Vec<Selected>,
    triangle: Triangle,
    n_rows: usize,
    states: Vec<String>,
    controls: Vec<String>,
    form: Form,
    dt: f64,
}

impl Regressed {
    /// Names of the terms, in PySINDy's notation.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.terms.iter().map(|t| t.name.as_str())
    }

    /// The account of each equation.
    #[must_use]
    pub fn equations(&self) -> &[Selected] {
        &self.equations
    }

    /// The triangle of [Θ | targets].
    #[must_use]
    pub fn triangle(&self) -> &Triangle {
        &self.triangle
    }

    /// Number of rows that were fitted.
    #[must_use]
    pub fn n_rows(&self) -> usize {
        self.n_rows
    }

    /// Ξ (n, F).
    #[must_use]
    pub fn coefficients(&self) -> Array2<f64> {
        let mut coefficients = Array2::zeros((self.equations.len(), self.terms.len()));
        for (i, equation) in self.equations.iter().enumerate() {
            for (&j, &c) in equation.support.iter().zip(&equation.coefficients) {
                coefficients[[i, j]] = c;
            }
        }
        coefficients
    }

    /// The equations, ready to step.
    ///
    /// # Errors
    /// [`ModelError`] if they are none.
    pub fn model(&self) -> Result<Model, ModelError> {
        let kinematic = vec![false; self.states.len()];
        let (states, controls) = (self.states.clone(), self.controls.clone());
        model(Space { states, controls, readings: None, kinematic }, &self.terms, &self.equations, self.form, self.dt)
    }
}

impl SindyFit {
    /// The coefficient of determination R² of the fitted targets, averaged over the states.
    #[must_use]
    pub fn score(&self) -> f64 {
        let (n_rows, n) = self.targets.dim();
        let n_features = self.names.len();
        let score = |i: usize| {
            let column = self.targets.column(i);
            let mean = column.sum() / n_rows as f64;
            let total: f64 = column.iter().map(|v| (v - mean) * (v - mean)).sum();
            let equation = &self.equations[i];
            let left = self.triangle.residual_norm(&equation.support, &equation.coefficients, n_features + i);
            1.0 - left * left / total
        };
        (0..n).map(score).sum::<f64>() / n as f64
    }
}

fn check(index: usize, trajectory: &Trajectory<'_>, n: usize, k: usize, target: &Target) -> Result<(), SindyError> {
    let shape = |what, expected, got| {
        if expected == got { Ok(()) } else { Err(SindyError::Shape { trajectory: index, what, expected, got }) }
    };
    let t = trajectory.x.nrows();
    shape("states", n, trajectory.x.ncols())?;
    shape("controls", k, trajectory.u.map_or(0, |u| u.ncols()))?;
    if let Some(u) = trajectory.u {
        let to_next = !matches!(target, Target::Continuous { .. }) && trajectory.x_dot.is_none();
        let between = to_next && u.nrows() + 1 == t;
        shape("rows of controls", t, if between { t } else { u.nrows() })?;
    }
    if let Some(x_dot) = trajectory.x_dot {
        shape("rows of derivatives", t, x_dot.nrows())?;
        shape("derivatives", n, x_dot.ncols())?;
    }
    let arrays = [("a state", Some(trajectory.x)), ("a control", trajectory.u), ("a derivative", trajectory.x_dot)];
    for (what, array) in arrays {
        let bad = array
            .filter(|a| !all_finite(*a))
            .and_then(|a| a.indexed_iter().find(|(_, v)| !v.is_finite()).map(|(at, v)| (at, *v)));
        if let Some(((row, column), value)) = bad {
            return Err(SindyError::NotFinite { trajectory: index, what, row, column, value });
        }
    }
    Ok(())
}
