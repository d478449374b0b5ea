//! Tests of the compiler: a file each, and first what they share.

#[path = "../../../../tests/pinned/mod.rs"]
mod pinned;
#[path = "../../../../tests/seeds/mod.rs"]
mod seeds;
#[path = "../../../../tests/skips/mod.rs"]
mod skips;

mod bounds;
mod c;
mod golden;
mod layout;
mod mistakes;
mod random;
mod refusals;
mod source;
mod specialise;
mod spirv;
mod tidy;
mod unroll;
mod words;
