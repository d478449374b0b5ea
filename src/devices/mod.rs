//! Evaluators of batches: CPU, GPUs, the choice between them, pools and audits.

pub mod audit;
pub mod auto;
pub mod backend;
pub mod background;
mod code;
pub mod cpu;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod pool;
pub mod probe;
pub mod threads;
mod variants;
