//! Measures of a robot's behaviour in an episode, computed from its trace.
//!
//! The places of an episode are the positions of the robot's centre at the beginning of each cycle and at the end of the last.
//! All numbers are computed by operations that every processor rounds alike.

use std::collections::BTreeSet;
use std::sync::Arc;

use oneiro::arena::{Arena, Block, Field, Obstacle, Wall};
use oneiro::batch::{Record, Trace};
use oneiro::compose::{DetailKind, Kind, Scalar};
use oneiro::random::Key;
use oneiro::world::World;
use oneiro_base::contents::Column;
use oneiro_report::csv::number;

/// Cycles per second.
const CYCLES_A_SECOND: f64 = 10.0;
/// Number of successive places, 9.9 s, over which a stuck robot's path is shorter than [`STUCK`].
pub const PLACES: usize = 100;
/// Distance in mm.
const STUCK: f64 = 50.0;

/// Measures of a robot's behaviour.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measures {
    /// Cycles that end in a collision.
    pub collisions: u32,
    /// 50 mm squares of the arena's field that contain the robot's centre at the beginning of a cycle.
    pub cells: u32,
    /// Length of the path from place to place, mm.
    pub distance: f64,
    /// `distance` over the duration, mm/s.
    pub speed: f64,
    /// Time stuck, s: the union of all stretches of [`PLACES`] successive places in which the robot's path is shorter than 50 mm.
    pub stuck: f64,
    /// Mean size of its turning on the way, turns/s.
    pub turning: f64,
    /// Position at the end of the episode, mm.
    pub end: [f32; 2],
    /// Free distance from the body's rim to the nearest wall, block or round obstacle at the beginning of a cycle, mean over
    /// the cycles, mm; 0 where the body touches it.
    pub wall_distance: f64,
    /// The task's memory after the last cycle: the words of its scalars, in their order.
    pub memory: Vec<u32>,
    /// Score of each robot in a world of several; empty if not requested.
    pub scores: Vec<f32>,
}

/// A measure by its name: what `oneiro evaluate --measures` lists.
#[derive(Clone, Debug)]
pub struct Descriptor {
    /// Its name, unit and meaning.
    pub column: Column,
    source: Source,
}

/// Selects a measure of an episode.
type Measured = fn(&Measures) -> f64;

/// What a measure needs of each cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    Collisions,
    Cells,
    Path,
    Stuck,
    Turning,
    Room,
    /// The last cycle only.
    End,
}

/// Where a measure's value is.
#[derive(Clone, Copy, Debug)]
enum Source {
    Life(Part, Measured),
    /// A scalar of the task's memory.
    Memory(usize, Scalar),
    /// The score of the robot with this number.
    Score(u32),
}

impl Descriptor {
    /// The score of one of several robots.
    pub fn score(robot: u32) -> Self {
        Self {
            column: score_of(&robot.to_string()),
            source: Source::Score(robot),
        }
    }

    /// Its value in an episode.
    pub fn value(&self, measures: &Measures) -> f64 {
        match self.source {
            Source::Life(_, value) => value(measures),
            Source::Memory(index, scalar) => {
                let word = measures.memory.get(index).copied();
                word.map_or(f64::NAN, |word| match scalar {
                    Scalar::Float => f32::from_bits(word).into(),
                    Scalar::Unsigned => word.into(),
                    Scalar::Signed => word.cast_signed().into(),
                })
            }
            Source::Score(robot) => measures.scores.get(robot as usize).map_or(f64::NAN, |&own| own.into()),
        }
    }

    fn part(&self) -> Part {
        match self.source {
            Source::Life(part, _) => part,
            Source::Memory(..) | Source::Score(_) => Part::End,
        }
    }

