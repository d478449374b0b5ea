//! Many robots of a kind in one world of Aseba's simulator, each in an arena or a place of its own, that live at the same time.

use std::f64::consts::PI;
use std::fmt::Write as _;

use rand::RngExt;
use rand_pcg::Pcg64;

use super::client::Client;
use super::{FIRST_PORT, live, world};

/// How much faster than real time the simulator runs.
const SPEED: u32 = 10;
/// A life, in cycles of 100 ms.
const CYCLES: usize = 500;

/// A kind of robot of the simulator, and its arena. Lengths are in mm.
pub(crate) struct Kind {
    /// Its name in the simulator.
    pub(crate) name: &'static str,
    /// The variables of its sensors of proximity, and of the left wheel's target, which the right one's follows.
    proximity: &'static str,
    target: &'static str,
    /// An event that the robot emits periodically, and its period in steps of 10 ms.
    event: (&'static str, usize),
    pub(crate) sensors: usize,
    /// What a sensor reads that is touched.
    pub(crate) touch: f64,
    /// The target of its greatest speed in the study.
    pub(crate) greatest: f64,
    /// The radius of its body, that of cylinders, and an arena's side.
    pub(crate) body: f64,
    pub(crate) cylinder: f64,
    side: f64,
    /// Robots that live at once: the simulator compares each with everything.
    crowd: usize,
}

pub(crate) const THYMIO: Kind = Kind {
    name: "thymio2",
    proximity: "prox.horizontal",
    target: "motor.left.target",
    event: ("motor", 1),
    sensors: 7,
    touch: 4500.0,
    greatest: 500.0,
    body: 80.0,
    cylinder: 40.0,
    side: 1000.0,
    crowd: 50,
};

pub(crate) const EPUCK: Kind = Kind {
    name: "e-puck",
    proximity: "prox",
    target: "speed.left",
    event: ("ir_sensors", 3),
    sensors: 8,
    touch: 3731.0,
    greatest: 1000.0,
    body: 37.0,
    cylinder: 37.0,
    side: 500.0,
    crowd: 20,
};

impl Kind {
    /// Genes of a perceptron.
    pub(crate) fn genes(&self) -> usize {
        2 * (self.sensors + 1)
    }

    /// What robots sense at about one time: the clock in units of 10 ms, and the sensors of proximity.
    pub(crate) fn sense(&self, robots: &mut [Client]) -> Vec<(usize, Vec<f64>)> {
        for robot in robots.iter_mut() {
            robot.ask_all(self.proximity, "clock");
        }
        let answer = |robot: &mut Client| {
            let words = robot.answer();
            let clock = usize::from(*words.last().unwrap() as u16) * self.event.1;
            (
                clock,
                words[..self.sensors].iter().map(|word| f64::from(*word)).collect(),
            )
        };
        robots.iter_mut().map(answer).collect()
    }

    /// Sets the targets of the wheels.
    pub(crate) fn drive(&self, robot: &mut Client, targets: [f64; 2]) {
        let words = targets.map(|target| target.round() as i16);
        robot.set(self.target, &words);
    }

    /// A free pose in the arena.
    pub(crate) fn start(&self, random: &mut Pcg64) -> Pose {
        loop {
            let mut within = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
            let [x, y] = [(); 2].map(|()| within(self.body, self.side - self.body));
            let heading = within(-PI, PI);
            if (x - self.side / 2.0).hypot(y - self.side / 2.0) >= self.body + self.cylinder {
                return [x, y, heading];
            }
        }
    }

    /// Lives in the simulator, up to `crowd` at once, each in a walled arena of its own.
    pub(crate) fn lives(&'static self, of: &[(&[f64], Pose)]) -> Lived {
        let (mut all, mut late) = (Lived::default(), 0);
        for part in of.chunks(self.crowd) {
            let (things, side) = self.arenas(part);
            let genes: Vec<&[f64]> = part.iter().map(|(genes, _)| *genes).collect();
            let (fitness, cycles) = things.live([side; 2], |robots| self.live_at_once(robots, &genes));
            all.fitness.extend(fitness);
            all.longest = all.longest.max(cycles.iter().copied().max().unwrap_or(0));
            late += cycles.into_iter().filter(|cycle| *cycle > 200).count();
        }
        all.late = late as f64 / (of.len() * CYCLES) as f64;
        all
    }

    /// An arena with a cylinder in its middle for each, side by side, and the side of the square that they take.
    fn arenas(&'static self, of: &[(&[f64], Pose)]) -> (Things, f64) {
        const WALL: f64 = 10.0;
        let (mut things, mut whole) = (Things::new(self), 0.0);
        let side = self.side;
        for (index, (_, [x, y, heading])) in of.iter().enumerate() {
            let ([left, below], square) = cell(index, of.len(), side + WALL);
            whole = square + WALL;
            let [left, below] = [left + WALL, below + WALL];
            things.robot([left + x, below + y, *heading]);
            let [middle, half, long] = [side / 2.0, WALL / 2.0, side + 2.0 * WALL];
            for (x, y, size) in [
                (-half, middle, [WALL, long]),
                (side + half, middle, [WALL, long]),
                (middle, -half, [long, WALL]),
                (middle, side + half, [long, WALL]),
            ] {
                things.wall([left + x, below + y], size);
            }
            things.cylinder([left + middle, below + middle]);
        }
        (things, whole)
    }

