//! A checked parametric robot: defaults are filled in, and values that need each other are one type.

use std::f64::consts::TAU;

use crate::parameter::{self, Choice, Choices, Datum, Invalid};
use crate::parts::compose::Grids;
use crate::world::arena::{self, Arena, Field, Light, Patch};
use crate::world::body::Body;
use crate::world::discs::Discs;
use crate::world::picture;
use crate::world::reference::{self, Model, Reference};
use crate::world::sensors::{Around, Response, Sensor};
use crate::world::surrogate::{Mounting, Object, Surrogate};
use crate::world::tables::SensorTables;

/// A checked [`Differential`](crate::world::differential::Differential).
#[derive(Clone, Debug)]
pub(crate) struct Described {
    pub(crate) drive: Drive,
    /// Maximum change of a wheel's speed, mm/s in a second; 0: wheels obey at once.
    pub(crate) acceleration: f32,
    /// Whole cycles from a command to its effect on the wheels.
    #[cfg_attr(not(feature = "compose"), expect(dead_code, reason = "only kernels that ship"))]
    pub(crate) latency: u32,
    pub(crate) battery: Option<Battery>,
    /// Values of robots that share a world.
    pub(crate) together: Option<Box<Together>>,
    pub(crate) sensors: Vec<Sensor>,
    /// What its kernel looks up in grids: see [`decide`](super::near::decide).
    pub(crate) grids: Grids,
    /// The column of the tables that each sensor reads; `None` for those that aren't sampled.
    pub(crate) columns: Vec<Option<u32>>,
}

/// What moves it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Drive {
    /// Two wheels that drive an arc in each cycle.
    Wheels(Wheels),
    /// Sampled motors.
    Motors {
        /// Fraction of a cycle's turn made before its displacement, 0 to 1.
        turn_before_move: f32,
    },
}

/// Two wheels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wheels {
    /// Distance between them, mm.
    pub(crate) base: f32,
    /// Maximum speed of each, mm/s.
    pub(crate) greatest_speed: f32,
    /// Number of speeds that each can be given, evenly spaced; 0 for any speed.
    pub(crate) speeds: u32,
    /// Noise of each wheel's speed in each cycle, as a fraction of that speed, and its distribution.
    pub(crate) noise: Option<(f32, WheelNoise)>,
}

impl Drive {
    /// The farthest that a wheel gets in a cycle, mm, noise included; `None` of sampled motors.
    pub(crate) fn farthest(&self) -> Option<f32> {
        let Self::Wheels(wheels) = self else { return None };
        let noise = wheels.noise.map_or(0.0, |(most, law)| most * law.greatest());
        Some(0.1 * wheels.greatest_speed * (1.0 + noise))
    }
}

/// A battery.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Battery {
    /// Time that it lasts when full, s.
    pub(crate) seconds: f32,
    /// Whether an episode ends when it is empty.
    pub(crate) ends_life: bool,
}

/// Robots that share a world.
#[derive(Clone, Debug)]
pub(crate) struct Together {
    /// Number of robots.
    pub(crate) count: u32,
    pub(crate) genomes: Genomes,
    pub(crate) contact: Contact,
    /// Where each starts, x and y in mm; `None`: at random places.
    pub(crate) starts: Option<Vec<[f32; 2]>>,
    /// The heading of each there, turns; none: random ones.
    pub(crate) headings: Vec<f32>,
    /// Their reference model and its values.
    pub(crate) model: Option<(Model, Reference)>,
    /// Pucks.
    pub(crate) pucks: Option<Discs>,
}

impl Together {
    /// Number of robots and pucks.
    pub(crate) fn bodies(&self) -> u32 {
        self.count + self.pucks.as_ref().map_or(0, |pucks| pucks.count)
    }

    /// Most squares of the arena by which bodies find those near them; 0: each looks at all.
    pub(crate) fn squares(&self) -> u32 {
        let bodies = self.bodies();
        if bodies > GREATEST_SEEN_MEMBERS { bodies } else { 0 }
    }

    /// Most rows of them.
    pub(crate) fn rows(&self) -> u32 {
        2 * self.squares().isqrt()
    }
}

/// The distribution of the noise of wheels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WheelNoise {
    /// Uniform, the noise at most.
    #[default]
    Uniform,
    /// Normal, the noise as its standard deviation.
    Normal,
}

