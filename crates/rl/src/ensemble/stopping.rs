//! When a fit has gone far enough, and what it was worth.

/// What a fit did, in numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct FitReport {
    /// Rows trained on; every member sees as many of them, drawn with repetition.
    pub training_rows: usize,
    /// Which rows were held out, as numbers into the rows of the fit.
    pub holdout_rows: Vec<usize>,
    /// Mean squared error of every member on the holdout rows after every epoch, mean over the targets in the networks'
    /// units: one vector of members per epoch.
    pub history: Vec<Vec<f64>>,
    /// The epoch, counted from 0, whose weights each member got back.
    pub best_epoch: Vec<usize>,
    /// Mean squared error of every member on the holdout rows as it is now.
    pub holdout_mse: Vec<f64>,
}

/// Remembers the best of every member, and since when none became better.
#[derive(Debug)]
pub(super) struct Stopping {
    best: Vec<f64>,
    pub(super) best_epoch: Vec<usize>,
    /// Weights, and after them the bounds.
    states: Vec<Vec<f32>>,
    min_improvement: f64,
    idle: usize,
    epoch: usize,
}

impl Stopping {
    pub(super) fn new(min_improvement: f64, members: usize) -> Self {
        Self {
            best: vec![f64::INFINITY; members],
            best_epoch: vec![0; members],
            states: vec![Vec::new(); members],
            min_improvement,
            idle: 0,
            epoch: 0,
        }
    }

    /// Takes note of an epoch: `errors` of the members, whose weights are `weights` under the `bounds` of all. Returns for
    /// how many epochs now none improved.
    pub(super) fn note<'a>(
        &mut self,
        errors: &[f64],
        weights: impl Iterator<Item = &'a [f32]>,
        bounds: &[f32],
    ) -> usize {
        self.idle += 1;
        for (i, (&error, weights)) in errors.iter().zip(weights).enumerate() {
            // The first epoch counts whatever it brought; a best of 0 cannot be improved.
            if self.epoch == 0 || error < self.best[i] * (1.0 - self.min_improvement) {
                self.best[i] = error;
                self.best_epoch[i] = self.epoch;
                self.states[i].clear();
                self.states[i].extend_from_slice(weights);
                self.states[i].extend_from_slice(bounds);
                self.idle = 0;
            }
        }
        self.epoch += 1;
        self.idle
    }

    /// Brings back the weights and the bounds with which member `i` was best.
    pub(super) fn restore(&self, i: usize, weights: &mut [f32], bounds: &mut [f32]) {
        let (best_weights, best_bounds) = self.states[i].split_at(weights.len());
        weights.copy_from_slice(best_weights);
        bounds.copy_from_slice(best_bounds);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_member_counts_as_improved_only_by_more_than_the_margin_below_its_best() {
        let mut stopping = Stopping::new(0.01, 2);
        let mut note = |errors: [f64; 2], mark: f32| {
            stopping.note(&errors, [[mark].as_slice(), &[-mark]].into_iter(), &[10.0 * mark])
        };
        assert_eq!(note([1.0, 1.0], 0.0), 0);
        assert_eq!(note([0.995, 1.2], 1.0), 1);
        assert_eq!(note([0.995, 0.98], 2.0), 0);
        assert_eq!(note([0.9901, 0.98], 3.0), 1, "two small steps are one that counts only if they add up");
        assert_eq!(note([0.9899, 0.98], 4.0), 0);
        assert_eq!(note([f64::NAN, 0.98], 5.0), 1);
        assert_eq!(stopping.best_epoch, [4, 2]);
        let (mut weights, mut bounds) = ([0.0], [0.0]);
        for (i, expected) in [(0, (4.0, 40.0)), (1, (-2.0, 20.0))] {
            stopping.restore(i, &mut weights, &mut bounds);
            assert_eq!((weights[0], bounds[0]), expected);
        }
    }
}
