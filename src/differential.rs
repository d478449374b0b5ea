//! Robots that are described by numbers rather than sampled: two wheels that obey at once, and sensors of a few kinds.

use std::f64::consts::TAU;

use crate::arena::{self, Arena, Light, Patch};
use crate::parameter::{Choice, Choices, Invalid};
use crate::tables::PREVIOUS;

/// Origin of a robot's sensors and motors.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Build {
    /// The tables of [`Robot::sensors`](crate::world::Robot::sensors) and [`Robot::motors`](crate::world::Robot::motors).
    #[default]
    Sampled,
    /// Numbers, which take the tables' place. Needs the feature `native`.
    Differential(Differential),
}

/// A robot on two wheels that obey at once. An output of 0 is full speed backwards, 1 full speed forwards, and each cycle is
/// an arc.
#[derive(Clone, Debug, PartialEq)]
pub struct Differential {
    /// Distance between the wheels, mm.
    pub wheel_base: f32,
    /// Greatest speed of a wheel, mm/s.
    pub greatest_speed: f32,
    /// Number of speeds that a wheel can be given, evenly spaced; 0 for any speed.
    pub speeds: u32,
    /// Its sensors.
    pub sensors: Vec<Sensor>,
}

/// A sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    /// Its name, an identifier in WGSL.
    pub name: String,
    /// What it measures.
    pub kind: SensorKind,
    /// Where it is on the body and where it looks, turns counter-clockwise from straight ahead.
    pub heading: f32,
    /// Distance from the body's centre, mm; none of a bumper's. `None`: the body's radius.
    pub offset: Option<f32>,
    /// Range of all but ground sensors, mm. Of a bumper: the gap between body and object below which it is pressed.
    pub range: Option<f32>,
    /// Width of a bumper, turns. `None`: half a turn.
    pub width: Option<f32>,
    /// Of a light sensor. `None`: linear.
    pub law: Option<Law>,
}

impl Default for Sensor {
    fn default() -> Self {
        Self {
            name: String::new(),
            kind: SensorKind::Proximity,
            heading: 0.0,
            offset: None,
            range: None,
            width: None,
            law: None,
        }
    }
}

/// What a sensor measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorKind {
    /// Distance to the nearest object along a ray, as a share of the range: 1 if nothing is in range.
    Distance,
    /// One minus that: 0 if nothing is in range.
    Proximity,
    /// 1 while something is as near as the range within its width, else 0.
    Bumper,
    /// Sum of the brightness of all lights that no object hides, each by its distance and direction, at most 1. A light at a
    /// quarter turn or more adds nothing.
    Light,
    /// Grey of the floor below it.
    Ground,
}

/// How the brightness of a light falls with its distance in ranges, `d`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Law {
    /// `1 - d`, and 0 from the range on.
    #[default]
    Linear,
    /// `exp(-d)`.
    Exponential,
    /// `1 / (1 + d^2)`.
    InverseSquare,
}

impl Choice for Law {
    const CHOICES: Choices<Self> = &[
        ("linear", Self::Linear, "1 - d, and 0 from the range on"),
        ("exponential", Self::Exponential, "exp(-d)"),
        ("inverse_square", Self::InverseSquare, "1 / (1 + d^2)"),
    ];
}

impl Choice for SensorKind {
    const CHOICES: Choices<Self> = &[
        (
            "distance",
            Self::Distance,
            "distance to the nearest object along a ray, as a share of the range: 1 if there is none",
        ),
        ("proximity", Self::Proximity, "one minus that: 0 if there is none"),
        (
            "bumper",
            Self::Bumper,
            "1 while an object is within its range and its width, else 0",
        ),
        (
            "light",
            Self::Light,
            "the brightness of all lights that no object hides, by their distance and direction",
        ),
        (
            "ground",
            Self::Ground,
            "grey of the floor below it, from 0 for black to 1 for white",
        ),
    ];
}