impl WheelNoise {
    /// The maximum deviation in multiples of the noise: of a normal one, drawn from 24 bits, the root of
    /// 48 ln 2, 5.77, and a little more.
    const fn greatest(self) -> f32 {
        match self {
            Self::Uniform => 1.0,
            Self::Normal => 5.8,
        }
    }
}

impl Choice for WheelNoise {
    const CHOICES: Choices<Self> = &[
        ("uniform", Self::Uniform, "uniform, up to wheel_noise"),
        (
            "normal",
            Self::Normal,
            "normal, with wheel_noise as its standard deviation",
        ),
    ];
}

/// What bodies do that meet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Contact {
    /// Each gives way by half of the overlap, and slides along what it touches.
    #[default]
    Push,
    /// A robot whose way is not free stays where it is, and turns.
    Stop,
}

impl Choice for Contact {
    const CHOICES: Choices<Self> = &[
        ("push", Self::Push, "each gives way by half of the overlap"),
        ("stop", Self::Stop, "a blocked robot turns, and does not move"),
    ];
}

/// Most robots of a swarm, and robots and pucks.
pub const GREATEST_MEMBERS: u32 = 1024;
/// Most of them where each looks at all others: without the squares of `lib/neighbours.wgsl`, which reference models don't have.
pub const GREATEST_SEEN_MEMBERS: u32 = 128;
/// Cells of the head of a grid of what is near.
pub(super) const GRID_HEAD: usize = 2;
/// Added to distances between bodies, mm: more than any rounding.
const MARGIN: f32 = 1.0;

/// Which robots of a swarm share their controller's genes. A world's genome has those of each controller, one after
/// the other.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Genomes {
    /// All of them.
    #[default]
    Homogeneous,
    /// None: each has its own.
    Heterogeneous,
    /// The robots of a team: the number of each robot's team, from 0.
    Teams(Vec<u32>),
}

impl Genomes {
    /// What the genes' names begin with, for each genome; nothing where there is only one.
    pub(crate) fn names(&self, count: u32) -> Vec<String> {
        match self {
            Self::Homogeneous => Vec::new(),
            Self::Heterogeneous => (0..count).map(|robot| format!("robot_{robot}")).collect(),
            Self::Teams(teams) => (0..=teams.iter().copied().max().unwrap_or(0))
                .map(|team| format!("team_{team}"))
                .collect(),
        }
    }

    /// The number of a robot's genome.
    pub(crate) fn of(&self, robot: u32) -> u32 {
        match self {
            Self::Homogeneous => 0,
            Self::Heterogeneous => robot,
            Self::Teams(teams) => teams.get(robot as usize).copied().unwrap_or(0),
        }
    }

    /// Checks that each of these robots has a team, and each team a robot.
    pub(crate) fn check(&self, count: u32) -> Result<(), Invalid> {
        let Self::Teams(teams) = self else {
            return Ok(());
        };
        let problem = if teams.len() != count as usize {
            format!("has {} teams; allowed: one for each robot, {count}", teams.len())
        } else if let Some(empty) = (0..teams.iter().copied().max().unwrap_or(0)).find(|team| !teams.contains(team)) {
            format!("has no robot in team {empty}; allowed: teams that are numbered from 0 on, each with a robot")
        } else {
            return Ok(());
        };
        Err(Invalid::new("robot.genomes", problem))
    }
}

impl parameter::Field for Genomes {
    fn get(&self) -> Option<Datum> {
        match self {
            // Experiments from before there was a choice keep their identity.
            Self::Homogeneous => None,
            Self::Heterogeneous => Some(Datum::Word(HETEROGENEOUS.to_owned())),
            Self::Teams(teams) => {
                let teams = teams.iter().map(|team| Datum::Whole((*team).into()));
                Some(Datum::List(teams.collect()))
            }
        }
    }

    fn set(&mut self, datum: &Datum) -> bool {
        let genomes = match datum {
            Datum::Word(word) if word == HOMOGENEOUS => Some(Self::Homogeneous),
            Datum::Word(word) if word == HETEROGENEOUS => Some(Self::Heterogeneous),
            Datum::List(list) => list.iter().map(Datum::whole).collect::<Option<_>>().map(Self::Teams),
            _ => None,
        };
        let is_set = genomes.is_some();
        if let Some(genomes) = genomes {
            *self = genomes;
        }
        is_set
    }

    fn kind(&self) -> &'static str {
        "homogeneous, heterogeneous, or a list of the robots' teams"
    }
}

