//! Robots that are described sensor by sensor: two wheels, sensors of a few kinds, and a battery. Sensors and motors may also be
//! sampled.

use std::f64::consts::TAU;

use crate::genes::PREVIOUS;
use crate::parameter::{self, Choice, Choices, Datum, Invalid, field_of_pairs, length};
use crate::world::arena::{self, Arena, Light, Patch};
use crate::world::body::{Body, Collision};
use crate::world::reference::{self, Model, Reference};
pub use crate::world::sensors::{GREATEST_POINTS, Law, Response, Sensor, SensorKind};
use crate::world::surrogate::{Mounting, Object, Surrogate};
use crate::world::tables::{self, SensorTables};

/// A robot on two wheels. An output of 0 commands full speed backwards, 1 full speed forwards, and each cycle is an arc; or its
/// motors are sampled.
#[derive(Clone, Debug, PartialEq)]
pub struct Differential {
    /// Whether [`Robot::motors`](crate::world::Robot::motors) drive it. Then it has none of the values up to `speeds`.
    pub sampled_motors: bool,
    /// Distance between the wheels, mm.
    pub wheel_base: Option<f32>,
    /// Greatest speed of a wheel, mm/s.
    pub greatest_speed: Option<f32>,
    /// Number of speeds that a wheel can be given, evenly spaced; 0 for any speed.
    pub speeds: u32,
    /// Greatest change of a wheel's speed, mm/s in a second. `None` or 0: wheels obey at once. Sampled motors need states
    /// whose speeds ascend, and then move as their samples do at a cycle's mean speeds, see
    /// [`MotorTable::full_speed`](crate::tables::MotorTable::full_speed).
    pub acceleration: Option<f32>,
    /// Whole cycles from a command to its effect on the wheels, which stand still until the first one arrives. `None`: 0.
    pub latency: Option<u32>,
    /// Of sampled motors: share of a cycle's turn made before its displacement, 0 to 1. `None`: 0.
    pub turn_before_move: Option<f32>,
    /// Time that a full battery lasts, s, rounded to whole cycles of 100 ms. Its charge falls evenly. `None`: it has none.
    pub battery: Option<f32>,
    /// Whether its life ends when the battery is empty. `None`: it doesn't.
    pub battery_ends_life: Option<bool>,
    /// Noise of each wheel's speed in each cycle, as a share of that speed, 0 to 0.5. `None`: 0.
    pub wheel_noise: Option<f32>,
    /// Distribution of that noise. `None`: uniform.
    pub wheel_noise_law: Option<WheelNoise>,
    /// Number of such robots that live in one world, 1 to [`GREATEST_MEMBERS`]. `None`: one, as a single robot.
    pub count: Option<u32>,
    /// Of several robots: which of them share their genes.
    pub genomes: Genomes,
    /// Of several robots: what bodies do that meet. `None`: they push.
    pub contact: Option<Contact>,
    /// Of several robots: where each starts, with a random heading. `None`: at random places.
    pub starts: Option<Starts>,
    /// Its reference model, of several robots. `None`: it has only the sensors of its list.
    pub model: Option<Model>,
    /// Values of that model.
    pub reference: Reference,
    /// Its sensors.
    pub sensors: Vec<Sensor>,
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
    /// How often the noise the greatest deviation that occurs is: of a normal one drawn from 24 bits that is the root of
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
        (
            "stop",
            Self::Stop,
            "a robot whose way is not free stays where it is, and turns",
        ),
    ];
}

/// Most robots that live in one world.
pub const GREATEST_MEMBERS: u32 = 128;

/// The farthest that a body gets in a cycle where several live together, as a share of its radius: `FARTHEST` of
/// `physics/contacts.wgsl`.
const FARTHEST: f32 = 0.75;

