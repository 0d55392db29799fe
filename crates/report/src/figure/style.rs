//! Colours and strokes of drawings, on pages and in files.

use std::fmt::Write as _;

use super::frame::{HEIGHT, WIDTH};
use crate::Catalog;
use crate::escape::escaped;
use crate::names::method_name;

/// Methods that have a colour of their own; variants take those of methods that are seldom beside them.
pub const METHOD_COLOURS: usize = METHODS.len();

/// Colours of the methods in their usual order, on light and on dark ground: each at least 4.5 : 1 against it.
const METHODS: [(&str, &str); 13] = [
    ("#0b5fa5", "#5cb3f0"),
    ("#9c2f2f", "#f09090"),
    ("#2f7d0b", "#8fd46a"),
    ("#00707a", "#4cc8d4"),
    ("#b0480a", "#ff9a5c"),
    ("#7d6400", "#e3c24a"),
    ("#06785a", "#41cfa0"),
    ("#a3338a", "#ee93d5"),
    ("#2b2b2b", "#e8e8e8"),
    ("#8b2fc9", "#cf9bf5"),
    ("#5b4fc4", "#aaa1ff"),
    ("#7a4a2a", "#d6ae8c"),
    ("#6a6a6a", "#a9a9a9"),
];

/// Ink, paper, grid, soft ink.
const INKS: [(&str, &str, &str); 4] = [
    ("ink", "#1b1b1b", "#ececec"),
    ("paper", "#ffffff", "#161616"),
    ("faint", "#dedede", "#383838"),
    ("soft", "#5f5f5f", "#a9a9a9"),
];

/// Strokes and fills that do not depend on the method.
const SHAPES: [(&str, &str); 15] = [
    (".grid", "stroke: VAR(faint); stroke-width: 1"),
    (".mark", "stroke: VAR(soft); stroke-width: 1.2; stroke-dasharray: 2 4"),
    (".curve", "fill: none; stroke-width: 2.2; stroke-linejoin: round"),
    (".level", "stroke-width: 1.6; stroke-dasharray: 7 4"),
    (".band", "opacity: .16; stroke: none"),
    (".leader", "fill: none; stroke-width: 1; opacity: .6"),
    (".truth", "fill: none; stroke: VAR(faint); stroke-width: 6; stroke-linejoin: round; stroke-linecap: round"),
    (".model", "fill: none; stroke-width: 1.6; stroke-linejoin: round"),
    (".middle", "text-anchor: middle"),
    (".end", "text-anchor: end"),
    (".name", "stroke: none; font-weight: 600"),
    (".ring", "fill: none; stroke-width: 2.4"),
    ("circle.ring", "fill: none"),
    (".tick", "stroke-width: 2"),
    (".seeds", "fill: none; stroke-width: 5; stroke-linecap: round"),
];

/// Those of figures that are only on pages.
const PAGE_SHAPES: [(&str, &str); 5] = [
    (
        ".measured",
        "fill: none; stroke: VAR(soft); opacity: .4; stroke-width: 5; stroke-linejoin: round; stroke-linecap: round",
    ),
    (".dots", "fill: none; stroke-width: 3; stroke-linecap: round; opacity: .65"),
    (".bar", "stroke: none; opacity: .5"),
    ("rect.ring", "fill: none"),
    (".solid", "fill: none; stroke: VAR(ink); stroke-width: 3; stroke-linecap: round; stroke-linejoin: round"),
];

/// The class whose colour is that of the method called `name`, in every drawing.
pub(crate) fn colour(catalog: &dyn Catalog, name: &str) -> String {
    let (last, name) = (METHOD_COLOURS - 1, method_name(name));
    let place = catalog.methods().iter().position(|method| method_name(method) == name).unwrap_or(last);
    format!("c{}", place.checked_sub(METHOD_COLOURS).map_or(place, |variant| 1 + variant % (last - 1)))
}

