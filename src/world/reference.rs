//! The e-puck by its reference models RM1.1 and RM1.2, as in the simulator ARGoS: a controller's inputs in
//! each cycle. `shaders/wgsl/sensor/reference.wgsl` computes it.
//!
//! Sources: the models are github.com/demiurge-project/demiurge-epuck-dao, commit ffb5c00a, the robot is
//! github.com/demiurge-project/argos3-epuck, commit 66cb8d9b, and what a network is given of the models is
//! github.com/demiurge-project/ARGoS3-NEAT, commit 40d8d34d.

use crate::parameter::{Choice, Choices};
use crate::world::arena::{Arena, Light};

/// Values of a reference model; what is `None` has its default, that of ARGoS's e-puck, of its configurations or of `EvoStick`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reference {
    /// Maximum error of each of the eight readings of proximity, uniform; the reading is clipped to 0 to 1. Default: 0.05.
    pub proximity_noise: Option<f32>,
    /// The same of the eight readings of light. Default: 0.05.
    pub light_noise: Option<f32>,
    /// The same of the three readings of the floor's grey. Default: 0.05.
    pub ground_noise: Option<f32>,
    /// Mean and standard deviation of what the left ground sensor gives a network of a floor that is neither black nor white, normal,
    /// and clipped to 0 to 1. Default: 0.41 and 0.18.
    pub grey_left: Option<[f32; 2]>,
    /// The same of the middle one. Default: 0.34 and 0.12.
    pub grey_middle: Option<[f32; 2]>,
    /// The same of the right one. Default: 0.42 and 0.18.
    pub grey_right: Option<[f32; 2]>,
    /// Maximum distance of the centres of two robots that hear each other, mm. Default: 700.
    pub signal_range: Option<f32>,
    /// Probability that a robot's message of a cycle is lost on the way to another one. Default: 0.85.
    pub signal_loss: Option<f32>,
    /// Cycles whose messages count for the attraction, this one's included. Default: 11.
    pub signal_cycles: Option<u32>,
    /// Factor of the attraction. Default: 1.
    pub attraction: Option<f32>,
    /// Height of a body, mm, by which it hides lamps from others. Default: 76.
    pub body_height: Option<f32>,
}

/// Distance from the body's centre to the end of the rays of proximity, mm: that of `sensor/reference.wgsl`.
pub(crate) const RAY_END: f32 = 86.0;

/// A reference model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Model {
    /// Eight readings each of proximity and light, three of the floor, the neighbours, and four of the attraction.
    #[default]
    Rm11,
    /// Four readings each of proximity, light and attraction, one of the floor, and the neighbours.
    Rm12,
    /// RM1.1 as `AutoMoDe`'s modules use it: proximity, light and attraction as vectors, the floor, and the number of neighbours.
    Vectors,
}

impl Model {
    /// Whether a reading of this name is from 0 to 1.
    pub fn is_within_one(self, reading: &str) -> bool {
        match self {
            Self::Rm11 => true,
            Self::Rm12 => !reading.starts_with("attraction"),
            Self::Vectors => reading == "ground",
        }
    }

    /// Names of its readings.
    pub fn readings(self) -> Vec<String> {
        let ring = |of: &str| (0..8).map(|index| format!("{of}_{index}")).collect::<Vec<_>>();
        let quarters = |of: &str| [45, 135, 225, 315].map(|degrees| format!("{of}_{degrees}")).to_vec();
        let named = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>();
        match self {
            Self::Rm11 => [
                ring("prox"),
                ring("light"),
                named(&["ground_left", "ground_middle", "ground_right", "neighbours"]),
                quarters("attraction"),
            ]
            .concat(),
            Self::Rm12 => [
                quarters("prox"),
                quarters("light"),
                named(&["ground", "neighbours"]),
                quarters("attraction"),
            ]
            .concat(),
            Self::Vectors => named(&[
                "prox_ahead",
                "prox_left",
                "light_ahead",
                "light_left",
                "ground",
                "neighbours",
                "attraction_ahead",
                "attraction_left",
            ]),
        }
    }

    /// The part that has its readings.
    #[cfg(feature = "compose")]
    pub(crate) fn part(self) -> &'static str {
        match self {
            Self::Rm11 => "sensor/rm11.wgsl",
            Self::Rm12 => "sensor/rm12.wgsl",
            Self::Vectors => "sensor/vectors.wgsl",
        }
    }

    /// The readings as expressions of the kernel's struct `Given`, here `given`, in the order of their names.
    #[cfg(feature = "compose")]
    pub(crate) fn expressions(self) -> Vec<String> {
        let vectors: &[(&str, usize)] = match self {
            Self::Rm11 => &[
                ("prox_first", 4),
                ("prox_last", 4),
                ("light_first", 4),
                ("light_last", 4),
                ("ground", 3),
                ("neighbours", 1),
                ("attraction", 4),
            ],
            Self::Rm12 => &[
                ("prox", 4),
                ("light", 4),
                ("ground", 1),
                ("neighbours", 1),
                ("attraction", 4),
            ],
            Self::Vectors => &[
                ("prox", 2),
                ("light", 2),
                ("ground", 1),
                ("neighbours", 1),
                ("attraction", 2),
            ],
        };
        let each = vectors.iter().flat_map(|&(name, size)| {
            let parts = ["x", "y", "z", "w"].into_iter().take(size);
            parts.map(move |part| match size {
                1 => format!("given.{name}"),
                _ => format!("given.{name}.{part}"),
            })
        });
        each.collect()
    }
}

