//! The sensors of a parametric robot: each kind is a file in the folder `sensors/` and a line of the registry, and its reading a function
//! of `shaders/wgsl/sensor/kinds.wgsl`.

mod battery;
#[cfg_attr(
    not(feature = "compose"),
    expect(dead_code, reason = "composed kernels alone are written")
)]
mod bumper;
mod gripper;
mod ground;
#[cfg_attr(
    not(feature = "compose"),
    expect(dead_code, reason = "composed kernels alone are written")
)]
mod kind;
mod light;
#[cfg_attr(
    not(feature = "compose"),
    expect(dead_code, reason = "composed kernels alone are written")
)]
mod ray;
#[cfg_attr(
    not(feature = "compose"),
    expect(dead_code, reason = "composed kernels alone are written")
)]
mod sampled;
mod sight;
mod text;

use crate::parameter::{Choice, Choices, Invalid, field_of_pairs, is_identifier, number, only_where};
use kind::kinds;
pub use kind::{Counterpart, Entry, Feature, Mark, Scale};
pub use light::Law;

pub use bumper::WIDTH as BUMPER_WIDTH;
#[cfg(feature = "compose")]
pub(crate) use bumper::{APART, of_an_object as of_bumpers};
pub(crate) use kind::Around;
#[cfg(feature = "compose")]
pub(crate) use ray::of_an_object as of_rays;
#[cfg(feature = "compose")]
pub(crate) use sampled::Planes;
#[cfg(feature = "compose")]
pub(crate) use text::{Each, Text};

// The registry, in the order of documents and messages.
kinds! {
    /// Distance to the nearest object along a ray, as a fraction of the range: 1 if nothing is in range.
    Distance: ray::DISTANCE;
    /// One minus that: 0 if nothing is in range.
    Proximity: ray::PROXIMITY;
    /// 1 while something is as near as the range within its width, else 0.
    Bumper: bumper::ENTRY;
    /// Sum of the brightness of all lights that no object hides, each by its distance and direction, at most 1. A light at a
    /// quarter turn or more adds nothing.
    Light: light::ENTRY;
    /// Grey of the floor below it.
    Ground: ground::ENTRY;
    /// Charge of the robot's battery, from 1 for full to 0 for empty.
    Battery: battery::ENTRY;
    /// What was sampled: a column of [`Robot::sensors`](crate::world::Robot::sensors).
    Sampled: sampled::ENTRY;
    /// 1 if what a ray meets first, within its range, is another robot, else 0.
    Sight: sight::ROBOT;
    /// 1 if what a ray meets first, within its range, is a puck, else 0.
    Puck: sight::PUCK;
    /// 1 while the robot carries a puck, else 0.
    Gripper: gripper::ENTRY;
}

/// A sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    /// Its name, an identifier in WGSL.
    pub name: String,
    /// What it measures.
    pub kind: SensorKind,
    /// Where it looks, turns counter-clockwise from straight ahead. None of a battery's.
    pub heading: f32,
    /// Where it is on the body, turns counter-clockwise from straight ahead. `None`: where it looks. For rays and light.
    pub bearing: Option<f32>,
    /// Distance from the body's centre, mm; none of a bumper's and a battery's. `None`: the body's radius.
    pub offset: Option<f32>,
    /// Range of all except ground and battery sensors, mm. Of a bumper: the gap between body and object below which it is pressed.
    pub range: Option<f32>,
    /// Width of a bumper, turns. `None`: half a turn.
    pub width: Option<f32>,
    /// Of a light sensor. `None`: linear.
    pub law: Option<Law>,
    /// Of a proximity sensor. `None`: linear.
    pub response: Option<Response>,
    /// Of a sampled sensor: its column of the tables, from 0. `None`: its place among the robot's sampled sensors.
    pub column: Option<u32>,
}

/// What a sensor reads at some distances, from the nearest to the farthest, mm and 0 to 1 each: straight lines between them,
/// and beyond either end the reading there, up to the sensor's range.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Response(pub Vec<[f32; 2]>);