    /// Its value as a cell of a table: measures to six digits, scalars of a task's memory in full.
    pub fn cell(&self, measures: &Measures) -> String {
        let value = self.value(measures);
        match self.source {
            Source::Life(..) => number(value),
            Source::Memory(_, Scalar::Float) | Source::Score(_) => (value as f32).to_string(),
            Source::Memory(..) => value.to_string(),
        }
    }
}

/// The measures of episodes in a world: those in [`LIFE`], and the scalars that its task remembers.
pub fn descriptors(world: &World) -> Vec<Descriptor> {
    let own = LIFE.iter().map(|(column, part, value)| Descriptor {
        column: column.clone(),
        source: Source::Life(*part, *value),
    });
    let remembered = world.details().iter().filter(|own| own.kind == MEMORY);
    let remembered = remembered.enumerate().map(|(index, own)| Descriptor {
        column: remembered_as(&own.name, own.scalar),
        source: Source::Memory(index, own.scalar),
    });
    own.chain(remembered).collect()
}

/// Trace details that are measures at the end of an episode.
const MEMORY: DetailKind = DetailKind::Memory(Kind::Task);

/// The column of a scalar that a task remembers.
pub fn remembered_as(name: &str, scalar: Scalar) -> Column {
    let column = match scalar {
        Scalar::Float => Column::number("", "", ""),
        Scalar::Unsigned | Scalar::Signed => Column::whole("", "", ""),
    };
    let about = format!("`{name}` of the task's memory after the last cycle");
    column.named(format!("end_task_{name}")).about(about)
}

/// The column of the score of one of several robots.
pub fn score_of(robot: &str) -> Column {
    let column = Column::number("", "", "").named(format!("score_robot_{robot}"));
    column.about(format!(
        "robot {robot}'s score from the task, counted from 0; only of swarms whose task scores each robot"
    ))
}

/// Measures that every episode has.
#[rustfmt::skip]
pub static LIFE: [(Column, Part, Measured); 9] = [
    (Column::whole("collisions", "cycles", "those that end in a collision"), Part::Collisions, |own| own.collisions.into()),
    (Column::whole("cells", "", "cells of 50 mm visited"), Part::Cells, |own| own.cells.into()),
    (Column::number("distance_mm", "mm", "the path's length"), Part::Path, |own| own.distance),
    (Column::number("mean_speed_mm_s", "mm/s", "the mean speed"), Part::Path, |own| own.speed),
    (Column::number("stuck_s", "s", "time stuck: less than 50 mm in 9.9 s"), Part::Stuck, |own| own.stuck),
    (Column::number("mean_turning_turns_s", "turns/s", "the mean size of its turns"), Part::Turning, |own| own.turning),
    (Column::number("end_x_mm", "mm", "x of the place where the episode ends, or where its last cycle begins if it ends early"), Part::End, |own| own.end[0].into()),
    (Column::number("end_y_mm", "mm", "y of that place"), Part::End, |own| own.end[1].into()),
    (Column::number("wall_distance_mm", "mm", "the free distance from the body's rim to the nearest wall, block or round obstacle, 0 where it touches: mean over the cycles, at the start of each"), Part::Room, |own| own.wall_distance),
];

/// The reference for measuring a world's episodes: squares, arena, and the measures.
#[derive(Debug)]
pub(crate) struct Frame {
    grid: Grid,
    arena: Arena,
    body_radius: f64,
    /// Indices of the task's memory among the trace's details.
    memory: Vec<usize>,
    /// Cycles of an episode.
    cycles: u32,
    /// What is measured: the bits of parts.
    parts: u32,
}

/// The frames of a world's episodes: one for each variant.
#[derive(Clone, Debug)]
pub(crate) struct Frames {
    world: World,
    of_variants: Vec<Arc<Frame>>,
}

impl Frames {
    /// As [`Frame::new`].
    pub(crate) fn new(world: &World, cycles: u32, wanted: &[Descriptor]) -> Self {
        let frame = |variant| Arc::new(Frame::new(variant, cycles, wanted));
        Self {
            world: world.clone(),
            of_variants: world.variants().iter().map(frame).collect(),
        }
    }