impl Reference {
    /// Defaults of `grey_left`, `grey_middle` and `grey_right`.
    pub const GREY: [[f32; 2]; 3] = [[0.41, 0.18], [0.34, 0.12], [0.42, 0.18]];

    /// All defaults.
    pub const DEFAULT: Self = Self {
        proximity_noise: None,
        light_noise: None,
        ground_noise: None,
        grey_left: None,
        grey_middle: None,
        grey_right: None,
        signal_range: None,
        signal_loss: None,
        signal_cycles: None,
        attraction: None,
        body_height: None,
    };

    /// The same without errors of readings. Messages are lost as before.
    #[must_use]
    pub fn without_noise(&self) -> Self {
        let exact = |given: Option<[f32; 2]>, [mean, _]: [f32; 2]| Some([given.map_or(mean, |[mean, _]| mean), 0.0]);
        let [left, middle, right] = Self::GREY;
        Self {
            proximity_noise: Some(0.0),
            light_noise: Some(0.0),
            ground_noise: Some(0.0),
            grey_left: exact(self.grey_left, left),
            grey_middle: exact(self.grey_middle, middle),
            grey_right: exact(self.grey_right, right),
            ..self.clone()
        }
    }

    /// Maximum distance of the centres of two robots that hear each other, mm.
    pub(crate) fn range(&self) -> f32 {
        self.signal_range.unwrap_or(700.0)
    }

    /// Mean and standard deviation of the three ground sensors' readings of a grey floor, from left to right.
    pub(crate) fn grey(&self) -> [[f32; 2]; 3] {
        let [left, middle, right] = Self::GREY;
        [
            self.grey_left.unwrap_or(left),
            self.grey_middle.unwrap_or(middle),
            self.grey_right.unwrap_or(right),
        ]
    }

    /// Factor of the attraction.
    pub(crate) fn factor(&self) -> f32 {
        self.attraction.unwrap_or(1.0)
    }

    /// Cycles whose messages count for the attraction.
    #[cfg(feature = "compose")]
    pub(crate) fn cycles(&self) -> u32 {
        self.signal_cycles.unwrap_or(11)
    }

    /// The first of its set values, by its key.
    pub(crate) fn given(&self) -> Option<&'static str> {
        let all = [
            ("robot.proximity_noise", self.proximity_noise.is_some()),
            ("robot.light_noise", self.light_noise.is_some()),
            ("robot.ground_noise", self.ground_noise.is_some()),
            ("robot.grey_left", self.grey_left.is_some()),
            ("robot.grey_middle", self.grey_middle.is_some()),
            ("robot.grey_right", self.grey_right.is_some()),
            ("robot.signal_range_mm", self.signal_range.is_some()),
            ("robot.signal_loss", self.signal_loss.is_some()),
            ("robot.signal_cycles", self.signal_cycles.is_some()),
            ("robot.attraction", self.attraction.is_some()),
            ("robot.body_height_mm", self.body_height.is_some()),
        ];
        all.into_iter().find(|(_, is_given)| *is_given).map(|(key, _)| key)
    }

    /// Number of its cells.
    #[cfg(feature = "compose")]
    pub(crate) const CELLS: usize = 4;

    /// Kernel data: the cells of `ReferenceCell` in `sensor/reference.wgsl`, and one for each lamp.
    pub(crate) fn cells(&self, arena: &Arena) -> impl Iterator<Item = [f32; 4]> + use<> {
        let range = self.range();
        let [left, middle, right] = self.grey();
        let cells = [
            [
                self.proximity_noise.unwrap_or(0.05),
                self.light_noise.unwrap_or(0.05),
                self.ground_noise.unwrap_or(0.05),
                range * range,
            ],
            // A message arrives where 16 random bits are not less than this.
            [
                65536.0 * self.signal_loss.unwrap_or(0.85),
                self.factor(),
                self.body_height.unwrap_or(76.0),
                arena.wall_height.unwrap_or(HIGHEST),
            ],
            [left[0], left[1], middle[0], middle[1]],
            [right[0], right[1], 0.0, 0.0],
        ];
        let lamp = |light: &Light| {
            let intensity = light.intensity.unwrap_or(1.0);
            [light.x, light.y, light.height.unwrap_or(0.0), 1.0 / intensity]
        };
        let lamps: Vec<_> = arena.lights.iter().map(lamp).collect();
        cells.into_iter().chain(lamps)
    }
}

/// The height of walls that hide every lamp, mm.
const HIGHEST: f32 = 1e5;

impl Choice for Model {
    const CHOICES: Choices<Self> = &[
        (
            "rm1.1",
            Self::Rm11,
            "eight readings each of proximity and light, three of the floor, the neighbours, and four of their attraction",
        ),
        (
            "rm1.2",
            Self::Rm12,
            "four readings each of proximity, light and attraction, one of the floor, and the neighbours",
        ),
        (
            "rm1.1-vectors",
            Self::Vectors,
            "rm1.1 as AutoMoDe's modules use it: vectors of proximity, light and attraction, the floor, and how many neighbours",
        ),
    ];
}

#[cfg(all(test, feature = "compose"))]
mod tests {
    use super::*;

    #[test]
    fn rays_end_where_the_kernel_ends_them() {
        let mut parts = oneiro_shader_parts::PARTS.iter();
        let (_, text) = parts.find(|(path, _)| *path == "sensor/reference.wgsl").unwrap();
        assert!(text.contains(&format!("const RAY_END: f32 = {RAY_END:?}f;")));
    }
}
