//! exp and log in double precision without branches or calls, so that loops over them become vector code.
//!
//! The same bits on every machine: nothing but sums, products and quotients in a fixed order.

use std::f64::consts::{LOG2_E, SQRT_2};

/// log 2 in two parts, the first with its last 20 bits clear, so that its products with exponents are exact.
const LN_2: (f64, f64) = (6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10);

/// A number this large holds another in its last bits, rounded to a whole one.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// eˣ to a few units in the last place; arguments beyond ±708 count as that, and a number that is none stays none.
#[inline(always)]
pub(crate) fn exp(x: f64) -> f64 {
    const MOST: f64 = 708.0;
    let x = if x < -MOST { -MOST } else { x };
    let x = if x > MOST { MOST } else { x };
    let rounded = x * LOG2_E + ROUND;
    let n = rounded - ROUND;
    let r = (x - n * LN_2.0) - n * LN_2.1;
    // Taylor's series; |r| is at most log 2 / 2, where the first term left out is 4e-18.
    const INVERSE_FACTORIALS: [f64; 14] = [
        1.0 / 6_227_020_800.0,
        1.0 / 479_001_600.0,
        1.0 / 39_916_800.0,
        1.0 / 3_628_800.0,
        1.0 / 362_880.0,
        1.0 / 40_320.0,
        1.0 / 5_040.0,
        1.0 / 720.0,
        1.0 / 120.0,
        1.0 / 24.0,
        1.0 / 6.0,
        0.5,
        1.0,
        1.0,
    ];
    let mut sum = 0.0;
    for c in INVERSE_FACTORIALS {
        sum = sum * r + c;
    }
    sum * f64::from_bits(rounded.to_bits().wrapping_add(1023) << 52)
}

/// log x to a few units in the last place, for normal positive x; a number that is none stays none.
#[inline(always)]
#[expect(clippy::eq_op, reason = "x - x is none where x is, and 0 elsewhere")]
pub(crate) fn ln(x: f64) -> f64 {
    // x = m 2ⁿ with m in √½..√2.
    const ONE: u64 = 1.0_f64.to_bits();
    let shifted = x.to_bits().wrapping_add(ONE.wrapping_sub(SQRT_2.to_bits() - (1 << 52)));
    let m = f64::from_bits(x.to_bits().wrapping_sub((shifted & (0xfff << 52)).wrapping_sub(ONE)));
    // The exponent as a whole number, by way of a number that holds it in its last bits.
    let n = f64::from_bits((shifted >> 52) | 2_f64.powi(52).to_bits()) - (2_f64.powi(52) + 1023.0);
    let s = (m - 1.0) / (m + 1.0);
    let z = s * s;
    // 2 artanh s; |s| is at most 0.172, where the first term left out is 1e-18.
    const ODD: [f64; 11] = [
        1.0 / 21.0,
        1.0 / 19.0,
        1.0 / 17.0,
        1.0 / 15.0,
        1.0 / 13.0,
        1.0 / 11.0,
        1.0 / 9.0,
        1.0 / 7.0,
        1.0 / 5.0,
        1.0 / 3.0,
        1.0,
    ];
    let mut sum = 0.0;
    for c in ODD {
        sum = sum * z + c;
    }
    n * LN_2.0 + (2.0 * s * sum + n * LN_2.1) + (x - x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_are_those_of_the_standard_library() {
        for i in -70_000..70_000 {
            let x = f64::from(i) * 0.010_1;
            assert!((exp(x) / x.exp() - 1.0).abs() < 1e-15, "exp {x}: {} {}", exp(x), x.exp());
            let y = (f64::from(i) * 1e-3).exp();
            assert!((ln(y) - y.ln()).abs() <= 1e-15 * y.ln().abs(), "ln {y}: {} {}", ln(y), y.ln());
        }
        assert!(exp(f64::NAN).is_nan() && ln(f64::NAN).is_nan());
        assert_eq!([exp(0.0), exp(f64::NEG_INFINITY), ln(1.0)], [1.0, exp(-708.0), 0.0]);
    }
}
