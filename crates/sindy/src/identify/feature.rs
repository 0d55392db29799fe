//! Terms as people write them in a report.

use crate::library::Term;

/// The term as people write it.
pub(super) fn feature(term: &Term, names: &[String]) -> String {
    if let Some(shape) = &term.shape {
        return shape.pretty(names);
    }
    match term.rate {
        None => term.expr.pretty(names).to_string(),
        Some(l) if term.expr.is_one() => format!("d{}/dt", names[l]),
        Some(l) => format!("{}·d{}/dt", term.expr.pretty(names).as_factor(), names[l]),
    }
}
