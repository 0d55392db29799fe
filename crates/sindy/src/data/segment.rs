//! Consecutive samples with nothing between them but the equations of motion.

use ndarray::{Array1, Array2, Axis, s};
use sindyna_core::InterSample;

use crate::motion::Run;

/// Consecutive samples of one trajectory.
#[derive(Debug, Clone)]
pub(crate) struct Segment {
    /// States (T + 1, n).
    pub(crate) x: Array2<f64>,
    /// Controls (T, k) at the beginning of each step.
    pub(crate) u: Array2<f64>,
    /// By how much controls change over each step (T, k); `None` if they are held.
    pub(crate) ramp: Option<Ramp>,
    /// Time from each sample to the next \[s\] (T).
    pub(crate) dt: Vec<f64>,
    /// Standard deviation of the error of each sample, relative to that of its channel (T + 1, n); `None` if all are the same. Infinite where a state was
    /// not measured: `x` is an estimate there, to begin with.
    pub(crate) relative: Option<Array2<f64>>,
    /// Standard deviation of the error with which each control may have been written (k), 0 for one that is exact; empty if all are.
    pub(crate) of_inputs: Vec<f64>,
    /// By how much controls differ from those that were written (T, k), if that was found.
    pub(crate) corrections: Option<Array2<f64>>,
}

/// How controls change between samples.
#[derive(Debug, Clone)]
pub(crate) struct Ramp {
    /// By how much over each step (T, k).
    pub(crate) by: Array2<f64>,
    /// In which way.
    pub(crate) intersample: InterSample,
}

impl Ramp {
    /// Part of the change that controls have after the part `over` of a step of `dt` \[s\]; where they jump, averaged over it.
    pub(crate) fn after(&self, over: f64, dt: f64) -> f64 {
        match self.intersample {
            InterSample::Late(_) => self.intersample.mean_share(dt),
            _ => self.intersample.share(over, dt),
        }
    }
}

impl Segment {
    /// The samples of `run`, `dt` \[s\] apart.
    pub(crate) fn even(run: &Run, dt: f64) -> Self {
        let (x, u, of_inputs) = (run.x.clone(), run.u.clone(), run.written.clone());
        Self { x, u, ramp: None, dt: vec![dt; run.len()], relative: None, of_inputs, corrections: None }
    }

    /// Number of steps T.
    pub(crate) fn len(&self) -> usize {
        self.u.nrows()
    }

    /// Steps `first` to `last`, that one excluded.
    pub(crate) fn part(&self, first: usize, last: usize) -> Self {
        Self {
            x: self.x.slice(s![first..=last, ..]).to_owned(),
            u: self.u.slice(s![first..last, ..]).to_owned(),
            ramp: self.ramp.as_ref().map(|r| Ramp { by: r.by.slice(s![first..last, ..]).to_owned(), ..*r }),
            dt: self.dt[first..last].to_vec(),
            relative: self.relative.as_ref().map(|r| r.slice(s![first..=last, ..]).to_owned()),
            of_inputs: self.of_inputs.clone(),
            corrections: self.corrections.as_ref().map(|r| r.slice(s![first..last, ..]).to_owned()),
        }
    }

    /// The same with controls that change linearly to those of the next step; without the last step, at whose end they are not known.
    pub(crate) fn with_linear_inputs(&self) -> Self {
        let last = self.len().saturating_sub(1);
        let by = &self.u.slice(s![1.., ..]) - &self.u.slice(s![..last, ..]);
        Self { ramp: Some(Ramp { by, intersample: InterSample::Foh }), ..self.part(0, last) }
    }

    /// Controls averaged over each step (T, k).
    pub(crate) fn mean_inputs(&self) -> Array2<f64> {
        let Some(Ramp { by, intersample }) = &self.ramp else { return self.u.clone() };
        let shares: Array1<f64> = self.dt.iter().map(|dt| intersample.mean_share(*dt)).collect();
        &self.u + &(by * &shares.insert_axis(Axis(1)))
    }

    /// Controls at the beginning of step `t`, and by how much they change over it: nothing if they are held.
    pub(crate) fn input(&self, t: usize) -> (Vec<f64>, Vec<f64>) {
        (self.u.row(t).to_vec(), self.ramp.as_ref().map_or_else(Vec::new, |ramp| ramp.by.row(t).to_vec()))
    }

    /// How controls change over each step.
    pub(crate) fn intersample(&self) -> InterSample {
        self.ramp.as_ref().map_or(InterSample::Zoh, |ramp| ramp.intersample)
    }

    /// Σ ln w² of the relative standard deviations w of all samples that were measured.
    pub(crate) fn log_variances(&self) -> f64 {
        let of = |r: &Array2<f64>| r.iter().filter(|w| w.is_finite()).map(|w| 2.0 * w.ln()).sum();
        self.relative.as_ref().map_or(0.0, of)
    }

    /// Standard deviation of the error of sample `t` of state `i`, relative to that of the channel.
    pub(crate) fn relative(&self, t: usize, i: usize) -> f64 {
        self.relative.as_ref().map_or(1.0, |r| r[[t, i]])
    }

    /// The same, and 1 for a sample that was not measured.
    pub(crate) fn relative_or_one(&self, t: usize, i: usize) -> f64 {
        Some(self.relative(t, i)).filter(|w| w.is_finite()).unwrap_or(1.0)
    }

    /// Whether state `i` was measured.
    pub(crate) fn measures(&self, i: usize) -> bool {
        self.relative.as_ref().is_none_or(|r| r.column(i).iter().any(|w| w.is_finite()))
    }

    /// Whether all samples of each state that was measured are equally exact.
    pub(crate) fn is_equally_exact(&self) -> bool {
        let same = |r: &Array2<f64>| r.iter().all(|w| w.is_infinite() || (w - 1.0).abs() < f64::EPSILON);
        self.relative.as_ref().is_none_or(same)
    }
}

/// Whether state `i` was measured in `segments`: in all of them, or in none.
pub(crate) fn measures(segments: &[Segment], i: usize) -> bool {
    segments.first().is_none_or(|s| s.measures(i))
}
