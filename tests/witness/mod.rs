//! An independent witness of the life kernel: one robot's life in plain scalar Rust, written by hand from the
//! models and from the order of operations that the WGSL states. Every backend shares the compiler's front end,
//! whose mistakes would be invisible to tests that only compare backends with each other.
//!
//! It is also what `cargo bench` measures the lane code against.

use oneiro::random::{Key, pcg4d};
use oneiro::tables::{MotorCell, SensorTable};
use oneiro::world::{Activation, Controller, Difference, Speed, Start, Task, WorldSpec};

mod numerics;
use numerics::{cosine_sine, direction_by, floor, logistic, reciprocal_root, root};

const START: u32 = 0;
const SENSOR: u32 = 1;
const ACTUATOR: u32 = 2;
const ENVIRONMENT: u32 = 3;

/// Squared distances are taken to be at least this, 2^-60.
const TOUCHING: f32 = 1.0 / (1_u64 << 60) as f32;

/// An object of the arena, as a segment with a radius.
struct Object<'a> {
    from: [f32; 2],
    length: [f32; 2],
    scaled: [f32; 2],
    contact: f32,
    reach_squared: f32,
    table: &'a SensorTable,
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
        walls
            .chain(obstacles)
            .map(|(from, to, radius, class)| Self::new(spec, from, to, radius, class))
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
            from,
            length,
            scaled,
            contact,
            reach_squared: reach * reach,
            table,
        }
    }

    /// From a point to the nearest point of the axis.
    fn toward(&self, x: f32, y: f32) -> [f32; 2] {
        let (from_x, from_y) = (x - self.from[0], y - self.from[1]);
        if self.length == [0.0; 2] {
            return [-from_x, -from_y];
        }
        let along = from_x * self.scaled[0] + from_y * self.scaled[1];
        let along = along.clamp(0.0, 1.0);
        [along * self.length[0] - from_x, along * self.length[1] - from_y]
    }
}

fn squared([x, y]: [f32; 2]) -> f32 {
    x * x + y * y
}

fn units(key: Key, stream: u32, step: u32, block: u32) -> [f32; 4] {
    pcg4d([key.0[0], key.0[1], step, stream << 16 | block]).map(|word| (word >> 8) as f32 / 16_777_216.0)
}

/// A life in progress.
pub(crate) struct Life<'a> {
    spec: &'a WorldSpec,
    objects: Vec<Object<'a>>,
    genes: &'a [f32],
    key: Key,
    x: f32,
    y: f32,
    heading: f32,
    shift: [f32; 2],
    outputs: [f32; 2],
    /// The sum of all rewards so far.
    pub(crate) fitness: f32,
}

impl<'a> Life<'a> {
    /// A life at its start. For worlds with random starts of which one of 64 draws is free.
    pub(crate) fn new(spec: &'a WorldSpec, genes: &'a [f32], key: Key) -> Self {
        let range = spec.noise.walk_range;
        let u = units(key, ENVIRONMENT, 0, 1);
        let mut life = Self {
            spec,
            objects: Object::all(spec),
            genes,
            key,
            x: 0.0,
            y: 0.0,
            heading: 0.0,
            shift: [(2.0 * u[0] - 1.0) * range, (2.0 * u[1] - 1.0) * range],
            outputs: [0.0; 2],
            fitness: 0.0,
        };
        (life.x, life.y, life.heading) = match spec.start {
            Start::At { x, y, heading } => (x, y, heading),
            Start::Random => life.random_pose(),
        };
        life
    }

    fn random_pose(&self) -> (f32, f32, f32) {
        let field = self.spec.arena.field;
        (0..64)
            .map(|draw| units(self.key, START, 0, draw))
            .map(|u| (field.x + u[0] * field.width, field.y + u[1] * field.height, u[2]))
            .find(|(x, y, _)| !self.touches(*x, *y))
            .expect("a quarter of the field is free")
    }

    fn touches(&self, x: f32, y: f32) -> bool {
        self.objects
            .iter()
            .any(|object| squared(object.toward(x, y)) < object.contact * object.contact)
    }

    /// x and y in mm, heading in turns.
    pub(crate) fn pose(&self) -> [f32; 3] {
        [self.x, self.y, self.heading]
    }

    /// One cycle of 100 ms.
    pub(crate) fn cycle(&mut self, step: u32) {
        let noise = &self.spec.noise;
        let mut shift = [0.0; 2];
        if noise.walk_range > 0.0 {
            shift = self.shift;
            let u = units(self.key, ENVIRONMENT, step, 0);
            for axis in 0..2 {
                self.shift[axis] = reflect(shift[axis] + (2.0 * u[axis] - 1.0) * noise.walk_step, noise.walk_range);
            }
        }
        let real = self.sense(shift);
        let perceived = self.with_noise(step, real);
        let outputs = self.control(&perceived);
        let moved = self.motion(step, outputs);

        let (cosine, sine) = cosine_sine(self.heading + self.spec.robot.turn_before_move * moved.turn);
        let x = self.x + moved.displacement * cosine;
        let y = self.y + moved.displacement * sine;
        let collided = self.touches(x, y);
        self.fitness += if collided {
            0.0
        } else {
            self.reward(&moved, &real, &perceived)
        };
        if !collided {
            let heading = self.heading + moved.turn;
            (self.x, self.y, self.heading) = (x, y, heading - floor(heading));
        }
        self.outputs = outputs;
    }

