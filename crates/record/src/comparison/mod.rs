//! A comparison of methods: what every run came to, and a digest of all of them.

mod digest;
mod files;
mod gather;
mod names;
mod outcome;
mod request;
mod seeds;

pub use digest::{Check, Digest, FoundModel, Run, RunTime};
pub use files::{SETTINGS, read_requests, read_seconds, write_requests, write_seconds};
pub use gather::gather;
pub use names::{Names, base, is_variant, noisy, variant};
pub use outcome::{Outcome, Point, mean};
pub use request::{Request, merged};
pub use seeds::Seeds;