impl Default for Sensor {
    fn default() -> Self {
        Self {
            name: String::new(),
            kind: SensorKind::Proximity,
            heading: 0.0,
            bearing: None,
            offset: None,
            range: None,
            width: None,
            law: None,
            response: None,
            column: None,
        }
    }
}

field_of_pairs!(Response);

impl SensorKind {
    /// Names of the kinds that have a key of a sensor's table; none for a key that all have.
    pub fn with(key: &str) -> Vec<&'static str> {
        let kinds = Self::CHOICES.iter().map(|(_, kind, _)| kind.entry());
        let kinds = kinds.filter(|entry| entry.keys.contains(&key));
        kinds.map(|entry| entry.name).collect()
    }
}

impl Sensor {
    /// Checks conditions that involve several of its values; errors have keys without the sensor's place.
    pub(crate) fn check(&self) -> Result<(), Invalid> {
        let Self { name, kind, .. } = self;
        if !is_identifier(name) {
            let allowed = "letters from a to z, digits and _, a letter first";
            return Err(Invalid::new("name", format!("is `{name}`; allowed: {allowed}")));
        }
        let has = |key: &str| kind.entry().keys.contains(&key);
        if has("range_mm") && self.range.is_none() {
            let problem = format!(
                "lacks `range_mm`; allowed: the range of the {} sensor in mm",
                kind.word()
            );
            return Err(Invalid::new("", problem));
        }
        only_where(
            format_args!("kind = \"{}\"", kind.word()),
            &[
                ("heading_turns", self.heading != 0.0),
                ("bearing_turns", self.bearing.is_some()),
                ("range_mm", self.range.is_some()),
                ("offset_mm", self.offset.is_some()),
                ("width_turns", self.width.is_some()),
                ("law", self.law.is_some()),
                ("response", self.response.is_some()),
                ("column", self.column.is_some()),
            ]
            .map(|(key, is_given)| (key, is_given, has(key))),
        )?;
        match &self.response {
            Some(response) => response.check(self.range.unwrap_or(0.0)),
            None => Ok(()),
        }
    }
}

impl Response {
    /// Checks its points, which lie within a sensor's range.
    pub(crate) fn check(&self, range: f32) -> Result<(), Invalid> {
        let points = &self.0;
        if !(2..=GREATEST_POINTS).contains(&points.len()) {
            let problem = format!("has {} points; allowed: 2 to {GREATEST_POINTS}", points.len());
            return Err(Invalid::new("response", problem));
        }
        for (index, &[distance, reading]) in points.iter().enumerate() {
            number(format_args!("response[{index}][0]"), distance, 0.0..=range)?;
            number(format_args!("response[{index}][1]"), reading, 0.0..=1.0)?;
        }
        let is_late = |[near, far]: &&[[f32; 2]; 2]| far[0] - near[0] < LEAST_STEP;
        if let Some(&[[near, _], [far, _]]) = points.array_windows().find(is_late) {
            let allowed = format!("each distance at least {LEAST_STEP} mm beyond the one before");
            let problem = format!("goes from {near} to {far} mm; allowed: {allowed}");
            return Err(Invalid::new("response", problem));
        }
        Ok(())
    }

    /// Kernel data: of each point its distance, its reading, and what the reading changes by for each mm to the next.
    pub(crate) fn cells(&self) -> impl Iterator<Item = [f32; 4]> {
        let next = self.0.iter().skip(1).map(Some).chain([None]);
        self.0.iter().zip(next).map(|(&[distance, reading], next)| {
            let slope = next.map_or(0.0, |next| (next[1] - reading) / (next[0] - distance));
            [distance, reading, slope, 0.0]
        })
    }
}

/// Most points of a sensor's response, and their minimum distance from each other, mm.
pub const GREATEST_POINTS: usize = 32;
const LEAST_STEP: f32 = 0.01;
