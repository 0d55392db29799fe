//! States by their names.

use crate::{DeclarationError, StateOption};

/// Where each of `names`, which `option` gives, stands among the `states`.
pub(crate) fn positions(
    names: &[String],
    states: &[String],
    option: StateOption,
) -> Result<Vec<usize>, DeclarationError> {
    let position = |name: &String| {
        states.iter().position(|s| s == name).ok_or_else(|| DeclarationError::UnknownState {
            option,
            state: name.clone(),
            known: states.to_vec(),
        })
    };
    names.iter().map(position).collect()
}
