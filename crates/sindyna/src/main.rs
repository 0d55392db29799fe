//! The `sindyna` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    sindyna::main()
}
