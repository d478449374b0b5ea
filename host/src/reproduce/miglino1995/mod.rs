//! The study of Miglino, Lund and Nolfi (1995): sample a robot, evolve in the simulator made from the samples, move
//! to reality, evolve on, and hold every claim of the paper against what came out.

pub(crate) mod claims;
pub(crate) mod report;
pub(crate) mod results;
