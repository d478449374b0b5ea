//! Parametric robots: two wheels, sensors of a few kinds, and a battery. Sensors and motors may also be
//! sampled.

use crate::genes::PREVIOUS;
use crate::parameter::{Choice, Invalid, field_of_pairs, length};
use crate::parts::compose::Grids;
use crate::world::arena::Arena;
use crate::world::body::{Body, Collision};
use crate::world::described::{Battery, Described, Drive, Together, Wheels};
pub use crate::world::described::{Contact, GREATEST_MEMBERS, GREATEST_SEEN_MEMBERS, Genomes, WheelNoise};
use crate::world::reference::{Model, Reference};
pub use crate::world::sensors::{
    BUMPER_WIDTH, Counterpart, Entry, Feature, GREATEST_POINTS, Law, Mark, Response, Scale, Sensor, SensorKind,
};
use crate::world::tables::{self, SensorTables};

/// A robot on two wheels. An output of 0 commands full speed backwards, 1 full speed forwards, and each cycle is an arc; or its
/// motors are sampled.
#[derive(Clone, Debug, PartialEq)]
pub struct Differential {
    /// Whether [`Robot::motors`](crate::world::Robot::motors) drive it. Then it has none of the values up to `speeds`.
    pub sampled_motors: bool,
    /// Distance between the wheels, mm.
    pub wheel_base: Option<f32>,
    /// Maximum speed of a wheel, mm/s.
    pub greatest_speed: Option<f32>,
    /// Number of speeds that a wheel can be given, evenly spaced; 0 for any speed.
    pub speeds: u32,
    /// Maximum change of a wheel's speed, mm/s in a second. `None` or 0: wheels obey at once. Sampled motors need states
    /// whose speeds ascend, and then move as their samples do at a cycle's mean speeds, see
    /// [`MotorTable::full_speed`](crate::tables::MotorTable::full_speed).
    pub acceleration: Option<f32>,
    /// Whole cycles from a command to its effect on the wheels, which stand still until the first one arrives. `None`: 0.
    pub latency: Option<u32>,
    /// Of sampled motors: share of a cycle's turn made before its displacement, 0 to 1. `None`: 0.
    pub turn_before_move: Option<f32>,
    /// Time that a full battery lasts, s, rounded to whole cycles of 100 ms. Its charge falls evenly. `None`: it has none.
    pub battery: Option<f32>,
    /// Whether its episode ends when the battery is empty. `None`: it doesn't.
    pub battery_ends_life: Option<bool>,
    /// Noise of each wheel's speed in each cycle, as a fraction of that speed, 0 to 0.5. `None`: 0.
    pub wheel_noise: Option<f32>,
    /// Distribution of that noise. `None`: uniform.
    pub wheel_noise_law: Option<WheelNoise>,
    /// Number of such robots in the world, 1 to [`GREATEST_MEMBERS`]. `None`: one, as a single robot.
    pub count: Option<u32>,
    /// Which robots of a swarm share their genes.
    pub genomes: Genomes,
    /// Of several robots: what bodies do that meet. `None`: they push.
    pub contact: Option<Contact>,
    /// Of several robots: where each starts, with a random heading. `None`: at random places.
    pub starts: Option<Starts>,
    /// Of robots whose starts are given: the heading of each, turns counter-clockwise from the x axis, 0 to less than 1. Empty: random ones.
    pub headings: Vec<f32>,
    /// Its reference model, of several robots. `None`: it has only the sensors of its list.
    pub model: Option<Model>,
    /// Values of that model.
    pub reference: Reference,
    /// Its sensors.
    pub sensors: Vec<Sensor>,
}

/// The farthest that a body gets in a cycle of a swarm, as a fraction of its radius: `FARTHEST` of
/// `physics/contacts.wgsl`.
pub(super) const FARTHEST: f32 = 0.75;

/// Start of each robot of a swarm: x and y, mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Starts(pub Vec<[f32; 2]>);

field_of_pairs!(Starts);

