//! Output for readers: pages, figures, tables, numbers and CSV files. It knows nothing of studies, sweeps or runs.

pub(crate) mod csv;
pub(crate) mod figures;
pub(crate) mod numbers;
pub(crate) mod page;
