//! A log whose states turn.

use sindyna_core::Kind;

use crate::{Log, Note};

impl Log {
    /// The same log with the states that may be angles ([`Log::may_turn`]) as angles, with a note of each. `None` if there are none.
    #[must_use]
    pub fn turned(&self) -> Option<Self> {
        (!self.may_turn.is_empty()).then(|| self.with_angles(&self.may_turn, true))
    }

    /// The same log with the states `names` as angles, with a note of each: names and units say so, if they are `named`, or else the data.
    #[must_use]
    pub fn with_angles(&self, names: &[String], named: bool) -> Self {
        let mut log = self.clone();
        log.may_turn.retain(|name| !names.contains(name));
        log.could_turn.retain(|(name, _)| !names.contains(name));
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
        log.notes.extend(names.iter().map(|state| Note::Turned { state: state.clone(), named }));
        log.decided.angles.get_or_insert_default().extend(names.iter().cloned());
        log
    }
}
