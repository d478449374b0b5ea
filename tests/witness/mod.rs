//! An independent witness of the life kernel: one robot's life in plain scalar Rust, written by hand from the models
//! and from the order of operations in the WGSL. All backends share the compiler's front end, whose mistakes would be
//! invisible to tests that only compare backends with each other.
//!
//! `cargo bench` also compares the lane code's speed with it, so it is written to be fast: everything that a world's
//! lives share is computed once, and the distances that show a move to be free are reused for the next cycle's sensing.

use oneiro::random::{Key, pcg4d};
use oneiro::tables::MotorCell;
use oneiro::world::{Activation, Collision, Controller, Difference, Drawn, Speed, Start, Task, WorldSpec};

mod numerics;
use numerics::{cosine_sine, direction_by, floor, least, logistic, most, reciprocal_root, root};

const START: u32 = 0;
const SENSOR: u32 = 1;
const ACTUATOR: u32 = 2;
const ENVIRONMENT: u32 = 3;

/// Least squared distance, 2^-60.
const TOUCHING: f32 = 1.0 / (1_u64 << 60) as f32;

/// Gap to an object when a displaced robot is on its far side.
const BEHIND: f32 = 1_048_576.0;

/// An object of the arena: a segment with a radius, or a block around `from`.
struct Object<'a> {
    block: Option<Block>,
    from: [f32; 2],
    length: [f32; 2],
    scaled: [f32; 2],
    contact: f32,
    contact_squared: f32,
    reach_squared: f32,
    readings: &'a [u16],
}

/// Properties of a block besides its centre.
struct Block {
    axis: [f32; 2],
    half: [f32; 2],
    views: u32,
}

impl<'a> Object<'a> {
    fn all(spec: &'a WorldSpec) -> Vec<Self> {
        let walls = spec
            .arena
            .walls
            .iter()
            .map(|wall| (wall.from, wall.to, 0.0, &wall.class));
        let obstacles = spec
            .arena
            .obstacles
            .iter()
            .map(|o| ([o.x, o.y], [o.x, o.y], o.radius, &o.class));
        let blocks = spec.arena.blocks.iter().map(|block| {
            let at = [block.x, block.y];
            let own = Self::new(spec, at, at, 0.0, &block.class);
            let class = spec.robot.sensors.class(&block.class).expect("a checked world");
            Self {
                block: Some(Block {
                    axis: block.axis().to_array(),
                    half: [0.5 * block.length, 0.5 * block.width],
                    views: spec.robot.sensors.classes[class].views,
                }),
                ..own
            }
        });
        walls
            .chain(obstacles)
            .map(|(from, to, radius, class)| Self::new(spec, from, to, radius, class))
            .chain(blocks)
            .collect()
    }

    fn new(spec: &'a WorldSpec, from: [f32; 2], to: [f32; 2], radius: f32, class: &str) -> Self {
        let sensors = &spec.robot.sensors;
        let table = &sensors.classes[sensors.class(class).expect("a checked world")];
        let length = [to[0] - from[0], to[1] - from[1]];
        let squared = length[0] * length[0] + length[1] * length[1];
        let scaled = if squared == 0.0 {
            [0.0; 2]
        } else {
            [length[0] / squared, length[1] / squared]
        };
        let contact = spec.robot.body_radius + radius;
        let reach = contact + table.reach();
        Self {
            block: None,
            from,
            length,
            scaled,
            contact,
            contact_squared: contact * contact,
            reach_squared: reach * reach,
            readings: &table.readings,
        }
    }

    /// Vector from a point to the nearest point of the axis, or of a block; an object without length is at `from`.
    fn toward(&self, x: f32, y: f32) -> [f32; 2] {
        let (from_x, from_y) = (x - self.from[0], y - self.from[1]);
        if let Some(block) = &self.block {
            let own = self.within(block, x, y);
            let beyond = [0, 1].map(|side| own[side] - least(most(own[side], -block.half[side]), block.half[side]));
            let [cosine, sine] = block.axis;
            return [
                beyond[1] * sine - beyond[0] * cosine,
                -(beyond[0] * sine) - beyond[1] * cosine,
            ];
        }
        let along = from_x * self.scaled[0] + from_y * self.scaled[1];
        let along = least(most(along, 0.0), 1.0);
        [along * self.length[0] - from_x, along * self.length[1] - from_y]
    }
}

