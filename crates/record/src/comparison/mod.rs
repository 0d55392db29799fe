//! A comparison of methods: what every run came to, and a digest of all of them.

mod digest;
mod files;
mod gather;
mod outcome;
mod request;

pub use digest::{Check, Digest, FoundModel, Run, RunTime};
pub use files::{SETTINGS, read_requests, read_seconds, write_requests, write_seconds};
pub use gather::gather;
pub use outcome::{Outcome, Point, mean};
pub use request::{Request, merged};

/// The names that a comparison may have, in their usual order: others become neither names of files nor text in pages.
#[derive(Debug, Clone, Copy)]
pub struct Names<'a> {
    /// Tasks.
    pub tasks: &'a [&'a str],
    /// Methods.
    pub methods: &'a [&'a str],
}
