//! Names of channels as names of variables in a program.

/// Words that mean something in Python, or in the functions written there.
const TAKEN: [&str; 44] = [
    "False",
    "None",
    "True",
    "and",
    "as",
    "assert",
    "async",
    "await",
    "break",
    "class",
    "continue",
    "def",
    "del",
    "elif",
    "else",
    "except",
    "finally",
    "for",
    "from",
    "global",
    "if",
    "import",
    "in",
    "is",
    "lambda",
    "nonlocal",
    "not",
    "or",
    "pass",
    "raise",
    "return",
    "try",
    "while",
    "with",
    "yield",
    "np",
    "state",
    "control",
    "out",
    "coupling",
    "rhs",
    "step",
    "DT",
    "_arguments",
];

/// A variable for each of `names`, all different: letters of the Latin and Greek alphabets, digits and `_`, which
/// Python reads as they stand. (Others it may fold into one another.)
pub(super) fn identifiers(names: &[String]) -> Vec<String> {
    let mut found: Vec<String> = Vec::with_capacity(names.len());
    for name in names {
        let mut identifier: String = name.chars().map(|c| if allowed(c) { c } else { '_' }).collect();
        if !identifier.starts_with(|c: char| !c.is_ascii_digit()) {
            identifier.insert(0, '_');
        }
        while TAKEN.contains(&identifier.as_str()) || found.contains(&identifier) {
            identifier.push('_');
        }
        found.push(identifier);
    }
    found
}

fn allowed(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_' || (c.is_alphabetic() && ('Α'..='ω').contains(&c))
}

#[cfg(test)]
mod tests {
    #[test]
    fn every_name_becomes_a_variable_of_its_own() {
        let names = ["θ", "θ̇", "cos θ", "cos_θ", "2x", "", "lambda", "np", "ﬁ", "a\"b\n"].map(String::from);
        let expected = ["θ", "θ_", "cos_θ", "cos_θ_", "_2x", "_", "lambda_", "np_", "__", "a_b_"];
        assert_eq!(super::identifiers(&names), expected);
    }
}
