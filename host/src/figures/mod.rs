//! Pictures, as SVG text: each function takes data and returns a whole file.

mod arena;
mod curve;
mod plot;
mod svg;
mod tables;

pub(crate) use arena::{arena, life};
pub(crate) use curve::{Series, learning_curve};
pub(crate) use tables::sensor_table;
