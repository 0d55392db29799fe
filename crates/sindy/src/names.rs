//! Names of channels as symbols in terms.

use crate::expr::{begins_name, continues_name};

/// The symbols terms are written with: `names` with everything that cannot stand in a name as `_`, made distinct.
pub(crate) fn symbols(names: &[String]) -> Vec<String> {
    let mut symbols: Vec<String> = Vec::with_capacity(names.len());
    for name in names {
        let mut symbol: String = name.chars().map(|c| if continues_name(c) { c } else { '_' }).collect();
        if !symbol.starts_with(begins_name) {
            symbol.insert(0, '_');
        }
        while symbols.contains(&symbol) {
            symbol.push('_');
        }
        symbols.push(symbol);
    }
    symbols
}

#[cfg(test)]
mod tests {
    #[test]
    fn every_name_becomes_a_symbol_of_its_own() {
        let names = ["θ̇", "cos θ", "cos_θ", "2x", ""].map(String::from);
        assert_eq!(super::symbols(&names), ["θ̇", "cos_θ", "cos_θ_", "_2x", "_"]);
    }
}
