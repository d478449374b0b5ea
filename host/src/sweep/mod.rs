//! Many evolutions as one job.
#![allow(dead_code, reason = "nothing writes the tables yet")]

#[cfg(feature = "parquet")]
mod parquet;
mod table;
