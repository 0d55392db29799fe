//! Fitting the networks to rows.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use ndarray::ArrayView2;
use rand_distr::{Distribution as _, StandardNormal};
use sindyna_core::{FitError, Rng};

use super::{
    Ensemble, EnsembleConfig, EnsembleError, FitReport, TargetScale,
    likelihood::first_bounds,
    networks::Member,
    rows::{Split, Table},
    run::Run,
    standard::Standard,
};
use crate::{Isa, IsaError, adam::Adam, mlp::Mlp};

/// Fits ensembles of probabilistic networks.
///
/// Some rows are held out, the others standardised; every member draws from those a bootstrap sample, which is shuffled
/// for every epoch. All members step together, on a batch of their own sample each, with Adam and the loss
///
/// Σ over members of (mean over rows and targets of (μ - y)²/σ² + log σ², plus Σ over layers of c/2 ‖W‖²)
/// + w (Σ max - Σ min),
///
/// where max and min softly bound log σ² and belong to all members. When for more than `patience` epochs no member's
/// squared error on the holdout rows fell below its best by `min_improvement`, every member gets its best weights back,
/// and predicts under the bounds it had then; a later fit begins with the mean of those. Elites are the members with the
/// least error then. One seed and one instruction set give the same bytes; everything is done on one thread.
///
/// Squared errors stand still before variances are learned: deviations much smaller than those of other targets come out
/// too large where training ends early.
///
/// # Deviations
/// 1. In Janner's program restored members predict under the bounds of the last epoch. Those close in on each other for as
///    long as training lasts, which makes predicted deviations wrong, and from fit to fit they run away from the weights.
///
/// # References
/// Chua et al. (2018), arXiv:1805.12114. Janner et al. (2019), arXiv:1906.08253, and their program `jannerm/mbpo`.
#[derive(Debug, Clone)]
pub struct EnsembleTrainer {
    config: EnsembleConfig,
    isa: Isa,
    stop: Arc<AtomicBool>,
}

impl EnsembleTrainer {
    /// A trainer with the widest instructions this machine has.
    ///
    /// # Errors
    /// [`EnsembleError::Setting`] if a setting is outside its range.
    pub fn new(config: EnsembleConfig) -> Result<Self, EnsembleError> {
        config.check()?;
        Ok(Self { config, isa: Isa::widest(), stop: Arc::default() })
    }

    /// The same with the matrix products run by the instructions `isa`.
    ///
    /// # Errors
    /// [`IsaError::Missing`] if this machine lacks them.
    pub fn with_isa(self, isa: Isa) -> Result<Self, IsaError> {
        Ok(Self { isa: isa.checked()?, ..self })
    }

    /// The same, whose fits end with [`FitError::Interrupted`] once `stop` is set.
    #[must_use]
    pub fn until(self, stop: Arc<AtomicBool>) -> Self {
        Self { stop, ..self }
    }

    /// The settings.
    #[must_use]
    pub fn config(&self) -> &EnsembleConfig {
        &self.config
    }

    /// Networks that predict each row of `targets` (N, q) from that of `inputs` (N, d). Training goes on from the weights
    /// of `previous`, if there is one; its scales are made anew.
    ///
    /// # Errors
    /// [`FitError::TooFewRows`] if none can be held out or fewer than two remain; [`FitError::Shape`] if rows do not fit
    /// each other or `previous`; [`FitError::Regression`] if the loss left the finite numbers; [`FitError::Interrupted`] if it was told to stop.
    pub fn fit(
        &self,
        inputs: ArrayView2<'_, f64>,
        targets: ArrayView2<'_, f64>,
        previous: Option<&Ensemble>,
        rng: &mut Rng,
    ) -> Result<Ensemble, FitError> {
        shape("rows of targets", inputs.nrows(), targets.nrows())?;
        let split = Split::draw(inputs.nrows(), self.config.holdout, self.config.max_holdout, rng)?;
        let mut ensemble = match previous {
            Some(previous) => self.go_on(previous, inputs.ncols(), targets.ncols())?,
            None => self.begin(inputs.ncols(), targets.ncols(), rng),
        };
        ensemble.input_scale = Standard::of(inputs, &split.training);
        ensemble.target_scale = match self.config.targets {
            TargetScale::Standardised => Standard::of(targets, &split.training),
            TargetScale::Raw => Standard::identity(targets.ncols()),
        };
        let table = |rows| Table::new((inputs, &ensemble.input_scale), (targets, &ensemble.target_scale), rows);
        let (training, holdout) = (table(&split.training), table(&split.holdout));
        let go_on = || !self.stop.load(Ordering::SeqCst);
        Run::new(&mut ensemble, &training, &holdout, split, rng).all(&go_on)?;
        Ok(ensemble)
    }

    /// An untrained ensemble.
    pub(super) fn begin(&self, inputs: usize, targets: usize, rng: &mut Rng) -> Ensemble {
        let (config, bounds) = (self.config.clone(), first_bounds(targets));
        let widths = config.widths(inputs, targets);
        let member = |_| {
            let net = random(&widths, rng);
            Member { adam: Adam::new(net.params.len(), config.learning_rate), bounds: bounds.clone(), net }
        };
        Ensemble {
            members: (0..config.members).map(member).collect(),
            bounds_adam: Adam::new(bounds.len(), config.learning_rate),
            bounds,
            input_scale: Standard::identity(inputs),
            target_scale: Standard::identity(targets),
            elites: Vec::new(),
            report: FitReport {
                training_rows: 0,
                holdout_rows: Vec::new(),
                history: Vec::new(),
                best_epoch: Vec::new(),
                holdout_mse: Vec::new(),
            },
            isa: self.isa,
            config,
        }
    }

    /// `previous`, to be trained further with the settings of this trainer.
    fn go_on(&self, previous: &Ensemble, inputs: usize, targets: usize) -> Result<Ensemble, FitError> {
        shape("members of the previous ensemble", self.config.members, previous.members.len())?;
        let widths = self.config.widths(inputs, targets);
        for member in &previous.members {
            shape("layers of the previous ensemble", widths.len(), member.net.sizes().len())?;
            for (expected, got) in widths.iter().zip(member.net.sizes()) {
                shape("width of a layer of the previous ensemble", *expected, *got)?;
            }
        }
        let mut ensemble = Ensemble { config: self.config.clone(), isa: self.isa, ..previous.clone() };
        let adams = ensemble.members.iter_mut().map(|m| &mut m.adam).chain([&mut ensemble.bounds_adam]);
        adams.for_each(|adam| adam.learning_rate = self.config.learning_rate);
        Ok(ensemble)
    }
}

pub(super) fn shape(what: &'static str, expected: usize, got: usize) -> Result<(), FitError> {
    if expected == got { Ok(()) } else { Err(FitError::Shape { what, expected, got }) }
}

/// A network whose weights are normal with standard deviation 1/(2√inputs) of their layer, drawn again beyond two of
/// them, and whose biases are 0.
fn random(widths: &[usize], rng: &mut Rng) -> Mlp {
    let mut params = Vec::new();
    for layer in widths.windows(2) {
        let deviation = 0.5 / (layer[0] as f64).sqrt();
        for _ in 0..layer[0] * layer[1] {
            let normal: f64 = loop {
                let normal: f64 = StandardNormal.sample(rng);
                if normal.abs() <= 2.0 {
                    break normal;
                }
            };
            params.push((deviation * normal) as f32);
        }
        params.resize(params.len() + layer[1], 0.0);
    }
    Mlp::from_params(widths, params)
}