const HOMOGENEOUS: &str = "homogeneous";
const HETEROGENEOUS: &str = "heterogeneous";

impl Described {
    /// Noise of its wheels.
    pub(crate) fn wheel_noise(&self) -> Option<(f32, WheelNoise)> {
        match &self.drive {
            Drive::Wheels(wheels) => wheels.noise,
            Drive::Motors { .. } => None,
        }
    }

    /// Its reference model and its values.
    pub(crate) fn model(&self) -> Option<&(Model, Reference)> {
        self.together.as_ref().and_then(|swarm| swarm.model.as_ref())
    }

    /// The pucks of its swarm.
    pub(crate) fn pucks(&self) -> Option<&Discs> {
        self.together.as_ref().and_then(|swarm| swarm.pucks.as_ref())
    }

    /// Whether it has a sensor that was sampled.
    pub(crate) fn has_sampled_sensors(&self) -> bool {
        self.columns.iter().any(Option::is_some)
    }

    /// Names of its readings: those of its list of sensors, then those of its reference model.
    #[cfg(feature = "compose")]
    pub(crate) fn readings(&self) -> Vec<String> {
        let listed = self.sensors.iter().map(|sensor| sensor.name.clone());
        let model = self.model().into_iter().flat_map(|(model, _)| model.readings());
        listed.chain(model).collect()
    }

    /// Start of each robot of a swarm, if set.
    pub(crate) fn start_places(&self) -> &[[f32; 2]] {
        let starts = self.together.as_ref().and_then(|swarm| swarm.starts.as_ref());
        starts.map_or(&[], Vec::as_slice)
    }

    /// The responses of its sensors, each once.
    pub(crate) fn responses(&self) -> Vec<&Response> {
        let mut responses: Vec<&Response> = Vec::new();
        for response in self.sensors.iter().filter_map(|sensor| sensor.response.as_ref()) {
            if !responses.contains(&response) {
                responses.push(response);
            }
        }
        responses
    }

    /// Kernel data for the robot and its arena: the cells that `robot/arcs.wgsl`, `robot/drive.wgsl` and `sensor/kinds.wgsl`
    /// declare.
    /// Those of a surrogate are followed by its differences, `lib/differences.wgsl` says which. A controller has `genes` genes. The
    /// greys of the arena's picture begin at the cell `greys` of the tables.
    pub(crate) fn cells(
        &self,
        body: &Body<'_>,
        arena: &Arena,
        surrogate: Option<&Surrogate>,
        genes: usize,
        greys: u32,
    ) -> Vec<[u32; 4]> {
        let (body_radius, tables) = (body.radius, body.sensors);
        let (base, speed, speeds, noise) = match self.drive {
            Drive::Wheels(wheels) => (wheels.base, wheels.greatest_speed, wheels.speeds, wheels.noise),
            // They don't use the first cell.
            Drive::Motors { .. } => (1.0, body.motors.full_speed().unwrap_or(1.0), 0, None),
        };
        let farthest = 0.1 * f64::from(speed);
        let steps = speeds.saturating_sub(1) as f32;
        let wheels = [
            farthest as f32,
            (farthest / (TAU * f64::from(base))) as f32,
            steps,
            inverse(steps),
        ];
        let change = self.acceleration / (10.0 * speed);
        let cycles = (10.0 * self.battery.map_or(0.0, |battery| battery.seconds)).round();
        let drive = [change, inverse(change), cycles, inverse(cycles)];
        let sensor = |(index, sensor): (usize, &Sensor)| {
            let mounting = surrogate.map_or(Mounting::TRUE, |surrogate| surrogate.mounting(index, sensor.kind));
            let [range, share] = (sensor.kind.entry().numbers)(sensor, tables.reach());
            [
                [
                    sensor.heading + mounting.heading,
                    sensor.offset.unwrap_or(body_radius),
                    range,
                    share,
                ],
                [sensor.bearing.unwrap_or(0.0), mounting.strength, 0.0, 0.0],
            ]
        };
        let light = |light: &Light| [light.x, light.y, light.brightness, 0.0];
        let grey = |index: usize, grey: f32| match surrogate {
            Some(surrogate) => (grey * surrogate.reflectivity(Object::Floor, index)).min(1.0),
            None => grey,
        };
        let patch = |(index, patch): (usize, &Patch)| {
            let axis = arena::axis(patch.heading);
            let radius = patch.radius.unwrap_or(0.0);
            let [length, width] = patch.sides.unwrap_or_default();
            [
                [patch.x, patch.y, axis.x, axis.y],
                [0.5 * length, 0.5 * width, radius * radius, grey(1 + index, patch.grey)],
            ]
        };
        let cells = [wheels, drive]
            .into_iter()
            .chain(self.sensors.iter().enumerate().flat_map(sensor))
            .chain([[grey(0, arena.floor.unwrap_or(1.0)), 0.0, 0.0, 0.0]])
            .chain(arena.lights.iter().map(light))
            .chain(arena.patches.iter().enumerate().flat_map(patch))
            .chain(self.responses().into_iter().flat_map(Response::cells))
            .chain(noise.map(|(most, _)| [most, 0.0, 0.0, 0.0]))
            .chain(self.members(body))
            .chain(self.pucks().into_iter().flat_map(Discs::cells))
            .chain(self.squares(body, arena).into_iter().flatten())
            .chain(self.differing(genes))
            .chain(self.model().into_iter().flat_map(|(_, values)| values.cells(arena)))
            .chain(
                surrogate
                    .into_iter()
                    .flat_map(|surrogate| surrogate.differing(self.track(body))),
            );
        // Zero has one sign.
        let bits = |number: f32| if number == 0.0 { 0 } else { number.to_bits() };
        let mut cells: Vec<_> = cells.map(|cell| cell.map(bits)).collect();
        if let Some(picture) = &arena.picture {
            let white = surrogate.map_or(1.0, |surrogate| surrogate.reflectivity(Object::Floor, 0));
            let at = self.picture_cell(arena);
            cells.splice(at..at, picture.head(greys, white));
        }
        cells
    }

