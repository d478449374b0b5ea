//! Exchange between robots: each broadcasts its simulator and the fitness earned with it, and robots within range hear
//! it. The transport of messages is behind one trait.

pub mod contact;
pub(crate) mod links;
pub(crate) mod pairs;
pub mod radio;

use std::ops::Range;

use oneiro_evolve::encapsulated::Genome;

/// A message, which a robot broadcasts once a second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Message {
    /// The robot that sends it.
    pub sender: usize,
    /// The interval, by the sender's clock, that the fitness was earned in.
    pub interval: u32,
    /// The gene of a simulator, `S0`.
    pub simulator: f32,
    /// The fitness credited to it, `F_R`.
    pub fitness: f32,
    /// The controller that the sender acts by.
    pub controller: Genome,
}

/// A way for messages to reach robots: within one process, or by radio.
pub trait Exchange {
    /// The messages that a robot received in these seconds, in order of arrival.
    fn heard(&self, robot: usize, seconds: Range<u32>) -> Vec<Message>;
}
