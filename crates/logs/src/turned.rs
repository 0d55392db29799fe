//! A log whose states turn.

use sindyna_core::Kind;

use crate::{Log, Note};

impl Log {
    /// The same log with the states that may be angles ([`Log::may_turn`]) as angles, with a note of each. `None` if there are none.
    #[must_use]
    pub fn turned(&self) -> Option<Self> {
        if self.may_turn.is_empty() {
            return None;
        }
        let mut log = self.clone();
        let names = std::mem::take(&mut log.may_turn);
        let angles: Vec<usize> =
            (0..log.spec.state.len()).filter(|&i| names.contains(&log.spec.state[i].name)).collect();
        let spec = &mut log.spec;
        for channel in spec.state.iter_mut().chain(&mut spec.observation) {
            let unit = match channel.kind {
                Kind::Plain if names.contains(&channel.name) => {
                    channel.kind = Kind::Angle;
                    "rad"
                }
                Kind::RateOf(of) if angles.contains(&of) => "rad/s",
                _ => continue,
            };
            if channel.unit.is_empty() {
                unit.clone_into(&mut channel.unit);
            }
        }
        log.notes.extend(names.iter().map(|state| Note::Turned { state: state.clone() }));
        log.decided.angles.get_or_insert_default().extend(names);
        Some(log)
    }
}