    /// The kernel's cell of a swarm: `MembersCell`.
    fn members(&self, body: &Body<'_>) -> Option<[f32; 4]> {
        let together = self.together.as_ref()?;
        let reach = self.reach(body.radius, body.sensors, false) + self.largest(body);
        let pushes = match together.contact {
            Contact::Push => 1.0,
            Contact::Stop => 0.0,
        };
        Some([together.count as f32, body.radius, reach * reach, pushes])
    }

    /// Radius of its swarm's largest bodies, mm.
    fn largest(&self, body: &Body<'_>) -> f32 {
        self.pucks().map_or(0.0, |pucks| pucks.radius).max(body.radius)
    }

    /// The kernel's cells of a swarm of many bodies: `SquaresCell` and `LooksCell`. Squares are as wide as two bodies that touch are
    /// apart, or as wide as their number asks for.
    fn squares(&self, body: &Body<'_>, arena: &Arena) -> Option<[[f32; 4]; 2]> {
        let swarm = self.together.as_ref().filter(|swarm| swarm.squares() > 0)?;
        let (most, most_rows) = (swarm.squares() as f32, swarm.rows() as f32);
        let Field { x, y, width, height } = arena.walled();
        let touching = 2.0 * self.largest(body) + MARGIN;
        let sensing = self.reach(body.radius, body.sensors, false) + self.largest(body) + MARGIN;
        let along = |side: f32| [width, height].map(|length| (length / side).ceil().max(1.0));
        let mut side = touching;
        let is_too_small = |[columns, rows]: [f32; 2]| columns * rows > most || rows > most_rows;
        while is_too_small(along(side)) {
            side *= 1.05;
        }
        let [columns, rows] = along(side);
        Some([[x, y, side.recip(), columns], [rows, touching, sensing, MARGIN]])
    }

    /// Number of robots whose starts or genes differ, if they do.
    fn differing_count(&self) -> u32 {
        let is_alike = |swarm: &&Together| swarm.starts.is_none() && swarm.genomes == Genomes::Homogeneous;
        self.together
            .as_deref()
            .filter(|swarm| !is_alike(swarm))
            .map_or(0, |swarm| swarm.count)
    }

    /// A cell for each of these robots: where it starts, its first gene, and its heading at the start.
    fn differing(&self, genes: usize) -> impl Iterator<Item = [f32; 4]> {
        let robots = self
            .together
            .iter()
            .flat_map(|swarm| (0..self.differing_count()).map(move |robot| (swarm, robot)));
        robots.map(move |(swarm, robot)| {
            let [x, y] = swarm.starts.as_ref().map_or([0.0; 2], |places| places[robot as usize]);
            let heading = swarm.headings.get(robot as usize).copied().unwrap_or(0.0);
            [x, y, (swarm.genomes.of(robot) as usize * genes) as f32, heading]
        })
    }

