//! Episodes in which robots or commands are outside of the kernels.

pub mod acting;
pub mod reported;
pub mod stepped;
