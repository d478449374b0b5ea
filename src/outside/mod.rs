//! Episodes whose robots or commands come from outside the kernels.

pub mod acting;
pub mod reported;
pub mod stepped;
