//! Between the environment's units and the networks': observations in, actions out.

use ndarray::ArrayView2;

use crate::{SacError, columns::Columns};

/// How observations are scaled before a network sees them: (o - `center`) / `scale`, value by value.
#[derive(Debug, Clone, PartialEq)]
pub struct Scaling {
    /// Value that becomes 0, one per observed value, in its unit.
    pub center: Vec<f64>,
    /// Distance from the centre that becomes 1, one per observed value, in its unit; positive.
    pub scale: Vec<f64>,
}

impl Scaling {
    /// No scaling of `n_observed` values.
    #[must_use]
    pub fn identity(n_observed: usize) -> Self {
        Self { center: vec![0.0; n_observed], scale: vec![1.0; n_observed] }
    }

    /// The scaling for observations of each `(mean, standard deviation)`: what is spread evenly becomes about −1..1. A deviation
    /// that cannot be divided by counts as 1.
    #[must_use]
    pub fn standard(observations: &[(f64, f64)]) -> Self {
        // Half the width of a uniform distribution, in standard deviations.
        let half = 3.0_f64.sqrt();
        let (center, scale) = observations.iter().map(|(mean, deviation)| (*mean, half * deviation)).unzip();
        let mut scaling = Self { center, scale };
        for (center, scale) in scaling.center.iter_mut().zip(&mut scaling.scale) {
            if !(scale.is_finite() && *scale > 0.0 && (1.0 / *scale).is_finite()) {
                *scale = 1.0;
            }
            if !center.is_finite() {
                *center = 0.0;
            }
        }
        scaling
    }

    /// Number of observed values.
    #[must_use]
    pub fn width(&self) -> usize {
        self.center.len()
    }

    /// The network's view of `observations` (rows, m), into `scaled` (rows, m).
    pub(crate) fn apply(&self, observations: ArrayView2<'_, f64>, scaled: &mut [f32]) {
        let mut scaled = Columns { table: scaled, width: self.width() };
        scaled.map(0, observations, |j, o| (o - self.center[j]) / self.scale[j]);
    }

    pub(crate) fn check(&self) -> Result<(), SacError> {
        let (center, scale) = (self.center.len(), self.scale.len());
        if center != scale || center == 0 {
            return Err(SacError::ScalingWidth { center, scale });
        }
        for (index, (&center, &scale)) in self.center.iter().zip(&self.scale).enumerate() {
            // `1/scale` too must be a number: the smallest scales would turn every observation infinite.
            if !(center.is_finite() && scale.is_finite() && scale > 0.0 && (1.0 / scale).is_finite()) {
                return Err(SacError::Scaling { index, center, scale });
            }
        }
        Ok(())
    }
}

/// The range of the actions, which the networks see as -1..1.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ActionRange {
    low: Vec<f64>,
    high: Vec<f64>,
}

impl ActionRange {
    pub(crate) fn new(low: &[f64], high: &[f64]) -> Result<Self, SacError> {
        if low.len() != high.len() || low.is_empty() {
            return Err(SacError::ActionEnds { low: low.len(), high: high.len() });
        }
        for (index, (&low, &high)) in low.iter().zip(high).enumerate() {
            // The width too must be finite; and a NaN fails the comparison.
            if !(low < high && (high - low).is_finite()) {
                return Err(SacError::ActionRange { index, low, high });
            }
        }
        Ok(Self { low: low.to_vec(), high: high.to_vec() })
    }

    /// Number of action values.
    pub(crate) fn width(&self) -> usize {
        self.low.len()
    }

    /// The lower ends.
    pub(crate) fn low(&self) -> &[f64] {
        &self.low
    }

    /// The upper ends.
    pub(crate) fn high(&self) -> &[f64] {
        &self.high
    }

    /// From the network's -1..1 to the range: low + (a + 1)/2 · (high - low).
    pub(crate) fn to_world(&self, index: usize, squashed: f64) -> f64 {
        let (low, high) = (self.low[index], self.high[index]);
        (low + 0.5 * (squashed + 1.0) * (high - low)).clamp(low, high)
    }

    /// `actions` (rows, k) from the range to -1..1, into the columns of `network` from `first` on. Actions beyond its ends count as the ends:
    /// that is what the system received.
    pub(crate) fn to_network(&self, actions: ArrayView2<'_, f64>, network: &mut Columns<'_>, first: usize) {
        network.map(first, actions, |j, a| {
            let (low, high) = (self.low[j], self.high[j]);
            // A NaN stays one, so that the update's checks see it.
            2.0 * (a.clamp(low, high) - low) / (high - low) - 1.0
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;

    #[test]
    fn ranges_map_their_ends_to_one_and_clamp_what_lies_beyond() {
        let range = ActionRange::new(&[-2.0, 0.0], &[2.0, 10.0]).expect("both ends are finite");
        let mut network = [0.0; 4];
        let mut columns = Columns { table: &mut network, width: 2 };
        range.to_network(array![[7.0, 2.5], [f64::NAN, 0.0]].view(), &mut columns, 0);
        assert_eq!(network[..2], [1.0, -0.5]);
        assert!(network[2].is_nan());
        assert_eq!([range.to_world(0, -1.0), range.to_world(0, 1.0), range.to_world(1, -0.5)], [-2.0, 2.0, 2.5]);
    }

    #[test]
    fn unusable_ranges_and_scalings_are_refused() {
        for (low, high) in [(1.0, 1.0), (f64::NEG_INFINITY, 0.0), (0.0, f64::NAN), (-f64::MAX, f64::MAX)] {
            assert!(matches!(ActionRange::new(&[0.0, low], &[1.0, high]), Err(SacError::ActionRange { index: 1, .. })));
        }
        assert!(matches!(ActionRange::new(&[0.0], &[]), Err(SacError::ActionEnds { low: 1, high: 0 })));
        for (center, scale) in [(f64::NAN, 1.0), (0.0, 0.0), (0.0, -1.0), (0.0, f64::INFINITY), (0.0, 5e-324)] {
            let scaling = Scaling { center: vec![center], scale: vec![scale] };
            assert!(matches!(scaling.check(), Err(SacError::Scaling { index: 0, .. })), "{center} {scale}");
        }
        assert!(matches!(Scaling::identity(0).check(), Err(SacError::ScalingWidth { .. })));
    }
}
