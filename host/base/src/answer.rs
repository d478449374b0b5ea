//! What a command answers.

use serde_json::Value;

/// The same data as text and as JSON. Whoever calls the command decides which is shown.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answer<T = Value> {
    /// For people; empty if they get messages only.
    pub text: String,
    /// For programs.
    pub value: T,
    /// What people should know about the data.
    pub warnings: Vec<String>,
    /// What was done besides, such as files that were written.
    pub messages: Vec<String>,
}

impl<T> Answer<T> {
    /// An answer without messages.
    pub fn new(text: impl Into<String>, value: T) -> Self {
        Self {
            text: text.into(),
            value,
            warnings: Vec::new(),
            messages: Vec::new(),
        }
    }
}