impl Differential {
    /// Kernel data for the robot and its arena: the cells that `robot/arcs.wgsl` and `sensor/kinds.wgsl` declare.
    pub(crate) fn cells(&self, body_radius: f32, arena: &Arena) -> Vec<[u32; 4]> {
        let farthest = 0.1 * f64::from(self.greatest_speed);
        let steps = self.speeds.saturating_sub(1) as f32;
        let wheels = [
            farthest as f32,
            (farthest / (TAU * f64::from(self.wheel_base))) as f32,
            steps,
            if steps > 0.0 { 1.0 / steps } else { 0.0 },
        ];
        let sensor = |sensor: &Sensor| {
            let range = sensor.range.unwrap_or(1.0);
            let [range, share] = match sensor.kind {
                SensorKind::Distance | SensorKind::Proximity => [range, 1.0 / range],
                SensorKind::Bumper => [range, 0.5 * sensor.width.unwrap_or(0.5)],
                SensorKind::Light => [f32::from(sensor.law.unwrap_or_default() as u8), 1.0 / range],
                SensorKind::Ground => [0.0, 0.0],
            };
            [sensor.heading, sensor.offset.unwrap_or(body_radius), range, share]
        };
        let light = |light: &Light| [light.x, light.y, light.brightness, 0.0];
        let patch = |patch: &Patch| {
            let axis = arena::axis(patch.heading);
            let radius = patch.radius.unwrap_or(0.0);
            let [length, width] = patch.sides.unwrap_or_default();
            [
                [patch.x, patch.y, axis.x, axis.y],
                [0.5 * length, 0.5 * width, radius * radius, patch.grey],
            ]
        };
        let cells = std::iter::once(wheels)
            .chain(self.sensors.iter().map(sensor))
            .chain([[arena.floor.unwrap_or(1.0), 0.0, 0.0, 0.0]])
            .chain(arena.lights.iter().map(light))
            .chain(arena.patches.iter().flat_map(patch));
        // Zero has one sign.
        let bits = |number: f32| if number == 0.0 { 0 } else { number.to_bits() };
        cells.map(|cell| cell.map(bits)).collect()
    }

    /// Greatest distance from the body's centre at which its sensors notice an object, mm, and a little more.
    pub(crate) fn reach(&self, body_radius: f32) -> f32 {
        let reach = |sensor: &Sensor| {
            let range = sensor.range.unwrap_or(0.0);
            match sensor.kind {
                SensorKind::Distance | SensorKind::Proximity => sensor.offset.unwrap_or(body_radius) + range,
                SensorKind::Bumper => body_radius + range,
                SensorKind::Light | SensorKind::Ground => 0.0,
            }
        };
        1.0 + self.sensors.iter().map(reach).fold(0.0, f32::max)
    }

    /// Checks conditions that involve several values.
    pub(crate) fn check(&self, readings: &[String], arena: &Arena) -> Result<(), Invalid> {
        if self.speeds == 1 {
            return Err(Invalid::new("robot.speeds", "is 1; allowed: 0, or 2 to 1024"));
        }
        let has_light = |sensor: &Sensor| sensor.kind == SensorKind::Light;
        if arena.lights.is_empty() && self.sensors.iter().any(has_light) {
            let problem = "is empty, and the robot has light sensors; allowed: one light and more";
            return Err(Invalid::new("arena.lights", problem));
        }
        for (list, count) in [("lights", arena.lights.len()), ("patches", arena.patches.len())] {
            if count > GREATEST_SENSORS {
                let problem = format!("has {count} elements; allowed: up to {GREATEST_SENSORS}");
                return Err(Invalid::new(format!("arena.{list}"), problem));
            }
        }
        for (index, patch) in arena.patches.iter().enumerate() {
            if patch.radius.is_some() == patch.sides.is_some() {
                let problem = "has both a radius and sides, or neither; allowed: `radius_mm` or `sides_mm`";
                return Err(Invalid::new(format!("arena.patches[{index}]"), problem));
            }
        }
        if self.sensors.len() > GREATEST_SENSORS {
            let problem = format!("has {} elements; allowed: up to {GREATEST_SENSORS}", self.sensors.len());
            return Err(Invalid::new("robot.sensors", problem));
        }
        for (index, sensor) in self.sensors.iter().enumerate() {
            let problem =
                |key: &str, problem: String| Err(Invalid::new(format!("robot.sensors[{index}].{key}"), problem));
            let Sensor { name, kind, .. } = sensor;
            if !is_identifier(name) {
                let allowed = "letters from a to z, digits and _, a letter first";
                return problem("name", format!("is `{name}`; allowed: {allowed}"));
            }
            let is_other = |other: &Sensor| other.name == *name;
            if self.sensors[..index].iter().any(is_other) || readings.contains(name) || PREVIOUS.contains(&&**name) {
                return problem(
                    "name",
                    format!("is `{name}`; allowed: a name that no other reading has"),
                );
            }
            let has_range = *kind != SensorKind::Ground;
            if has_range && sensor.range.is_none() {
                return problem(
                    "range_mm",
                    format!("is missing; allowed: the range of the {} sensor", kind.word()),
                );
            }
            for (key, is_given, is_allowed) in [
                ("range_mm", sensor.range.is_some(), has_range),
                ("offset_mm", sensor.offset.is_some(), *kind != SensorKind::Bumper),
                ("width_turns", sensor.width.is_some(), *kind == SensorKind::Bumper),
                ("law", sensor.law.is_some(), *kind == SensorKind::Light),
            ] {
                if is_given && !is_allowed {
                    return problem(key, format!("is given; allowed: not with kind = \"{}\"", kind.word()));
                }
            }
        }
        Ok(())
    }
}

/// Most sensors of a robot, and most lights and patches of its arena.
pub const GREATEST_SENSORS: usize = 64;

fn is_identifier(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_lowercase())
        && name
            .chars()
            .all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
}
