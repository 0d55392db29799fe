//! What the records were made with: in a file beside the page.

use std::collections::BTreeSet;

use crate::document::{Block, File};
use crate::numbers::plural;

/// The line that begins the settings of a method on a task.
const OF: &str = "# ";

/// The file beside the page.
pub(super) const FILE: &str = "settings.toml";

/// Version, commit and instructions of the `settings` of a digest, as far as they say.
pub(super) fn origin(settings: &str) -> Option<String> {
    let value = |name: &str| {
        let line = common(settings).lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(" = "))?;
        Some(line.trim_matches('"').to_owned())
    };
    let commit = value("commit")?;
    let version = value("version").map_or_else(String::new, |version| format!("sindyna {version}, "));
    let isa = value("isa").map_or_else(String::new, |isa| format!(", instructions {isa}"));
    Some(format!("The records were made by {version}commit {commit}{isa}."))
}

/// Episodes of a check on the way, `100 episodes`, if the `settings` of a digest say so and alike for all methods.
pub(super) fn check_episodes(settings: &str) -> Option<String> {
    let sections = settings.split("\n[").filter(|section| section.starts_with("schedule.checks]"));
    let counts = sections.filter_map(|section| {
        let text = section.lines().find_map(|line| line.strip_prefix("episodes = "))?;
        text.parse::<usize>().ok()
    });
    let counts: BTreeSet<usize> = counts.collect();
    counts.first().filter(|_| counts.len() == 1).map(|count| plural(*count, "episode"))
}

/// What all runs have in common.
fn common(settings: &str) -> &str {
    settings.split("\n\n").next().unwrap_or(settings)
}

/// A link to the settings.
pub(super) fn block(settings: &str) -> Block {
    Block::File(File {
        name: FILE.into(),
        text: "Version, commit and instructions of all runs, and the settings of each method on each task, are in "
            .into(),
        contents: document(settings),
    })
}

/// The `settings` of a digest, documents one after another, as one document: a table for each method and task.
fn document(settings: &str) -> String {
    let (mut text, mut of) = (String::new(), None);
    for line in settings.lines() {
        let bare = line.strip_prefix('[').and_then(|line| line.strip_suffix(']'));
        if let Some((method, task)) = line.strip_prefix(OF).and_then(|line| line.split_once(" on ")) {
            let table = format!("\"{method}\".\"{task}\"");
            text += &format!("[{table}]\n");
            of = Some(table);
        } else if let (Some(name), Some(of)) = (bare.filter(|name| !name.starts_with('[')), &of) {
            text += &format!("[{of}.{name}]\n");
        } else if let (Some(name), Some(of)) = (bare.and_then(|n| n.strip_prefix('[')?.strip_suffix(']')), &of) {
            text += &format!("[[{of}.{name}]]\n");
        } else {
            text += &format!("{line}\n");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETTINGS: &str = "version = \"0.1.0\"\ncommit = \"abc\"\nisa = \"avx2\"\n\n# sindy on cart-pole\nseed = 0\n\n[sac]\nhidden = [64, 64]\n\n\
                            # sac on pendulum+noise-0.01\nseed = 0\n[sac]\nhidden = [32]\n";

    #[test]
    fn who_made_the_records_is_told() {
        let told = origin(SETTINGS).expect("they say so");
        assert_eq!(told, "The records were made by sindyna 0.1.0, commit abc, instructions avx2.");
        assert_eq!(origin("seed = 0\n"), None);
    }

    #[test]
    fn episodes_of_a_check_are_those_of_the_settings() {
        let of = |counts: [usize; 2]| {
            let section = |n: &usize| format!("# sac on cart-pole\n[schedule.checks]\nevery = 250\nepisodes = {n}\n\n");
            check_episodes(&counts.iter().map(section).collect::<String>())
        };
        assert_eq!(of([10, 10]).as_deref(), Some("10 episodes"));
        assert_eq!((of([10, 100]), check_episodes(SETTINGS)), (None, None));
    }

    #[test]
    fn settings_of_all_methods_are_one_document() {
        let parsed: toml::Table = document(SETTINGS).parse().expect("it is a TOML document");
        assert_eq!(parsed["commit"].as_str(), Some("abc"));
        assert_eq!(parsed["sindy"]["cart-pole"]["sac"]["hidden"].as_array().map(Vec::len), Some(2));
        assert_eq!(parsed["sac"]["pendulum+noise-0.01"]["sac"]["hidden"].as_array().map(Vec::len), Some(1));
    }
}
