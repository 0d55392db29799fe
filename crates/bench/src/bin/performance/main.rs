//! Writes docs/performance.md and docs/best-subset.md of the result files that programs here leave.
//!
//! A section whose file is missing is left out.

mod best_subset;
mod ours;
mod peers;
mod section;

use sindyna_bench::study::{Page, Result, command, root};
use sindyna_record::save;

fn main() -> Result {
    let (findings, sections): (Vec<_>, Vec<_>) = [
        peers::whole_job()?,
        peers::updates()?,
        peers::ensemble()?,
        peers::model_steps()?,
        ours::parts()?,
        ours::solved()?,
        ours::growth()?,
        ours::footprint()?,
    ]
    .into_iter()
    .flatten()
    .map(|section| (section.findings, section.body))
    .unzip();
    let page = Page::new("Performance").list(findings.into_iter().flatten());
    let page = sections.into_iter().fold(page, |page, body| page.text(body.markdown().trim()));
    let page = page.section("How it was measured").text(&format!(
        "Every table is of one run in which all that is compared took turns; medians, with the least and the largest of the repeats. The machine was shared with other work, so \
         only ratios are meaningful. Each table has its command, and the commit and the day of its figures; `scripts/peers_install` installs the peers. Made by `{}` of the files in \
         `results/`.",
        command()
    ));
    save(&root().join("docs/performance.md"), page.markdown().as_bytes())?;
    Ok(save(&root().join("docs/best-subset.md"), best_subset::page()?.as_bytes())?)
}
