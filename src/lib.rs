//! Oneiro evaluates robot controllers in simulated lives, millions at a time, with the same bits on every device.

// Tests of what is not public share worlds with those of what is.
#[cfg(test)]
extern crate self as oneiro;

pub mod acting;
#[cfg(all(feature = "ahead", any(target_arch = "x86_64", target_arch = "aarch64")))]
pub mod ahead;
pub mod arena;
pub mod audit;
pub mod auto;
pub mod automode;
pub mod backend;
pub mod background;
pub mod batch;
mod cells;
mod code;
pub mod compose;
pub mod cpu;
pub mod differential;
pub mod evaluator;
pub mod exact;
pub mod foraging;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod network;
pub mod parameter;
pub mod pool;
pub mod probe;
pub mod random;
pub mod reference;
pub mod reported;
pub mod stepped;
pub mod surrogate;
pub mod swarm;
pub mod tables;
pub mod threads;
#[cfg(all(feature = "compose", any(feature = "gpu", feature = "native")))]
mod variants;
pub mod world;

#[cfg(all(feature = "compose", panic = "abort"))]
compile_error!(
    "what naga panics about must be refused: the feature `compose` needs `panic = \"unwind\"`, as in the profile `robot-compose`"
);

/// Compiles the program in the README as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