    /// The fitness of each robot with its genes, and the lengths of all cycles but the first in ms.
    fn live_at_once(&self, robots: &mut [Client], genes: &[&[f64]]) -> (Vec<f64>, Vec<usize>) {
        let first: Vec<usize> = self.sense(robots).into_iter().map(|(clock, _)| clock).collect();
        let mut sums = vec![0.0; robots.len()];
        let mut done = vec![(0_usize, 0_usize); robots.len()];
        let mut cycles = Vec::new();
        while done.iter().any(|(cycles, _)| *cycles < CYCLES) {
            for (index, (clock, mut readings)) in self.sense(robots).into_iter().enumerate() {
                let (count, last) = &mut done[index];
                let now = clock - first[index];
                if *count == CYCLES || now < 10 * *count {
                    continue;
                }
                if *count > 0 {
                    cycles.push(10 * (now - *last));
                }
                (*count, *last) = (*count + 1, now);
                for reading in &mut readings {
                    *reading = (*reading / self.touch).clamp(0.0, 1.0);
                }
                let [left, right] = decide(genes[index], &readings);
                self.drive(&mut robots[index], [left, right].map(|speed| speed * self.greatest));
                let nearest = readings.into_iter().fold(0.0, f64::max);
                let straight = 1.0 - ((left - right).abs() / 2.0).sqrt();
                sums[index] += f64::midpoint(left.abs(), right.abs()) * straight * (1.0 - nearest);
            }
        }
        (sums, cycles)
    }
}

/// A place in mm and a heading in rad.
pub(crate) type Pose = [f64; 3];

/// Elements of a world with robots of a kind.
pub(crate) struct Things {
    kind: &'static Kind,
    /// As the simulator's file has them, whose lengths are in cm.
    text: String,
    robots: usize,
}

impl Things {
    pub(crate) fn new(kind: &'static Kind) -> Self {
        Self {
            kind,
            text: String::new(),
            robots: 0,
        }
    }

    pub(crate) fn robot(&mut self, [x, y, heading]: Pose) {
        let (index, port) = (self.robots, FIRST_PORT + self.robots as u16);
        writeln!(
            self.text,
            r#"<robot type="{}" x="{}" y="{}" angle="{heading}" port="{port}" name="r{index}" nodeId="{}"/>"#,
            self.kind.name,
            x / 10.0,
            y / 10.0,
            index + 1
        )
        .unwrap();
        self.robots += 1;
    }

    /// A wall of these sides along the axes, about a place.
    pub(crate) fn wall(&mut self, [x, y]: [f64; 2], [width, height]: [f64; 2]) {
        let [x, y, width, height] = [x, y, width, height].map(|length| length / 10.0);
        writeln!(
            self.text,
            r#"<wall x="{x}" y="{y}" l1="{width}" l2="{height}" h="10" angle="0" color="white"/>"#
        )
        .unwrap();
    }

    pub(crate) fn cylinder(&mut self, [x, y]: [f64; 2]) {
        writeln!(
            self.text,
            r#"<cylinder x="{}" y="{}" r="{}" h="10" color="white"/>"#,
            x / 10.0,
            y / 10.0,
            self.kind.cylinder / 10.0
        )
        .unwrap();
    }

    /// Starts the simulator with these, and connects to all robots. Each counts its kind's event as its clock.
    pub(crate) fn live<T>(&self, [width, height]: [f64; 2], scenario: impl Fn(&mut Vec<Client>) -> T) -> T {
        let world = world(width / 10.0, height / 10.0, &self.text);
        live(&world, self.robots as u16, SPEED, |_| {
            let ports = FIRST_PORT..FIRST_PORT + self.robots as u16;
            let mut robots: Vec<Client> = ports.map(Client::connect).collect();
            for robot in &mut robots {
                robot.count(self.kind.event.0, "clock");
            }
            scenario(&mut robots)
        })
    }
}

/// The place of the cell of this index in a square of `count` cells of a size, and the square's side.
pub(crate) fn cell(index: usize, count: usize, size: f64) -> ([f64; 2], f64) {
    let columns = (count as f64).sqrt().ceil() as usize;
    let corner = [index % columns, index / columns].map(|at| at as f64 * size);
    (corner, columns as f64 * size)
}

/// What a perceptron's two wheels do, from -1 to 1, for readings from 0 to 1.
fn decide(genes: &[f64], readings: &[f64]) -> [f64; 2] {
    let wheel = |genes: &[f64]| {
        let sum: f64 = genes.iter().zip(readings).map(|(gene, reading)| gene * reading).sum();
        2.0 / (1.0 + (-sum - genes[readings.len()]).exp()) - 1.0
    };
    let (left, right) = genes.split_at(readings.len() + 1);
    [wheel(left), wheel(right)]
}

/// What lives in the simulator came to.
#[derive(Default)]
pub(crate) struct Lived {
    /// Of each, by equation 1 without its rule for collisions, which no client sees.
    pub(crate) fitness: Vec<f64>,
    /// The longest cycle, ms.
    pub(crate) longest: usize,
    /// Share of cycles longer than 200 ms: a crowded machine is late, which is no matter of the controller.
    pub(crate) late: f64,
}

/// The next generation by the 1995 genetic algorithm: the best `parents` have equally many children, whose genes are changed each
/// by up to 1 with a probability of a quarter.
pub(crate) fn children(population: &[Vec<f64>], fitness: &[f64], parents: usize, random: &mut Pcg64) -> Vec<Vec<f64>> {
    let mut order: Vec<usize> = (0..population.len()).collect();
    order.sort_by(|a, b| fitness[*b].total_cmp(&fitness[*a]));
    let mut mutate = |gene: &f64| {
        let change = 2.0 * random.random::<f64>() - 1.0;
        if random.random::<f64>() < 0.25 {
            gene + change
        } else {
            *gene
        }
    };
    (0..population.len())
        .map(|index| population[order[index % parents]].iter().map(&mut mutate).collect())
        .collect()
}
