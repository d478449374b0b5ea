//! The physics of a checked world.

use std::sync::Arc;

use crate::world::described::{Described, Together};
use crate::world::discs::Discs;
use crate::world::forager::Forager;
use crate::world::surrogate::Surrogate;

/// Each kind of robot with its values, and no others.
#[derive(Clone, Debug)]
pub(crate) enum Physics {
    /// Samples of a real robot.
    Sampled,
    /// Rays: an individual instead of the sampled robot.
    Individual(Arc<Surrogate>),
    /// A parametric robot, or an individual that differs from it.
    Described(Described, Option<Arc<Surrogate>>),
    /// A forager's on-board simulator.
    Forager(Forager),
}

impl Physics {
    /// The parametric robot.
    pub(crate) fn described(&self) -> Option<&Described> {
        match self {
            Self::Described(robot, _) => Some(robot),
            Self::Sampled | Self::Individual(_) | Self::Forager(_) => None,
        }
    }

    /// Values of robots that share a world.
    pub(crate) fn together(&self) -> Option<&Together> {
        self.described()?.together.as_deref()
    }

    /// Their pucks.
    pub(crate) fn pucks(&self) -> Option<&Discs> {
        self.described()?.pucks()
    }

    /// Given starts of robots that share a world: x and y of each, mm.
    pub(crate) fn start_places(&self) -> &[[f32; 2]] {
        self.described().map_or(&[], Described::start_places)
    }
}
