//! What readers see: pages, figures, tables, numbers and CSV files. It knows of no study, sweep or run.

pub(crate) mod csv;
pub(crate) mod figures;
pub(crate) mod numbers;
pub(crate) mod page;