    /// That of an episode.
    pub(crate) fn of(&self, key: Key) -> Arc<Frame> {
        Arc::clone(&self.of_variants[self.world.variant(key)])
    }

    /// Whether the record of the last cycle is enough.
    pub(crate) fn needs_only_the_end(&self) -> bool {
        self.of_variants[0].needs_only_the_end()
    }
}

impl Frame {
    /// Measures episodes of `cycles` cycles by some descriptors; other measures are then meaningless, but take no time. Records
    /// of later cycles only count as places: the first of them is where the episode ends.
    pub(crate) fn new(world: &World, cycles: u32, wanted: &[Descriptor]) -> Self {
        let details = world.details().iter().enumerate();
        let spec = world.spec();
        Self {
            grid: Grid::new(spec.arena.within_walls()),
            arena: spec.arena.clone(),
            body_radius: spec.robot.body_radius.into(),
            memory: details
                .filter(|(_, own)| own.kind == MEMORY)
                .map(|(index, _)| index)
                .collect(),
            cycles,
            parts: wanted.iter().fold(0, |parts, own| parts | 1 << own.part() as u32),
        }
    }

    /// Whether the record of the last cycle is enough.
    pub(crate) fn needs_only_the_end(&self) -> bool {
        self.parts & !(1 << Part::End as u32) == 0
    }

    fn has(&self, part: Part) -> bool {
        self.parts & 1 << part as u32 != 0
    }

    /// Objects of the arena.
    fn objects(&self) -> usize {
        self.arena.walls.len() + self.arena.obstacles.len() + self.arena.blocks.len()
    }

    /// Distance of a point from an object, by its number: walls, then obstacles, then blocks.
    fn to_object(&self, number: usize, at: [f64; 2]) -> f64 {
        let Arena {
            walls,
            obstacles,
            blocks,
            ..
        } = &self.arena;
        let of_round = number.wrapping_sub(walls.len());
        let of_block = of_round.wrapping_sub(obstacles.len());
        match (walls.get(number), obstacles.get(of_round), blocks.get(of_block)) {
            (Some(wall), ..) => to_wall(wall, at),
            (_, Some(obstacle), _) => to_obstacle(obstacle, at),
            (.., Some(block)) => to_block(block, at),
            _ => f64::INFINITY,
        }
    }
}

/// Free distances along a path. An object that was far away at an earlier place can't be the nearest until the robot has come so much
/// nearer: so most objects are not looked at in most cycles.
#[derive(Debug)]
struct Room {
    /// Length of the path so far, rounded up, mm; at most [`Room::LONGEST`].
    path: f64,
    /// For each object, the length of the path before which it is at least `nearest` away, plus `nearest`.
    due: Vec<f64>,
    /// The object that was the nearest one.
    nearest: usize,
}

impl Room {
    /// Length of the path after which all objects are looked at, so that roundings stay far below [`Room::SLACK`].
    const LONGEST: f64 = 1e8;
    /// Distance in mm that is more than the roundings of distances in arenas. Moves and the axes of blocks are rounded to floats of
    /// 32 bits: a millionth is more than that.
    const SLACK: f64 = 1e-6;

    fn new(frame: &Frame) -> Self {
        Self {
            path: 0.0,
            due: vec![f64::NEG_INFINITY; frame.objects()],
            nearest: 0,
        }
    }

