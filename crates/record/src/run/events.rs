//! `events.jsonl`: what happened in a run, a JSON object per line.

use serde_json::{Value, json};
use sindyna_core::Event;

/// The lines of `events.jsonl`, gathered while the run goes on.
#[derive(Debug, Default)]
pub struct EventLog {
    text: String,
}

impl EventLog {
    /// The lines that were gathered before.
    #[must_use]
    pub fn of(text: String) -> Self {
        Self { text }
    }

    /// Adds a line for `event`, if it is one that is recorded.
    pub fn note(&mut self, event: &Event<'_>) {
        if let Some(value) = describe(event) {
            self.text.push_str(&value.to_string());
            self.text.push('\n');
        }
    }

    /// The lines so far.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        self.text.as_bytes()
    }
}

fn describe(event: &Event<'_>) -> Option<Value> {
    Some(match *event {
        Event::Collected { data } => {
            json!({"event": "collected", "real_steps": data.n_steps(), "real_episodes": data.n_rollouts()})
        }
        Event::Fitted { rows, description } => json!({"event": "fitted", "rows": rows, "equations": description}),
        Event::NotFitted { rows, reason } => json!({"event": "not_fitted", "rows": rows, "reason": reason}),
        Event::Updated { updates, model_steps, diverged, left_region, metrics, .. } => {
            let mut line = json!({
                "event": "updated", "updates": updates, "model_steps": model_steps, "diverged": diverged,
                "left_region": left_region,
            });
            for (name, value) in metrics {
                line[*name] = json!(value);
            }
            line
        }
        Event::Imagined { updates, mean_return, best_return } => {
            json!({"event": "trial", "updates": updates, "model_return": mean_return, "best_model_return": best_return})
        }
        Event::Confirmed { real, predicted } => {
            json!({"event": "confirmed", "real_return": real, "predicted_return": predicted})
        }
        Event::Evaluated { returns } => json!({"event": "evaluated", "returns": returns}),
        // Events added to core later are no part of this record yet.
        _ => return None,
    })
}
