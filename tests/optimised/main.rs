//! Tests that compute much: targets of the library's own package, which the development profile optimises.

#[allow(dead_code, reason = "tests of the library use the rest")]
#[path = "../composed/mod.rs"]
mod composed;
#[path = "../described/mod.rs"]
mod described;
#[allow(dead_code, reason = "tests of the library use the rest")]
#[path = "../lives/mod.rs"]
mod lives;
#[path = "../pinned/mod.rs"]
mod pinned;
#[path = "../skips/mod.rs"]
mod skips;

#[cfg(all(feature = "gpu", feature = "compose"))]
mod machine_code;
#[cfg(feature = "native")]
mod sampled;