    /// The kernel's first cell of the arena's picture.
    pub(crate) fn picture_cell(&self, arena: &Arena) -> usize {
        let points = self.responses().iter().map(|response| response.0.len()).sum::<usize>();
        2 + 2 * self.sensors.len() + 1 + arena.lights.len() + 2 * arena.patches.len() + points
    }

    /// The kernel's first cell of the grid of patches.
    pub(crate) fn patches_cell(&self, arena: &Arena) -> usize {
        self.picture_cell(arena) + if arena.picture.is_some() { picture::HEAD } else { 0 }
    }

    /// The kernel's cell of the noise of wheels.
    #[cfg(feature = "compose")]
    pub(crate) fn noise_cell(&self, arena: &Arena) -> usize {
        self.patches_cell(arena) + if self.grids.patches { GRID_HEAD } else { 0 }
    }

    /// The kernel's cell of a swarm.
    #[cfg(feature = "compose")]
    pub(crate) fn members_cell(&self, arena: &Arena) -> usize {
        self.noise_cell(arena) + usize::from(self.wheel_noise().is_some())
    }

    /// The kernel's first cell of pucks.
    #[cfg(feature = "compose")]
    pub(crate) fn pucks_cell(&self, arena: &Arena) -> usize {
        self.members_cell(arena) + usize::from(self.together.is_some())
    }

    /// The kernel's first cell of the squares of a swarm of many bodies.
    #[cfg(feature = "compose")]
    pub(crate) fn squares_cell(&self, arena: &Arena) -> usize {
        self.pucks_cell(arena) + self.pucks().map_or(0, |pucks| pucks.cells().count())
    }

    /// The kernel's first cell of robots whose starts or genes differ.
    #[cfg(feature = "compose")]
    pub(crate) fn differing_cell(&self, arena: &Arena) -> usize {
        let has_squares = self.together.as_ref().is_some_and(|swarm| swarm.squares() > 0);
        self.squares_cell(arena) + if has_squares { 2 } else { 0 }
    }

    /// The kernel's first cell of a reference model.
    #[cfg(feature = "compose")]
    pub(crate) fn reference_cell(&self, arena: &Arena) -> usize {
        self.differing_cell(arena) + self.differing_count() as usize
    }

    /// Number of cells before a surrogate's differences. Surrogates have no reference model.
    #[cfg(feature = "compose")]
    pub(crate) fn own_cells(&self, arena: &Arena) -> usize {
        self.reference_cell(arena)
    }

    /// Distance between the wheels, mm. Of sampled motors that at which wheels that don't slip would turn as they do on the spot
    /// at full speed; `None` if they don't turn there, or don't move at full speed.
    fn track(&self, body: &Body<'_>) -> Option<f64> {
        if let Drive::Wheels(wheels) = &self.drive {
            return Some(wheels.base.into());
        }
        let cells = &body.motors.cells;
        let [ahead, around] = [cells.last()?, &cells[body.motors.states.checked_sub(1)? as usize]];
        let track = 2.0 * f64::from(ahead.displacement) / (TAU * f64::from(around.turn));
        (1.0..=1e5).contains(&track).then_some(track)
    }

    /// Maximum distance from the body's centre at which its sensors notice an object, mm, and a little more. Those of a
    /// surrogate may see farther.
    pub(crate) fn reach(&self, body_radius: f32, tables: &SensorTables, is_surrogate: bool) -> f32 {
        let farther = if is_surrogate { FARTHER } else { 1.0 };
        let around = Around {
            body_radius,
            farther,
            tables: tables.reach(),
        };
        let reach = |sensor: &Sensor| (sensor.kind.entry().reach)(sensor, &around);
        let of_model = if self.model().is_some() {
            reference::RAY_END
        } else {
            0.0
        };
        1.0 + self.sensors.iter().map(reach).fold(of_model, f32::max)
    }
}

/// Factor on the range of a surrogate's proximity sensor, as in `lib/differences.wgsl`. At a severity of 2
/// objects return at most 1.4 times the light of their surroundings, which have at most 1.6 times theirs, and sensors see at most
/// 1.375 times as far.
const FARTHER: f32 = 2.1;

/// The inverse of a number; 0 of 0.
fn inverse(number: f32) -> f32 {
    if number > 0.0 { 1.0 / number } else { 0.0 }
}
