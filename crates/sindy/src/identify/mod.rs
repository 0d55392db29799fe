//! From recorded rollouts to equations of motion.

mod choices;
mod region;
mod report;
mod rows;

use ndarray::Array2;
use sindyna_core::{Channel, Dataset, DynamicsLearner, FitError, Kind, Rng, Spec};

pub use choices::{LibraryChoice, SolverChoice, Target};
pub use report::{EquationReport, Identified, Report};

use crate::coordinates::{Coordinates, inputs};
use crate::expr::Tape;
use crate::library::{Input, LibraryError, Term, auto, complexity, paper, paper_degree2};
use crate::model::{Form, Model, ModelParts, Reading};
use crate::names::symbols;
use crate::solve::{Selected, Selection};
use crate::{BestSubset, CoordinateMode, Triangle};
use rows::Rows;

/// Identifies equations of motion from rollouts of a system that a [`Spec`] declares.
///
/// By default: the library of one rule for every system, best subsets, increments, recognised coordinates.
#[derive(Debug, Clone)]
pub struct Identifier {
    spec: Spec,
    library: LibraryChoice,
    solver: SolverChoice,
    target: Target,
    coordinates: CoordinateMode,
}

impl Identifier {
    /// An identifier for the system `spec` declares.
    #[must_use]
    pub fn new(spec: &Spec) -> Self {
        Self {
            spec: spec.clone(),
            library: LibraryChoice::Auto,
            solver: SolverChoice::BestSubset(BestSubset::default()),
            target: Target::Increment,
            coordinates: CoordinateMode::Recognised,
        }
    }

    /// The same with other candidate terms.
    ///
    /// # Errors
    /// [`LibraryError`] if they cannot be terms over the variables of the chosen coordinates.
    pub fn with_library(self, library: LibraryChoice) -> Result<Self, LibraryError> {
        let chosen = Self { library, ..self };
        chosen.terms()?;
        Ok(chosen)
    }

    /// The same with another solver.
    #[must_use]
    pub fn with_solver(self, solver: SolverChoice) -> Self {
        Self { solver, ..self }
    }

    /// The same with another left-hand side.
    #[must_use]
    pub fn with_target(self, target: Target) -> Self {
        Self { target, ..self }
    }

    /// The same in other coordinates. Choose them before terms of your own, which are checked against their names.
    #[must_use]
    pub fn with_coordinates(self, coordinates: CoordinateMode) -> Self {
        Self { coordinates, ..self }
    }

    /// The variables z = (x; u) of the terms, with the names they have there.
    #[must_use]
    pub fn inputs(&self) -> Vec<Input> {
        let inputs = inputs(&self.spec, self.coordinates);
        let names: Vec<String> = inputs.iter().map(|i| i.name.clone()).collect();
        symbols(&names).into_iter().zip(&inputs).map(|(name, input)| Input { name, role: input.role }).collect()
    }

    /// The candidate terms, in order.
    ///
    /// # Errors
    /// [`LibraryError`] if the library does not fit the variables.
    pub fn terms(&self) -> Result<Vec<Term>, LibraryError> {
        let inputs = self.inputs();
        let n_states = self.channels().len();
        let names: Vec<String> = inputs.iter().map(|i| i.name.clone()).collect();
        let roles: Vec<_> = inputs.iter().map(|i| i.role).collect();
        let mut terms = match &self.library {
            LibraryChoice::Auto => auto(&inputs),
            LibraryChoice::Paper => paper(&inputs, n_states),
            LibraryChoice::PaperDegree2 => paper_degree2(&inputs, n_states),
            LibraryChoice::Terms(texts) => crate::Library::Custom(texts.clone()).terms(&names)?,
            LibraryChoice::Custom(library) => library.terms(&names)?,
        };
        for term in &mut terms {
            term.complexity = complexity(&term.expr, &roles);
        }
        Ok(terms)
    }

    fn channels(&self) -> &[Channel] {
        match self.coordinates {
            CoordinateMode::Recognised => &self.spec.state,
            CoordinateMode::Raw => &self.spec.observation,
        }
    }

    /// Identifies the equations behind `data`.
    ///
    /// # Errors
    /// [`FitError`] if the data do not have the spec's shape, are too few, or the library does not fit.
    pub fn identify(&self, data: &Dataset) -> Result<Identified, FitError> {
        self.check(data)?;
        let failed = |reason: String| FitError::Regression { reason };
        let terms = self.terms().map_err(|e| failed(e.to_string()))?;
        let coordinates = Coordinates::new(&self.spec, self.coordinates)
            .map_err(|state| failed(format!("no observation shows the state `{state}`")))?;
        let rows = Rows::new(&self.spec, &coordinates, &self.target, data).map_err(|e| failed(e.to_string()))?;
        let (n, needed) = (rows.targets.ncols(), 1 + self.spec.state_dim() + self.spec.control_dim());
        if rows.z.nrows() < needed {
            let unknowns = format!("{n} equations");
            return Err(FitError::TooFewRows { got: rows.z.nrows(), needed, unknowns });
        }
        let triangle = triangle(&terms, &rows.z, &rows.targets).map_err(failed)?;
        let points = region::points(&self.spec, self.channels(), &self.inputs(), &rows.z);
        // A term that is not finite somewhere in the region says nothing about the others there.
        let region = self::triangle(&terms, &points, &Array2::zeros((points.nrows(), 0))).ok();
        let complexity: Vec<u32> = terms.iter().map(|t| t.complexity).collect();
        let selection = |i: usize| Selection { floor: rows.floor[i], complexity: &complexity, region: region.as_ref() };
        let fits: Vec<Selected> = (0..n).map(|i| self.fit_equation(&triangle, terms.len() + i, selection(i))).collect();
        let model = self.model(&terms, &fits).map_err(failed)?;
        let report = Report::new(self.names(), &terms, &rows, &triangle, fits);
        Ok(Identified { model, report })
    }

