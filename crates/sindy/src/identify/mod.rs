//! From recorded rollouts to equations of motion.

mod actuators;
mod after_changes;
mod choices;
mod compare;
mod constraints;
mod derivatives;
mod ends;
mod estimated;
mod feature;
mod in_motion;
mod in_pieces;
mod joints;
mod knowledge;
mod known;
mod misfits;
mod models;
mod noisy;
mod outliers;
mod recording;
mod refitted;
mod region;
mod report;
mod rows;
mod shown;
mod signals;
mod unmeasured;
mod warnings;

use ndarray::Array2;
use sindyna_core::{Channel, Dataset, DynamicsLearner, FitError, Kind, Knowledge, Rng, Spec};

pub use choices::{Disturbances, LibraryChoice, NoiseChoice, SolverChoice, Target};
pub use derivatives::Derived;
pub use known::{EquationConstraint, EquationConstraintError};
pub use models::Models;
pub use recording::Recording;
pub use refitted::Refitted;
pub use report::{EquationReport, Identified, InsideParameter, Noise, Report};
pub use signals::{Signals, SignalsError};

use crate::coordinates::{Coordinates, inputs};
use crate::library::{Input, LibraryError, Term, Tiers, auto, complexity, mechanical, paper, paper_degree2};
use crate::model::{Model, Reading};
use crate::names::symbols;
use crate::regression::{Space, design, model};
use crate::solve::{Selected, Selection};
use crate::{BestSubset, CoordinateMode, Watch};
use rows::Rows;

/// Identifies equations of motion from rollouts of a system that a [`Spec`] declares.
///
/// By default: the library of one rule for every system, best subsets, equations of motion with the way they are stepped,
/// recognised coordinates.
///
/// # Examples
/// A mass of 2 kg on a line, pushed by a force g:
/// ```
/// use sindyna_core::{Channel, Dataset, Kind, Precision, Space, Spec};
/// use sindyna_sindy::Identifier;
///
/// let state = vec![Channel::new("x", "m", Kind::Plain, 1.0), Channel::new("v", "m/s", Kind::RateOf(0), 1.0)];
/// let spec = Spec {
///     name: "mass".into(),
///     observation: state.clone(),
///     state,
///     control: vec![Channel::new("g", "N", Kind::Plain, 1.0)],
///     action_space: Space::Box { low: vec![-1.0], high: vec![1.0] },
///     precision: Precision::F64,
///     noise: 0.0,
///     dt: 0.1,
/// };
/// let mut data = Dataset::new(2, 1, 1, spec.dt);
/// let (mut x, mut v) = (0.3, -0.2);
/// data.begin(&[x, v])?;
/// for i in 0..20 {
///     let g = (0.9 * f64::from(i)).sin();
///     (x, v) = (x + 0.1 * v, v + 0.1 * g / 2.0);
///     data.push(&[g], &[g], 0.0, &[x, v])?;
/// }
/// let found = Identifier::new(&spec).identify(&data)?;
/// assert_eq!(found.model.equations(), ["x\u{307} = v", "v\u{307} = 0.5 g"]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Identifier {
    spec: Spec,
    library: LibraryChoice,
    own_terms: Vec<String>,
    solver: SolverChoice,
    target: Target,
    coordinates: CoordinateMode,
    noise: NoiseChoice,
    effort: f64,
    simulators: bool,
    disturbances: Disturbances,
    constraints: Vec<(usize, EquationConstraint)>,
    previous: Option<Model>,
}

impl Identifier {
    /// An identifier for the system `spec` declares.
    #[must_use]
    pub fn new(spec: &Spec) -> Self {
        Self {
            spec: spec.clone(),
            library: LibraryChoice::Auto,
            own_terms: Vec::new(),
            solver: SolverChoice::BestSubset(BestSubset::default()),
            target: Target::Motion,
            coordinates: CoordinateMode::Recognised,
            noise: NoiseChoice::Declared,
            effort: 1.0,
            simulators: true,
            disturbances: Disturbances::Possible,
            constraints: Vec::new(),
            previous: None,
        }
    }

