//! QR of matrices of a few columns by reflections, column by column, in their own place.

use pulp::{Arch, Simd, WithSimd};

/// The factor R (width, width) of all rows so far, column after column.
#[derive(Debug, Clone)]
pub(crate) struct Reflected {
    r: Vec<f64>,
    width: usize,
    /// Columns that reflections clear; those after them are targets.
    pivots: usize,
}

impl Reflected {
    /// Of no rows, or of a diagonal matrix: `pivots` columns with this `diagonal`, and `targets` more.
    pub(crate) fn new(pivots: usize, targets: usize, diagonal: f64) -> Self {
        let width = pivots + targets;
        let mut r = vec![0.0; width * width];
        (0..pivots).for_each(|j| r[j * width + j] = diagonal);
        Self { r, width, pivots }
    }

    /// Adds the rows of `block` (height, width), which is column after column; what is left in it is of no use.
    pub(crate) fn absorb(&mut self, block: &mut [f64]) {
        Arch::new().dispatch(Absorb { r: &mut self.r, width: self.width, pivots: self.pivots, block });
    }

    /// Number of columns.
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// Element (i, j) of the factor.
    pub(crate) fn at(&self, i: usize, j: usize) -> f64 {
        if i <= j { self.r[j * self.width + i] } else { 0.0 }
    }

    /// The factor of some columns alone: the pivots numbered `columns`, and the target number `target` of those after the pivots.
    pub(crate) fn chosen(&self, columns: &[usize], target: usize) -> Self {
        let mut chosen = Self::new(columns.len(), 1, 0.0);
        let mut block = Vec::with_capacity(self.pivots * (columns.len() + 1));
        for &j in columns {
            block.extend((0..self.pivots).map(|i| self.at(i, j)));
        }
        let first = (self.pivots + target) * self.width;
        block.extend_from_slice(&self.r[first..first + self.pivots]);
        chosen.absorb(&mut block);
        chosen
    }

    /// The least-squares coefficients of the pivots for the target number `target`; `None` where the columns may depend on each other.
    pub(crate) fn solve(&self, target: usize) -> Option<Vec<f64>> {
        let k = self.pivots;
        let diagonal = || (0..k).map(|i| self.at(i, i).abs());
        let largest = diagonal().fold(0.0, f64::max);
        // Also where one of them is no number.
        if !(largest > 0.0 && diagonal().all(|d| d > DEPENDENT * largest)) {
            return None;
        }
        let first = (k + target) * self.width;
        let mut xi = self.r[first..first + k].to_vec();
        self.substitute(&mut xi);
        Some(xi)
    }

    /// R⁻¹ `right`, in its place.
    fn substitute(&self, right: &mut [f64]) {
        for i in (0..right.len()).rev() {
            let column = &self.r[i * self.width..][..i];
            right[i] /= self.at(i, i);
            let value = right[i];
            right[..i].iter_mut().zip(column).for_each(|(slot, r)| *slot -= value * r);
        }
    }

    /// A number that the condition number of the pivots does not exceed: ‖R‖ ‖R⁻¹‖ in the norm of Frobenius.
    pub(crate) fn condition(&self) -> f64 {
        let k = self.pivots;
        let (mut size, mut inverse) = (0.0, 0.0);
        let mut column = vec![0.0; k];
        for j in 0..k {
            size += (0..=j).map(|i| self.at(i, j) * self.at(i, j)).sum::<f64>();
            column.fill(0.0);
            column[j] = 1.0;
            self.substitute(&mut column[..=j]);
            inverse += column.iter().map(|v| v * v).sum::<f64>();
        }
        (size * inverse).sqrt()
    }
}

/// Smallest part of the largest diagonal element at which columns count as independent.
const DEPENDENT: f64 = 1e-12;

/// Squared lengths between which nothing is lost.
const PLAIN: std::ops::Range<f64> = 1e-280..1e280;

/// Reflections of [R; block], pivot by pivot, with the vectors of this processor: of R each touches one row.
struct Absorb<'a> {
    r: &'a mut [f64],
    width: usize,
    pivots: usize,
    block: &'a mut [f64],
}

impl WithSimd for Absorb<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { r, width, pivots, block } = self;
        let height = block.len() / width;
        for k in 0..pivots {
            let (known, rest) = block.split_at_mut((k + 1) * height);
            let v = &mut known[k * height..];
            let Some(reflection) = Reflection::new(simd, r[k * width + k], v) else { continue };
            r[k * width + k] = reflection.pivot;
            let v = &*v;
            let mut at = (k + 1) * width + k;
            let mut fours = rest.chunks_exact_mut(4 * height);
            for four in &mut fours {
                let (ab, cd) = four.split_at(2 * height);
                let columns = [&ab[..height], &ab[height..], &cd[..height], &cd[height..]];
                let inside = dots(simd, v, columns);
                let mut along = [0.0; 4];
                for l in 0..4 {
                    along[l] = reflection.of(&mut r[at + l * width], inside[l]);
                }
                subtract_four(simd, v, along, four);
                at += 4 * width;
            }
            for one in fours.into_remainder().chunks_exact_mut(height) {
                let [inside] = dots(simd, v, [&*one]);
                let along = reflection.of(&mut r[at], inside);
                subtract(simd, v, along, one);
                at += width;
            }
        }
    }
}

