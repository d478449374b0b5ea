//! Custom parts of kernels, and networks and machines that become such parts.

pub mod automode;
pub mod compose;
pub mod network;