impl<'a> Object<'a> {
    /// Coordinates of a point along and across a block, from its centre.
    fn within(&self, block: &Block, x: f32, y: f32) -> [f32; 2] {
        let (from_x, from_y) = (x - self.from[0], y - self.from[1]);
        let [cosine, sine] = block.axis;
        [from_x * cosine + from_y * sine, from_y * cosine - from_x * sine]
    }

    /// Readings for an object seen from a point.
    fn seen_from(&self, x: f32, y: f32) -> &'a [u16] {
        let Some(block) = &self.block else {
            return self.readings;
        };
        let [along, across] = self.within(block, x, y);
        let inverse = reciprocal_root(most(squared([along, across]), TOUCHING));
        let twice = 2.0 * direction_by(along, across, inverse);
        let share = twice - floor(twice);
        let view = ((share * block.views as f32) as i32 as u32).min(block.views - 1);
        let cells = self.readings.len() / block.views as usize;
        &self.readings[view as usize * cells..][..cells]
    }
}

fn squared([x, y]: [f32; 2]) -> f32 {
    x * x + y * y
}

fn units(key: Key, stream: u32, step: u32, block: u32) -> [f32; 4] {
    pcg4d([key.words[0], key.words[1], step, stream << 16 | block]).map(|word| (word >> 8) as f32 / 16_777_216.0)
}

/// Motion of one pair of motor states, and its reward if nothing is near.
#[derive(Clone, Copy)]
struct Motion {
    displacement: f32,
    turn: f32,
    earned: f32,
}

impl Motion {
    fn new(task: Task, cell: &MotorCell) -> Self {
        let Task::Avoidance { speed, difference, .. } = task else {
            panic!("the witness knows equation 1 alone");
        };
        let speed = match speed {
            Speed::Unsigned => 0.5 * (cell.left.abs() + cell.right.abs()),
            Speed::Signed => 0.5 * (cell.left + cell.right),
        };
        let apart = 0.5 * (cell.left - cell.right).abs();
        let turning = match difference {
            Difference::Root => root(apart),
            Difference::Square => apart * apart,
        };
        Self {
            displacement: cell.displacement,
            turn: cell.turn,
            earned: speed * (1.0 - turning),
        }
    }
}

/// Data shared by all lives in one world.
pub(crate) struct Setting<'a> {
    spec: &'a WorldSpec,
    objects: Vec<Object<'a>>,
    /// At `left * states + right`.
    motions: Vec<Motion>,
    activation: Activation,
    /// Value of a new cell.
    new_cell: f32,
    /// From the sensor tables: gap of the first row, rows per mm, rows, bearings.
    nearest: f32,
    rows_per_mm: f32,
    rows: u32,
    bearings: u32,
}

impl<'a> Setting<'a> {
    /// Prepares a world with objects.
    pub(crate) fn new(spec: &'a WorldSpec) -> Self {
        let Task::Avoidance {
            activation, new_cell, ..
        } = spec.task
        else {
            panic!("the witness knows equation 1 alone");
        };
        let table = &spec.robot.sensors.classes[0];
        let cells = spec.robot.motors.cells.iter();
        Self {
            spec,
            objects: Object::all(spec),
            motions: cells.map(|cell| Motion::new(spec.task, cell)).collect(),
            activation,
            new_cell,
            nearest: table.nearest,
            rows_per_mm: 1.0 / table.spacing,
            rows: table.rows,
            bearings: table.bearings,
        }
    }

    /// Finds the objects within a robot's reach. Returns whether the robot is free; if not, some objects are missing, unless
    /// it sticks.
    fn around(&self, x: f32, y: f32, near: &mut Vec<Near>) -> bool {
        near.clear();
        let sticks = self.spec.robot.collision == Collision::Stick;
        let mut is_free = true;
        for (object, index) in self.objects.iter().zip(0..) {
            let to = object.toward(x, y);
            let squared = squared(to);
            if squared < object.reach_squared {
                if squared < object.contact_squared {
                    is_free = false;
                    if !sticks {
                        return false;
                    }
                }
                near.push(Near {
                    object: index,
                    to,
                    squared,
                });
            }
        }
        is_free
    }