    fn check(&self, data: &Dataset) -> Result<(), FitError> {
        let shape = |what, expected, got| {
            if expected == got { Ok(()) } else { Err(FitError::Shape { what, expected, got }) }
        };
        shape("observed values", self.spec.observation_dim(), data.observation_dim())?;
        shape("controls", self.spec.control_dim(), data.control_dim())
    }

    fn fit_equation(&self, triangle: &Triangle, target: usize, selection: Selection<'_>) -> Selected {
        let n_features = selection.complexity.len();
        match &self.solver {
            SolverChoice::BestSubset(solver) => solver.solve(triangle, target, selection),
            SolverChoice::Stlsq(solver) => {
                let fit = solver.solve(triangle, n_features, target);
                Selected::dense(triangle, target, &fit.coefficients, selection.floor)
            }
            SolverChoice::LeastSquares { ridge } => {
                let all: Vec<usize> = (0..n_features).collect();
                let xi = triangle.solve(&all, target, *ridge);
                Selected::dense(triangle, target, &xi, selection.floor)
            }
        }
    }

    fn names(&self) -> Vec<String> {
        self.channels().iter().map(|c| c.name.clone()).chain(self.spec.control.iter().map(|c| c.name.clone())).collect()
    }

    fn model(&self, terms: &[Term], fits: &[Selected]) -> Result<Model, String> {
        let mut active: Vec<usize> = fits.iter().flat_map(|f| f.support.iter().copied()).collect();
        active.sort_unstable();
        active.dedup();
        let symbols: Vec<String> = self.inputs().into_iter().map(|i| i.name).collect();
        let place = |j: &usize| active.binary_search(j).unwrap_or(0);
        let equation =
            |f: &Selected| f.support.iter().map(place).zip(f.coefficients.iter().copied()).collect::<Vec<_>>();
        let parts = ModelParts {
            states: self.channels().iter().map(|c| c.name.clone()).collect(),
            controls: self.spec.control.iter().map(|c| c.name.clone()).collect(),
            form: match self.target {
                Target::Increment => Form::Increment,
                Target::Discrete => Form::Discrete,
                Target::Continuous { scheme, .. } => Form::Continuous(scheme),
            },
            dt: self.spec.dt,
            readings: self.readings()?,
            terms: active.iter().map(|&j| terms[j].expr.display(&symbols).to_string()).collect(),
            equations: fits.iter().map(equation).collect(),
            kinematic: self.kinematic(),
            n_features: terms.len(),
        };
        Model::new(parts).map_err(|e| e.to_string())
    }

    /// Per state of the model: whether another state is declared to be its rate.
    fn kinematic(&self) -> Vec<bool> {
        let has_rate = |i: usize| self.spec.state.iter().any(|s| s.kind == Kind::RateOf(i));
        match self.coordinates {
            CoordinateMode::Recognised => (0..self.spec.state_dim()).map(has_rate).collect(),
            CoordinateMode::Raw => {
                let state = |c: &Channel| match c.kind {
                    Kind::CosOf(i) | Kind::SinOf(i) => Some(i),
                    _ => self.spec.state.iter().position(|s| s.name == c.name),
                };
                self.spec.observation.iter().map(|c| state(c).is_some_and(has_rate)).collect()
            }
        }
    }

    fn readings(&self) -> Result<Option<Vec<Reading>>, String> {
        if self.coordinates == CoordinateMode::Recognised {
            return Ok(None);
        }
        let reading = |c: &Channel| match c.kind {
            Kind::CosOf(i) => Ok(Reading::Cosine(i)),
            Kind::SinOf(i) => Ok(Reading::Sine(i)),
            _ => match self.spec.state.iter().position(|s| s.name == c.name) {
                Some(i) => Ok(Reading::Direct(i)),
                None => Err(format!("the observation `{}` shows no state", c.name)),
            },
        };
        self.spec.observation.iter().map(reading).collect::<Result<_, _>>().map(Some)
    }
}

/// The triangle of [Θ(z) | targets].
fn triangle(terms: &[Term], z: &Array2<f64>, targets: &Array2<f64>) -> Result<Triangle, String> {
    let tape = Tape::new(z.ncols(), terms.iter().map(|t| &t.expr));
    let mut registers = vec![0.0; tape.n_registers()];
    let width = terms.len() + targets.ncols();
    let mut triangle = Triangle::new(width);
    let mut columns = Array2::zeros((z.nrows(), width));
    for (i, mut row) in columns.rows_mut().into_iter().enumerate() {
        for (register, value) in registers.iter_mut().zip(z.row(i)) {
            *register = *value;
        }
        tape.run(&mut registers);
        for (slot, &register) in row.iter_mut().zip(tape.outputs()) {
            *slot = registers[register as usize];
        }
        for (slot, target) in row.iter_mut().skip(terms.len()).zip(targets.row(i)) {
            *slot = *target;
        }
    }
    triangle.push(columns.view()).map_err(|e| match e {
        crate::TriangleError::NotFinite { row, column, value } if column < terms.len() => {
            format!("the term `{}` is {value} in row {row}", terms[column].name)
        }
        other => other.to_string(),
    })?;
    Ok(triangle)
}

impl DynamicsLearner for Identifier {
    type Model = Model;

    fn fit(&self, data: &Dataset, _previous: Option<&Model>, _rng: &mut Rng) -> Result<Option<Model>, FitError> {
        self.identify(data).map(|identified| Some(identified.model))
    }
}
