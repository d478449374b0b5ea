//! What a command answers.

use serde_json::Value;

/// The same data as text and as JSON. Whoever calls the command decides which is shown.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answer {
    /// For people.
    pub text: String,
    /// For programs.
    pub value: Value,
    /// What people should know about the data.
    pub warnings: Vec<String>,
    /// What was done besides, such as files that were written.
    pub messages: Vec<String>,
}

impl Answer {
    /// An answer without messages.
    pub fn new(text: impl Into<String>, value: Value) -> Self {
        Self {
            text: text.into(),
            value,
            ..Self::default()
        }
    }
}