    /// The linear one: increments regressed on a constant, states and inputs by least squares, with nothing left out. What a
    /// regulator is made from where nobody looks for equations.
    ///
    /// # Errors
    /// [`LibraryError`] if the names of states and inputs cannot be terms.
    pub fn linear(spec: &Spec) -> Result<Self, LibraryError> {
        let identifier = Self::new(spec);
        let variables = identifier.inputs().into_iter().map(|input| input.name);
        identifier
            .with_target(Target::Increment)
            .with_solver(SolverChoice::LeastSquares { ridge: 0.0 })
            .with_library(LibraryChoice::Terms([String::from("1")].into_iter().chain(variables).collect()))
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

    /// The same with terms of the user's own, such as `v*abs(v)`, beside those of the library.
    ///
    /// # Errors
    /// [`LibraryError`] if they cannot be terms over the variables of the chosen coordinates.
    pub fn with_own_terms(self, own_terms: Vec<String>) -> Result<Self, LibraryError> {
        let chosen = Self { own_terms, ..self };
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

    /// What is declared about the system.
    #[must_use]
    pub fn spec(&self) -> &Spec {
        &self.spec
    }

    /// The same with something else believed of the errors of the samples.
    #[must_use]
    pub fn with_noise(mut self, noise: NoiseChoice) -> Self {
        if noise != NoiseChoice::Declared {
            self.spec.noise = 0.0;
        }
        Self { noise, ..self }
    }

    /// The same with the part `effort` (0 to 1) of the usual operations for a search where the noise is estimated.
    #[must_use]
    pub fn with_effort(self, effort: f64) -> Self {
        Self { effort: if effort.is_nan() { 1.0 } else { effort.clamp(0.0, 1.0) }, ..self }
    }

    /// The same for data of a system of which the model `previous` was identified from fewer. Where the noise is estimated, its terms are the hypothesis that the search begins
    /// with, if they leave noise alone; a model with other terms than the candidates, or with parameters inside them, begins nothing.
    #[must_use]
    pub fn with_previous(self, previous: Option<&Model>) -> Self {
        Self { previous: previous.cloned(), ..self }
    }

    /// The same with the part `part` (0 to 1) of the effort it would make.
    #[must_use]
    pub fn with_less_effort(self, part: f64) -> Self {
        let effort = self.effort * part;
        self.with_effort(effort)
    }

    /// Whether the system is disturbed.
    #[must_use]
    pub fn with_disturbances(self, disturbances: Disturbances) -> Self {
        Self { disturbances, ..self }
    }

    /// Whether positions whose rates were not measured may be those of a simulator.
    #[must_use]
    pub fn with_simulators(self, simulators: bool) -> Self {
        Self { simulators, ..self }
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
        symbols(&names).into_iter().zip(&inputs).map(|(name, input)| Input { name, ..input.clone() }).collect()
    }

    /// The candidate terms, in order.
    ///
    /// # Errors
    /// [`LibraryError`] if the library does not fit the variables.
    pub fn terms(&self) -> Result<Vec<Term>, LibraryError> {
        Ok(self.tiers()?.terms)
    }

    /// The candidate terms; those in the first tier are tried before the others.
    fn tiers(&self) -> Result<Tiers, LibraryError> {
        let inputs = self.inputs();
        let n_states = self.channels().len();
        let names: Vec<String> = inputs.iter().map(|i| i.name.clone()).collect();
        let roles: Vec<_> = inputs.iter().map(|i| i.role).collect();
        let mut tiers = match &self.library {
            LibraryChoice::Auto if self.in_motion() => mechanical(&inputs, &self.speeds()),
            LibraryChoice::Auto => Tiers::flat(auto(&inputs, self.target == Target::Discrete)),
            LibraryChoice::Paper => Tiers::flat(paper(&inputs, n_states)),
            LibraryChoice::PaperDegree2 => Tiers::flat(paper_degree2(&inputs, n_states)),
            LibraryChoice::Terms(texts) => Tiers::flat(crate::Library::Custom(texts.clone()).terms(&names)?),
            LibraryChoice::Custom(library) => Tiers::flat(library.terms(&names)?),
        };
        if !self.own_terms.is_empty() {
            // What the user knows is tried first.
            let own = crate::Library::Custom(self.own_terms.clone()).terms(&names)?;
            tiers.terms.splice(tiers.core..tiers.core, own);
            tiers.core += self.own_terms.len();
        }
        for term in tiers.terms.iter_mut().filter(|t| t.rate.is_none()) {
            term.complexity = complexity(&term.expr, &roles);
        }
        Ok(tiers)
    }

    /// Whether equations of motion are looked for together with the way they are stepped.
    fn in_motion(&self) -> bool {
        self.motion_solver().is_some()
    }

    fn motion_solver(&self) -> Option<&BestSubset> {
        match (self.target, &self.solver, self.coordinates) {
            (Target::Motion, SolverChoice::BestSubset(solver), CoordinateMode::Recognised) => Some(solver),
            _ => None,
        }
    }

    /// Per state: the state that is declared to be its rate.
    fn rates(&self) -> Vec<Option<usize>> {
        let rate = |i: usize| self.spec.state.iter().position(|s| s.kind == Kind::RateOf(i));
        (0..self.spec.state_dim()).map(rate).collect()
    }

    /// The states that are angles.
    fn angles(&self) -> Vec<usize> {
        (0..self.spec.state_dim()).filter(|&i| self.spec.state[i].kind == Kind::Angle).collect()
    }

    /// The states that are rates of others.
    fn speeds(&self) -> Vec<usize> {
        let mut speeds: Vec<usize> = self.rates().into_iter().flatten().collect();
        speeds.sort_unstable();
        speeds.dedup();
        speeds
    }

    fn channels(&self) -> &[Channel] {
        match self.coordinates {
            CoordinateMode::Recognised => &self.spec.state,
            CoordinateMode::Raw => &self.spec.observation,
        }
    }

    /// Transitions below which nothing is identified: what a model linear in states and controls has to determine.
    #[must_use]
    pub fn needed_rows(&self) -> usize {
        1 + self.spec.state_dim() + self.spec.control_dim()
    }

    /// Identifies the equations behind `data`.
    ///
    /// # Errors
    /// [`FitError`] if the data do not have the spec's shape, are too few, or the library does not fit.
    pub fn identify(&self, data: &Dataset) -> Result<Identified, FitError> {
        self.identify_watched(data, &Watch::default())
    }

    /// The same, followed by `watch`, which may end it.
    ///
    /// # Errors
    /// As [`Self::identify`]; [`FitError::Interrupted`] if `watch` did.
    pub fn identify_watched(&self, data: &Dataset, watch: &Watch<'_>) -> Result<Identified, FitError> {
        let found = if data.intersample().is_held() {
            self.identified(data, watch)
        } else {
            self.under_changing_inputs(data, watch)
        };
        if watch.go_on() { found } else { Err(FitError::Interrupted) }
    }

    fn identified(&self, data: &Dataset, watch: &Watch<'_>) -> Result<Identified, FitError> {
        self.check(data)?;
        let failed = |reason: String| FitError::Regression { reason };
        let tiers = self.tiers().map_err(|e| failed(e.to_string()))?;
        let coordinates = Coordinates::new(&self.spec, self.coordinates)
            .map_err(|state| failed(format!("no observation shows the state `{state}`")))?;
        if let Some(solver) = self.motion_solver() {
            return self.in_motion_of(data, tiers, &coordinates, solver, watch);
        }
        self.refuse_constraints()?;
        let terms = tiers.terms;
        let rows = Rows::new(&self.spec, &coordinates, &self.target, data).map_err(|e| failed(e.to_string()))?;
        let (n, needed) = (rows.targets.ncols(), self.needed_rows());
        if rows.z.nrows() < needed {
            let unknowns = format!("{n} equations");
            return Err(FitError::TooFewRows { got: rows.z.nrows(), needed, unknowns });
        }
        let triangle = design(&terms, rows.z.view(), rows.targets.view()).map_err(|e| failed(e.to_string()))?;
        let points = region::points(&self.spec, self.channels(), &self.inputs(), &rows.z);
        // A term that is not finite somewhere in the region says nothing about the others there.
        let region = design(&terms, points.view(), Array2::zeros((points.nrows(), 0)).view()).ok();
        let complexity: Vec<u32> = terms.iter().map(|t| t.complexity).collect();
        let selection = |i: usize| Selection { floor: rows.floor[i], complexity: &complexity, region: region.as_ref() };
        let fits: Vec<Selected> = (0..n).map(|i| self.solver.solve(&triangle, terms.len() + i, selection(i))).collect();
        let model = self.model(&terms, &fits).map_err(failed)?;
        let report = Report::new(self.names(), &terms, &rows, &triangle, fits);
        Ok(Identified { model, report, models: None })
    }

    pub(super) fn check(&self, data: &Dataset) -> Result<(), FitError> {
        let shape = |what, expected, got| {
            if expected == got { Ok(()) } else { Err(FitError::Shape { what, expected, got }) }
        };
        shape("observed values", self.spec.observation_dim(), data.observation_dim())?;
        shape("controls", self.spec.control_dim(), data.control_dim())?;
        let (declared, recorded) = (self.spec.dt, data.dt());
        if (declared - recorded).abs() > 1e-9 * declared {
            let reason = format!("the data were recorded every {recorded} s, the system is declared with {declared} s");
            return Err(FitError::Regression { reason });
        }
        Ok(())
    }

    fn names(&self) -> Vec<String> {
        self.channels().iter().map(|c| c.name.clone()).chain(self.spec.control.iter().map(|c| c.name.clone())).collect()
    }

    fn model(&self, terms: &[Term], fits: &[Selected]) -> Result<Model, String> {
        model(self.space()?, terms, fits, self.target.form(), self.spec.dt).map_err(|e| e.to_string())
    }

    fn space(&self) -> Result<Space, String> {
        Ok(Space {
            states: self.channels().iter().map(|c| c.name.clone()).collect(),
            controls: self.spec.control.iter().map(|c| c.name.clone()).collect(),
            readings: self.readings()?,
            kinematic: self.kinematic(),
        })
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

impl DynamicsLearner for Identifier {
    type Model = Model;

    fn fit(
        &self,
        data: &Dataset,
        previous: Option<&Model>,
        _rng: &mut Rng,
    ) -> Result<Option<Knowledge<Model>>, FitError> {
        let identified = self.clone().with_previous(previous).identify(data)?;
        Ok(Some(identified.knowledge(&self.spec)))
    }

    fn goes_on(&self) -> bool {
        true
    }
}