    /// The free distance after a move of this length, the same as [`free_distance`].
    fn after(&mut self, frame: &Frame, moved: f64, at: [f64; 2]) -> f64 {
        self.path += moved * (1.0 + 1e-6) + Self::SLACK;
        // Also if it is not a number.
        if !(self.path <= Self::LONGEST && at[0].abs() + at[1].abs() <= Self::LONGEST) {
            self.path = 0.0;
            self.due.fill(f64::NEG_INFINITY);
        }
        let mut least = f64::INFINITY;
        let nearest = self.nearest;
        for number in std::iter::once(nearest).chain(0..self.due.len()) {
            if number == nearest && least < f64::INFINITY
                || self.due.get(number).is_none_or(|due| *due > least + self.path)
            {
                continue;
            }
            let distance = frame.to_object(number, at);
            self.due[number] = distance * (1.0 - 1e-9) + self.path - Self::SLACK;
            if distance < least {
                (least, self.nearest) = (distance, number);
            }
        }
        (least - frame.body_radius).max(0.0)
    }
}

/// The sum of the last moves from place to place, and whether it is less than [`STUCK`].
#[derive(Debug)]
struct Moves {
    last: [f64; PLACES - 1],
    /// Place of the next one, and the number of them.
    next: usize,
    count: usize,
    /// Their sum with its rounding errors, and more than these.
    about: f64,
    doubt: f64,
}

impl Moves {
    fn new() -> Self {
        Self {
            last: [0.0; PLACES - 1],
            next: 0,
            count: 0,
            about: 0.0,
            doubt: 0.0,
        }
    }

    /// Adds a move. Returns whether all together are less than [`STUCK`], by the sum in their order; never of fewer.
    fn add(&mut self, length: f64) -> bool {
        let oldest = std::mem::replace(&mut self.last[self.next], length);
        self.next = (self.next + 1) % self.last.len();
        self.count = (self.count + 1).min(self.last.len());
        let more = self.about + length;
        self.about = more - oldest;
        // Two roundings, and those of the sum in order, each of at most half of this.
        self.doubt += 4.0 * f64::EPSILON * more;
        if self.count < self.last.len() {
            return false;
        }
        let roundings = self.last.len() as f64 * f64::EPSILON * (self.about.abs() + STUCK);
        if (self.about - STUCK).abs() > self.doubt + roundings {
            return self.about < STUCK;
        }
        // Also if it is not a number.
        let (newer, older) = self.last.split_at(self.next);
        let in_order = || older.iter().chain(newer).copied();
        self.about = in_order().sum();
        self.doubt = roundings;
        is_stuck(in_order())
    }
}

/// Free distance from the rim of a body at a place to the nearest object, mm.
pub(crate) fn free_distance(arena: &Arena, body_radius: f64, at: [f64; 2]) -> f64 {
    let Arena {
        walls,
        obstacles,
        blocks,
        ..
    } = arena;
    let walls = walls.iter().map(|wall| to_wall(wall, at));
    let obstacles = obstacles.iter().map(|obstacle| to_obstacle(obstacle, at));
    let blocks = blocks.iter().map(|block| to_block(block, at));
    let nearest = walls.chain(obstacles).chain(blocks).fold(f64::INFINITY, f64::min);
    (nearest - body_radius).max(0.0)
}

/// Distance of a point from a wall, which may have length 0.
fn to_wall(wall: &Wall, at: [f64; 2]) -> f64 {
    let [from, to] = [wall.from, wall.to].map(|end| end.map(f64::from));
    let (along, own) = (apart(to, from), apart(at, from));
    let length = dot(along, along);
    let share = if length > 0.0 { dot(own, along) / length } else { 0.0 };
    let share = share.clamp(0.0, 1.0);
    size(apart(own, along.map(|part| share * part)))
}

/// Distance of a point from a round obstacle, 0 inside.
fn to_obstacle(obstacle: &Obstacle, at: [f64; 2]) -> f64 {
    let centre = [obstacle.x, obstacle.y].map(f64::from);
    (size(apart(at, centre)) - f64::from(obstacle.radius)).max(0.0)
}