    /// Final position of a body that slides along what it would touch at its goal.
    fn slide(&self, start: [f32; 2], goal: [f32; 2]) -> [f32; 2] {
        let touches = |object: &Object<'_>, [x, y]: [f32; 2]| squared(object.toward(x, y)) < object.contact_squared;
        let mut way = [goal[0] - start[0], goal[1] - start[1]];
        for object in self.objects.iter().filter(|object| touches(object, goal)) {
            let to = object.toward(start[0], start[1]);
            let inverse = reciprocal_root(most(squared(to), TOUCHING));
            let room = squared(to) * inverse - (object.contact + 0.003_906_25);
            let approach = (way[0] * to[0] + way[1] * to[1]) * inverse;
            if approach > room {
                for axis in 0..2 {
                    way[axis] -= (approach - room) * (to[axis] * inverse);
                }
            }
        }
        let end = [start[0] + way[0], start[1] + way[1]];
        let stays = self.objects.iter().any(|object| touches(object, end));
        if stays { start } else { end }
    }

    /// Adds the readings of an object in some direction.
    fn read(&self, readings: &[u16], to: [f32; 2], squared: f32, contact: f32, heading: f32, sums: &mut [u32; 8]) {
        let inverse = reciprocal_root(most(squared, TOUCHING));
        let gap = squared * inverse - contact;
        let row = most((gap - self.nearest) * self.rows_per_mm, 0.0) as i32 as u32;
        if row >= self.rows {
            return;
        }
        let clockwise = heading - direction_by(to[0], to[1], inverse);
        let share = clockwise - floor(clockwise);
        let bearing = ((share * self.bearings as f32) as i32 as u32).min(self.bearings - 1);
        let cell = &readings[8 * (row * self.bearings + bearing) as usize..][..8];
        for (sum, &reading) in sums.iter_mut().zip(cell) {
            *sum += u32::from(reading);
        }
    }
}

/// An object within reach.
#[derive(Clone, Copy)]
struct Near {
    object: usize,
    to: [f32; 2],
    squared: f32,
}

/// A life in progress.
pub(crate) struct Life<'a> {
    setting: &'a Setting<'a>,
    genes: &'a [f32],
    key: Key,
    x: f32,
    y: f32,
    heading: f32,
    /// Cosine and sine of the heading.
    facing: (f32, f32),
    /// Objects within reach of this pose, and a buffer for the next pose's.
    near: Vec<Near>,
    next_near: Vec<Near>,
    shift: [f32; 2],
    outputs: [f32; 2],
    /// Displacement and turn that were commanded last.
    commanded: [f32; 2],
    /// Cells of the field that it has visited, by column and row.
    visited: std::collections::HashSet<(i32, i32)>,
    /// Sum of all rewards so far.
    /// Whether it has stuck to what it touched.
    sticks: bool,
    pub(crate) fitness: f32,
}

impl<'a> Life<'a> {
    /// A life at its start. A random start must be free in one of 64 draws.
    pub(crate) fn new(setting: &'a Setting<'a>, genes: &'a [f32], key: Key) -> Self {
        let spec = setting.spec;
        let range = spec.noise.walk_range;
        let u = units(key, ENVIRONMENT, 0, 1);
        let mut near = Vec::with_capacity(setting.objects.len());
        let (x, y, heading) = match spec.start {
            Start::At { x, y, heading } => {
                setting.around(x, y, &mut near);
                (x, y, heading)
            }
            Start::Poses(_) | Start::Zone(_) => unreachable!("these worlds have neither"),
            Start::Random => {
                let field = spec.arena.field;
                (0..64)
                    .map(|draw| units(key, START, 0, draw))
                    .map(|u| (field.x + u[0] * field.width, field.y + u[1] * field.height, u[2]))
                    .find(|(x, y, _)| setting.around(*x, *y, &mut near))
                    .expect("a quarter of the field is free")
            }
        };
        Self {
            setting,
            genes,
            key,
            x,
            y,
            heading,
            facing: cosine_sine(heading),
            next_near: Vec::with_capacity(near.capacity()),
            near,
            shift: [(2.0 * u[0] - 1.0) * range, (2.0 * u[1] - 1.0) * range],
            outputs: [0.0; 2],
            commanded: [0.0; 2],
            visited: std::collections::HashSet::new(),
            sticks: false,
            fitness: 0.0,
        }
    }

    /// x and y in mm, heading in turns.
    pub(crate) fn pose(&self) -> [f32; 3] {
        [self.x, self.y, self.heading]
    }

