//! What passes between robots: simulators with the fitness that their robots earn, from whoever is near. How messages
//! travel is behind one trait.

pub(crate) mod pairs;

use std::ops::Range;

use crate::evolve::encapsulated::Genome;

/// What a robot says once a second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Message {
    /// Who says it.
    pub(crate) sender: usize,
    /// In which interval of its own.
    pub(crate) interval: u32,
    /// The gene of a simulator, `S0`.
    pub(crate) simulator: f32,
    /// The fitness that goes with it, `F_R`.
    pub(crate) fitness: f32,
    /// The controller that acts.
    pub(crate) controller: Genome,
}

/// How messages come.
pub(crate) trait Exchange {
    /// What a robot heard in these seconds, in the order in which it came.
    fn heard(&self, robot: usize, seconds: Range<u32>) -> Vec<Message>;
}
