//! Literals of Python, as the headers of NumPy have them.

/// A value; tuples are lists.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Literal {
    Text(String),
    Bool(bool),
    /// `None` for one that no size can be.
    Number(Option<usize>),
    List(Vec<Literal>),
    Map(Vec<(String, Literal)>),
}

impl Literal {
    pub(super) fn text(&self) -> Option<&String> {
        if let Self::Text(text) = self { Some(text) } else { None }
    }

    /// A list of sizes.
    pub(super) fn sizes(&self) -> Option<Vec<usize>> {
        let Self::List(list) = self else { return None };
        list.iter().map(|n| if let Self::Number(n) = n { *n } else { None }).collect()
    }
}

/// Brackets within brackets that are followed.
const DEEPEST: usize = 8;

/// The value that `text` writes.
pub(super) fn parse(text: &str) -> Result<Literal, String> {
    let mut rest = text.trim_end_matches(['\0', '\n', ' ']);
    let value = value(&mut rest, DEEPEST)?;
    if rest.trim().is_empty() { Ok(value) } else { Err("its header goes on where it should end".into()) }
}

fn value(rest: &mut &str, depth: usize) -> Result<Literal, String> {
    const BAD: &str = "its header cannot be understood";
    let depth = depth.checked_sub(1).ok_or("its header is nested too deeply")?;
    *rest = rest.trim_start();
    for (word, of) in [("True", true), ("False", false)] {
        if let Some(after) = rest.strip_prefix(word) {
            *rest = after;
            return Ok(Literal::Bool(of));
        }
    }
    let first = rest.chars().next().ok_or(BAD)?;
    match first {
        '\'' | '"' => {
            let (text, after) = rest[1..].split_once(first).ok_or(BAD)?;
            // NumPy writes what needs one with an escape.
            if text.contains('\\') {
                return Err(BAD.into());
            }
            *rest = after;
            Ok(Literal::Text(text.to_owned()))
        }
        '(' | '[' | '{' => {
            let close = match first {
                '(' => ')',
                '[' => ']',
                _ => '}',
            };
            *rest = &rest[1..];
            let (mut list, mut map) = (Vec::new(), Vec::new());
            loop {
                *rest = rest.trim_start();
                if let Some(after) = rest.strip_prefix(close) {
                    *rest = after;
                    return Ok(if close == '}' { Literal::Map(map) } else { Literal::List(list) });
                }
                let one = value(rest, depth)?;
                *rest = rest.trim_start();
                if close == '}' {
                    *rest = rest.strip_prefix(':').ok_or(BAD)?;
                    map.push((one.text().ok_or(BAD)?.clone(), value(rest, depth)?));
                    *rest = rest.trim_start();
                } else {
                    list.push(one);
                }
                if let Some(after) = rest.strip_prefix(',') {
                    *rest = after;
                } else if !rest.starts_with(close) {
                    return Err(BAD.into());
                }
            }
        }
        _ => {
            let end = rest.find(|c: char| !c.is_ascii_digit() && c != '-').unwrap_or(rest.len());
            let (number, after) = rest.split_at(end);
            if number.is_empty() {
                return Err(BAD.into());
            }
            // Python 2 writes whole numbers with an L.
            *rest = after.strip_prefix('L').unwrap_or(after);
            Ok(Literal::Number(number.parse().ok()))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_are_read_and_nonsense_is_refused() {
        let told = parse("{'descr': [('t', '<f8', (2,))], 'fortran_order': False, 'shape': (3L, 4), }   \n").unwrap();
        let Literal::Map(entries) = told else { panic!("a dictionary") };
        assert_eq!(entries[1], ("fortran_order".into(), Literal::Bool(false)));
        assert_eq!(entries[2].1.sizes(), Some(vec![3, 4]));
        let Literal::List(fields) = &entries[0].1 else { panic!("a list") };
        assert!(matches!(&fields[0], Literal::List(parts) if parts[2].sizes() == Some(vec![2])));
        assert_eq!(parse("(-1,)").unwrap().sizes(), None);
        for bad in [
            "",
            "{",
            "{'a'",
            "{'a': }",
            "('a",
            "(1 2)",
            "x",
            "{1: 2}",
            "() x",
            "'\\x41'",
            "\u{1f600}",
            &"[".repeat(100_000),
        ] {
            assert!(parse(bad).is_err(), "{bad:.20}");
        }
    }
}
