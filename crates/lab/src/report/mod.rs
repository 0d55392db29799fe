//! What a comparison comes to: statistics, figures and pages, all of them functions of its [`Digest`].

mod content;
mod curve;
mod digest;
mod document;
mod equations;
mod figure;
mod gather;
mod groups;
mod html;
mod markdown;
mod paper;
mod portrait;
mod scores;
mod shown;
mod stats;

pub(crate) use content::gaps;
pub(crate) use digest::Digest;
pub(crate) use gather::gather;
pub(crate) use groups::{Group, groups};
pub(crate) use shown::{fixed, plural};

use std::fs;
use std::path::Path;

use anyhow::Context as _;

use crate::failure::Failure;
use crate::record::{Own, json, save};
use document::{Block, figures};

const TITLE: &str = "How many real steps each method needs";

/// Where the digest of a comparison lies in its directory.
pub(crate) const DIGEST: &str = "digest";

/// Writes summary, table, page and figures into `directory`.
pub(crate) fn write(digest: &Digest, groups: &[Group], directory: &Path) -> Result<(), Failure> {
    let blocks = content::blocks(digest, groups);
    save(&directory.join("summary.json"), &json(&groups)?)?;
    let mut table = content::speed_ups(groups);
    table.extend(gaps(digest).map(Block::Text));
    save(&directory.join("table.md"), markdown::markdown(TITLE, &table, "figures").as_bytes())?;
    draw(&blocks, &directory.join("figures"), Pixels::Too)?;
    save(&directory.join("report.html"), html::page(TITLE, &blocks).as_bytes())
}

/// Writes the report on the digest in `source` as Markdown to the file `path`, and its figures into a folder of that name beside it.
pub(crate) fn write_markdown(digest: &Digest, groups: &[Group], source: &Path, path: &Path) -> Result<(), Failure> {
    let folder = path.with_extension("");
    let name = folder.file_name().and_then(|name| name.to_str()).filter(|_| folder != path);
    let name = name.ok_or_else(|| Failure::new(format!("{} is no name of a Markdown file", path.display())))?;
    let own = Own { path, what: "report", option: "--markdown" };
    own.check(format!("# {TITLE}\n").as_bytes())?;
    if !path.exists() && fs::read_dir(&folder).is_ok_and(|mut entries| entries.next().is_some()) {
        return Err(Failure::new(format!("the figures would go to {}, which holds something else", folder.display()))
            .hint("name another file with --markdown"));
    }
    let command = format!("Made by `sindyna report {} --markdown {}`.", quoted(source), quoted(path));
    let mut blocks = vec![Block::text(command)];
    blocks.extend(content::blocks(digest, groups));
    draw(&blocks, &folder, Pixels::No)?;
    own.save(markdown::markdown(TITLE, &blocks, name).as_bytes())
}

/// A path as a shell takes it.
fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    if text.chars().any(char::is_whitespace) { format!("'{text}'") } else { text }
}

/// Whether figures are wanted as pixels beside the drawings.
#[derive(Clone, Copy, PartialEq)]
enum Pixels {
    Too,
    No,
}

/// Writes every figure of `blocks` into `folder`.
fn draw(blocks: &[Block], folder: &Path, pixels: Pixels) -> Result<(), Failure> {
    fs::create_dir_all(folder).with_context(|| format!("cannot make the directory {}", folder.display()))?;
    for figure in figures(blocks) {
        let svg = figure::standalone(figure);
        save(&folder.join(format!("{}.svg", figure.name)), svg.as_bytes())?;
        if pixels == Pixels::Too {
            save(&folder.join(format!("{}.png", figure.name)), &figure::png(&svg)?)?;
        }
    }
    Ok(())
}
