//! What was identified, as bytes.

use sindyna_core::{decode, encode};
use sindyna_sindy::Identified;

/// How such a file begins; the build follows, whose types these are.
const HEAD: &str = "sindyna identified 1 ";

/// The first line of a file that this build writes.
fn head() -> String {
    format!("{HEAD}{} {}\n", env!("CARGO_PKG_VERSION"), crate::COMMIT)
}

/// `identified` with the models that the data allow.
pub fn identified_bytes(identified: &Identified) -> Vec<u8> {
    let contents = encode(identified);
    let sum = crc32fast::hash(&contents).to_le_bytes();
    [head().as_bytes(), &sum, &contents].concat()
}

/// What [`identified_bytes`] wrote; else why not.
pub fn identified_of(bytes: &[u8]) -> Result<Identified, String> {
    let Some(rest) = bytes.strip_prefix(head().as_bytes()) else {
        return Err(if bytes.starts_with(HEAD.as_bytes()) {
            "it was written by another build: identify again".into()
        } else {
            "it was not written by `sindyna identify`".into()
        });
    };
    let contents = rest.split_at_checked(4).filter(|(sum, rest)| *sum == crc32fast::hash(rest).to_le_bytes());
    let identified = contents.and_then(|(_, contents)| decode(contents).ok());
    identified.ok_or_else(|| "it is damaged: identify again".into())
}