/// Distance of a point from a block, 0 inside. The block's axis is computed in f32, as in simulated episodes.
fn to_block(block: &Block, at: [f64; 2]) -> f64 {
    let axis = block.axis().to_array().map(f64::from);
    let own = apart(at, [block.x, block.y].map(f64::from));
    let beyond = |along: f64, side: f32| (along.abs() - 0.5 * f64::from(side)).max(0.0);
    size([
        beyond(dot(own, axis), block.length),
        beyond(dot(own, [-axis[1], axis[0]]), block.width),
    ])
}

fn apart(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn size(a: [f64; 2]) -> f64 {
    dot(a, a).sqrt()
}

/// Takes an episode's records in order. Memory doesn't grow with the episode's length.
#[derive(Debug)]
pub(crate) struct Meter {
    frame: Arc<Frame>,
    visited: BTreeSet<usize>,
    collisions: u32,
    distance: f64,
    turned: f64,
    place: Option<Record>,
    /// The square of the last cycle.
    cell: Option<usize>,
    /// The last moves from place to place.
    moves: Moves,
    /// Moves so far, and the number of them that count as stuck.
    moved: u32,
    stuck: u32,
    /// All earlier moves that can count have been counted.
    counted: u32,
    /// Cycles so far, the sum of their free distances, and the task's memory after the last.
    lived: u32,
    room: f64,
    free: Room,
    memory: Vec<u32>,
}

impl Meter {
    /// Measures an episode.
    pub(crate) fn new(frame: Arc<Frame>) -> Self {
        Self {
            free: Room::new(&frame),
            frame,
            visited: BTreeSet::new(),
            collisions: 0,
            distance: 0.0,
            turned: 0.0,
            place: None,
            cell: None,
            moves: Moves::new(),
            moved: 0,
            stuck: 0,
            counted: 0,
            lived: 0,
            room: 0.0,
            memory: Vec::new(),
        }
    }

    /// Takes the record of the next cycle, with its details.
    pub(crate) fn add(&mut self, record: &Record, details: &[u32]) {
        let mut length = 0.0;
        if let Some(last) = self.place.replace(*record) {
            self.moved += 1;
            if self.frame.has(Part::Path) || self.frame.has(Part::Stuck) || self.frame.has(Part::Room) {
                length = distance(&last, record);
            }
            if self.frame.has(Part::Path) {
                self.distance += length;
            }
            if self.frame.has(Part::Turning) {
                let turn = f64::from(record.heading) - f64::from(last.heading);
                self.turned += (turn - (turn + 0.5).floor()).abs();
            }
            if self.frame.has(Part::Stuck) && self.moves.add(length) {
                let first = self.counted.max(self.moved - (PLACES as u32 - 1));
                self.stuck += self.moved - first;
                self.counted = self.moved;
            }
            if self.moved >= self.frame.cycles {
                return;
            }
        }
        if self.frame.has(Part::Cells) {
            let cell = Some(self.frame.grid.cell(record));
            if self.cell != cell {
                self.visited.extend(cell);
                self.cell = cell;
            }
        }
        self.collisions += u32::from(record.collided > 0.0);
        self.lived += 1;
        if self.frame.has(Part::Room) {
            let at = [record.x, record.y].map(f64::from);
            self.room += self.free.after(&self.frame, length, at);
        }
        self.memory.clear();
        self.memory
            .extend(self.frame.memory.iter().map(|&index| details[index]));
    }

    /// Takes the records of the next cycles.
    pub(crate) fn add_all(&mut self, trace: &Trace) {
        for (record, details) in trace.lines() {
            self.add(record, details);
        }
    }

    /// Measures of the episode.
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
            wall_distance: self.room / f64::from(self.lived),
            memory: self.memory.clone(),
            scores: Vec::new(),
        }
    }
}

/// Whether a robot that makes these moves is stuck.
pub fn is_stuck(moves: impl Iterator<Item = f64>) -> bool {
    moves.sum::<f64>() < STUCK
}

