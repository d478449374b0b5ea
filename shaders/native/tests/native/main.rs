//! Tests of code that is compiled at run time: a file each, and first what they share.

#[allow(dead_code, reason = "the build script uses the rest")]
#[path = "../../../catalogue.rs"]
mod catalogue;
mod common;
#[path = "../../../../tests/seeds/mod.rs"]
mod seeds;

mod cache;
mod kernels;
mod ordinary;
mod random;
