//! The tables of a sweep.

/// What the cells of a column hold. An empty cell holds nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Holds {
    /// Whole numbers from -2^63 to 2^63 - 1.
    Whole,
    /// Numbers as f64 holds them, NaN and infinities among them.
    Number,
    /// Words.
    Text,
}

/// A column's name and what it holds.
pub(crate) type Column = (&'static str, Holds);
