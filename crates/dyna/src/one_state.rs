//! The spec of a system of one state, for the tests of these files.

use sindyna_core::{Channel, Kind, Precision, Space, Spec};

/// One state that is seen as it is, and one control from −1 to 1.
pub(crate) fn spec() -> Spec {
    let x = Channel::new("x", "m", Kind::Plain, 1.0);
    Spec {
        name: "push".into(),
        state: vec![x.clone()],
        observation: vec![x.clone()],
        control: vec![x],
        action_space: Space::Box { low: vec![-1.0], high: vec![1.0] },
        precision: Precision::F64,
        noise: 0.0,
        dt: 0.1,
    }
}
