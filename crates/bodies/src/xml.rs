//! Parts of XML files, read and written.

use std::ops::Range;

use nalgebra::Vector3;
use roxmltree::{Document, Node};

use crate::BodiesError;

/// A part of a file, and what to write there.
pub(crate) type Change = (Range<usize>, String);

/// Elements inside each other, at most, and links or bodies of a robot.
pub(crate) const DEEPEST: usize = 200;

/// The document in `text`, whose outermost element is `root`.
pub(crate) fn document<'a>(text: &'a str, root: &'static str) -> Result<Document<'a>, BodiesError> {
    if depth(text) > DEEPEST {
        return Err(BodiesError::Unsupported {
            what: format!("a file with more than {DEEPEST} elements inside each other"),
        });
    }
    let document = Document::parse(text).map_err(BodiesError::Xml)?;
    let got = document.root_element().tag_name().name();
    if got == root { Ok(document) } else { Err(BodiesError::Root { expected: root, got: got.to_owned() }) }
}

/// How many elements of `text` are inside each other, at most, before anything is parsed.
fn depth(text: &str) -> usize {
    let (mut rest, mut here, mut deepest) = (text, 0_usize, 0);
    while let Some(at) = rest.find('<') {
        rest = &rest[at..];
        let end = if rest.starts_with("<!--") { rest.find("-->") } else { rest.find('>') };
        let Some(end) = end else { break };
        let tag = &rest[..end];
        match tag.as_bytes().get(1) {
            Some(b'!' | b'?') => {}
            Some(b'/') => here = here.saturating_sub(1),
            _ if tag.ends_with('/') => {}
            _ => here += 1,
        }
        deepest = deepest.max(here);
        rest = &rest[end..];
    }
    deepest
}

/// The first child with the tag `tag`.
pub(crate) fn child<'a, 'i>(node: Node<'a, 'i>, tag: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|n| n.has_tag_name(tag))
}

/// The numbers in an attribute; `None` without it.
pub(crate) fn numbers<const N: usize>(
    node: Node<'_, '_>,
    what: &'static str,
    name: &str,
) -> Result<Option<[f64; N]>, BodiesError> {
    let Some(text) = node.attribute(what) else { return Ok(None) };
    let failed = || BodiesError::Number { what, name: name.to_owned(), text: text.to_owned(), expected: N };
    let all = text.split_whitespace().map(str::parse::<f64>).collect::<Result<Vec<_>, _>>().map_err(|_| failed())?;
    let all: [f64; N] = all.try_into().map_err(|_| failed())?;
    if all.iter().all(|v| v.is_finite()) { Ok(Some(all)) } else { Err(failed()) }
}

/// Three numbers in an attribute; `None` without it.
pub(crate) fn vector(node: Node<'_, '_>, what: &'static str, name: &str) -> Result<Option<Vector3<f64>>, BodiesError> {
    Ok(numbers::<3>(node, what, name)?.map(Vector3::from))
}

/// Where the child `tag` of `node` stands, or where one may be put, and what to write there.
pub(crate) fn replaced(node: Node<'_, '_>, tag: &str, text: &str) -> Change {
    if let Some(old) = child(node, tag) {
        return (old.range(), text.to_owned());
    }
    let source = &node.document().input_text()[node.range()];
    let range = node.range();
    match source.strip_suffix("/>") {
        // <link name="a"/> has no content yet.
        Some(_) if node.first_child().is_none() => {
            (range.end - 2..range.end, format!(">\n    {text}\n  </{}>", node.tag_name().name()))
        }
        _ => {
            let close = range.start + source.rfind("</").unwrap_or(source.len());
            (close..close, format!("  {text}\n  "))
        }
    }
}

/// Where the attribute `name` of `node` stands, or where one may be put, and what to write there.
pub(crate) fn with_attribute(node: Node<'_, '_>, name: &str, value: &str) -> Change {
    if let Some(attribute) = node.attributes().find(|a| a.name() == name) {
        return (attribute.range_value(), value.to_owned());
    }
    let at = node.range().start + 1 + node.tag_name().name().len();
    (at..at, format!(" {name}=\"{value}\""))
}

/// `text` with all `changes`, which do not overlap.
pub(crate) fn changed(text: &str, mut changes: Vec<Change>) -> String {
    changes.sort_by_key(|(range, _)| std::cmp::Reverse(range.start));
    let mut text = text.to_owned();
    for (range, new) in changes {
        text.replace_range(range, &new);
    }
    text
}

/// A number with ten digits.
pub(crate) fn digits(value: f64) -> String {
    format!("{:?}", format!("{value:.9e}").parse::<f64>().unwrap_or(value))
}
