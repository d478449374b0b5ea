//! The host's optimisers without the rest of the program, which takes a minute to compile: for `tests/aarch64.sh`, on emulated 64-bit
//! ARM. Elsewhere they are tested with the program.

#![cfg(target_arch = "aarch64")]
#![allow(dead_code, unused_imports, reason = "the program uses it")]
#![allow(missing_docs, reason = "the program has no public interface here")]

#[path = "../host/evolve/src/mod.rs"]
mod evolve;
#[path = "../host/base/src/exit.rs"]
mod exit;
mod pinned;
#[path = "../host/base/src/sealed.rs"]
mod sealed;
#[path = "../host/statistics/src/mod.rs"]
mod statistics;
