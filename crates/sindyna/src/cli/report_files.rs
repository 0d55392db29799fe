//! Files of the report on a comparison.

use std::fs;
use std::path::Path;

use anyhow::Context as _;
use sindyna_record::{Own, json, save};
use sindyna_report::{Comparison, Page};

use crate::cli::failure::Failure;

/// Where the digest of a comparison lies in its directory.
pub(crate) const DIGEST: &str = "digest";

/// Writes summary, table, page and figures into `directory`.
pub(crate) fn write(comparison: &Comparison<'_>, directory: &Path) -> Result<(), Failure> {
    let page = comparison.report();
    save(&directory.join("summary.json"), &json(&comparison.groups())?)?;
    save(&directory.join("table.md"), comparison.steps_table().markdown("figures").as_bytes())?;
    draw(&page, &directory.join("figures"), Pixels::Too)?;
    beside(&page, directory)?;
    Ok(save(&directory.join("report.html"), page.html().as_bytes())?)
}

/// Writes the report on the records in `source` as Markdown to the file `path`, and its figures into a folder of that name beside it.
pub(crate) fn write_markdown(comparison: &Comparison<'_>, source: &Path, path: &Path) -> Result<(), Failure> {
    let page = comparison.report();
    let folder = path.with_extension("");
    let name = folder.file_name().and_then(|name| name.to_str()).filter(|_| folder != path);
    let name = name.ok_or_else(|| Failure::new(format!("{} is no name of a Markdown file", path.display())))?;
    let (own, refused) = (Own { path, what: "a report" }, |e| Failure::of_own(e, "--markdown"));
    own.check(page.markdown_heading().as_bytes()).map_err(refused)?;
    if !path.exists() && fs::read_dir(&folder).is_ok_and(|mut entries| entries.next().is_some()) {
        return Err(Failure::new(format!(
            "the figures would be written to {}, which holds other files",
            folder.display()
        ))
        .hint("name another file with --markdown"));
    }
    draw(&page, &folder, Pixels::No)?;
    beside(&page, &folder)?;
    let command = format!("Made by `sindyna report {} --markdown {}`.", quoted(source), quoted(path));
    own.save(page.with_closing(command).markdown(name).as_bytes()).map_err(refused)
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

/// Writes the files that `page` has links to into `folder`.
fn beside(page: &Page, folder: &Path) -> Result<(), Failure> {
    Ok(page.files().try_for_each(|(name, contents)| save(&folder.join(name), contents.as_bytes()))?)
}

/// Writes every figure of `page` into `folder`.
fn draw(page: &Page, folder: &Path, pixels: Pixels) -> Result<(), Failure> {
    fs::create_dir_all(folder).with_context(|| format!("cannot make the directory {}", folder.display()))?;
    for figure in page.figures() {
        save(&folder.join(format!("{}.svg", figure.name)), figure.svg().as_bytes())?;
        #[cfg(feature = "png")]
        if pixels == Pixels::Too {
            save(&folder.join(format!("{}.png", figure.name)), &figure.png()?)?;
        }
    }
    let _ = pixels;
    Ok(())
}
