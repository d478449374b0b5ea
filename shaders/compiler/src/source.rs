//! Concatenates the parts of a kernel, and finds the part and line that a message is about.

use std::fmt;

use crate::rules::Rule;
use crate::tree::{Program, Value};

/// One WGSL file of a kernel.
#[derive(Clone, Debug)]
pub struct Part {
    /// Name in messages, such as `lib/numerics.wgsl`.
    pub path: String,
    /// WGSL.
    pub text: String,
}

/// Joined parts of a kernel.
#[derive(Clone, Debug)]
pub struct Source {
    /// Joined text.
    pub text: String,
    /// The path of each part, and the byte at which it begins.
    parts: Vec<(String, usize)>,
}

impl Source {
    /// Joins parts in order.
    pub fn new(parts: &[Part]) -> Self {
        let mut text = String::new();
        let mut starts = Vec::new();
        for part in parts {
            starts.push((part.path.clone(), text.len()));
            text.push_str(&part.text);
            if !part.text.ends_with('\n') {
                text.push('\n');
            }
        }
        Self { text, parts: starts }
    }

    /// The same parts after another one.
    pub(crate) fn after(&self, part: &Part) -> Self {
        let mut all = Self::new(std::slice::from_ref(part));
        let begin = all.text.len();
        all.text.push_str(&self.text);
        let moved = self.parts.iter().map(|(path, at)| (path.clone(), begin + at));
        all.parts.extend(moved);
        all
    }

    /// Paths of the parts, in order.
    pub fn paths(&self) -> Vec<String> {
        self.parts.iter().map(|(path, _)| path.clone()).collect()
    }

    /// Finds the part that a byte of the joined text comes from.
    pub fn place(&self, byte: usize) -> Place {
        let byte = byte.min(self.text.len());
        let (path, begin) = self.part_at(byte).map_or(("?", 0), |part| {
            let (path, begin) = &self.parts[part];
            (path.as_str(), *begin)
        });
        let before = &self.text[begin..byte];
        Place {
            path: path.to_owned(),
            line: before.matches('\n').count() + 1,
            column: before.rsplit('\n').next().unwrap_or_default().chars().count() + 1,
        }
    }

    /// The index of the part that a byte of the joined text comes from.
    fn part_at(&self, byte: usize) -> Option<usize> {
        self.parts.iter().rposition(|(_, begin)| *begin <= byte)
    }

    /// The index of the part that has all of a span of naga's; `None` if no part has.
    pub(crate) fn part_of(&self, span: naga::Span) -> Option<usize> {
        let range = span.to_range().filter(|range| !range.is_empty())?;
        let part = self.part_at(range.start)?;
        (self.part_at(range.end - 1) == Some(part)).then_some(part)
    }

    /// Finds where a span of naga's begins. An undefined span begins where the text does.
    pub fn place_of(&self, span: naga::Span) -> Place {
        self.place(span.to_range().map_or(0, |range| range.start))
    }

    /// Places of a value of a program that was lowered from this: its own, and then those of the calls around it, the innermost first.
    pub(crate) fn places(&self, program: &Program, value: Value) -> impl Iterator<Item = Place> {
        let node = &program.values[value.0 as usize];
        let call = |index: u32| program.calls[index as usize];
        let calls = std::iter::successors(node.call.map(call), move |inner| inner.within.map(call));
        let spans = std::iter::once(node.span).chain(calls.map(|call| call.span));
        spans.map(|span| self.place_of(span))
    }

    /// The text of a span of naga's.
    pub(crate) fn text_of(&self, span: naga::Span) -> &str {
        span.to_range()
            .and_then(|range| self.text.get(range))
            .unwrap_or_default()
    }
}

/// A place in a part, or a part as a whole.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// Path of the part.
    pub path: String,
    /// Line, counted from 1; 0 for the part as a whole.
    pub line: usize,
    /// Column in characters, counted from 1; 0 for the part as a whole.
    pub column: usize,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.line == 0 {
            return f.write_str(&self.path);
        }
        write!(f, "{}:{}:{}", self.path, self.line, self.column)
    }
}

/// Reason why a kernel is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {}{message} [{rule}]", function.as_ref().map(|name| format!("in `{name}`: ")).unwrap_or_default())]
pub struct Refusal {
    /// Place that is refused.
    pub place: Place,
    /// Function around it, if there is one.
    pub function: Option<String>,
    /// Rule that is broken.
    pub rule: Rule,
    /// Problem, and what is allowed instead.
    pub message: String,
}

/// One or more refusals.
pub type Refusals = Vec<Refusal>;
