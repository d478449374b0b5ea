//! Parts that kernels are composed of when the program runs: a user's, and networks and machines that are written out as WGSL.

pub mod automode;
pub mod compose;
pub mod network;