/// Which of the robots that live together share their controller's genes. A world's genome has those of each controller, one after
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
    fn check(&self, count: u32) -> Result<(), Invalid> {
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
        let own = match datum {
            Datum::Word(word) if word == HOMOGENEOUS => Some(Self::Homogeneous),
            Datum::Word(word) if word == HETEROGENEOUS => Some(Self::Heterogeneous),
            Datum::List(list) => list.iter().map(Datum::whole).collect::<Option<_>>().map(Self::Teams),
            _ => None,
        };
        let is_set = own.is_some();
        if let Some(own) = own {
            *self = own;
        }
        is_set
    }

    fn kind(&self) -> &'static str {
        "homogeneous, heterogeneous, or a list of the robots' teams"
    }
}

const HOMOGENEOUS: &str = "homogeneous";
const HETEROGENEOUS: &str = "heterogeneous";

/// Where robots that live together start: x and y of each, mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Starts(pub Vec<[f32; 2]>);

field_of_pairs!(Starts);

impl Differential {
    /// A robot that obeys at once, without sensors and battery: the distance between its wheels, mm, and their greatest speed,
    /// mm/s.
    pub const fn new(wheel_base: f32, greatest_speed: f32) -> Self {
        Self::driven(false, Some(wheel_base), Some(greatest_speed))
    }

    /// A robot that its sampled motors drive, without sensors and battery.
    pub const fn sampled() -> Self {
        Self::driven(true, None, None)
    }

    /// A robot whose drive is yet to be described.
    pub(crate) const fn open() -> Self {
        Self::driven(false, None, None)
    }

    const fn driven(sampled_motors: bool, wheel_base: Option<f32>, greatest_speed: Option<f32>) -> Self {
        Self {
            sampled_motors,
            wheel_base,
            greatest_speed,
            speeds: 0,
            acceleration: None,
            latency: None,
            turn_before_move: None,
            battery: None,
            battery_ends_life: None,
            wheel_noise: None,
            wheel_noise_law: None,
            count: None,
            genomes: Genomes::Homogeneous,
            contact: None,
            starts: None,
            model: None,
            reference: Reference::DEFAULT,
            sensors: Vec::new(),
        }
    }

    /// Names of its readings: those of its list of sensors, then those of its reference model.
    pub(crate) fn readings(&self) -> Vec<String> {
        let own = self.sensors.iter().map(|sensor| sensor.name.clone());
        let model = self.model.into_iter().flat_map(Model::readings);
        own.chain(model).collect()
    }

    /// The farthest that a wheel gets in a cycle, mm, noise included.
    pub(crate) fn farthest(&self) -> Option<f32> {
        let noise = self.wheel_noise.unwrap_or(0.0) * self.wheel_noise_law.unwrap_or_default().greatest();
        Some(0.1 * self.greatest_speed? * (1.0 + noise))
    }

    /// Whether it has a sensor that was sampled.
    pub fn has_sampled_sensors(&self) -> bool {
        self.sensors.iter().any(|sensor| sensor.kind == SensorKind::Sampled)
    }

    /// The column of the tables that each of its sensors reads; `None` for those that aren't sampled.
    pub fn columns(&self) -> Vec<Option<u32>> {
        let mut places = 0..;
        let column = |sensor: &Sensor| {
            let place = (sensor.kind == SensorKind::Sampled).then(|| places.next()).flatten();
            place.map(|place| sensor.column.unwrap_or(place))
        };
        self.sensors.iter().map(column).collect()
    }

    /// Whether its wheels' speeds change gradually.
    pub(crate) fn is_slow(&self) -> bool {
        self.acceleration.is_some_and(|acceleration| acceleration > 0.0)
    }

