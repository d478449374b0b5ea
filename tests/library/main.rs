//! Tests of the library `oneiro`, by its public interface alone: a file each, and first what they share.

#[path = "../composed/mod.rs"]
mod composed;
#[path = "../described/mod.rs"]
mod described;
mod epucks;
#[cfg(feature = "compose")]
#[path = "../exported/mod.rs"]
mod exported;
#[allow(dead_code, reason = "other tests use the rest")]
#[path = "../hostile/world.rs"]
mod hostile;
#[path = "../lives/mod.rs"]
mod lives;
mod modules;
#[allow(dead_code, reason = "other tests use the rest")]
#[path = "../mutations/mod.rs"]
mod mutations;
#[path = "../pinned/mod.rs"]
mod pinned;
#[path = "../skips/mod.rs"]
mod skips;
#[path = "../witness/mod.rs"]
mod witness;

#[cfg(feature = "native")]
mod arrays;
mod batch;
#[cfg(feature = "compose")]
mod behaviour_tree;
#[cfg(feature = "compose")]
mod chips;
mod collisions;
#[cfg(feature = "compose")]
mod compose;
#[cfg(feature = "gpu")]
mod corpus;
mod cpu;
#[cfg(feature = "compose")]
mod differential;
#[cfg(feature = "compose")]
mod drawn;
mod drives;
#[cfg(feature = "compose")]
mod export;
#[cfg(feature = "compose")]
mod export_systems;
#[cfg(feature = "compose")]
mod export_world;
#[cfg(feature = "native")]
mod features;
mod forager;
#[cfg(feature = "compose")]
mod forager_parts;
#[cfg(feature = "compose")]
mod genomes;
mod goldens;
#[cfg(feature = "gpu")]
mod gpu;
#[cfg(feature = "compose")]
mod individual;
#[cfg(feature = "compose")]
mod isolation;
#[cfg(feature = "compose")]
mod members;
#[cfg(feature = "native")]
mod missions;
#[cfg(feature = "compose")]
mod mutants;
#[cfg(feature = "compose")]
mod near;
#[cfg(feature = "compose")]
mod neighbours;
mod network;
mod numerics;
#[cfg(feature = "compose")]
mod observed;
mod operations;
mod ordinary;
mod parity;
#[cfg(feature = "compose")]
mod pictures;
mod pool;
#[cfg(feature = "compose")]
mod pucks;
#[cfg(feature = "rapier")]
mod rapier;
#[cfg(feature = "compose")]
mod reference;
#[cfg(feature = "compose")]
mod reported;
mod state_machine;
#[cfg(feature = "compose")]
mod stepped;
mod surrogate;
mod swarm;
mod tables;
mod tasks;
mod turns;
#[cfg(feature = "compose")]
mod varied;
mod worlds;