/// Distances between successive places of a trace, mm.
pub fn moves(trace: &[Record]) -> impl Iterator<Item = f64> {
    trace.windows(2).map(|pair| distance(&pair[0], &pair[1]))
}

/// The distance between two places, mm.
pub fn distance(a: &Record, b: &Record) -> f64 {
    let (x, y) = (f64::from(a.x - b.x), f64::from(a.y - b.y));
    (x * x + y * y).sqrt()
}

/// The 50 mm squares that cover a field, row by row from its lower left corner.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    field: Field,
    pub columns: usize,
    pub rows: usize,
}

impl Grid {
    /// Side of a square, mm.
    pub const SIZE: f32 = 50.0;

    /// Covers a field; the squares at its right and upper edges may extend beyond it.
    pub fn new(field: Field) -> Self {
        Self {
            field,
            columns: (field.width / Self::SIZE).ceil() as usize,
            rows: (field.height / Self::SIZE).ceil() as usize,
        }
    }

    /// Index of the square that a robot is in.
    pub fn cell(&self, record: &Record) -> usize {
        let index = |x: f32| (x / Self::SIZE).max(0.0) as usize;
        let cell = index(record.y - self.field.y) * self.columns + index(record.x - self.field.x).min(self.columns - 1);
        cell.min(self.columns * self.rows - 1)
    }

    /// Centre of a square.
    pub fn middle(&self, cell: usize) -> [f32; 2] {
        let middle = |index: usize| (index as f32 + 0.5) * Self::SIZE;
        [
            self.field.x + middle(cell % self.columns),
            self.field.y + middle(cell / self.columns),
        ]
    }
}

#[cfg(test)]
mod tests {
    use oneiro::world::WorldSpec;

    use super::*;

    const FIELD: Field = Field {
        x: 0.0,
        y: 0.0,
        width: 600.0,
        height: 350.0,
    };

    fn frame(arena: Arena, cycles: u32) -> Arc<Frame> {
        Arc::new(Frame {
            grid: Grid::new(FIELD),
            arena,
            body_radius: 30.0,
            memory: Vec::new(),
            cycles,
            parts: u32::MAX,
        })
    }

