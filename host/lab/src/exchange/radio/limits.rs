//! Limits of the values of packets.

use oneiro_evolve::encapsulated::GREATEST;

use super::{OPERATOR, Packet, Refusal, Status};
use crate::exchange::Message;

/// Maximum difference of a pair's second from the receiver's. Robots that receive no beacon for half a second stand, and a pair is sent
/// when its second begins.
pub(crate) const TOLERANCE: u32 = 2;

/// The earliest time of an experiment before it begins, and the latest after its end, ms: a day, and an hour.
const EARLIEST: i64 = -86_400_000;
const AFTERWARDS: i64 = 3_600_000;
/// Maximum distance from the origin, mm, and maximum voltage of a battery.
const FARTHEST: f32 = 1e5;
const VOLTS: f32 = 100.0;

/// Limits of packets' values that follow from an experiment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Number of robots; their numbers are below it.
    pub robots: u16,
    /// Seconds of an interval.
    pub interval: u32,
    /// Seconds within which robots are switched on.
    pub offset: u32,
    /// How many intervals before the present one is the one whose fitness robots report: 0 or 1.
    pub lag: u32,
    /// The maximum fitness that can be earned in an interval.
    pub fitness: f32,
    /// Seconds of the experiment.
    pub seconds: u32,
    /// The maximum number of items that a robot can bring in them.
    pub food: u32,
}

impl Limits {
    /// Whether a sender is a robot of the experiment, or its operator.
    pub(super) fn knows(&self, sender: u16) -> bool {
        sender < self.robots || sender == OPERATOR
    }

    /// Checks all values of a packet, in this second of the receiver's, if it is known.
    ///
    /// # Errors
    /// The name of the first value that is not allowed.
    pub(super) fn check(&self, packet: &Packet, sender: u16, second: Option<u32>) -> Result<(), Refusal> {
        let is_operator = sender == OPERATOR;
        let checks = match packet {
            Packet::Pair { second: at, message } => {
                let Message {
                    interval,
                    simulator,
                    fitness,
                    controller,
                    ..
                } = *message;
                vec![
                    ("kind", !is_operator),
                    ("second", second.is_none_or(|second| at.abs_diff(second) <= TOLERANCE)),
                    ("interval", self.is_interval(*at, interval)),
                    ("simulator", is_gene(simulator)),
                    ("fitness", self.is_fitness(fitness)),
                    ("controller", controller.into_iter().all(is_gene)),
                ]
            }
            Packet::Beacon { milliseconds, .. } => {
                vec![("kind", is_operator), ("milliseconds", self.is_time(*milliseconds))]
            }
            Packet::Call { .. } => vec![("kind", is_operator)],
            Packet::Status(status) => {
                let Status {
                    interval,
                    simulator,
                    real,
                    simulated,
                    controller,
                    brought,
                    pose: [x, y, heading],
                    volts,
                    ..
                } = *status;
                vec![
                    ("kind", !is_operator),
                    ("milliseconds", self.is_time(status.milliseconds)),
                    ("interval", interval <= self.seconds / self.interval),
                    ("simulator", is_gene(simulator)),
                    ("real", self.is_fitness(real)),
                    ("simulated", simulated == UNKNOWN || self.is_fitness(simulated)),
                    ("controller", controller.into_iter().all(is_gene)),
                    ("brought", brought <= self.food),
                    (
                        "pose",
                        [x, y].into_iter().all(|own| own.abs() <= FARTHEST) && (0.0..=1.0).contains(&heading),
                    ),
                    ("volts", volts == UNKNOWN || (0.0..=VOLTS).contains(&volts)),
                ]
            }
            Packet::Hello { .. } => Vec::new(),
        };
        match checks.into_iter().find(|(_, is_valid)| !is_valid) {
            Some((name, _)) => Err(Refusal::OutOfRange(name)),
            None => Ok(()),
        }
    }

    /// Whether a robot that was switched on in time may report an interval in a second.
    fn is_interval(&self, second: u32, interval: u32) -> bool {
        let latest = second / self.interval;
        let earliest = second.saturating_sub(self.offset) / self.interval;
        let present = interval.checked_add(self.lag);
        present.is_some_and(|present| (earliest..=latest).contains(&present))
    }

    fn is_time(&self, milliseconds: i64) -> bool {
        (EARLIEST..=1000 * i64::from(self.seconds) + AFTERWARDS).contains(&milliseconds)
    }

    fn is_fitness(&self, fitness: f32) -> bool {
        (0.0..=self.fitness).contains(&fitness)
    }
}

/// Marks an unknown value of a status.
const UNKNOWN: f32 = -1.0;

/// Whether a number is a gene that kernels take: 0, or normal and up to 0.99.
fn is_gene(gene: f32) -> bool {
    gene.to_bits() == 0 || (gene.is_normal() && (0.0..=GREATEST as f32).contains(&gene))
}
