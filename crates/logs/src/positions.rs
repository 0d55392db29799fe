//! States by their names.

use crate::{LogError, StateOption};

/// Where each of `names`, which `option` gives, stands among the `states`.
pub(crate) fn positions(names: &[String], states: &[String], option: StateOption) -> Result<Vec<usize>, LogError> {
    let position = |name: &String| {
        states.iter().position(|s| s == name).ok_or_else(|| LogError::UnknownState {
            option,
            state: name.clone(),
            known: states.to_vec(),
        })
    };
    names.iter().map(position).collect()
}
