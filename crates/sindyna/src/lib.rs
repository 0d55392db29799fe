//! The `sindyna` command: names to objects, settings, run records, progress.
//!
//! The only crate with files, clock and terminal. Every experiment here is put together from the other crates;
//! nothing of identification, learning or physics is written here.

mod account_text;
mod cli;
mod compare;
mod config;
mod failure;
mod hints;
mod identification;
mod interrupt;
mod learner;
mod machine;
mod overrides;
mod plain;
mod problem;
mod progress;
mod real;
mod registry;
mod report_files;
mod table;
mod task_file;

pub use cli::main;

/// The examples of the README, executed.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
