//! State that can be written down, and gone on from as if nothing had happened.

use serde::{Serialize, de::DeserializeOwned};

/// Bytes that are no checkpoint of what they are given to.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("not a checkpoint of this: {what}")]
pub struct CheckpointError {
    /// What does not fit.
    pub what: String,
}

impl CheckpointError {
    /// One that says `what` does not fit.
    pub fn new(what: impl Into<String>) -> Self {
        Self { what: what.into() }
    }

    /// Refuses `got` values where there must be `expected`.
    ///
    /// # Errors
    /// [`CheckpointError`] if the two differ.
    pub fn expect_len(what: &str, expected: usize, got: usize) -> Result<(), Self> {
        if expected == got { Ok(()) } else { Err(Self::new(format!("{got} {what}, expected {expected}"))) }
    }
}

/// What has a state of its own. Restored into an equal of its own making, it goes on with the same bits.
///
/// Who keeps nothing from call to call needs neither method.
pub trait Checkpoint {
    /// The state, in a format of one's own.
    fn save(&self) -> Vec<u8> {
        Vec::new()
    }

    /// Takes on the state that [`Self::save`] of an equal wrote.
    ///
    /// # Errors
    /// [`CheckpointError`] if `saved` is not the state of such a one; then nothing has changed.
    fn restore(&mut self, saved: &[u8]) -> Result<(), CheckpointError> {
        CheckpointError::expect_len("bytes", 0, saved.len())
    }
}

/// `value` as bytes, every bit of a number kept.
pub fn encode<T: Serialize>(value: &T) -> Vec<u8> {
    postcard::to_stdvec(value).expect("memory takes any value whose length is known")
}

/// The value that [`encode`] wrote.
///
/// # Errors
/// [`CheckpointError`] if the bytes are of something else, or not all of it.
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, CheckpointError> {
    match postcard::take_from_bytes(bytes) {
        Ok((value, [])) => Ok(value),
        Ok((_, rest)) => Err(CheckpointError::new(format!("{} bytes too many", rest.len()))),
        Err(error) => Err(CheckpointError::new(error.to_string())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_keep_every_bit_and_are_refused_if_there_are_too_few_or_too_many() {
        let values = (vec![f64::NAN, -0.0, f64::NEG_INFINITY, 0.1], crate::Seed::new(3).numpy());
        let bytes = encode(&values);
        let (read, rng): (Vec<f64>, crate::Rng) = decode(&bytes).expect("it was written so");
        let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!((bits(&read), &rng), (bits(&values.0), &values.1));
        assert!(decode::<(Vec<f64>, crate::Rng)>(&bytes[..bytes.len() - 1]).is_err());
        assert!(decode::<(Vec<f64>, crate::Rng)>(&[&bytes[..], &[0]].concat()).is_err());
    }
}
