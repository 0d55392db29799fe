//! What `events.jsonl` says of the training curve.

use serde_json::Value;

/// Something that happened in a run, after so many updates.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Moment {
    /// The policy was tried in the model.
    Trial {
        /// Updates so far.
        updates: u64,
        /// Its mean return there.
        model_return: f64,
    },
    /// Equations were identified.
    Fitted {
        /// Updates so far.
        updates: u64,
    },
    /// The policy had an episode on the system, and the model is compared with it.
    Confirmed {
        /// Updates so far.
        updates: u64,
        /// Its return.
        real_return: f64,
    },
}

impl Moment {
    /// The moments in the text of `events.jsonl`; lines that are something else are passed over.
    #[must_use]
    pub fn all(text: &str) -> Vec<Self> {
        let mut updates = 0;
        let mut moments = Vec::new();
        for value in text.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok()) {
            updates = value["updates"].as_u64().unwrap_or(updates);
            let number = |name: &str| value[name].as_f64();
            moments.extend(match value["event"].as_str() {
                Some("trial") => number("model_return").map(|model_return| Self::Trial { updates, model_return }),
                Some("fitted") => Some(Self::Fitted { updates }),
                Some("confirmed") => number("real_return").map(|real_return| Self::Confirmed { updates, real_return }),
                _ => None,
            });
        }
        moments
    }
}
