//! A report as Markdown, with its figures in files beside it.

use std::fmt::Write as _;

use super::document::{Block, File};

/// The report called `title`; `folder` is where its figures lie, as seen from the file.
pub(crate) fn markdown(title: &str, blocks: &[Block], folder: &str) -> String {
    let mut text = format!("# {title}\n");
    for block in blocks {
        text.push('\n');
        match block {
            Block::Section(name) => text += &format!("## {name}\n"),
            Block::Part(name) => text += &format!("### {name}\n"),
            Block::Text(paragraph) => text += &format!("{paragraph}\n"),
            Block::Verdict { text: verdict, .. } => text += &format!("**{verdict}**\n"),
            Block::Markup { text: plain, .. } => text += &format!("```text\n{}\n```\n", plain.trim_end()),
            Block::Table { words, head, rows } => table(&mut text, *words, head, rows),
            Block::Figures(figures) => {
                // A blank would end the address.
                let folder = folder.replace(' ', "%20");
                for figure in figures {
                    let _ = writeln!(text, "![{}]({folder}/{}.svg)", figure.alternative, figure.name);
                }
            }
            Block::List(lines) => lines.iter().for_each(|line| text += &format!("- {line}\n")),
            Block::File(File { name, text: before, .. }) => {
                let _ = writeln!(text, "{before}[{name}]({}/{name}).", folder.replace(' ', "%20"));
            }
            Block::Code(code) => text += &format!("```text\n{}\n```\n", code.trim_end()),
        }
    }
    text
}

fn table(text: &mut String, words: usize, head: &[String], rows: &[Vec<String>]) {
    let line = |cells: &[String]| {
        format!("| {} |", cells.iter().map(|c| c.replace('|', "\\|")).collect::<Vec<_>>().join(" | "))
    };
    let rule = (0..head.len()).map(|i| if i < words { "---|" } else { "---:|" }).collect::<String>();
    let _ = writeln!(text, "{}\n|{rule}", line(head));
    for row in rows {
        let _ = writeln!(text, "{}", line(row));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_on_the_right_and_bars_are_kept_apart() {
        let blocks = [Block::Section("Steps".into()), Block::table(1, ["task", "a|b"], vec![["x".into(), "1".into()]])];
        let text = markdown("Title", &blocks, "figures");
        assert_eq!(text, "# Title\n\n## Steps\n\n| task | a\\|b |\n|---|---:|\n| x | 1 |\n");
    }
}