    /// Measures of an episode with the given places.
    fn measured(places: &[[f32; 2]]) -> Measures {
        let mut meter = Meter::new(frame(Arena::default(), places.len() as u32 - 1));
        for &[x, y] in places {
            let record = Record {
                x,
                y,
                collided: f32::from(u8::from(x > 500.0)),
                ..Record::default()
            };
            meter.add(&record, &[]);
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
        let mut meter = Meter::new(frame(Arena::default(), 3));
        for heading in [0.95, 0.05, 0.95, 0.75] {
            let record = Record {
                heading,
                ..Record::default()
            };
            meter.add(&record, &[]);
        }
        // 0.1, 0.1 and 0.2 turns in 0.3 s.
        assert!((meter.finish().turning - 4.0 / 3.0).abs() < 1e-6);
    }

    #[test]
    fn collisions_are_cycles_and_the_end_is_none() {
        let measures = measured(&[[501.0, 10.0], [501.0, 10.0], [400.0, 10.0], [501.0, 10.0]]);
        assert_eq!((measures.collisions, measures.cells), (2, 2));
    }

    /// The robot drives for 20 s, stands for 30 s, and drives on for 10 s. It is stuck while it stands, and before and after that
    /// for as long as about 100 places contain less than 50 mm of its path.
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

    /// Free distances against those to points all over each object.
    #[test]
    fn free_distances_end_at_the_nearest_object() {
        let heading = 0.15;
        let block = Block {
            x: 400.0,
            y: 200.0,
            length: 120.0,
            width: 60.0,
            heading,
            ..Block::default()
        };
        let obstacle = Obstacle {
            x: 150.0,
            y: 120.0,
            radius: 40.0,
            ..Obstacle::default()
        };
        let wall = |from, to| Wall {
            from,
            to,
            ..Wall::default()
        };
        let arena = Arena {
            walls: vec![wall([0.0, 0.0], [500.0, 20.0]), wall([250.0, 300.0], [250.0, 300.0])],
            obstacles: vec![obstacle],
            blocks: vec![block],
            ..Arena::default()
        };
        let turn = f64::from(heading) * std::f64::consts::TAU;
        let grid = || (0..=200_i16).flat_map(|a| (0..=200_i16).map(move |b| [a, b].map(|own| f64::from(own) / 200.0)));
        let of_wall = grid().map(|[share, _]| [500.0 * share, 20.0 * share]);
        let of_round = grid().map(|[share, angle]| {
            let angle = angle * std::f64::consts::TAU;
            [150.0 + 40.0 * share * angle.cos(), 120.0 + 40.0 * share * angle.sin()]
        });
        let of_block = grid().map(|[length, width]| {
            let (along, across) = (120.0 * (length - 0.5), 60.0 * (width - 0.5));
            let x = 400.0 + along * turn.cos() - across * turn.sin();
            [x, 200.0 + along * turn.sin() + across * turn.cos()]
        });
        let points: Vec<[f64; 2]> = of_wall
            .chain(of_round)
            .chain(of_block)
            .chain([[250.0, 300.0]])
            .collect();
        let frame = frame(arena, 1);
        let mut touching = 0;
        for [x, y] in grid().step_by(97).map(|share| share.map(|share| 600.0 * share - 20.0)) {
            let record = Record {
                x: x as f32,
                y: y as f32,
                ..Record::default()
            };
            let [x, y] = [record.x, record.y].map(f64::from);
            let nearest = points
                .iter()
                .map(|point| (point[0] - x).hypot(point[1] - y))
                .fold(f64::MAX, f64::min);
            let room = free_distance(&frame.arena, frame.body_radius, [x, y]);
            let expected = (nearest - 30.0).max(0.0);
            assert!(
                room <= expected + 1e-4 && expected < room + 1.5,
                "at {x}, {y}: {room}, {expected}"
            );
            touching += u32::from(room == 0.0);
        }
        assert!((30..300).contains(&touching), "{touching}");
    }

    /// What is left out of sums and of searches for the nearest object changes no bit: along drives that turn, stand still, jump and
    /// leave the arena.
    #[test]
    fn shortcuts_change_no_bit() {
        let wall = |from, to| Wall {
            from,
            to,
            ..Wall::default()
        };
        let block = |x, y| Block {
            x,
            y,
            length: 120.0,
            width: 60.0,
            heading: 0.15,
            ..Block::default()
        };
        let obstacle = |x, y| Obstacle {
            x,
            y,
            radius: 40.0,
            ..Obstacle::default()
        };
        let arena = Arena {
            walls: vec![
                wall([0.0, 0.0], [900.0, 20.0]),
                wall([900.0, 20.0], [900.0, 600.0]),
                wall([250.0, 300.0], [250.0, 300.0]),
            ],
            obstacles: vec![obstacle(150.0, 120.0), obstacle(700.0, 400.0)],
            blocks: vec![block(400.0, 200.0), block(600.0, 500.0)],
            ..Arena::default()
        };
        let frame = frame(arena, 1);
        let (mut room, mut moves) = (Room::new(&frame), Moves::new());
        let (mut last, mut lengths, mut looks) = (None::<Record>, Vec::new(), [0, 0]);
        for cycle in 0..20_000_u32 {
            let random = oneiro::random::pcg4d([cycle, 0, 0, 7]).map(|word| (word >> 8) as f32 / 16_777_216.0);
            // Slow, so that a hundred moves are about 50 mm, or at rest, or fast; now and then elsewhere at once.
            let speed = [0.5, 0.505, 0.0, 30.0][(cycle / 500 % 4) as usize];
            let at =
                |own: fn(&Record) -> f32, part: f32| last.as_ref().map_or(300.0, own) + speed * (part - 0.5).signum();
            let [x, y] = match cycle % 4_999 {
                0 => [900.0 * random[0], 600.0 * random[1]],
                1 if cycle > 10_000 => [1e9, f32::NAN],
                2 => [500.0, 300.0],
                _ => [at(|own| own.x, random[0]), last.as_ref().map_or(300.0, |own| own.y)],
            };
            let record = Record {
                x,
                y,
                ..Record::default()
            };
            let length = last.map_or(0.0, |last| distance(&last, &record));
            let place = [x, y].map(f64::from);
            let (short, whole) = (
                room.after(&frame, length, place),
                free_distance(&frame.arena, frame.body_radius, place),
            );
            assert_eq!(short.to_bits(), whole.to_bits(), "cycle {cycle} at {x}, {y}");
            if last.replace(record).is_some() {
                lengths.push(length);
                let stuck = moves.add(length);
                let window = &lengths[lengths.len().saturating_sub(PLACES - 1)..];
                let expected = window.len() == PLACES - 1 && is_stuck(window.iter().copied());
                assert_eq!(stuck, expected, "cycle {cycle}");
                looks[usize::from(stuck)] += 1;
            }
        }
        assert!(looks.into_iter().all(|count| count > 1_000), "{looks:?}");
    }

    /// A requested measure does not depend on what else is measured.
    #[test]
    fn a_measure_alone_is_the_same() {
        let world = World::new(WorldSpec::miglino1995()).unwrap();
        let known = descriptors(&world);
        let life = |frame: Frame| {
            let mut meter = Meter::new(Arc::new(frame));
            for cycle in 0..400_u16 {
                let along = f32::from(cycle % 250);
                let record = Record {
                    x: 100.0 + along,
                    y: 60.0 + 0.3 * along,
                    heading: 0.001 * along,
                    collided: f32::from(cycle % 7 / 6),
                    ..Record::default()
                };
                // It stands still at the end.
                let still = Record {
                    x: 300.0,
                    y: 90.0,
                    ..record
                };
                meter.add(if cycle < 200 { &record } else { &still }, &[]);
            }
            meter.finish()
        };
        let all = life(Frame::new(&world, 400, &known));
        for own in &known {
            let alone = life(Frame::new(&world, 400, std::slice::from_ref(own)));
            assert!(own.value(&all) != 0.0, "{}", own.column.name);
            assert_eq!(
                own.value(&alone).to_bits(),
                own.value(&all).to_bits(),
                "{}",
                own.column.name
            );
        }
        let only = |name: &str| {
            let own = known.iter().find(|own| own.column.name == name).unwrap();
            Frame::new(&world, 400, std::slice::from_ref(own)).needs_only_the_end()
        };
        assert!(only("end_x_mm") && only("end_y_mm") && !only("collisions") && !only("mean_speed_mm_s"));
    }

    /// The record after the last cycle only gives the place where the episode ends.
    #[test]
    fn distances_and_memory_are_those_of_the_cycles() {
        let wall = Wall {
            from: [0.0, 0.0],
            to: [500.0, 0.0],
            ..Wall::default()
        };
        let arena = Arena {
            walls: vec![wall],
            ..Arena::default()
        };
        let whole = Frame {
            memory: vec![2, 0],
            ..Arc::into_inner(frame(arena, 3)).unwrap()
        };
        let mut meter = Meter::new(Arc::new(whole));
        for (y, word) in [(50.0, 1), (20.0, 2), (70.0, 3), (500.0, 4)] {
            let record = Record {
                x: 100.0,
                y,
                ..Record::default()
            };
            meter.add(&record, &[word, 9, 10 * word]);
        }
        let measures = meter.finish();
        assert_eq!(measures.wall_distance, (20.0 + 0.0 + 40.0) / 3.0);
        assert_eq!(measures.memory, [30, 3]);
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
