//! The world of an episode: robot, arena, noise, controller, task and start as plain data, and the validated [`World`]
//! made from them.

pub mod arena;
mod body;
mod check;
mod checked;
mod described;
pub(crate) mod differential;
mod discs;
mod draws;
mod forager;
mod given;
mod near;
mod noise;
mod owner;
mod pack;
mod parameters;
mod physics;
pub mod picture;
pub(crate) mod pucks;
mod reach;
pub mod reference;
mod robot;
mod sensors;
mod spec;
mod start;
pub mod surrogate;
pub mod tables;
pub mod tasks;
mod varied;
#[cfg(feature = "compose")]
mod wgsl;

pub use crate::genes::{Gene, GeneKind, GeneLayout};
pub use body::Collision;
pub use checked::{DrawnNumbers, World};
pub use forager::Forager;
pub use noise::{Drawn, Noise};
pub use parameters::{COORDINATE, LENGTH, parameters};
pub use pucks::Pucks;
pub use robot::{Build, Robot};
pub use spec::{Activation, Controller, Difference, Speed, Task, WorldSpec};
pub use start::{Poses, Start, Zone};
pub use varied::{ByKey, Varied};
