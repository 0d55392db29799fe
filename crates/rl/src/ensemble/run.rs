//! One fit: epochs until none helps, and the best weights back.

use sindyna_core::{FitError, Rng};

use super::{
    Ensemble, FitReport,
    networks::Member,
    rows::{Split, Table, bootstrap, shuffle},
    step::Step,
    stopping::Stopping,
};

/// Epochs whose errors find room in the report without asking for more.
const EXPECTED_EPOCHS: usize = 256;

/// The memory of a fit. After the first epoch it takes no more but an entry of the report per epoch.
pub(super) struct Run<'a> {
    ensemble: &'a mut Ensemble,
    training: &'a Table,
    holdout: &'a Table,
    rng: &'a mut Rng,
    /// Each member's bootstrap sample, in the order of this epoch.
    samples: Vec<Vec<usize>>,
    step: Step,
    stopping: Stopping,
    report: FitReport,
}

impl<'a> Run<'a> {
    pub(super) fn new(
        ensemble: &'a mut Ensemble,
        training: &'a Table,
        holdout: &'a Table,
        split: Split,
        rng: &'a mut Rng,
    ) -> Self {
        let members = ensemble.members.len();
        let report = FitReport {
            training_rows: split.training.len(),
            holdout_rows: split.holdout,
            history: Vec::with_capacity(EXPECTED_EPOCHS),
            best_epoch: Vec::new(),
            holdout_mse: Vec::new(),
        };
        Self {
            samples: (0..members).map(|_| bootstrap(split.training.len(), rng)).collect(),
            step: Step::new(ensemble),
            stopping: Stopping::new(ensemble.config.min_improvement, members),
            ensemble,
            training,
            holdout,
            rng,
            report,
        }
    }

    /// Trains the ensemble as long as `go_on` says so, and leaves its elites and the report in it.
    pub(super) fn all(mut self, go_on: &dyn Fn() -> bool) -> Result<(), FitError> {
        let config = &self.ensemble.config;
        let (patience, per_epoch) = (config.patience, self.report.training_rows.div_ceil(config.batch_size));
        let by_steps = config.max_steps.map(|most| most.div_ceil(per_epoch));
        // At least one epoch, since there is nothing to go back to before it.
        let most = [config.max_epochs, by_steps].into_iter().flatten().min();
        let mut idle = 0;
        while idle <= patience && most.is_none_or(|most| self.report.history.len() < most) {
            self.epoch(go_on)?;
            let errors = self.holdout_errors();
            idle = self.stopping.note(
                &errors,
                self.ensemble.members.iter().map(|m| &*m.net.params),
                &self.ensemble.bounds,
            );
            self.report.history.push(errors);
        }
        for (i, member) in self.ensemble.members.iter_mut().enumerate() {
            self.stopping.restore(i, &mut member.net.params, &mut member.bounds);
        }
        self.ensemble.meet_bounds();
        self.report.holdout_mse = self.holdout_errors();
        let errors = &self.report.holdout_mse;
        let mut order: Vec<usize> = (0..errors.len()).collect();
        order.sort_by(|a, b| errors[*a].total_cmp(&errors[*b]));
        order.truncate(self.ensemble.config.elites);
        self.ensemble.elites = order;
        self.report.best_epoch = self.stopping.best_epoch;
        self.ensemble.report = self.report;
        Ok(())
    }

    /// Every member sees its whole sample, batch by batch.
    fn epoch(&mut self, go_on: &dyn Fn() -> bool) -> Result<(), FitError> {
        let (rows, batch) = (self.report.training_rows, self.ensemble.config.batch_size);
        for start in (0..rows).step_by(batch) {
            if !go_on() {
                return Err(FitError::Interrupted);
            }
            let samples = self.samples.iter().map(|s| &s[start..rows.min(start + batch)]);
            self.step.take(self.ensemble, self.training, samples).map_err(|(member, loss)| FitError::Regression {
                reason: format!("the loss of network {member} is {loss} after {} epochs", self.report.history.len()),
            })?;
        }
        self.samples.iter_mut().for_each(|s| shuffle(s, self.rng));
        Ok(())
    }

    /// Mean squared error of each member on the holdout rows.
    fn holdout_errors(&mut self) -> Vec<f64> {
        let (d, q) = (self.ensemble.n_inputs(), self.ensemble.n_targets());
        // As many rows at once as a step has, for which there is memory.
        let rows = self.ensemble.config.batch_size;
        let pass = &mut self.step.pass;
        let error = |member: &Member| {
            let parts = self.holdout.inputs.chunks(rows * d).zip(self.holdout.targets.chunks(rows * q));
            let sum: f64 = parts.map(|(x, y)| sum_of_squares(pass.forward(&member.net, x), y, q)).sum();
            sum / self.holdout.targets.len() as f64
        };
        self.ensemble.members.iter().map(error).collect()
    }
}

/// Σ (μ - y)² over `targets` (rows, q), where a row of `outputs` (rows, 2q) begins with μ.
fn sum_of_squares(outputs: &[f32], targets: &[f32], q: usize) -> f64 {
    let rows = outputs.chunks_exact(2 * q).zip(targets.chunks_exact(q));
    rows.flat_map(|(o, y)| o.iter().zip(y)).map(|(o, y)| (f64::from(*o) - f64::from(*y)).powi(2)).sum()
}
