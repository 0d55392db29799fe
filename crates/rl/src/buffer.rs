//! Memory that is kept from update to update and begins on a cache line.

use std::ops::{Deref, DerefMut};

/// Bytes in a cache line: a vector that lies across two of them is loaded and stored at half the speed.
const LINE: usize = 64;

/// Numbers that are overwritten again and again, of a length that changes.
#[derive(Debug, Default)]
pub(crate) struct Buffer {
    data: Vec<f32>,
    start: usize,
    len: usize,
}

impl Buffer {
    /// The first `len` numbers, whatever they are. Allocates only where there were never so many.
    pub(crate) fn sized(&mut self, len: usize) -> &mut [f32] {
        if self.data.len() < self.start + len {
            self.data = vec![0.0; len + LINE / size_of::<f32>()];
            self.start = self.data.as_ptr().align_offset(LINE).min(LINE / size_of::<f32>());
        }
        self.len = len;
        self
    }
}

impl Deref for Buffer {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        &self.data[self.start..self.start + self.len]
    }
}

impl DerefMut for Buffer {
    fn deref_mut(&mut self) -> &mut [f32] {
        &mut self.data[self.start..self.start + self.len]
    }
}

impl Clone for Buffer {
    fn clone(&self) -> Self {
        let mut twin = Self::default();
        twin.sized(self.len).copy_from_slice(self);
        twin
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_change_and_numbers_stay() {
        let mut b = Buffer::default();
        assert!(b.is_empty());
        b.sized(100).fill(3.0);
        b.sized(5)[4] = 4.0;
        let twin = b.clone();
        assert_eq!((&b.sized(6)[..], &twin[..]), (&[3.0, 3.0, 3.0, 3.0, 4.0, 3.0][..], &[3.0, 3.0, 3.0, 3.0, 4.0][..]));
        assert!(b.as_ptr().addr() % LINE == 0 && twin.as_ptr().addr() % LINE == 0);
    }
}