/// The reflection that leaves of a column with `first` before v the `pivot` alone.
struct Reflection {
    first: f64,
    weight: f64,
    pivot: f64,
}

impl Reflection {
    /// That of the column (head; v), which may be scaled; none where v is zero.
    #[inline(always)]
    fn new<S: Simd>(simd: S, mut head: f64, v: &mut [f64]) -> Option<Self> {
        let [mut below] = dots(simd, v, [&*v]);
        let mut scale = 1.0;
        if !PLAIN.contains(&(below + head * head)) {
            scale = v.iter().fold(head.abs(), |m, a| m.max(a.abs()));
            if scale == 0.0 {
                return None;
            }
            head /= scale;
            v.iter_mut().for_each(|a| *a /= scale);
            [below] = dots(simd, v, [&*v]);
        }
        if below == 0.0 {
            return None;
        }
        let length = (head * head + below).sqrt();
        let pivot = if head > 0.0 { -length } else { length };
        let first = head - pivot;
        Some(Self { first, weight: -1.0 / (pivot * first), pivot: pivot * scale })
    }

    /// What is to be subtracted, in v, of a column with `head` before `inside` = v·column; `head` is what it becomes.
    #[inline(always)]
    fn of(&self, head: &mut f64, inside: f64) -> f64 {
        let along = self.weight * (self.first * *head + inside);
        *head -= along * self.first;
        along
    }
}

/// The products of v with some columns of its length.
#[inline(always)]
fn dots<S: Simd, const N: usize>(simd: S, v: &[f64], columns: [&[f64]; N]) -> [f64; N] {
    let (v, v_rest) = S::as_simd_f64s(v);
    let mut parts: [&[S::f64s]; N] = [&[]; N];
    let (mut even, mut odd) = ([simd.splat_f64s(0.0); N], [simd.splat_f64s(0.0); N]);
    let mut found = [0.0; N];
    for l in 0..N {
        let (part, rest) = S::as_simd_f64s(columns[l]);
        parts[l] = &part[..v.len()];
        for i in 0..v_rest.len() {
            found[l] += v_rest[i] * rest[i];
        }
    }
    let mut i = 0;
    while i + 1 < v.len() {
        for l in 0..N {
            even[l] = simd.mul_add_e_f64s(v[i], parts[l][i], even[l]);
            odd[l] = simd.mul_add_e_f64s(v[i + 1], parts[l][i + 1], odd[l]);
        }
        i += 2;
    }
    for l in 0..N {
        if i < v.len() {
            even[l] = simd.mul_add_e_f64s(v[i], parts[l][i], even[l]);
        }
        found[l] += simd.reduce_sum_f64s(simd.add_f64s(even[l], odd[l]));
    }
    found
}

/// Subtracts `along` v from each of four columns of its length.
#[inline(always)]
fn subtract_four<S: Simd>(simd: S, v: &[f64], along: [f64; 4], columns: &mut [f64]) {
    let (a, others) = columns.split_at_mut(v.len());
    let (b, others) = others.split_at_mut(v.len());
    let (c, d) = others.split_at_mut(v.len());
    let (v, v_rest) = S::as_simd_f64s(v);
    let (a, a_rest) = S::as_mut_simd_f64s(a);
    let (b, b_rest) = S::as_mut_simd_f64s(b);
    let (c, c_rest) = S::as_mut_simd_f64s(c);
    let (d, d_rest) = S::as_mut_simd_f64s(d);
    let by = [
        simd.splat_f64s(-along[0]),
        simd.splat_f64s(-along[1]),
        simd.splat_f64s(-along[2]),
        simd.splat_f64s(-along[3]),
    ];
    for ((((v, a), b), c), d) in v.iter().zip(a).zip(b).zip(c).zip(d) {
        *a = simd.mul_add_e_f64s(by[0], *v, *a);
        *b = simd.mul_add_e_f64s(by[1], *v, *b);
        *c = simd.mul_add_e_f64s(by[2], *v, *c);
        *d = simd.mul_add_e_f64s(by[3], *v, *d);
    }
    for ((((v, a), b), c), d) in v_rest.iter().zip(a_rest).zip(b_rest).zip(c_rest).zip(d_rest) {
        *a -= along[0] * v;
        *b -= along[1] * v;
        *c -= along[2] * v;
        *d -= along[3] * v;
    }
}

/// Subtracts `along` v from a column of its length.
#[inline(always)]
fn subtract<S: Simd>(simd: S, v: &[f64], along: f64, column: &mut [f64]) {
    let (v, v_rest) = S::as_simd_f64s(v);
    let (a, a_rest) = S::as_mut_simd_f64s(column);
    let by = simd.splat_f64s(-along);
    for (v, a) in v.iter().zip(a) {
        *a = simd.mul_add_e_f64s(by, *v, *a);
    }
    for (v, a) in v_rest.iter().zip(a_rest) {
        *a -= along * v;
    }
}
