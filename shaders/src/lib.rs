//! Oneiro's kernels: each written once in WGSL and compiled at build time to SPIR-V for GPUs, to Rust lane
//! code for CPUs, and to the structs through which the host fills their buffers.

pub mod kernel;
pub mod lanes;

/// What the build made of `wgsl/`.
#[allow(clippy::unreadable_literal, reason = "generated")]
mod generated {
    include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
}
pub use generated::*;
pub use kernel::{Binding, BindingKind, Kernel, LaneFn, Turns, Variant, WordOf, Words};