impl Differential {
    /// A robot that obeys at once, without sensors and battery: the distance between its wheels, mm, and their maximum speed,
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
            headings: Vec::new(),
            model: None,
            reference: Reference::DEFAULT,
            sensors: Vec::new(),
        }
    }

    /// Names of its readings: those of its list of sensors, then those of its reference model.
    pub(crate) fn readings(&self) -> Vec<String> {
        let listed = self.sensors.iter().map(|sensor| sensor.name.clone());
        let model = self.model.into_iter().flat_map(Model::readings);
        listed.chain(model).collect()
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

    /// Start of each robot of a swarm, if set.
    pub(crate) fn start_places(&self) -> &[[f32; 2]] {
        self.starts.as_ref().map_or(&[], |Starts(places)| places)
    }

    /// Checks conditions that involve several values, and puts together what belongs together.
    pub(crate) fn check(&self, readings: &[String], body: &Body<'_>, arena: &Arena) -> Result<Described, Invalid> {
        let tables = body.sensors;
        let drive = self.check_drive()?;
        if self.speeds == 1 {
            return Err(Invalid::new("robot.speeds", "is 1; allowed: 0, or 2 to 1024"));
        }
        if let Some(acceleration) = self.acceleration
            && acceleration != 0.0
            && acceleration < LEAST_ACCELERATION
        {
            let problem = format!("is {acceleration}; allowed: 0, or at least {LEAST_ACCELERATION}");
            return Err(Invalid::new("robot.acceleration_mm_s2", problem));
        }
        let (acceleration, latency) = (self.acceleration.unwrap_or(0.0), self.latency.unwrap_or(0));
        if self.sampled_motors && (acceleration > 0.0 || latency > 0) && body.motors.full_speed().is_none() {
            let problem = "have no speeds between states; allowed with acceleration or latency: at least 2 states of \
                           ascending speeds. They are the same for both wheels, and move the robot forwards and \
                           backwards alike";
            return Err(Invalid::new("robot.motors", problem));
        }
        if self.battery.is_none() && self.battery_ends_life == Some(true) {
            return Err(Invalid::new("robot.battery_ends_life", ONLY_WITH_A_BATTERY));
        }
        let together = self.check_members(&drive, body)?.map(Box::new);
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
            } else if kind.entry().has(Feature::ReadsBattery) && self.battery.is_none() {
                let problem = format!("is {}; allowed: only with robot.battery_s", kind.word());
                Err(Invalid::new("kind", problem))
            } else {
                sensor.check().and_then(|()| self.check_column(index, &columns, tables))
            };
            checked.map_err(|invalid| invalid.within(&format!("robot.sensors[{index}]")))?;
        }
        Ok(Described {
            drive,
            acceleration,
            latency,
            battery: self.battery.map(|seconds| Battery {
                seconds,
                ends_life: self.battery_ends_life == Some(true),
            }),
            together,
            grids: Grids::default(),
            columns,
            sensors: self.sensors.clone(),
        })
    }

    /// Checks that either motors were sampled or wheels are described.
    fn check_drive(&self) -> Result<Drive, Invalid> {
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
            let problem = "is given; allowed: only with robot.motors, since parametric wheels drive arcs";
            return Err(Invalid::new("robot.turn_before_move", problem));
        }
        Ok(match (self.wheel_base, self.greatest_speed) {
            (Some(base), Some(greatest_speed)) => Drive::Wheels(Wheels {
                base,
                greatest_speed,
                speeds: self.speeds,
                noise: self
                    .wheel_noise
                    .map(|most| (most, self.wheel_noise_law.unwrap_or_default())),
            }),
            _ => Drive::Motors {
                turn_before_move: self.turn_before_move.unwrap_or(0.0),
            },
        })
    }

    /// Checks what only swarms have, and what they can't have.
    fn check_members(&self, drive: &Drive, body: &Body<'_>) -> Result<Option<Together>, Invalid> {
        const ALONE: &str = "allowed: only without robot.count";
        let reads_robots = |sensor: &Sensor| sensor.kind.entry().has(Feature::ReadsRobots);
        let sight = self.sensors.iter().position(reads_robots);
        let Some(count) = self.count else {
            let sight = sight.map(|index| {
                let what = format!("is {}", self.sensors[index].kind.word());
                (format!("robot.sensors[{index}].kind"), what)
            });
            let is_given = || "is given".to_owned();
            let differ = self.genomes != Genomes::Homogeneous;
            let genomes = differ.then(|| ("robot.genomes".to_owned(), is_given()));
            let contact = self.contact.map(|_| ("robot.contact".to_owned(), is_given()));
            let starts = self.starts.as_ref().map(|_| ("robot.starts_mm".to_owned(), is_given()));
            let model = self.model.map(|_| ("robot.model".to_owned(), is_given()));
            return match sight.or(genomes).or(contact).or(starts).or(model) {
                Some((key, what)) => Err(Invalid::new(key, format!("{what}; allowed: only with robot.count"))),
                None => Ok(None),
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
        let farthest = drive.farthest().unwrap_or(0.0);
        let most = FARTHEST * body.radius;
        if farthest > most {
            let problem = format!(
                "robots move up to {farthest} mm in a cycle, noise included; allowed with robot.count: up to \
                 {FARTHEST} of the body's radius, {most} mm"
            );
            return Err(Invalid::new("robot.greatest_speed_mm_s", problem));
        }
        if self.model.is_some() && count > GREATEST_SEEN_MEMBERS {
            let problem = format!("is {count}; allowed with robot.model: 1 to {GREATEST_SEEN_MEMBERS}");
            return Err(Invalid::new("robot.count", problem));
        }
        self.genomes.check(count)?;
        self.check_starts(body)?;
        Ok(Some(Together {
            count,
            genomes: self.genomes.clone(),
            contact: self.contact.unwrap_or_default(),
            starts: self.starts.as_ref().map(|Starts(places)| places.clone()),
            headings: self.headings.clone(),
            model: self.model.map(|model| (model, self.reference.clone())),
            pucks: None,
        }))
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
        if ![0, places.len()].contains(&self.headings.len()) {
            return invalid(format!(
                "has {} headings; allowed: one for each robot, or none",
                self.headings.len()
            ));
        }
        if let Some(heading) = self.headings.iter().find(|heading| !(0.0..1.0).contains(*heading)) {
            return invalid(format!("has the heading {heading}; allowed: 0 to less than 1 turns"));
        }
        let least = 2.0 * body.radius;
        for (second, place) in places.iter().enumerate() {
            let near = |other: &[f32; 2]| {
                let apart = [place[0] - other[0], place[1] - other[1]];
                apart[0] * apart[0] + apart[1] * apart[1] < least * least
            };
            if let Some(first) = places[..second].iter().position(near) {
                return invalid(format!(
                    "has overlapping places {first} and {second}; allowed: at least {least} mm between any two"
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
        length("arena.lights", arena.lights.len(), GREATEST_LIST)?;
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

const ONLY_WITH_A_BATTERY: &str = "is true; allowed: only with robot.battery_s";

/// Minimum acceleration of wheels that don't obey at once, mm/s in a second: below, changes of speed would get lost in roundings.
const LEAST_ACCELERATION: f32 = 1.0;

/// Most sensors of a robot, and most lights of its arena.
pub const GREATEST_LIST: usize = tables::GREATEST_SENSORS;
