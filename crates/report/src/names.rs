//! Names of methods as readers see them.

use sindyna_record::comparison::base;

/// Names that records of old comparisons have, and what the methods are called.
const CALLED: [(&str, &str); 2] = [("truth", "oracle"), ("hand", "expert")];

/// What the method or variant `name` of a record is called.
#[must_use]
pub fn method_name(name: &str) -> String {
    let of = base(name);
    let called = CALLED.iter().find(|(old, _)| *old == of).map_or(of, |(_, called)| called);
    called.to_owned() + &name[of.len()..]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn old_names_are_called_what_they_are_and_others_stay() {
        let called = ["hand", "truth", "truth+slow", "expert", "sindy+stlsq"].map(method_name);
        assert_eq!(called, ["expert", "oracle", "oracle+slow", "expert", "sindy+stlsq"]);
    }
}
