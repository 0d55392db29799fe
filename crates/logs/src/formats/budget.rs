//! How much of a file is held in memory.

use std::io::Read;

/// Bytes that may be unpacked of one file, or that its numbers may take: a small one may unpack to more than any memory.
#[derive(Debug)]
pub(super) struct Budget {
    left: usize,
}

/// Numbers of a log that are held in memory.
pub(super) const MOST_NUMBERS: usize = 1 << 25;

impl Default for Budget {
    fn default() -> Self {
        Self { left: 8 * MOST_NUMBERS }
    }
}

impl Budget {
    /// Takes `bytes` of it.
    pub(super) fn spend(&mut self, bytes: usize) -> Result<(), String> {
        let left = self.left.checked_sub(bytes).ok_or("it has more than 256 MiB of numbers, which is the maximum")?;
        self.left = left;
        Ok(())
    }

    /// All that `packed` unpacks to.
    pub(super) fn read(&mut self, packed: impl Read) -> Result<Vec<u8>, String> {
        let mut bytes = Vec::new();
        let most = self.left as u64 + 1;
        let read = packed.take(most).read_to_end(&mut bytes).map_err(|e| format!("it cannot be unpacked: {e}"))?;
        self.spend(read)?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write as _;

    #[test]
    fn a_small_file_that_unpacks_to_much_is_refused() {
        let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
        packed.write_all(&[0; 1 << 20]).unwrap();
        let packed = packed.finish().unwrap();
        let read = |left: usize| Budget { left }.read(flate2::read::ZlibDecoder::new(&packed[..]));
        assert_eq!(read(1 << 20).unwrap().len(), 1 << 20);
        assert!(packed.len() < 2000 && read((1 << 20) - 1).unwrap_err().contains("more than 256 MiB"));
    }
}
