//! Measures of a robot's behaviour, from the trace of its life.
//!
//! The places of a life are the positions of the robot's centre at the beginning of each cycle, and at the end of the
//! last.

use std::collections::{BTreeSet, VecDeque};

use oneiro::arena::Field;
use oneiro::batch::Record;

/// Cycles per second.
const CYCLES_A_SECOND: f64 = 10.0;
/// Number of successive places, 9.9 s, over which a stuck robot goes less than [`STUCK`].
pub(crate) const PLACES: usize = 100;
/// Distance in mm.
const STUCK: f64 = 50.0;

/// Measures of a robot's behaviour.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Measures {
    /// Cycles that end in a collision.
    pub(crate) collisions: u32,
    /// 50 mm squares of the arena's field that contain the robot's centre at the beginning of a cycle.
    pub(crate) cells: u32,
    /// Length of the path from place to place, mm.
    pub(crate) distance: f64,
    /// `distance` over the duration, mm/s.
    pub(crate) speed: f64,
    /// Time stuck, s: the union of all stretches of [`PLACES`] successive places in which the robot goes less than 50
    /// mm.
    pub(crate) stuck: f64,
    /// Turning on the way, mean of its size, turns/s.
    pub(crate) turning: f64,
    /// Position where the life ends, mm.
    pub(crate) end: [f32; 2],
}

/// Takes the records of a life, one after another. Its memory doesn't grow with the life's length.
#[derive(Debug)]
pub(crate) struct Meter {
    grid: Grid,
    cycles: u32,
    visited: BTreeSet<usize>,
    collisions: u32,
    distance: f64,
    turned: f64,
    place: Option<Record>,
    /// Lengths of the last moves from place to place.
    moves: VecDeque<f64>,
    /// Moves so far, and the number of them that count as stuck.
    moved: u32,
    stuck: u32,
    /// All earlier moves that can count have been counted.
    counted: u32,
}

impl Meter {
    /// Measures a life of `cycles` cycles. Records of later cycles only count as places: the first of them is where the
    /// life ends.
    pub(crate) fn new(field: Field, cycles: u32) -> Self {
        Self {
            grid: Grid::new(field),
            cycles,
            visited: BTreeSet::new(),
            collisions: 0,
            distance: 0.0,
            turned: 0.0,
            place: None,
            moves: VecDeque::with_capacity(PLACES),
            moved: 0,
            stuck: 0,
            counted: 0,
        }
    }

    /// Takes the record of the next cycle.
    pub(crate) fn add(&mut self, record: &Record) {
        if let Some(last) = self.place.replace(*record) {
            let length = distance(&last, record);
            self.distance += length;
            let turn = f64::from(record.heading) - f64::from(last.heading);
            self.turned += (turn - (turn + 0.5).floor()).abs();
            self.moved += 1;
            if self.moves.len() == PLACES - 1 {
                self.moves.pop_front();
            }
            self.moves.push_back(length);
            if self.moves.len() == PLACES - 1 && is_stuck(self.moves.iter().copied()) {
                let first = self.counted.max(self.moved - self.moves.len() as u32);
                self.stuck += self.moved - first;
                self.counted = self.moved;
            }
            if self.moved >= self.cycles {
                return;
            }
        }
        self.visited.insert(self.grid.cell(record));
        self.collisions += u32::from(record.collided > 0.0);
    }

    /// Measures of the life.
    pub(crate) fn finish(&self) -> Measures {
        let seconds = |moves: u32| f64::from(moves) / CYCLES_A_SECOND;
        let duration = seconds(self.moved.max(1));
        Measures {
            collisions: self.collisions,
            cells: self.visited.len() as u32,
            distance: self.distance,
            speed: self.distance / duration,
            turning: self.turned / duration,
            end: self.place.map_or([f32::NAN; 2], |place| [place.x, place.y]),
            stuck: seconds(self.stuck),
        }
    }
}

/// Whether a robot that makes these moves is stuck.
pub(crate) fn is_stuck(moves: impl Iterator<Item = f64>) -> bool {
    moves.sum::<f64>() < STUCK
}

/// Distances between successive places of a trace, mm.
pub(crate) fn moves(trace: &[Record]) -> impl Iterator<Item = f64> {
    trace.windows(2).map(|pair| distance(&pair[0], &pair[1]))
}

/// The distance between two places, mm.
pub(crate) fn distance(a: &Record, b: &Record) -> f64 {
    let (x, y) = (f64::from(a.x - b.x), f64::from(a.y - b.y));
    (x * x + y * y).sqrt()
}

