//! Names of lines: at their right ends, one below the other where the ends meet, or in a list.

use std::fmt::Write as _;

use crate::escape::escaped;

/// A name, and where its line ends.
pub(super) struct Name<'a> {
    pub(super) y: f64,
    pub(super) class: String,
    pub(super) text: &'a str,
}

/// Height of a line of text, in units of the drawing.
const LEADING: f64 = 16.0;

/// Writes the names between `top` and `bottom`, right of lines that end at `x`, each with a stroke to its line.
pub(super) fn draw(text: &mut String, mut names: Vec<Name<'_>>, x: f64, (top, bottom): (f64, f64)) {
    names.sort_by(|a, b| a.y.total_cmp(&b.y));
    let places = spread(&names.iter().map(|name| name.y).collect::<Vec<_>>(), top, bottom);
    for (name, place) in names.iter().zip(places) {
        let (class, y) = (&name.class, name.y);
        let _ = writeln!(
            text,
            r#"<polyline class="{class} leader" points="{:.1},{y:.1} {:.1},{place:.1}"/>"#,
            x + 2.0,
            x + 12.0
        );
        let _ = writeln!(
            text,
            r#"<text class="{class} name" x="{:.1}" y="{:.1}">{}</text>"#,
            x + 15.0,
            place + 4.5,
            escaped(name.text)
        );
    }
}

/// Lists names, each with a piece of its line, right of `x` and from `top` down.
pub(super) fn legend(text: &mut String, entries: &[(String, &str)], x: f64, top: f64) {
    for (i, (class, name)) in entries.iter().enumerate() {
        let name = escaped(name);
        let y = top + (i as f64 + 0.5) * LEADING;
        let _ = writeln!(
            text,
            r#"<polyline class="{class} curve" points="{:.1},{y:.1} {:.1},{y:.1}"/>"#,
            x + 2.0,
            x + 12.0
        );
        let _ = writeln!(text, r#"<text class="{class} name" x="{:.1}" y="{:.1}">{name}</text>"#, x + 15.0, y + 4.5);
    }
}

/// Places near ascending `wanted` ones, at least [`LEADING`] apart, between `top` and `bottom` as long as there is room.
fn spread(wanted: &[f64], top: f64, bottom: f64) -> Vec<f64> {
    let mut places: Vec<f64> = Vec::with_capacity(wanted.len());
    for &y in wanted {
        places.push(places.last().map_or(top, |above| above + LEADING).max(y));
    }
    let mut below = bottom;
    for place in places.iter_mut().rev() {
        *place = place.min(below);
        below = *place - LEADING;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_text_whatever_they_hold() {
        let (mut text, name) = (String::new(), "<script>&");
        draw(&mut text, vec![Name { y: 1.0, class: "c0".into(), text: name }], 0.0, (0.0, 9.0));
        legend(&mut text, &[("c0".into(), name)], 0.0, 0.0);
        assert_eq!((text.matches("&lt;script&gt;&amp;").count(), text.matches("<script>").count()), (2, 0), "{text}");
    }

    #[test]
    fn names_keep_their_distance_and_their_order() {
        assert_eq!(spread(&[10.0, 100.0], 0.0, 200.0), [10.0, 100.0], "where there is room nothing moves");
        assert_eq!(spread(&[10.0, 10.0, 12.0], 0.0, 200.0), [10.0, 26.0, 42.0]);
        assert_eq!(spread(&[198.0, 199.0, 200.0], 0.0, 200.0), [168.0, 184.0, 200.0]);
    }
}