    fn sense(&self, shift: [f32; 2]) -> [f32; 8] {
        let (x, y) = (self.x + shift[0], self.y + shift[1]);
        let mut sums = [0_u32; 8];
        for object in &self.objects {
            let mut to = object.toward(x, y);
            if squared(to) >= object.reach_squared {
                continue;
            }
            let mut contact = object.contact;
            if self.spec.noise.walk_range > 0.0 {
                let unshifted = object.toward(self.x, self.y);
                if unshifted[0] * to[0] + unshifted[1] * to[1] < 0.0 {
                    to = [-to[0], -to[1]];
                    contact = 1_048_576.0;
                }
            }
            let table = object.table;
            let square = squared(to);
            let inverse = reciprocal_root(if square > TOUCHING { square } else { TOUCHING });
            let gap = square * inverse - contact;
            let row = (gap - table.nearest) * (1.0 / table.spacing);
            let row = if row > 0.0 { row as u32 } else { 0 };
            if row >= table.rows {
                continue;
            }
            let clockwise = self.heading - direction_by(to[0], to[1], inverse);
            let share = clockwise - floor(clockwise);
            let bearing = ((share * table.bearings as f32) as u32).min(table.bearings - 1);
            let cell = table.readings[(row * table.bearings + bearing) as usize];
            for (sum, reading) in sums.iter_mut().zip(cell) {
                *sum += u32::from(reading);
            }
        }
        sums.map(|sum| {
            let activation = sum as f32 * self.spec.robot.sensors.reading_scale;
            if activation < 1.0 { activation } else { 1.0 }
        })
    }

    fn with_noise(&self, step: u32, mut readings: [f32; 8]) -> [f32; 8] {
        let (low, high) = self.spec.noise.sensor;
        let span = high - low;
        if span > 0.0 {
            let (a, b) = (units(self.key, SENSOR, step, 0), units(self.key, SENSOR, step, 1));
            for (reading, u) in readings.iter_mut().zip(a.into_iter().chain(b)) {
                let noisy = *reading + (u * span + low);
                *reading = noisy.clamp(0.0, 1.0);
            }
        }
        readings
    }

    fn weighed(&self, first: usize, readings: &[f32; 8]) -> f32 {
        let products = self.genes[first..]
            .iter()
            .zip(readings)
            .map(|(gene, reading)| gene * reading);
        products.reduce(|sum, product| sum + product).unwrap_or_default()
    }

    fn control(&self, readings: &[f32; 8]) -> [f32; 2] {
        let genes = self.genes;
        match self.spec.controller {
            Controller::Perceptron => [0, 9].map(|first| logistic(self.weighed(first, readings) + genes[first + 8])),
            Controller::Recurrent => [0, 11].map(|first| {
                let sum = self.weighed(first, readings);
                logistic(
                    sum + genes[first + 8] * self.outputs[0] + genes[first + 9] * self.outputs[1] + genes[first + 10],
                )
            }),
            Controller::Hidden { units } => {
                let biases = 11 * units as usize;
                let mut sums = [genes[biases], genes[biases + 1]];
                for first in (0..biases).step_by(11) {
                    let output = logistic(self.weighed(first, readings) + genes[first + 8]);
                    sums[0] += genes[first + 9] * output;
                    sums[1] += genes[first + 10] * output;
                }
                sums.map(logistic)
            }
        }
    }

    fn motion(&self, step: u32, outputs: [f32; 2]) -> MotorCell {
        let motors = &self.spec.robot.motors;
        let [left, right] =
            outputs.map(|output| ((output * motors.scale + motors.offset) as u32).min(motors.states - 1));
        let mut moved = motors.cells[(left * motors.states + right) as usize];
        let noise = self.spec.noise.motor;
        if noise > 0.0 {
            let u = units(self.key, ACTUATOR, step, 0);
            moved.displacement *= 1.0 + noise * (2.0 * u[0] - 1.0);
            moved.turn *= 1.0 + noise * (2.0 * u[1] - 1.0);
        }
        moved
    }

    fn reward(&self, moved: &MotorCell, real: &[f32; 8], perceived: &[f32; 8]) -> f32 {
        let Task::Avoidance {
            speed,
            difference,
            activation,
        } = self.spec.task;
        let speed = match speed {
            Speed::Unsigned => 0.5 * (moved.left.abs() + moved.right.abs()),
            Speed::Signed => 0.5 * (moved.left + moved.right),
        };
        let apart = 0.5 * (moved.left - moved.right).abs();
        let turning = match difference {
            Difference::Root => root(apart),
            Difference::Square => apart * apart,
        };
        let highest = |readings: &[f32; 8]| readings.iter().fold(0.0, |most, r| if *r > most { *r } else { most });
        let near = match activation {
            Activation::Real => highest(real),
            Activation::Perceived => highest(perceived),
            Activation::None => 0.0,
        };
        speed * (1.0 - turning) * (1.0 - near)
    }
}

/// Folds a number back at -range and range.
fn reflect(x: f32, range: f32) -> f32 {
    if x < -range {
        -2.0 * range - x
    } else if x > range {
        2.0 * range - x
    } else {
        x
    }
}
