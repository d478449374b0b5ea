//! Oneiro evaluates robot controllers in simulated lives, millions at a time, with the same bits on every device.

// Tests of what is not public share worlds with those of what is.
#[cfg(test)]
extern crate self as oneiro;

pub mod batch;
mod cells;
mod devices;
pub mod evaluator;
pub mod exact;
mod foragers;
mod genes;
mod outside;
pub mod parameter;
mod parts;
pub mod random;
pub mod world;

#[cfg(all(feature = "ahead", any(target_arch = "x86_64", target_arch = "aarch64")))]
pub use devices::ahead;
#[cfg(feature = "gpu")]
pub use devices::gpu;
pub use devices::{audit, auto, backend, background, cpu, pool, probe, threads};
pub use foragers::{foraging, swarm};
pub use outside::{acting, reported, stepped};
pub use parts::{automode, compose, network};
pub use world::{arena, differential, reference, surrogate, tables};

#[cfg(all(feature = "compose", panic = "abort"))]
compile_error!(
    "what naga panics about must be refused: the feature `compose` needs `panic = \"unwind\"`, as in the profile `robot-compose`"
);

/// Compiles the program in the README as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
