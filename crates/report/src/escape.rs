//! Text as HTML and SVG hold it.

/// `text` with the characters replaced that mean something there.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
