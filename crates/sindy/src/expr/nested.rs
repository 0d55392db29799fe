//! Terms read back, no deeper than can be walked.

use std::cell::Cell;

use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error as _};

use super::Expr;

/// Levels of a term that is read: as many as a parsed one can have, and no more, since each takes its part of the stack.
const MAX_DEPTH: usize = 1100;

thread_local! {
    static DEPTH: Cell<usize> = const { Cell::new(0) };
}

impl Serialize for Expr {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Self::serialize(self, serializer)
    }
}

impl<'de> Deserialize<'de> for Expr {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let depth = DEPTH.get();
        if depth >= MAX_DEPTH {
            return Err(D::Error::custom("a term is nested too deeply"));
        }
        DEPTH.set(depth + 1);
        let read = Self::deserialize(deserializer);
        DEPTH.set(depth);
        read
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sindyna_core::{decode, encode};

    /// −−…x with so many signs.
    fn negated(signs: usize) -> Vec<u8> {
        let sign = &encode(&Expr::Neg(Box::new(Expr::Variable(0))))[..1];
        [sign.repeat(signs), encode(&Expr::Variable(0))].concat()
    }

    #[test]
    fn a_term_is_read_as_deep_as_it_can_be_parsed_and_no_deeper() {
        let sum = ["x"; 1001].join("+");
        let deepest = super::super::parse(&sum, &["x".into()]).expect("a thousand operators are allowed");
        assert_eq!(decode(&encode(&deepest)), Ok(deepest));
        assert!(decode::<Expr>(&negated(MAX_DEPTH - 1)).is_ok());
        for signs in [MAX_DEPTH, 10_000_000] {
            assert!(decode::<Expr>(&negated(signs)).is_err(), "{signs} signs");
        }
        assert!(decode::<Expr>(&negated(3)).is_ok(), "a refused one leaves nothing behind");
    }
}
