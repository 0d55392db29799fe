//! Sums of sine and cosine told as one wave of an angle with another zero.

use super::fitting::Terms;
use super::found::{Found, Search};
use super::tilt::{Turn, turns};
use crate::model::ModelError;
use std::f64::consts::PI;

/// Difference of the zeros that two sums tell \[rad\], beyond which they are not due to one zero.
const APART: f64 = 1e-2;

/// RMS of a summand, as part of all, above which it does not come from an offset that was not quite right.
const NEGLIGIBLE: f64 = 1e-3;

impl Search<'_> {
    /// Whether some equation has a wave of an angle that is neither sine nor cosine.
    pub(super) fn is_mixed(&self, found: &Found) -> bool {
        self.system.angles.iter().any(|&angle| !self.sums(found, angle).is_empty())
    }

    /// The same equations with each p·(a sin mθ + b cos mθ) told as p·c sin m(θ + δ); `None` if there is no such sum, if
    /// the sums do not agree on δ, or if the data do not.
    pub(super) fn untangled(&self, found: &Found) -> Result<Option<Found>, ModelError> {
        if !found.explains() {
            return Ok(None);
        }
        let mut offsets = found.model.offsets().to_vec();
        let mut fits = found.fits.clone();
        for &angle in self.system.angles {
            let sums = self.sums(found, angle);
            let Some(heaviest) = sums.iter().max_by(|a, b| a.weight.total_cmp(&b.weight)) else { continue };
            if sums.iter().any(|s| (s.offset - heaviest.offset).abs() > APART) {
                return Ok(None);
            }
            let offset = offsets[angle] + heaviest.offset;
            // Half a turn only changes signs.
            offsets[angle] = offset - PI * (offset / PI).round();
            for sum in &sums {
                let fit = &mut fits[sum.equation];
                let kept = fit.support.iter().zip(&fit.coefficients).filter(|(j, _)| **j != sum.lesser);
                (fit.support, fit.coefficients) = kept.map(|(j, c)| (*j, *c)).unzip();
                // What was looked at before had the angle's zero elsewhere.
                (fit.path, fit.ties) = (Vec::new(), Vec::new());
            }
        }
        if offsets == found.model.offsets() {
            return Ok(None);
        }
        let start = self.fit(found.stepping, &offsets, Some(&found.model), &Terms::Same(&fits))?;
        let untangled = self.refine(start)?;
        Ok(untangled.explains().then_some(untangled))
    }

    /// `found` without the terms that move it next to nothing and without which it explains the data too: they took up what offsets now
    /// do, or what is wrong with the numbers of the data.
    pub(super) fn pruned(&self, mut found: Found) -> Found {
        while found.explains() {
            let fewer = (0..found.fits.len()).find_map(|i| self.without_least(&found, i));
            match fewer {
                Some(fewer) => found = fewer,
                None => break,
            }
        }
        found
    }

    /// `found` without the term of equation `i` that moves it least, if that explains the data too.
    fn without_least(&self, found: &Found, i: usize) -> Option<Found> {
        if self.system.rates[i].is_some() || found.fits[i].support.len() < 2 {
            return None;
        }
        let theta = self.averages_of(found, &found.model);
        let moves = |at: &usize| {
            let (j, c) = (found.fits[i].support[*at], found.fits[i].coefficients[*at]);
            theta.iter().flat_map(|t| t.column(j).to_vec()).map(|v| (c * v).powi(2)).sum::<f64>()
        };
        let moved: Vec<f64> = (0..found.fits[i].support.len()).map(|at| moves(&at)).collect();
        let least = (0..moved.len()).min_by(|a, b| moved[*a].total_cmp(&moved[*b]))?;
        if moved[least] > NEGLIGIBLE * NEGLIGIBLE * moved.iter().sum::<f64>() {
            return None;
        }
        let mut fits = found.fits.clone();
        fits[i].support.remove(least);
        fits[i].coefficients.remove(least);
        let fewer = self.with_terms_of(found, &fits)?;
        fewer.explains().then_some(fewer)
    }

    /// Every term of an equation beside which its companion stands, with the larger coefficient of the two.
    fn sums(&self, found: &Found, angle: usize) -> Vec<Sum> {
        let mut sums = Vec::new();
        for (equation, fit) in found.fits.iter().enumerate() {
            for (at, turn) in turns(self.system, &fit.support, angle).into_iter().enumerate() {
                let Some(Turn { companion, frequency, sign }) = turn else { continue };
                let (larger, smaller) = (fit.coefficients[at], fit.coefficients[companion]);
                if larger.abs() > smaller.abs() {
                    let offset = (sign * smaller / larger).atan() / frequency;
                    sums.push(Sum { equation, lesser: fit.support[companion], offset, weight: larger.abs() });
                }
            }
        }
        sums
    }
}

/// A sum of sine and cosine of one angle in an equation.
struct Sum {
    equation: usize,
    /// The term with the smaller coefficient.
    lesser: usize,
    /// What has to be added to the angle for the lesser term to vanish \[rad\].
    offset: f64,
    /// Size of the larger coefficient.
    weight: f64,
}
