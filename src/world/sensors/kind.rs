//! Entries of the registry of kinds of sensors. The registry is in `sensors.rs`: one line a kind, from which its name, the keys that
//! it has, its checks, its cells, the WGSL of its reading, its place in pictures and the readings of connected robots follow.

use super::Sensor;
use super::text::{Each, Text};

/// A kind's entry in the registry.
pub struct Entry {
    /// Its name in an experiment.
    pub name: &'static str,
    /// What it reads.
    pub about: &'static str,
    /// Keys of a sensor that it has besides `name` and `kind`. It needs its range.
    pub(crate) keys: &'static [&'static str],
    /// Where it differs from other kinds.
    pub(crate) features: &'static [Feature],
    /// How an individual's differs, if it does: turns by which it looks aside, and how strong it is, from the turns and the strength
    /// that are drawn for each sensor.
    pub(crate) mounting: Option<fn(f64, f64) -> [f64; 2]>,
    /// The last two numbers of its first cell; the second argument is how far sampled sensors reach, mm.
    pub(crate) numbers: fn(&Sensor, f32) -> [f32; 2],
    /// How far from the body's centre it notices objects, mm.
    pub(crate) reach: fn(&Sensor, &Around) -> f32,
    /// Writes what its reading needs, and returns the expression.
    pub(crate) write: fn(&mut Text, &Each<'_>) -> String,
    /// How it is drawn.
    pub mark: Mark,
    /// What a connected robot has in its place.
    pub counterpart: Option<Counterpart>,
}

impl Entry {
    /// A kind without keys and features that reads no objects.
    pub(super) const fn new([name, about]: [&'static str; 2], write: fn(&mut Text, &Each<'_>) -> String) -> Self {
        Self {
            name,
            about,
            keys: &[],
            features: &[],
            mounting: None,
            numbers: |_, _| [0.0; 2],
            reach: |_, _| 0.0,
            write,
            mark: Mark::None,
            counterpart: None,
        }
    }

    /// Whether it has a feature.
    pub fn has(&self, feature: Feature) -> bool {
        self.features.contains(&feature)
    }
}

/// Where a kind differs from others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// It reads numbers between 0 and 1 off something outside of the robot.
    Analogue,
    /// The light of the surroundings is in its readings.
    SeesLight,
    /// What it reads depends on how much light a surface returns.
    SeesSurfaces,
    /// It reads more, the nearer an object is.
    SeesNearness,
    /// It reads the floor.
    ReadsFloor,
    /// It reads lights.
    ReadsLights,
    /// It reads the charge of the robot's battery.
    ReadsBattery,
    /// It reads only what moves: other robots or pucks.
    ReadsRobots,
    /// It reads only pucks.
    ReadsPucks,
}

/// What the reach of a sensor depends on.
pub(crate) struct Around {
    /// mm.
    pub(crate) body_radius: f32,
    /// How much farther than its range a sensor that gets light back may see.
    pub(crate) farther: f32,
    /// How far sampled sensors reach, mm.
    pub(crate) tables: f32,
}

/// How a sensor is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Not at all.
    None,
    /// As its arc of the body.
    Arc,
    /// As a dot where it is.
    Dot,
    /// With its ray.
    Ray,
    /// With the direction in which it looks.
    Direction,
}

/// A sensor of a connected robot with the readings of a parametric robot's sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Counterpart {
    /// Its kind, in the words of connected robots.
    pub kind: &'static str,
    /// How its reading becomes one from 0 to 1.
    pub scale: Scale,
    /// How it responds to obstacles that come nearer: 1 if it grows, -1 if it falls from 1, 0 if it does not.
    pub nearness: f32,
}

/// How a connected robot's reading becomes one from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// As samples do.
    Samples,
    /// As a fraction of the sensor's range.
    Range,
    /// As a fraction of its maximum reading.
    Greatest,
    /// As what is left to its maximum reading.
    Rest,
}

/// Makes the registry: a line has a kind's name in Rust and the path of its entry.
macro_rules! kinds {
    ($($(#[$doc:meta])* $kind:ident: $entry:path;)*) => {
        /// What a sensor measures.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum SensorKind {
            $($(#[$doc])* $kind,)*
        }

        impl Choice for SensorKind {
            const CHOICES: Choices<Self> = &[$(($entry.name, Self::$kind, $entry.about),)*];
        }

        impl SensorKind {
            /// Its entry.
            pub fn entry(self) -> &'static Entry {
                match self {
                    $(Self::$kind => &$entry,)*
                }
            }
        }
    };
}
pub(super) use kinds;
