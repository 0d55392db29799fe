//! A report as a page: one file that needs nothing else.

use std::fmt::Write as _;

use super::document::{Block, File};
use super::figure::page_style;
use crate::escape::escaped;

/// The report called `title`.
pub(crate) fn page(title: &str, blocks: &[Block]) -> String {
    let title = escaped(title);
    let mut text = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
         <link rel=\"icon\" href=\"data:,\">\n<style>\n{}{STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n",
        page_style()
    );
    let mut open = false;
    for block in blocks {
        match block {
            Block::Section(name) => {
                text += if open { "</section>\n" } else { "" };
                let _ = writeln!(text, "<section>\n<h2>{}</h2>", escaped(name));
                open = true;
            }
            Block::Part(name) => text += &format!("<h3>{}</h3>\n", escaped(name)),
            Block::Text(paragraph) => text += &format!("<p>{}</p>\n", with_code(&escaped(paragraph))),
            Block::Verdict { good, text: verdict } => {
                let class = match good {
                    Some(true) => "good",
                    Some(false) => "bad",
                    None => "open",
                };
                let _ = writeln!(text, "<p class=\"verdict {class}\">{}</p>", escaped(verdict));
            }
            Block::Markup { html, .. } => text += html,
            Block::Table { words, head, rows } => table(&mut text, *words, head, rows),
            Block::Figures(figures) => {
                text += "<div class=\"figures\">\n";
                for figure in figures {
                    let _ = writeln!(
                        text,
                        "<figure>\n{}<figcaption>{}</figcaption>\n</figure>",
                        figure.inline(),
                        escaped(&figure.caption)
                    );
                }
                text += "</div>\n";
            }
            Block::List(lines) => {
                let items = lines.iter().map(|line| format!("<li>{}</li>\n", with_code(&escaped(line))));
                text += &format!("<ul>\n{}</ul>\n", items.collect::<String>());
            }
            Block::File(File { name, text: before, .. }) => {
                let (name, before) = (escaped(name), escaped(before));
                text += &format!("<p>{before}<a href=\"{name}\">{name}</a>.</p>\n");
            }
            Block::Code(code) => text += &format!("<pre tabindex=\"0\">{}</pre>\n", escaped(code.trim_end())),
        }
    }
    text + if open { "</section>\n" } else { "" } + "</main>\n</body>\n</html>\n"
}

fn table(text: &mut String, words: usize, head: &[String], rows: &[Vec<String>]) {
    let class = |i: usize| if i < words { " class=\"word\"" } else { "" };
    // What is too wide for a phone is moved under its frame, which the keyboard reaches too.
    text.push_str("<div class=\"scroll\" tabindex=\"0\"><table>\n<thead><tr>");
    for (i, cell) in head.iter().enumerate() {
        let _ = write!(text, "<th scope=\"col\"{}>{}</th>", class(i), escaped(cell));
    }
    text.push_str("</tr></thead>\n<tbody>\n");
    for (row, before) in rows.iter().zip(std::iter::once(None).chain(rows.iter().map(Some))) {
        // A new task is set apart, and named once.
        let same = |i: usize| i == 0 && words > 1 && before.is_some_and(|before| before[0] == row[0]);
        text.push_str(if words > 1 && before.is_some() && !same(0) { "<tr class=\"next\">" } else { "<tr>" });
        for (i, cell) in row.iter().enumerate() {
            let cell = if same(i) { String::new() } else { escaped(cell) };
            let _ = write!(text, "<td{}>{cell}</td>", class(i));
        }
        text.push_str("</tr>\n");
    }
    text.push_str("</tbody>\n</table></div>\n");
}

/// What stands between backticks, as code.
fn with_code(text: &str) -> String {
    let mut parts = text.split('`');
    let mut found = parts.next().unwrap_or("").to_owned();
    while let (Some(code), rest) = (parts.next(), parts.next()) {
        found += &format!("<code>{code}</code>{}", rest.unwrap_or(""));
    }
    found
}

const STYLE: &str = "\
body { margin: 0; background: var(--paper); color: var(--ink); font: 16px/1.5 system-ui, sans-serif; }
main { max-width: 66rem; margin: 0 auto; padding: 1rem; }
h1 { font-size: 1.6rem; line-height: 1.25; } h2 { font-size: 1.25rem; margin: 2.5rem 0 .5rem; } h3 { font-size: 1rem; margin: 1.5rem 0 .3rem; }
p { max-width: 44rem; overflow-wrap: anywhere; }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 24rem), 1fr)); gap: 1.5rem 2rem; margin: 1rem 0; }
figure { margin: 0; max-width: 34rem; } figure > svg { display: block; width: 100%; height: auto; }
figcaption { color: var(--soft); font-size: .85rem; }
@media (max-width: 30rem) { svg text { font-size: 14.5px; } }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: .9rem; }
th, td { padding: .25rem 0 .25rem 1.1rem; text-align: right; border-bottom: 1px solid var(--faint); white-space: nowrap; }
th { color: var(--soft); font-weight: 400; vertical-align: bottom; white-space: normal; min-width: 4rem; }
.word { text-align: left; } th:first-child, td:first-child { padding-left: 0; min-width: 0; }
tr.next td { border-top: 2px solid var(--soft); }
li { max-width: 44rem; margin: .3rem 0; overflow-wrap: anywhere; } a { color: var(--c0); }
.verdict { font-size: 1.1rem; font-weight: 600; padding-left: .8rem; border-left: .35rem solid var(--soft); }
.verdict.good { border-color: var(--c2); } .verdict.bad { border-color: var(--c4); }
.equation { max-width: none; margin: .4rem 0; overflow-wrap: normal; font-size: 1.15rem; line-height: 2.2; padding-left: 2rem; text-indent: -2rem; }
.equation math { margin-right: .15em; text-indent: 0; }
.controls { display: flex; gap: .8rem; max-width: 30rem; } .controls input { flex: 1; min-width: 0; }
pre { overflow-x: auto; white-space: pre-wrap; padding: .6rem; border: 1px solid var(--faint); border-radius: 4px; font: .9rem/1.6 system-ui, sans-serif; }
";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_needs_nothing_but_itself_and_closes_what_it_opens() {
        let blocks = [
            Block::Section("Equations".into()),
            Block::Code("a < b & c".into()),
            Block::text("runs of `random` and `hand`."),
            Block::Section("Steps".into()),
            Block::table(
                2,
                ["task", "method", "steps"],
                vec![["t", "m", "1"].map(String::from), ["t", "n", "2"].map(String::from)],
            ),
        ];
        let text = page("Title", &blocks);
        assert!(
            text.contains("a &lt; b &amp; c") && text.contains("<td class=\"word\"></td><td class=\"word\">n</td>")
        );
        assert!(text.contains("<p>runs of <code>random</code> and <code>hand</code>.</p>"));
        for tag in ["section", "table", "pre", "div", "main", "html"] {
            let (open, close) = (text.matches(&format!("<{tag}")).count(), text.matches(&format!("</{tag}>")).count());
            assert_eq!(open, close, "{tag}");
        }
        assert!(!text.contains("http") && !text.contains("src="));
    }
}
