//! `sindyna doctor`: what this installation can do.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde::Serialize;
use sindyna_mujoco::{Library, Place, Search};
use sindyna_rl::Isa;

use super::answer::{Answer, Verdict};
use super::machine;
use crate::cli::failure::Failure;

/// Check this installation: vector instructions, MuJoCo, write access
///
/// Exits with code 1 if something that runs need is broken. MuJoCo is needed by task files with an MJCF model only, the Python package by
/// nothing.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Directory in which runs are to be written
    #[arg(value_name = "DIR", default_value = ".")]
    directory: PathBuf,
}

/// One thing that was looked at.
#[derive(Debug, Serialize)]
struct Check {
    name: &'static str,
    state: State,
    detail: String,
}

/// How it was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum State {
    Ok,
    /// Not there, and not needed by most.
    Missing,
    Broken,
}

pub(crate) fn run(args: &Args) -> Result<Answer, Failure> {
    let checks = [program(), machine(), instructions(), writing(&args.directory), mujoco()];
    let width = checks.iter().map(|check| check.name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for Check { name, state, detail } in &checks {
        let mark = match state {
            State::Ok => "ok",
            State::Missing => "missing",
            State::Broken => "BROKEN",
        };
        let detail = detail.replace('\n', &format!("\n{:1$}", "", width + 11));
        let _ = writeln!(text, "{name:width$}  {mark:7}  {detail}");
    }
    let broken = checks.iter().any(|check| check.state == State::Broken);
    let verdict = if broken { Verdict::MissedTarget } else { Verdict::Done };
    Answer::new(verdict, text, &serde_json::json!({"broken": broken, "checks": checks}))
}

fn ok(name: &'static str, detail: String) -> Check {
    Check { name, state: State::Ok, detail }
}

fn program() -> Check {
    let (version, commit) = (env!("CARGO_PKG_VERSION"), sindyna_training::COMMIT);
    ok("sindyna", format!("{version}, commit {commit}, {}-{}", std::env::consts::ARCH, std::env::consts::OS))
}

fn machine() -> Check {
    ok("processor", machine::describe())
}

/// Which instructions updates of networks use.
fn instructions() -> Check {
    let known: Vec<&str> = Isa::ALL.into_iter().filter_map(|isa| isa.checked().ok()).map(Isa::name).collect();
    ok("instructions", format!("{}; updates use {}", known.join(", "), Isa::widest().name()))
}

/// Whether files can be written, and renamed, in `directory`.
fn writing(directory: &Path) -> Check {
    let name = "write access";
    let tried = tempfile::tempdir_in(directory).and_then(|temp| {
        std::fs::write(temp.path().join("a"), b"a")
            .and_then(|()| std::fs::rename(temp.path().join("a"), temp.path().join("b")))
    });
    match tried {
        Ok(()) => ok(name, format!("files can be written in {}", directory.display())),
        Err(e) => Check {
            name,
            state: State::Broken,
            detail: format!("no file can be written in {}: {}", directory.display(), sindyna_record::cause(e)),
        },
    }
}

/// Whether there is a MuJoCo that can be used; only what was named for certain and does not work is broken.
fn mujoco() -> Check {
    let name = "MuJoCo";
    let search = Search::from_environment();
    match Library::load(&search) {
        Ok(library) => ok(name, format!("{} at {}", library.version(), library.file().display())),
        Err(e) => {
            let named = matches!(search.places(), [Place::File(_)]);
            let state = if named { State::Broken } else { State::Missing };
            Check { name, state, detail: e.to_string() }
        }
    }
}