    /// Lives one cycle of 100 ms. Returns the place that it senses from, and its readings, as perceived and before
    /// sensor noise.
    pub(crate) fn cycle(&mut self, step: u32) -> ([f32; 2], [[f32; 8]; 2]) {
        let spec = self.setting.spec;
        let seen = if spec.noise.walk_range > 0.0 {
            [self.x + self.shift[0], self.y + self.shift[1]]
        } else {
            [self.x, self.y]
        };
        let sums = if spec.noise.walk_range > 0.0 {
            self.sense_displaced(step)
        } else {
            self.sense()
        };
        let scale = spec.robot.sensors.reading_scale;
        let real = sums.map(|sum| least(sum as i32 as f32 * scale, 1.0));
        let perceived = self.with_noise(step, real);
        let outputs = self.control(&perceived);
        let mut moved = self.motion(step, outputs);
        if self.sticks {
            (moved.displacement, moved.turn) = (0.0, 0.0);
        }

        let (cosine, sine) = if spec.robot.turn_before_move == 0.0 {
            self.facing
        } else {
            cosine_sine(self.heading + spec.robot.turn_before_move * moved.turn)
        };
        let x = self.x + moved.displacement * cosine;
        let y = self.y + moved.displacement * sine;
        let mut earned = 0.0;
        if self.setting.around(x, y, &mut self.next_near) {
            std::mem::swap(&mut self.near, &mut self.next_near);
            let near = match self.setting.activation {
                Activation::Real => highest(&real),
                Activation::Perceived => highest(&perceived),
                Activation::None => 0.0,
            };
            earned = moved.earned * (1.0 - near);
            let heading = self.heading + moved.turn;
            (self.x, self.y, self.heading) = (x, y, heading - floor(heading));
            self.facing = cosine_sine(self.heading);
        } else if spec.robot.collision == Collision::Stick {
            std::mem::swap(&mut self.near, &mut self.next_near);
            let heading = self.heading + moved.turn;
            (self.x, self.y, self.heading) = (x, y, heading - floor(heading));
            self.facing = cosine_sine(self.heading);
            self.sticks = true;
        } else if spec.robot.collision != Collision::Undo {
            if spec.robot.collision == Collision::Slide {
                [self.x, self.y] = self.setting.slide([self.x, self.y], [x, y]);
            }
            let heading = self.heading + moved.turn;
            self.heading = heading - floor(heading);
            self.facing = cosine_sine(self.heading);
            self.setting.around(self.x, self.y, &mut self.near);
        }
        let setting = self.setting;
        if setting.new_cell > 0.0 {
            let cell = |at: f32, from: f32| most((at - from) * 0.02, 0.0) as i32;
            let field = spec.arena.field;
            if self.visited.insert((cell(self.x, field.x), cell(self.y, field.y))) {
                earned += setting.new_cell;
            }
        }
        self.fitness += earned;
        self.outputs = outputs;
        (seen, [perceived, real])
    }

    /// Sums of all objects' readings.
    fn sense(&self) -> [u32; 8] {
        let mut sums = [0; 8];
        for near in &self.near {
            let object = &self.setting.objects[near.object];
            let readings = object.seen_from(self.x, self.y);
            self.setting
                .read(readings, near.to, near.squared, object.contact, self.heading, &mut sums);
        }
        sums
    }

    /// The same from the position displaced by conservative noise, followed by the next step of that walk.
    fn sense_displaced(&mut self, step: u32) -> [u32; 8] {
        let noise = &self.setting.spec.noise;
        let shift = self.shift;
        let u = units(self.key, ENVIRONMENT, step, 0);
        for axis in 0..2 {
            self.shift[axis] = reflect(shift[axis] + (2.0 * u[axis] - 1.0) * noise.walk_step, noise.walk_range);
        }
        let (x, y) = (self.x + shift[0], self.y + shift[1]);
        let mut sums = [0; 8];
        for object in &self.setting.objects {
            let mut to = object.toward(x, y);
            let square = squared(to);
            if square >= object.reach_squared {
                continue;
            }
            let mut contact = object.contact;
            let unshifted = object.toward(self.x, self.y);
            let facing = unshifted[0] * to[0] + unshifted[1] * to[1];
            let mut from = [x, y];
            if object.block.is_some() && facing <= 0.0 {
                to = unshifted;
                contact = BEHIND;
                from = [self.x, self.y];
            } else if facing < 0.0 {
                to = [-to[0], -to[1]];
                contact = BEHIND;
            }
            let square = squared(to);
            let readings = object.seen_from(from[0], from[1]);
            self.setting
                .read(readings, to, square, contact, self.heading, &mut sums);
        }
        sums
    }

