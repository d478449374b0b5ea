//! Episodes whose robots or commands come from outside the kernels.

pub mod acting;
#[cfg(feature = "compose")]
pub mod export;
pub mod reported;
pub mod stepped;
