//! The sensors of a parametric robot.

use crate::parameter::{Choice, Choices, Invalid, field_of_pairs, is_identifier, number, only_where};

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

/// What a sensor measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorKind {
    /// Distance to the nearest object along a ray, as a fraction of the range: 1 if nothing is in range.
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
    /// Charge of the robot's battery, from 1 for full to 0 for empty.
    Battery,
    /// What was sampled: a column of [`Robot::sensors`](crate::world::Robot::sensors).
    Sampled,
    /// 1 if what a ray meets first, within its range, is another robot, else 0.
    Sight,
}

impl SensorKind {
    /// Whether it reads numbers between 0 and 1 off something outside of the robot.
    pub(crate) fn is_analogue(self) -> bool {
        !matches!(self, Self::Bumper | Self::Battery | Self::Sight)
    }

    /// Whether the light of the surroundings is in its readings.
    pub(crate) fn sees_light(self) -> bool {
        matches!(self, Self::Proximity | Self::Light | Self::Sampled)
    }
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
            "distance to the nearest object along a ray, as a fraction of the range: 1 if there is none",
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
        (
            "battery",
            Self::Battery,
            "charge of the battery, from 1 for full to 0 for empty",
        ),
        ("sampled", Self::Sampled, "a column of the robot's tables of samples"),
        (
            "sight",
            Self::Sight,
            "1 if what a ray meets first is another robot, else 0",
        ),
    ];
}

field_of_pairs!(Response);

impl Sensor {
    /// Checks conditions that involve several of its values; errors have keys without the sensor's place.
    pub(crate) fn check(&self) -> Result<(), Invalid> {
        use SensorKind::{Battery, Bumper, Distance, Ground, Light, Proximity, Sampled, Sight};
        let Self { name, kind, .. } = self;
        if !is_identifier(name) {
            let allowed = "letters from a to z, digits and _, a letter first";
            return Err(Invalid::new("name", format!("is `{name}`; allowed: {allowed}")));
        }
        let has_range = !matches!(kind, Ground | Battery | Sampled);
        if has_range && self.range.is_none() {
            let problem = format!(
                "lacks `range_mm`; allowed: the range of the {} sensor in mm",
                kind.word()
            );
            return Err(Invalid::new("", problem));
        }
        only_where(
            format_args!("kind = \"{}\"", kind.word()),
            &[
                ("heading_turns", self.heading != 0.0, !matches!(kind, Battery | Sampled)),
                (
                    "bearing_turns",
                    self.bearing.is_some(),
                    matches!(kind, Distance | Proximity | Light),
                ),
                ("range_mm", self.range.is_some(), has_range),
                (
                    "offset_mm",
                    self.offset.is_some(),
                    !matches!(kind, Bumper | Battery | Sampled | Sight),
                ),
                ("width_turns", self.width.is_some(), *kind == Bumper),
                ("law", self.law.is_some(), *kind == Light),
                ("response", self.response.is_some(), *kind == Proximity),
                ("column", self.column.is_some(), *kind == Sampled),
            ],
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
            let allowed = format!("each distance {LEAST_STEP} mm and more beyond the one before");
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
