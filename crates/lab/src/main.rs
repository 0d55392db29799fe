//! The `sindyna` command.
fn main() {}
