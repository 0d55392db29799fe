//! Equations of a disturbed system in other readings of its log, and in parts of it.

use sindyna_core::FitError;

use super::Identifier;
use super::recording::Recording;
use crate::coordinates::Coordinates;
use crate::data::Segment;
use crate::library::Joints;
use crate::model::Model;
use crate::pieces::Cut;
use crate::{CoordinateMode, Watch};

impl Identifier {
    /// How far the equations of `model`, those of a system that is disturbed, miss pieces of each of `readings`, which differ in their inputs alone: mean squares of residuals, per
    /// piece, over their size in most pieces of the first, with coefficients fitted to that reading; infinite where the model diverges. `None` if states are not
    /// positions and speeds of joints, or pieces are too few.
    ///
    /// # Errors
    /// [`FitError`] if recordings do not have the spec's shape.
    pub fn misfits_of_pieces(
        &self,
        model: &Model,
        readings: &[Vec<Recording>],
        watch: &Watch<'_>,
    ) -> Result<Option<Vec<Vec<f64>>>, FitError> {
        self.with_cuts(readings, |cuts| Cut::misfits(cuts, model, watch))
    }

    /// The equations of `model` with coefficients fitted to pieces of `recordings`. `None` if states are not positions and speeds of joints, or pieces are too few.
    ///
    /// # Errors
    /// [`FitError`] if recordings do not have the spec's shape.
    pub fn fitted_to_pieces(
        &self,
        model: &Model,
        recordings: Vec<Recording>,
        watch: &Watch<'_>,
    ) -> Result<Option<Model>, FitError> {
        self.with_cuts(&[recordings], |cuts| cuts.first()?.refitted(model, watch))
    }

    /// What `of` says of the pieces of each of `readings`.
    fn with_cuts<T>(
        &self,
        readings: &[Vec<Recording>],
        of: impl FnOnce(&[Cut<'_>]) -> Option<T>,
    ) -> Result<Option<T>, FitError> {
        readings.iter().flatten().try_for_each(|r| r.check(&self.spec))?;
        let coordinates = Coordinates::new(&self.spec, CoordinateMode::Recognised)
            .map_err(|state| FitError::Regression { reason: format!("no observation shows the state `{state}`") })?;
        let Some(joints) = Joints::any(&self.inputs(), &self.rates(), &[]) else { return Ok(None) };
        let floor = self.smallest_errors(&coordinates, readings.first().map_or(&[], Vec::as_slice));
        let segments: Vec<Vec<Segment>> = readings
            .iter()
            .map(|all| all.iter().map(|r| r.segment(&coordinates)).filter(|s| s.len() > 0).collect())
            .collect();
        let cuts: Option<Vec<Cut<'_>>> = segments.iter().map(|all| Cut::new(all, &floor, &joints.speeds())).collect();
        Ok(cuts.and_then(|cuts| of(&cuts)))
    }
}
