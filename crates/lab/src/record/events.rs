//! `events.jsonl`: what happened in a run, a JSON object per line.

use serde_json::{Value, json};
use sindyna_core::Event;

/// The lines of `events.jsonl`, gathered while the run goes on.
#[derive(Debug, Default)]
pub(crate) struct EventLog {
    text: String,
}

impl EventLog {
    /// The lines that were gathered before.
    pub(crate) fn of(text: String) -> Self {
        Self { text }
    }

    pub(crate) fn note(&mut self, event: &Event<'_>) {
        if let Some(value) = describe(event) {
            self.text.push_str(&value.to_string());
            self.text.push('\n');
        }
    }

    pub(crate) fn as_bytes(&self) -> &[u8] {
        self.text.as_bytes()
    }
}

fn describe(event: &Event<'_>) -> Option<Value> {
    Some(match *event {
        Event::Collected { data } => {
            json!({"event": "collected", "real_steps": data.n_steps(), "real_episodes": data.n_rollouts()})
        }
        Event::Fitted { rows, description } => json!({"event": "fitted", "rows": rows, "equations": description}),
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
        Event::Confirmed { real, promised } => {
            json!({"event": "confirmed", "real_return": real, "promised_return": promised})
        }
        Event::Evaluated { returns } => json!({"event": "evaluated", "returns": returns}),
        // Events added to core later are no part of this record yet.
        _ => return None,
    })
}
