//! What the columns of a sweep's tables hold.

/// What a column holds; a cell may be empty.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Holds {
    /// Whole numbers of 64 bits with a sign.
    Whole,
    /// Numbers of double precision, NaN among them.
    Number,
    /// Words.
    Text,
}

/// A column's name and what it holds.
pub(crate) type Column = (&'static str, Holds);