    /// Whether its wheels obey cycles later.
    pub(crate) fn is_late(&self) -> bool {
        self.latency.is_some_and(|cycles| cycles > 0)
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
    /// Those of a surrogate are followed by its differences, `lib/differences.wgsl` says which. A controller has `genes` genes.
    pub(crate) fn cells(
        &self,
        body: &Body<'_>,
        arena: &Arena,
        surrogate: Option<&Surrogate>,
        genes: usize,
    ) -> Vec<[u32; 4]> {
        let (body_radius, tables) = (body.radius, body.sensors);
        // Sampled motors don't use the first cell.
        let base = self.wheel_base.unwrap_or(1.0);
        let speed = self.greatest_speed.or(body.motors.full_speed()).unwrap_or(1.0);
        let farthest = 0.1 * f64::from(speed);
        let steps = self.speeds.saturating_sub(1) as f32;
        let wheels = [
            farthest as f32,
            (farthest / (TAU * f64::from(base))) as f32,
            steps,
            inverse(steps),
        ];
        let change = self.acceleration.unwrap_or(0.0) / (10.0 * speed);
        let cycles = (10.0 * self.battery.unwrap_or(0.0)).round();
        let drive = [change, inverse(change), cycles, inverse(cycles)];
        let sensor = |(index, sensor): (usize, &Sensor)| {
            let mounting = surrogate.map_or(Mounting::TRUE, |surrogate| surrogate.mounting(index, sensor.kind));
            let range = sensor.range.unwrap_or(1.0);
            let [range, share] = match sensor.kind {
                SensorKind::Distance | SensorKind::Proximity | SensorKind::Sight => [range, 1.0 / range],
                SensorKind::Bumper => [range, 0.5 * sensor.width.unwrap_or(0.5)],
                SensorKind::Light => [f32::from(sensor.law.unwrap_or_default() as u8), 1.0 / range],
                SensorKind::Ground | SensorKind::Battery => [0.0, 0.0],
                SensorKind::Sampled => [tables.reach(), 0.0],
            };
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
            .chain(self.wheel_noise.map(|noise| [noise, 0.0, 0.0, 0.0]))
            .chain(self.members(body))
            .chain(self.differing(genes))
            .chain(self.model.into_iter().flat_map(|_| self.reference.cells(arena)))
            .chain(
                surrogate
                    .into_iter()
                    .flat_map(|surrogate| surrogate.differing(self.track(body))),
            );
        // Zero has one sign.
        let bits = |number: f32| if number == 0.0 { 0 } else { number.to_bits() };
        cells.map(|cell| cell.map(bits)).collect()
    }

    /// The kernel's cell of robots that live together, if they do: `MembersCell`.
    fn members(&self, body: &Body<'_>) -> Option<[f32; 4]> {
        let count = self.count?;
        let reach = self.reach(body.radius, body.sensors, false) + body.radius;
        let pushes = match self.contact.unwrap_or_default() {
            Contact::Push => 1.0,
            Contact::Stop => 0.0,
        };
        Some([count as f32, body.radius, reach * reach, pushes])
    }

    /// Number of robots whose starts or genes differ, if they do.
    fn differing_count(&self) -> u32 {
        let is_alike = self.starts.is_none() && self.genomes == Genomes::Homogeneous;
        self.count.filter(|_| !is_alike).unwrap_or(0)
    }

    /// A cell for each of these robots: where it starts, and its first gene.
    fn differing(&self, genes: usize) -> impl Iterator<Item = [f32; 4]> {
        (0..self.differing_count()).map(move |robot| {
            let [x, y] = self.start_places().get(robot as usize).copied().unwrap_or_default();
            [x, y, (self.genomes.of(robot) as usize * genes) as f32, 0.0]
        })
    }

    /// Where robots that live together start, if that is given.
    pub(crate) fn start_places(&self) -> &[[f32; 2]] {
        self.starts.as_ref().map_or(&[], |Starts(places)| places)
    }

    /// The kernel's cell of the noise of wheels.
    #[cfg(feature = "compose")]
    pub(crate) fn noise_cell(&self, arena: &Arena) -> usize {
        let points = self.responses().iter().map(|response| response.0.len()).sum::<usize>();
        2 + 2 * self.sensors.len() + 1 + arena.lights.len() + 2 * arena.patches.len() + points
    }

    /// The kernel's cell of robots that live together.
    #[cfg(feature = "compose")]
    pub(crate) fn members_cell(&self, arena: &Arena) -> usize {
        self.noise_cell(arena) + usize::from(self.wheel_noise.is_some())
    }

    /// The kernel's first cell of robots whose starts or genes differ.
    #[cfg(feature = "compose")]
    pub(crate) fn differing_cell(&self, arena: &Arena) -> usize {
        self.members_cell(arena) + usize::from(self.count.is_some())
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
        if let Some(base) = self.wheel_base {
            return Some(base.into());
        }
        let cells = &body.motors.cells;
        let [ahead, around] = [cells.last()?, &cells[body.motors.states.checked_sub(1)? as usize]];
        let track = 2.0 * f64::from(ahead.displacement) / (TAU * f64::from(around.turn));
        (1.0..=1e5).contains(&track).then_some(track)
    }

    /// Greatest distance from the body's centre at which its sensors notice an object, mm, and a little more. Those of a
    /// surrogate may see farther.
    pub(crate) fn reach(&self, body_radius: f32, tables: &SensorTables, is_surrogate: bool) -> f32 {
        let farther = if is_surrogate { FARTHER } else { 1.0 };
        let reach = |sensor: &Sensor| {
            let range = sensor.range.unwrap_or(0.0);
            match sensor.kind {
                SensorKind::Distance | SensorKind::Sight => sensor.offset.unwrap_or(body_radius) + range,
                SensorKind::Proximity => sensor.offset.unwrap_or(body_radius) + farther * range,
                SensorKind::Bumper => body_radius + range,
                SensorKind::Sampled => body_radius + tables.reach(),
                SensorKind::Light | SensorKind::Ground | SensorKind::Battery => 0.0,
            }
        };
        let of_model = if self.model.is_some() { reference::RAY_END } else { 0.0 };
        1.0 + self.sensors.iter().map(reach).fold(of_model, f32::max)
    }

    /// Checks conditions that involve several values.
    pub(crate) fn check(&self, readings: &[String], body: &Body<'_>, arena: &Arena) -> Result<(), Invalid> {
        let tables = body.sensors;
        self.check_drive()?;
        if self.speeds == 1 {
            return Err(Invalid::new("robot.speeds", "is 1; allowed: 0, or 2 to 1024"));
        }
        if let Some(acceleration) = self.acceleration
            && acceleration != 0.0
            && acceleration < LEAST_ACCELERATION
        {
            let problem = format!("is {acceleration}; allowed: 0, or {LEAST_ACCELERATION} and more");
            return Err(Invalid::new("robot.acceleration_mm_s2", problem));
        }
        if self.sampled_motors && (self.is_slow() || self.is_late()) && body.motors.full_speed().is_none() {
            let problem = "have no speeds between states; allowed with acceleration or latency: 2 states and more of ascending \
                           speeds, the same for both wheels, and a robot that goes forwards and backwards as they do";
            return Err(Invalid::new("robot.motors", problem));
        }
        if self.battery.is_none() && self.battery_ends_life == Some(true) {
            return Err(Invalid::new("robot.battery_ends_life", ONLY_WITH_A_BATTERY));
        }
        self.check_members(body)?;
        self.check_arena(arena)?;
        length("robot.sensors", self.sensors.len(), GREATEST_LIST)?;
        let columns = self.columns();
        let of_model = self.model.map_or_else(Vec::new, Model::readings);
        for (index, sensor) in self.sensors.iter().enumerate() {
            let Sensor { name, kind, .. } = sensor;
            let is_other = |other: &Sensor| other.name == *name;
            let is_taken =
                self.sensors[..index].iter().any(is_other) || readings.contains(name) || of_model.contains(name);
            let checked = if is_taken || PREVIOUS.contains(&&**name) {
                let problem = format!("is `{name}`; allowed: a name that no other reading has");
                Err(Invalid::new("name", problem))
            } else if *kind == SensorKind::Battery && self.battery.is_none() {
                Err(Invalid::new("kind", "is battery; allowed: only with robot.battery_s"))
            } else {
                sensor.check().and_then(|()| self.check_column(index, &columns, tables))
            };
            checked.map_err(|invalid| invalid.within(&format!("robot.sensors[{index}]")))?;
        }
        Ok(())
    }

    /// Checks that either motors were sampled or wheels are described.
    fn check_drive(&self) -> Result<(), Invalid> {
        for (key, is_given, is_needed) in [
            ("wheel_base_mm", self.wheel_base.is_some(), true),
            ("greatest_speed_mm_s", self.greatest_speed.is_some(), true),
            ("speeds", self.speeds != 0, false),
            ("wheel_noise", self.wheel_noise.is_some(), false),
            ("wheel_noise_law", self.wheel_noise_law.is_some(), false),
        ] {
            if is_given && self.sampled_motors {
                let problem = "is given; allowed: not with robot.motors, whose samples have it";
                return Err(Invalid::new(format!("robot.{key}"), problem));
            }
            if is_needed && !is_given && !self.sampled_motors {
                let problem =
                    format!("lacks `{key}`; allowed: `wheel_base_mm` and `greatest_speed_mm_s`, or sampled `motors`");
                return Err(Invalid::new("robot", problem));
            }
        }
        if self.wheel_noise_law.is_some() && self.wheel_noise.is_none() {
            return Err(Invalid::new(
                "robot.wheel_noise_law",
                "is given; allowed: only with robot.wheel_noise",
            ));
        }
        if self.turn_before_move.is_some() && !self.sampled_motors {
            let problem = "is given; allowed: only with robot.motors, since the way of described wheels is an arc";
            return Err(Invalid::new("robot.turn_before_move", problem));
        }
        Ok(())
    }

    /// Checks what only robots that live together have, and what they can't have.
    fn check_members(&self, body: &Body<'_>) -> Result<(), Invalid> {
        const ALONE: &str = "allowed: only without robot.count";
        let sight = self.sensors.iter().position(|sensor| sensor.kind == SensorKind::Sight);
        let Some(count) = self.count else {
            let sight = sight.map(|index| (format!("robot.sensors[{index}].kind"), "is sight"));
            let differ = self.genomes != Genomes::Homogeneous;
            let genomes = differ.then(|| ("robot.genomes".to_owned(), "is given"));
            let contact = self.contact.map(|_| ("robot.contact".to_owned(), "is given"));
            let starts = self.starts.as_ref().map(|_| ("robot.starts_mm".to_owned(), "is given"));
            let model = self.model.map(|_| ("robot.model".to_owned(), "is given"));
            return match sight.or(genomes).or(contact).or(starts).or(model) {
                Some((key, what)) => Err(Invalid::new(key, format!("{what}; allowed: only with robot.count"))),
                None => Ok(()),
            };
        };
        let sampled = self
            .sensors
            .iter()
            .position(|sensor| sensor.kind == SensorKind::Sampled);
        if let Some(index) = sampled {
            let problem = format!("is sampled, and samples show no other robots; {ALONE}");
            return Err(Invalid::new(format!("robot.sensors[{index}].kind"), problem));
        }
        for (key, is_given) in [
            ("robot.motors", self.sampled_motors),
            ("robot.collision", body.collision != Collision::Undo),
            ("robot.battery_ends_life", self.battery_ends_life == Some(true)),
        ] {
            if is_given {
                return Err(Invalid::new(key, format!("is given; {ALONE}")));
            }
        }
        let farthest = self.farthest().unwrap_or(0.0);
        let most = FARTHEST * body.radius;
        if farthest > most {
            let problem = format!(
                "robots get {farthest} mm in a cycle, noise included; allowed with robot.count: up to {FARTHEST} of the body's \
                 radius, {most} mm"
            );
            return Err(Invalid::new("robot.greatest_speed_mm_s", problem));
        }
        self.genomes.check(count)?;
        self.check_starts(body)
    }

    /// Checks that each robot has a place to start, apart from all others.
    fn check_starts(&self, body: &Body<'_>) -> Result<(), Invalid> {
        let (places, count) = (self.start_places(), self.count.unwrap_or_default());
        if self.starts.is_none() {
            return Ok(());
        }
        let invalid = |problem| Err(Invalid::new("robot.starts_mm", problem));
        if places.len() != count as usize {
            return invalid(format!(
                "has {} places; allowed: one for each robot, {count}",
                places.len()
            ));
        }
        let least = 2.0 * body.radius;
        for (second, place) in places.iter().enumerate() {
            let near = |other: &[f32; 2]| {
                let apart = [place[0] - other[0], place[1] - other[1]];
                apart[0] * apart[0] + apart[1] * apart[1] < least * least
            };
            if let Some(first) = places[..second].iter().position(near) {
                return invalid(format!(
                    "has places {first} and {second} on each other; allowed: {least} mm and more between two of them"
                ));
            }
        }
        Ok(())
    }

    /// Checks the column of a sensor that was sampled, given those of all; errors have keys without the sensor's place.
    fn check_column(&self, index: usize, columns: &[Option<u32>], tables: &SensorTables) -> Result<(), Invalid> {
        let Some(column) = columns[index] else {
            return Ok(());
        };
        let problem = match tables.sensors() {
            0 => "is 0, and there are no tables; allowed: a table for each class of object".to_owned(),
            count if column >= count => {
                format!(
                    "is {column}; allowed: 0 to {}, since the tables have {count} sensors",
                    count - 1
                )
            }
            _ => match columns[..index].iter().position(|other| *other == Some(column)) {
                Some(other) => {
                    let other = &self.sensors[other].name;
                    format!("is {column}, the column of `{other}`; allowed: one that no other sensor has")
                }
                None => return Ok(()),
            },
        };
        Err(Invalid::new("column", problem))
    }

    /// Checks the lights and patches of its arena.
    fn check_arena(&self, arena: &Arena) -> Result<(), Invalid> {
        for (list, count) in [("lights", arena.lights.len()), ("patches", arena.patches.len())] {
            length(format!("arena.{list}"), count, GREATEST_LIST)?;
        }
        if self.model.is_none() {
            let height = arena.lights.iter().position(|light| light.height.is_some());
            let intensity = arena.lights.iter().position(|light| light.intensity.is_some());
            let given = [
                self.reference.given().map(str::to_owned),
                arena.wall_height.map(|_| "arena.wall_height_mm".to_owned()),
                height.map(|index| format!("arena.lights[{index}].height_mm")),
                intensity.map(|index| format!("arena.lights[{index}].intensity")),
            ];
            if let Some(key) = given.into_iter().flatten().next() {
                return Err(Invalid::new(key, "is given; allowed: only with robot.model"));
            }
        }
        for (index, patch) in arena.patches.iter().enumerate() {
            if patch.radius.is_some() == patch.sides.is_some() {
                let problem = if patch.radius.is_some() {
                    "has both `radius_mm` and `sides_mm`; allowed: one of them"
                } else {
                    "lacks `radius_mm` or `sides_mm`; allowed: one of them"
                };
                return Err(Invalid::new(format!("arena.patches[{index}]"), problem));
            }
            if patch.charges == Some(true) && self.battery.is_none() {
                return Err(Invalid::new(
                    format!("arena.patches[{index}].charges"),
                    ONLY_WITH_A_BATTERY,
                ));
            }
        }
        Ok(())
    }
}

/// The inverse of a number; 0 of 0.
fn inverse(number: f32) -> f32 {
    if number > 0.0 { 1.0 / number } else { 0.0 }
}

const ONLY_WITH_A_BATTERY: &str = "is true; allowed: only with robot.battery_s";

/// How much farther than its range a proximity sensor of a surrogate may see, as `lib/differences.wgsl` has it: at a severity of 2
/// objects return at most 1.4 times the light of their surroundings, which have at most 1.6 times theirs, and sensors see at most
/// 1.375 times as far.
const FARTHER: f32 = 2.1;

/// Least acceleration of wheels that don't obey at once, mm/s in a second: below, changes of speed would get lost in roundings.
const LEAST_ACCELERATION: f32 = 1.0;

/// Most sensors of a robot, most lights and most patches of its arena.
pub const GREATEST_LIST: usize = tables::GREATEST_SENSORS;