/// The rules of drawings on a page, whose colours are variables that follow the reader's wish for light or dark.
pub(crate) fn page_style() -> String {
    let variables = |of: &dyn Fn(&(&str, &str)) -> String, inks: &dyn Fn(&(&str, &str, &str)) -> String| {
        let methods = METHODS.iter().enumerate().map(|(i, pair)| format!("--c{i}: {};", of(pair)));
        let inks = INKS.iter().map(|ink| format!("--{}: {};", ink.0, inks(ink)));
        inks.chain(methods).collect::<Vec<_>>().join(" ")
    };
    let light = variables(&|pair| pair.0.into(), &|ink| ink.1.into());
    let dark = variables(&|pair| pair.1.into(), &|ink| ink.2.into());
    format!(
        ":root {{ color-scheme: light dark; {light} }}\n@media (prefers-color-scheme: dark) {{ :root {{ {dark} }} }}\n{}",
        rules("svg ", &|name| format!("var(--{name})"), &PAGE_SHAPES)
    )
}

/// The drawing as a file of its own: dark on white, whatever the reader prefers.
pub(crate) fn standalone(alternative: &str, elements: &str) -> String {
    let light = |name: &str| {
        let ink = INKS.iter().find(|ink| ink.0 == name).map(|ink| ink.1);
        let method = || METHODS.get(name.strip_prefix('c')?.parse::<usize>().ok()?).map(|pair| pair.0);
        ink.or_else(method).unwrap_or("black").to_owned()
    };
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" height=\"{HEIGHT}\">\n\
         <title>{}</title>\n<style>\n{}</style>\n<rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"{}\"/>\n{}</svg>\n",
        escaped(alternative),
        rules("", &light, &[]),
        light("paper"),
        elements
    )
}

/// All rules and those for `more`, of elements below `scope`, with the colours that `colour` has for their names.
fn rules(scope: &str, colour: &dyn Fn(&str) -> String, more: &[(&str, &str)]) -> String {
    let mut text =
        format!("{scope}text {{ font: 13px system-ui, 'DejaVu Sans', sans-serif; fill: {}; }}\n", colour("soft"));
    for i in 0..METHODS.len() {
        let paint = colour(&format!("c{i}"));
        let _ = writeln!(text, "{scope}.c{i} {{ stroke: {paint}; }}");
        for filled in ["polygon", "circle", "text"] {
            let _ = writeln!(text, "{scope}{filled}.c{i} {{ fill: {paint}; }}");
        }
    }
    for (selector, declarations) in SHAPES.iter().chain(more) {
        let mut declarations = (*declarations).to_owned();
        for (name, _, _) in INKS {
            declarations = declarations.replace(&format!("VAR({name})"), &colour(name));
        }
        let _ = writeln!(text, "{scope}{selector} {{ {declarations}; }}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Contrast of two colours (Web Content Accessibility Guidelines 2.1).
    fn contrast(a: &str, b: &str) -> f64 {
        let luminance = |colour: &str| {
            let channel = |at: usize| {
                let value = f64::from(u8::from_str_radix(&colour[at..at + 2], 16).expect("a number")) / 255.0;
                if value <= 0.03928 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
            };
            0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5)
        };
        let (a, b) = (luminance(a) + 0.05, luminance(b) + 0.05);
        a.max(b) / a.min(b)
    }

    #[test]
    fn every_name_can_be_read_on_its_ground() {
        let (_, white, black) = INKS[1];
        for (i, (light, dark)) in METHODS.iter().enumerate() {
            assert!(contrast(light, white) >= 4.5, "c{i} on light: {}", contrast(light, white));
            assert!(contrast(dark, black) >= 4.5, "c{i} on dark: {}", contrast(dark, black));
        }
        for (name, light, dark) in [INKS[0], INKS[3]] {
            assert!(contrast(light, white) >= 4.5 && contrast(dark, black) >= 4.5, "{name}");
        }
    }

    #[test]
    fn a_file_of_its_own_needs_no_page() {
        let elements = "<text class=\"c0 name\" x=\"1\" y=\"2\">sindy</text>\n".to_owned();
        let text = standalone("a < b", &elements);
        assert!(text.contains("text.c0 { fill: #0b5fa5; }") && text.contains("a &lt; b"), "{text}");
        assert!(!text.contains("var(") && !text.contains("VAR("), "{text}");
        assert!(page_style().contains("svg .c8 { stroke: var(--c8); }"));
    }
}
