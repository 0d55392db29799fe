//! Text as HTML, SVG and MathML hold it.

/// `text` with the characters replaced that mean something there, that XML cannot hold, or that turn the direction of what follows.
pub(crate) fn escaped(text: &str) -> String {
    let mut found = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => found.push_str("&amp;"),
            '<' => found.push_str("&lt;"),
            '>' => found.push_str("&gt;"),
            '"' => found.push_str("&quot;"),
            '\'' => found.push_str("&#39;"),
            '\n' | '\t' => found.push(c),
            // Marks of direction, and characters that are not allowed in XML.
            '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => {
                found.push('\u{fffd}')
            }
            '\u{fffe}' | '\u{ffff}' => found.push('\u{fffd}'),
            c if c.is_control() => found.push('\u{fffd}'),
            c => found.push(c),
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_that_means_something_is_left() {
        assert_eq!(
            escaped("<script>\"a\"&'b'</script>]]>"),
            "&lt;script&gt;&quot;a&quot;&amp;&#39;b&#39;&lt;/script&gt;]]&gt;"
        );
        assert_eq!(escaped("a\u{202e}b\u{1}c"), "a\u{fffd}b\u{fffd}c");
    }
}
