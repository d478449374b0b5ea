//! Oneiro evaluates robot controllers in simulation, millions of episodes at a time, with the same bits on every device.
//!
//! For a program that uses it: `cargo add oneiro --no-default-features --features gpu,native`. The default features are those of
//! `cargo install oneiro`, which brings the program.

#[doc(inline)]
pub use library::*;
