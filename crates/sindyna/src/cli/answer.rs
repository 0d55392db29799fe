//! What a command comes to: for people, for programs, and for whoever waits for its exit code.

use serde::Serialize;
use serde_json::{Map, Value, json};

use super::failure::Failure;
use super::interrupt::EXIT_INTERRUPTED;
use super::text::Text;

/// Version of the JSON that `--json` prints.
const FORMAT: u32 = 1;

/// How a command that ran came out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Verdict {
    Done,
    MissedTarget,
    Interrupted,
}

/// What a command comes to.
#[derive(Debug)]
pub(crate) struct Answer {
    verdict: Verdict,
    pub(super) text: Text,
    result: Value,
    pub(super) failure: Option<Failure>,
}

impl Answer {
    /// A result as `text` for people and as `result` for programs.
    pub(crate) fn new(verdict: Verdict, text: String, result: &impl Serialize) -> Result<Self, Failure> {
        Ok(Self { verdict, text: Text::People(text), result: serde_json::to_value(result)?, failure: None })
    }

    /// The same, whose text is a program or the like, written as it is.
    pub(crate) fn raw(text: String, result: &impl Serialize) -> Result<Self, Failure> {
        let result = serde_json::to_value(result)?;
        Ok(Self { verdict: Verdict::Done, text: Text::Programs(text), result, failure: None })
    }

    /// Nothing to tell.
    pub(crate) fn silent(verdict: Verdict) -> Self {
        Self { verdict, text: Text::People(String::new()), result: Value::Null, failure: None }
    }

    /// The same, if `failure` is none: what was found is told even if the rest went wrong.
    pub(crate) fn and<T>(self, failure: Result<T, Failure>) -> Self {
        Self { failure: self.failure.or(failure.err()), ..self }
    }

    pub(super) fn exit_code(&self) -> u8 {
        match (&self.failure, self.verdict) {
            (Some(_), _) => 2,
            (None, Verdict::Done) => 0,
            (None, Verdict::MissedTarget) => 1,
            (None, Verdict::Interrupted) => EXIT_INTERRUPTED,
        }
    }

    /// The one object that `--json` prints, for the command called `name`.
    pub(super) fn json(&self, name: &str) -> Value {
        let mut object = Map::new();
        object.insert("format".into(), json!(FORMAT));
        object.insert("command".into(), json!(name));
        object.insert("exit_code".into(), json!(self.exit_code()));
        if !self.result.is_null() {
            object.insert("result".into(), self.result.clone());
        }
        if let Some(failure) = &self.failure {
            object.insert("error".into(), failure.json());
        }
        Value::Object(object)
    }
}

impl From<Failure> for Answer {
    fn from(failure: Failure) -> Self {
        Self { failure: Some(failure), ..Self::silent(Verdict::Done) }
    }
}