/// The 50 mm squares that cover a field, row by row from its lower left corner.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid {
    field: Field,
    pub(crate) columns: usize,
    pub(crate) rows: usize,
}

impl Grid {
    /// Side of a square, mm.
    pub(crate) const SIZE: f32 = 50.0;

    /// Covers a field; the squares at its right and upper edges may extend beyond it.
    pub(crate) fn new(field: Field) -> Self {
        Self {
            field,
            columns: (field.width / Self::SIZE).ceil() as usize,
            rows: (field.height / Self::SIZE).ceil() as usize,
        }
    }

    /// Index of the square that a robot is in.
    pub(crate) fn cell(&self, record: &Record) -> usize {
        let index = |x: f32| (x / Self::SIZE).max(0.0) as usize;
        let cell = index(record.y - self.field.y) * self.columns + index(record.x - self.field.x).min(self.columns - 1);
        cell.min(self.columns * self.rows - 1)
    }

    /// Centre of a square.
    pub(crate) fn middle(&self, cell: usize) -> [f32; 2] {
        let middle = |index: usize| (index as f32 + 0.5) * Self::SIZE;
        [
            self.field.x + middle(cell % self.columns),
            self.field.y + middle(cell / self.columns),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIELD: Field = Field {
        x: 0.0,
        y: 0.0,
        width: 600.0,
        height: 350.0,
    };

    /// Measures of a life with the given places.
    fn measured(places: &[[f32; 2]]) -> Measures {
        let mut meter = Meter::new(FIELD, places.len() as u32 - 1);
        for &[x, y] in places {
            meter.add(&Record {
                x,
                y,
                collided: f32::from(u8::from(x > 500.0)),
                ..Record::default()
            });
        }
        meter.finish()
    }

    #[test]
    fn a_straight_drive() {
        // 8 mm a cycle, from the first square into the eighth; the last place is in the ninth.
        let places: Vec<[f32; 2]> = (0..=50_u8).map(|cycle| [f32::from(cycle) * 8.0, 10.0]).collect();
        let measures = measured(&places);
        assert_eq!((measures.end, measures.turning), ([400.0, 10.0], 0.0));
        assert_eq!((measures.collisions, measures.cells), (0, 8));
        assert_eq!((measures.distance, measures.speed, measures.stuck), (400.0, 80.0, 0.0));
    }

    #[test]
    fn turns_count_by_their_size_across_a_whole_turn() {
        let mut meter = Meter::new(FIELD, 3);
        for heading in [0.95, 0.05, 0.95, 0.75] {
            meter.add(&Record {
                heading,
                ..Record::default()
            });
        }
        // 0.1, 0.1 and 0.2 turns in 0.3 s.
        assert!((meter.finish().turning - 4.0 / 3.0).abs() < 1e-6);
    }

    #[test]
    fn collisions_are_cycles_and_the_end_is_none() {
        let measures = measured(&[[501.0, 10.0], [501.0, 10.0], [400.0, 10.0], [501.0, 10.0]]);
        assert_eq!((measures.collisions, measures.cells), (2, 2));
    }

    /// The robot drives for 20 s, stands for 30 s, and drives on for 10 s. It is stuck while it stands, and before and
    /// after that as long as some 100 places contain less than 50 mm of its path.
    #[test]
    fn time_stuck_counts_each_moment_once() {
        let mut x = 0.0;
        let mut places = vec![[x, 100.0]];
        for cycle in 0..600 {
            if !(200..500).contains(&cycle) {
                x += 1.0;
            }
            places.push([x, 100.0]);
        }
        let stuck = measured(&places).stuck;
        // 49 moves of 1 mm at either end.
        assert_eq!(stuck, 30.0 + 2.0 * 4.9);
        let still = vec![[10.0, 10.0]; 501];
        assert_eq!(measured(&still).stuck, 50.0);
        assert_eq!(
            measured(&still[..99]).stuck,
            0.0,
            "nobody is stuck in less than 100 places"
        );
        assert_eq!(measured(&still[..100]).stuck, 9.9);
    }

    #[test]
    fn squares_cover_the_field() {
        let grid = Grid::new(FIELD);
        assert_eq!((grid.columns, grid.rows), (12, 7));
        for cell in 0..84 {
            let [x, y] = grid.middle(cell);
            let record = Record {
                x,
                y,
                ..Record::default()
            };
            assert_eq!(grid.cell(&record), cell);
        }
        let beyond = Record {
            x: 1e4,
            y: 1e4,
            ..Record::default()
        };
        assert_eq!(grid.cell(&beyond), 83);
    }
}
