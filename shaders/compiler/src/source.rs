//! Kernels are concatenated from parts; messages must still name the part and its line.

use std::fmt;

/// One WGSL file of a kernel.
#[derive(Clone, Debug)]
pub struct Part {
    /// What messages call it, such as `lib/numerics.wgsl`.
    pub path: String,
    /// Its text.
    pub text: String,
}

/// A kernel's parts, joined.
#[derive(Clone, Debug)]
pub struct Source {
    /// The joined text.
    pub text: String,
    parts: Vec<(String, usize)>,
}

impl Source {
    /// Joins parts in order.
    pub fn new(parts: &[Part]) -> Self {
        let mut text = String::new();
        let mut starts = Vec::new();
        for part in parts {
            starts.push((part.path.clone(), text.lines().count()));
            text.push_str(&part.text);
            if !part.text.ends_with('\n') {
                text.push('\n');
            }
        }
        Self { text, parts: starts }
    }

    /// The parts' paths, in order.
    pub fn paths(&self) -> Vec<String> {
        self.parts.iter().map(|(path, _)| path.clone()).collect()
    }

    /// Where a byte of the joined text comes from.
    pub fn place(&self, byte: usize) -> Place {
        let before = &self.text[..byte.min(self.text.len())];
        let line = before.matches('\n').count();
        let (path, first) = self
            .parts
            .iter()
            .rev()
            .find(|(_, first)| *first <= line)
            .cloned()
            .unwrap_or_else(|| ("?".into(), 0));
        Place {
            path,
            line: line - first + 1,
            column: before.rsplit('\n').next().unwrap_or_default().chars().count() + 1,
        }
    }

    /// Where a span of naga's comes from; the start of the text if it has none.
    pub fn place_of(&self, span: naga::Span) -> Place {
        self.place(span.to_range().map_or(0, |range| range.start))
    }
}

/// A place in a part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The part.
    pub path: String,
    /// Counted from 1.
    pub line: usize,
    /// In characters, counted from 1.
    pub column: usize,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.path, self.line, self.column)
    }
}

/// Why a kernel was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {}{message}", function.as_ref().map(|name| format!("in `{name}`: ")).unwrap_or_default())]
pub struct Refusal {
    /// Where.
    pub place: Place,
    /// In which function, if in one.
    pub function: Option<String>,
    /// What, and what is allowed instead.
    pub message: String,
}

/// Refusals, at least one.
pub type Refusals = Vec<Refusal>;