    /// The cycle whose draws count in a cycle.
    fn drawn(&self, step: u32) -> u32 {
        match self.setting.spec.noise.drawn {
            Some(Drawn::Life) => 0,
            Some(Drawn::Cycle) | None => step,
        }
    }

    fn with_noise(&self, step: u32, mut readings: [f32; 8]) -> [f32; 8] {
        let noise = &self.setting.spec.noise;
        let step = self.drawn(step);
        let draws = |block| {
            let (a, b) = (
                units(self.key, SENSOR, step, block),
                units(self.key, SENSOR, step, block + 1),
            );
            a.into_iter().chain(b)
        };
        if let Some(gain) = noise.gain {
            for (reading, u) in readings.iter_mut().zip(draws(2)) {
                *reading *= (2.0 * u - 1.0) * gain + 1.0;
            }
        }
        let (low, high) = noise.sensor;
        for (reading, u) in readings.iter_mut().zip(draws(0)) {
            *reading = (*reading + (u * (high - low) + low)).clamp(0.0, 1.0);
        }
        readings
    }

    fn control(&self, readings: &[f32; 8]) -> [f32; 2] {
        let genes = self.genes;
        match &self.setting.spec.controller {
            Controller::Perceptron => {
                let left = weighed(&genes[..9], readings) + genes[8];
                let right = weighed(&genes[9..18], readings) + genes[17];
                [logistic(left), logistic(right)]
            }
            Controller::Recurrent => [0, 11].map(|first| {
                let own = &genes[first..first + 11];
                let sum = weighed(own, readings);
                logistic(sum + own[8] * self.outputs[0] + own[9] * self.outputs[1] + own[10])
            }),
            Controller::Hidden { units } => {
                let biases = 11 * *units as usize;
                let mut sums = [genes[biases], genes[biases + 1]];
                for own in genes[..biases].chunks_exact(11) {
                    let output = logistic(weighed(own, readings) + own[8]);
                    sums[0] += own[9] * output;
                    sums[1] += own[10] * output;
                }
                sums.map(logistic)
            }
            Controller::Network(_)
            | Controller::StateMachine(_)
            | Controller::BehaviourTree(_)
            | Controller::Behaviours
            | Controller::Own => {
                unreachable!("the witness has the controllers of shipped kernels")
            }
        }
    }

    fn motion(&mut self, step: u32, [left, right]: [f32; 2]) -> Motion {
        let motors = &self.setting.spec.robot.motors;
        let noise = &self.setting.spec.noise;
        let state = |output: f32| ((output * motors.scale + motors.offset) as i32 as u32).min(motors.states - 1);
        let mut moved = self.setting.motions[(state(left) * motors.states + state(right)) as usize];
        let now = [moved.displacement, moved.turn];
        let u = units(self.key, ACTUATOR, self.drawn(step), 0);
        if let Some(delay) = noise.delay {
            moved.displacement += delay * u[3] * (self.commanded[0] - now[0]);
            moved.turn += delay * u[3] * (self.commanded[1] - now[1]);
        }
        if noise.motor > 0.0 {
            moved.displacement *= 1.0 + noise.motor * (2.0 * u[0] - 1.0);
            moved.turn *= 1.0 + noise.motor * (2.0 * u[1] - 1.0);
        }
        if let Some(veer) = noise.veer {
            moved.turn += veer * 1e-3 * (2.0 * u[2] - 1.0) * moved.displacement;
        }
        self.commanded = now;
        moved
    }
}

/// Sum of the first eight genes' products with the readings, from the first to the last.
fn weighed(genes: &[f32], readings: &[f32; 8]) -> f32 {
    let mut sum = genes[0] * readings[0];
    for (gene, reading) in genes[1..8].iter().zip(&readings[1..]) {
        sum += gene * reading;
    }
    sum
}

fn highest(readings: &[f32; 8]) -> f32 {
    readings.iter().fold(0.0, |highest, &reading| most(highest, reading))
}

/// Reflects a number at -range and range.
fn reflect(x: f32, range: f32) -> f32 {
    if x < -range {
        -2.0 * range - x
    } else if x > range {
        2.0 * range - x
    } else {
        x
    }
}
