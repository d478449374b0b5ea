//! Oneiro evaluates robot controllers in simulation, millions of episodes at a time, with the same bits on every device.

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

#[cfg(feature = "gpu")]
pub use devices::gpu;
pub use devices::{audit, auto, backend, background, cpu, pool, probe, threads};
pub use foragers::swarm;
#[cfg(feature = "compose")]
pub use outside::export;
pub use outside::{acting, reported, stepped};
pub use parts::{automode, compose, network};
pub use world::{arena, picture, reference, surrogate, tables, tasks};

pub mod foraging {
    //! Foraging e-pucks, as worlds and as robots of other worlds.

    pub use crate::foragers::foraging::*;
    pub use crate::world::Forager;
}

pub mod differential {
    //! Parametric robots, and what else a robot may be.

    pub use crate::world::Build;
    pub use crate::world::differential::*;
}

// In a browser, a page begins anew.
#[cfg(all(feature = "compose", panic = "abort", not(target_family = "wasm")))]
compile_error!(
    "what naga panics about must be refused: the feature `compose` needs `panic = \"unwind\"`, as in the profile `robot-compose`"
);

/// Compiles the program in the README as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
