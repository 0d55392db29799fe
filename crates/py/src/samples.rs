//! What is asked of samples and times.

use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

/// Whether every number is finite.
#[pyfunction]
pub(crate) fn finite(values: PyReadonlyArray2<'_, f64>) -> bool {
    let values = values.as_array();
    match values.as_slice_memory_order() {
        // All of them are looked at, side by side.
        Some(values) => values.iter().fold(true, |all, v| all & v.is_finite()),
        None => values.iter().all(|v| v.is_finite()),
    }
}

/// Whether times (T) increase from one finite number to another.
#[pyfunction]
pub(crate) fn increasing(t: PyReadonlyArray1<'_, f64>) -> bool {
    let t = t.as_array();
    let ends = [t.first(), t.last()];
    ends.into_iter().flatten().all(|v| v.is_finite())
        && t.iter().zip(t.iter().skip(1)).fold(true, |all, (a, b)| all & (b > a))
}

/// The interval between times (T) that are even but for the part `within` of it; none where they are not, or fewer than two.
#[pyfunction]
pub(crate) fn interval(t: PyReadonlyArray1<'_, f64>, within: f64) -> Option<f64> {
    let t = t.as_array();
    let (first, last) = (t.first()?, t.last().filter(|_| t.len() > 1)?);
    let mean = (last - first) / (t.len() - 1) as f64;
    let steps = t.iter().zip(t.iter().skip(1)).map(|(a, b)| b - a);
    let (least, most) = steps.fold((mean, mean), |(least, most), step| {
        (if step < least { step } else { least }, if step > most { step } else { most })
    });
    ((most - mean).max(mean - least) <= within * mean).then_some(mean)
}
