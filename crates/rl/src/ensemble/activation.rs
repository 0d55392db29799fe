//! What a hidden layer does to its sums.

use serde::{Deserialize, Serialize};

use sindyna_core::vectorized;

use crate::affine::relu;

/// The function after every layer but the last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Activation {
    /// max(z, 0).
    Relu,
    /// z/(1 + e⁻ᶻ), also known as SiLU.
    ///
    /// # References
    /// Ramachandran, Zoph, Le (2017), arXiv:1710.05941.
    Swish,
}

impl Activation {
    /// Applies the function to `z` in place.
    pub(super) fn apply(self, z: &mut [f32]) {
        vectorized(
            #[inline(always)]
            || match self {
                // Loops: a closure that an adaptor calls may be compiled apart, without these instructions.
                Self::Relu => {
                    for z in z {
                        *z = relu(*z);
                    }
                }
                Self::Swish => {
                    for z in z {
                        *z *= sigmoid(*z);
                    }
                }
            },
        );
    }
}

/// y = z σ(z), and in place of z its slope σ + y (1 - σ).
pub(super) fn swish_and_slope(z: &mut [f32], y: &mut [f32]) {
    vectorized(
        #[inline(always)]
        || {
            for (z, y) in z.iter_mut().zip(y) {
                let s = sigmoid(*z);
                *y = *z * s;
                *z = s + *y * (1.0 - s);
            }
        },
    );
}

/// 1/(1 + e⁻ᶻ) to a relative error of about 3e-7 + 6e-8 |z|; a number that is none stays none.
#[inline(always)]
fn sigmoid(z: f32) -> f32 {
    1.0 / (1.0 + power_of_two(-std::f32::consts::LOG2_E * z))
}

/// 2ᵗ to 2.3e-7, without branches or calls, so that loops over it become vector code: the same bits on every machine.
/// Exponents beyond ±125 count as that.
#[inline(always)]
fn power_of_two(t: f32) -> f32 {
    const MOST: f32 = 125.0;
    /// A number this large holds another in its last bits, rounded to a whole one.
    const ROUND: f32 = 12_582_912.0;
    /// Of all polynomials of this degree the one with the least largest relative error on ±½, the highest power first.
    const COEFFICIENTS: [f32; 5] = [0.001_327_644_5, 0.009_675_537, 0.055_507_135, 0.240_221_2, 0.693_146_94];
    const CONSTANT: f32 = 1.000_000_1;
    let t = if t < -MOST { -MOST } else { t };
    let t = if t > MOST { MOST } else { t };
    let rounded = t + ROUND;
    let r = t - (rounded - ROUND);
    let [mut sum, rest @ ..] = COEFFICIENTS;
    for c in rest {
        sum = sum * r + c;
    }
    sum = sum * r + CONSTANT;
    // What is whole goes into the exponent.
    f32::from_bits(sum.to_bits().wrapping_add(rounded.to_bits() << 23))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn swish_and_its_slope_are_those_of_their_definition() {
        for i in -4000..4000 {
            let z = f64::from(i) * 0.01;
            let (s, mut slope, mut y) = (1.0 / (1.0 + (-z).exp()), [z as f32], [0.0]);
            swish_and_slope(&mut slope, &mut y);
            let close = |got: f32, expected: f64| (f64::from(got) - expected).abs() < 1e-6 * (1.0 + z.abs());
            assert!(close(y[0], z * s), "{z}: {} is not {}", y[0], z * s);
            assert!(close(slope[0], s * (1.0 + z * (1.0 - s))), "{z}: slope {}", slope[0]);
            let mut alone = [z as f32];
            Activation::Swish.apply(&mut alone);
            assert_eq!(alone, y, "with and without slope, the bits are the same");
        }
    }

    #[test]
    fn extremes_stay_finite_and_a_broken_number_is_not_hidden() {
        let mut z = [1e30, -1e30, 0.0];
        Activation::Swish.apply(&mut z);
        assert!(z[0] == 1e30 && z[1].abs() < 1e-6 && z[2] == 0.0, "{z:?}");
        for activation in [Activation::Relu, Activation::Swish] {
            let mut z = [f32::NAN];
            activation.apply(&mut z);
            assert!(z[0].is_nan(), "{activation:?}");
        }
    }
}
