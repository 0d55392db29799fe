//! A comparison of methods: what every run came to, and a digest of all of them.

mod digest;
mod files;
mod gather;
mod names;
mod outcome;
mod request;

pub use digest::{Check, Digest, FoundModel, Run, RunTime};
pub use files::{SETTINGS, read_requests, read_seconds, write_requests, write_seconds};
pub use gather::gather;
pub use names::Names;
pub use outcome::{Outcome, Point, mean};
pub use request::{Request, merged};
