//! Who may hear whom: robots that meet, or islands with fixed links, as in spatially structured evolutionary algorithms (Sprave 1999;
//! Tomassini 2005).

use oneiro::parameter::{Choice, Choices};
use oneiro_evolve::random::{Stream, stream, unit};

/// The robots whose messages can reach a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Topology {
    /// Those that it meets.
    Encounters,
    /// All others.
    All,
    /// Those with the numbers before and after its own.
    Ring,
    /// Its neighbours in a grid without borders, the most square one that the number of robots divides into: four if both sides have
    /// three robots or more.
    Torus,
}

impl Choice for Topology {
    const CHOICES: Choices<Self> = &[
        ("encounters", Self::Encounters, "those that it meets"),
        ("all", Self::All, "all others, wherever they are"),
        ("ring", Self::Ring, "those with the numbers before and after its own"),
        (
            "torus",
            Self::Torus,
            "its neighbours in a grid without borders, by their numbers: the most square grid that the number of robots divides into; four of them, fewer where a side has less than three robots",
        ),
    ];
}

impl Topology {
    /// The robots that one is linked to, a bit each; none if encounters decide.
    fn linked(self, robot: usize, robots: usize) -> Option<u128> {
        let bits = |others: &[usize]| others.iter().fold(0, |mask, other| mask | 1_u128 << other) & !(1 << robot);
        // A neighbour in a ring of so many robots, of which this is the number `at`.
        let beside = |at: usize, count: usize| [(at + 1) % count, (at + count - 1) % count];
        match self {
            Self::Encounters => None,
            Self::All => Some(u128::MAX >> (u128::BITS as usize - robots) & !(1 << robot)),
            Self::Ring => Some(bits(&beside(robot, robots))),
            Self::Torus => {
                let width = (1..=robots).find(|width| robots.is_multiple_of(*width) && width * width >= robots);
                let width = width.unwrap_or(robots);
                let (row, column) = (robot / width, robot % width);
                let in_row = beside(column, width).map(|column| row * width + column);
                let in_column = beside(row, robots / width).map(|row| row * width + column);
                Some(bits(&[in_row, in_column].concat()))
            }
        }
    }
}

/// Links between robots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Links {
    pub topology: Topology,
    /// Chance that messages of one robot can reach another one during an interval.
    pub migration: f64,
}

impl Links {
    /// Those of robots that meet.
    pub const ENCOUNTERS: Self = Self {
        topology: Topology::Encounters,
        migration: 1.0,
    };

    /// Whom each robot can hear in an interval, by its clock: its links, and those of them that are open.
    pub(crate) fn open(&self, seed: u64, interval: u32, robots: usize) -> Vec<Heard> {
        let mut random = stream(seed, Stream::Migration, interval);
        let mut drawn = |_| {
            (0..robots).fold(0, |mask, other| {
                mask | u128::from(unit(&mut random) < self.migration) << other
            })
        };
        let each = (0..robots).map(|robot| (self.topology.linked(robot, robots), drawn(robot)));
        each.map(|(linked, open)| Heard { linked, open }).collect()
    }
}

/// Whom a robot can hear in an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Heard {
    linked: Option<u128>,
    open: u128,
}

impl Heard {
    /// The senders of the received messages, a bit each; `met` has the robots in range.
    pub(crate) fn of(self, met: u128) -> u128 {
        self.linked.unwrap_or(met) & self.open
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn neighbours(topology: Topology, robot: usize, robots: usize) -> Vec<usize> {
        let mask = topology.linked(robot, robots).unwrap();
        (0..128).filter(|other| mask >> other & 1 == 1).collect()
    }

    #[test]
    fn neighbours_are_those_worked_out_by_hand() {
        assert_eq!(neighbours(Topology::Ring, 0, 10), [1, 9]);
        // Two rows of five.
        assert_eq!(neighbours(Topology::Torus, 6, 10), [1, 5, 7]);
        assert_eq!(neighbours(Topology::Torus, 9, 10), [4, 5, 8]);
        // Three rows of four.
        assert_eq!(neighbours(Topology::Torus, 0, 12), [1, 3, 4, 8]);
        assert_eq!(neighbours(Topology::All, 1, 4), [0, 2, 3]);
        assert_eq!(neighbours(Topology::All, 127, 128).len(), 127);
        // A prime number of robots is one row; nobody is a neighbour of itself.
        assert_eq!(neighbours(Topology::Torus, 3, 7), [2, 4]);
        for topology in [Topology::Ring, Topology::Torus, Topology::All] {
            assert_eq!(neighbours(topology, 0, 1), [0; 0]);
            assert_eq!(neighbours(topology, 1, 2), [0]);
        }
        assert_eq!(Topology::Encounters.linked(0, 10), None);
    }

    #[test]
    fn links_are_open_with_the_chance_and_in_each_direction_by_itself() {
        let links = Links {
            topology: Topology::All,
            migration: 0.25,
        };
        let (mut open, mut both) = (0, 0);
        for interval in 0..400 {
            let heard = links.open(7, interval, 10);
            let hears = |robot: usize, other: usize| heard[robot].of(0) >> other & 1 == 1;
            for robot in 0..10 {
                assert!(!hears(robot, robot));
                for other in (0..10).filter(|other| *other != robot) {
                    open += u32::from(hears(robot, other));
                    both += u32::from(hears(robot, other) && hears(other, robot));
                }
            }
        }
        // Of 36,000 links, within five standard deviations.
        assert!((8_590..=9_410).contains(&open), "{open}");
        assert!((1_900..=2_600).contains(&both), "{both}");
        let always = Links {
            migration: 1.0,
            ..links
        };
        assert!(always.open(7, 0, 10).iter().all(|heard| heard.of(0).count_ones() == 9));
        let met = Links::ENCOUNTERS.open(7, 0, 10);
        assert_eq!(met[3].of(0b1_0000_0100), 0b1_0000_0100);
    }
}
