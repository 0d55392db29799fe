//! A comparison as a page to look at: one file that needs nothing else.

use std::fmt::Write as _;

use super::chart::{Line, svg};
use super::curve::curve;
use super::method::is_anchor;
use super::{Group, Outcome};

/// The page of `outcomes`, whose `groups` are their numbers; `marks` are the returns that solve the tasks.
pub(crate) fn page(outcomes: &[Outcome], groups: &[Group], marks: &[(String, Option<f64>)], settings: &str) -> String {
    let mut text = String::from(HEAD);
    for (task, mark) in marks {
        let _ = writeln!(text, "<section>\n<h2>{}</h2>", escaped(task));
        text += &svg(&escaped(task), &lines(outcomes, groups, task), *mark);
        text += &table(groups, task);
        text += &equations(outcomes, task);
        text += "</section>\n";
    }
    let _ = write!(
        text,
        "<section>\n<h2>Settings</h2>\n<pre>{}</pre>\n</section>\n</main>\n</body>\n</html>\n",
        escaped(settings)
    );
    text
}

/// The methods on `task`: those that were looked at on the way as curves, the others as levels.
fn lines(outcomes: &[Outcome], groups: &[Group], task: &str) -> Vec<Line> {
    let line = |group: &Group| {
        let runs: Vec<&Outcome> = outcomes.iter().filter(|o| o.task == task && o.method == group.method).collect();
        let points = if is_anchor(&group.method) { Vec::new() } else { curve(&runs) };
        let level = if points.is_empty() { group.mean_return } else { None };
        Line { name: group.method.clone(), points, level }
    };
    groups.iter().filter(|g| g.task == task).map(line).collect()
}

fn table(groups: &[Group], task: &str) -> String {
    let mut text = String::from(
        "<div class=\"scroll\"><table>\n<thead><tr><th>method</th><th>solved</th><th>real steps until solved</th><th>least – most</th>\
         <th>over sindy</th><th>return</th><th>lowest</th><th>parameters</th></tr></thead>\n<tbody>\n",
    );
    let ours = groups.iter().find(|g| g.task == task && g.method == "sindy").and_then(|g| g.steps_median);
    for group in groups.iter().filter(|g| g.task == task) {
        let anchor = is_anchor(&group.method);
        let steps = if anchor { None } else { group.steps_median };
        let ratio = steps.zip(ours).map(|(steps, ours)| steps / ours);
        let range = group.steps_range.filter(|_| !anchor);
        let _ = writeln!(
            text,
            "<tr><th scope=\"row\">{}</th><td>{} of {}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            escaped(&group.method),
            group.solved,
            group.runs,
            shown(steps, 0),
            range.map_or_else(|| "–".into(), |(least, most)| format!("{least} – {most}")),
            shown(ratio, 0),
            shown(group.mean_return, 1),
            shown(group.lowest_return, 1),
            group.model_parameters.map_or_else(|| "–".into(), |p| p.to_string()),
        );
    }
    text + "</tbody>\n</table></div>\n"
}

/// The equations that the first seed found.
fn equations(outcomes: &[Outcome], task: &str) -> String {
    let found = outcomes.iter().find(|o| o.task == task && !o.equations.is_empty());
    found.map_or_else(String::new, |outcome| {
        let lines = escaped(&outcome.equations.join("\n"));
        format!("<p>Found with seed {} from {} real steps:</p>\n<pre>{lines}</pre>\n", outcome.seed, outcome.real_steps)
    })
}

fn shown(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "–".into(), |v| format!("{v:.digits$}").replace('-', "\u{2212}"))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

const HEAD: &str = r#"<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>sindyna: a comparison</title>
<style>
:root { color-scheme: light dark; --ink: #1b1b1b; --paper: #ffffff; --faint: #d9d9d9; --soft: #6b6b6b;
  --c0: #0072b2; --c1: #d55e00; --c2: #009e73; --c3: #b8860b; --c4: #cc79a7; --c5: #4b6a88; --c6: #7a7a7a; }
@media (prefers-color-scheme: dark) { :root { --ink: #ececec; --paper: #161616; --faint: #3a3a3a; --soft: #a0a0a0;
  --c0: #56b4e9; --c1: #ff8a47; --c2: #2fcfa0; --c3: #f0c04a; --c4: #e79cc4; --c5: #9bb8d3; --c6: #b0b0b0; } }
body { margin: 0; background: var(--paper); color: var(--ink); font: 16px/1.5 system-ui, sans-serif; }
main { max-width: 50rem; margin: 0 auto; padding: 1rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.2rem; margin: 2rem 0 .5rem; }
svg { width: 100%; height: auto; }
svg text { font: 12px system-ui, sans-serif; fill: var(--soft); }
.grid { stroke: var(--faint); stroke-width: 1; }
.mark { stroke: var(--soft); stroke-width: 1; stroke-dasharray: 2 4; }
.curve { fill: none; stroke-width: 2; } .level { stroke-width: 1.5; stroke-dasharray: 7 4; } .band { opacity: .18; stroke: none; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; white-space: nowrap; }
th, td { padding: .2rem .7rem .2rem 0; text-align: right; border-bottom: 1px solid var(--faint); font-weight: 400; }
thead th { color: var(--soft); } tr th:first-child { text-align: left; } tbody th { font-weight: 600; }
pre { overflow-x: auto; padding: .6rem; border: 1px solid var(--faint); border-radius: 4px; font-size: .85rem; }
.c0 { stroke: var(--c0); } .c1 { stroke: var(--c1); } .c2 { stroke: var(--c2); } .c3 { stroke: var(--c3); }
.c4 { stroke: var(--c4); } .c5 { stroke: var(--c5); } .c6 { stroke: var(--c6); }
polygon.c0, circle.c0, svg text.c0 { fill: var(--c0); } polygon.c1, circle.c1, svg text.c1 { fill: var(--c1); }
polygon.c2, circle.c2, svg text.c2 { fill: var(--c2); } polygon.c3, circle.c3, svg text.c3 { fill: var(--c3); }
polygon.c4, circle.c4, svg text.c4 { fill: var(--c4); } polygon.c5, circle.c5, svg text.c5 { fill: var(--c5); }
polygon.c6, circle.c6, svg text.c6 { fill: var(--c6); } .name { stroke: none; }
</style>
</head>
<body>
<main>
<h1>Real steps until solved</h1>
<p>Lines: median over seeds of the mean return of ten episodes; bands: the middle half of the seeds. A run that has ended keeps its
last score. Dashed: methods whose real steps say nothing. Dotted: the return that solves the task. Parameters: numbers in the model.</p>
"#;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::groups;
    use crate::compare::outcome::Point;

    #[test]
    fn a_page_needs_nothing_but_itself() {
        let run = |method: &str, steps: usize, score: f64| Outcome {
            solved_after: Some(steps),
            returns: vec![score; 4],
            curve: vec![Point { real_steps: steps, updates: 0, returns: vec![score] }],
            equations: vec!["a < b & c".into()],
            ..Outcome::new("any", method, 0)
        };
        let outcomes = [run("sindy", 10, 5.0), run("sac", 1000, 4.0), run("hand", 0, 6.0)];
        let text = page(&outcomes, &groups(&outcomes), &[("any".into(), Some(3.0))], "version = \"0\"");
        for wanted in ["<svg", "a &lt; b &amp; c", "<td>100</td>", "polyline", "class=\"mark\"", "</html>"] {
            assert!(text.contains(wanted), "{wanted} is missing");
        }
        assert!(!text.contains("href=") && !text.contains("src="));
        assert_eq!(text.matches("<section>").count(), text.matches("</section>").count());
    }
}
