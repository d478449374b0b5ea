//! The physics that a checked world's robot lives by.

use std::sync::Arc;

use crate::world::described::{Described, Together};
use crate::world::forager::Forager;
use crate::world::surrogate::Surrogate;

/// Each kind of robot has what it needs and nothing else.
#[derive(Clone, Debug)]
pub(crate) enum Physics {
    /// Samples of a real robot.
    Sampled,
    /// Rays, where an individual lives in place of the robot that was sampled.
    Individual(Arc<Surrogate>),
    /// A description, from which an individual may differ.
    Described(Described, Option<Arc<Surrogate>>),
    /// A forager's on-board simulator.
    Forager(Forager),
}

impl Physics {
    /// The described robot.
    pub(crate) fn described(&self) -> Option<&Described> {
        match self {
            Self::Described(own, _) => Some(own),
            Self::Sampled | Self::Individual(_) | Self::Forager(_) => None,
        }
    }

    /// Several robots that live together.
    pub(crate) fn together(&self) -> Option<&Together> {
        self.described()?.together.as_ref()
    }

    /// Where robots that live together start, if that is given: x and y of each, mm.
    pub(crate) fn start_places(&self) -> &[[f32; 2]] {
        self.described().map_or(&[], Described::start_places)
    }
}
