//! Savitzky–Golay smoothing.

use faer::Mat;
use ndarray::{Array2, ArrayView2};

use super::TooShort;
use crate::error::InvalidParam;

/// A moving least-squares polynomial: each sample is replaced by the value of the polynomial through its window; near
/// the ends by that of the first or last whole window.
///
/// # References
/// Savitzky, Golay (1964), Anal. Chem. 36(8). SciPy's `savgol_filter(mode="interp")` does the same; window 11 and
/// degree 3 are PySINDy's defaults.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SavitzkyGolay {
    window: usize,
    degree: usize,
}

impl Default for SavitzkyGolay {
    /// Window 11, degree 3.
    fn default() -> Self {
        Self { window: 11, degree: 3 }
    }
}

impl SavitzkyGolay {
    /// A filter of an odd `window` and a polynomial of `degree` below it.
    ///
    /// # Errors
    /// [`InvalidParam`] for an even window or too high a degree.
    pub fn new(window: usize, degree: usize) -> Result<Self, InvalidParam> {
        if window.is_multiple_of(2) || window > 999 {
            return Err(InvalidParam { name: "window", value: window as f64, wanted: "odd and below 1000" });
        }
        if degree >= window || degree > 12 {
            return Err(InvalidParam { name: "degree", value: degree as f64, wanted: "below the window and 13" });
        }
        Ok(Self { window, degree })
    }

    /// Smooths one trajectory `x` (T, n) along time.
    ///
    /// # Errors
    /// [`TooShort`] if T is smaller than the window.
    pub fn smooth(&self, x: ArrayView2<'_, f64>) -> Result<Array2<f64>, TooShort> {
        let (t, n) = x.dim();
        if t < self.window {
            return Err(TooShort { got: t, needed: self.window });
        }
        let half = self.window / 2;
        let hat = self.hat();
        let mut smoothed = Array2::zeros((t, n));
        for i in 0..t {
            let first = i.saturating_sub(half).min(t - self.window);
            for j in 0..n {
                smoothed[[i, j]] = (0..self.window).map(|k| hat[(i - first, k)] * x[[first + k, j]]).sum();
            }
        }
        Ok(smoothed)
    }

    /// Row i: the weights of the window's samples in the fitted polynomial's value at sample i.
    fn hat(&self) -> Mat<f64> {
        let half = (self.window / 2) as f64;
        let powers =
            Mat::from_fn(self.window, self.degree + 1, |i, m| ((i as f64 - half) / half.max(1.0)).powi(m as i32));
        let q = powers.qr().compute_thin_Q();
        &q * q.transpose()
    }
}
