//! Records the commit the binary is built from.

use std::process::Command;

fn main() {
    let git = |args: &[&str]| {
        let output = Command::new("git").args(args).output().ok().filter(|o| o.status.success())?;
        String::from_utf8(output.stdout).ok().map(|s| s.trim().to_owned())
    };
    // A package tells its commit in a file; the repository around it is somebody else's.
    println!("cargo:rerun-if-changed=.cargo_vcs_info.json");
    let packaged = std::fs::read_to_string(".cargo_vcs_info.json").ok();
    let commit = match &packaged {
        Some(text) => text.split('"').find(|word| word.len() == 40).map(|sha| sha[..12].to_owned()),
        None => git(&["rev-parse", "--short=12", "HEAD"]),
    };
    println!("cargo:rustc-env=SINDYNA_COMMIT={}", commit.unwrap_or_else(|| "unknown".into()));
    if packaged.is_some() {
        return;
    }
    if let Some(head) = git(&["rev-parse", "--git-path", "logs/HEAD"]) {
        println!("cargo:rerun-if-changed={head}");
    }
}
