//! The WGSL of readings, to which each sensor adds.

use super::Sensor;

/// Text of the function that reads all sensors.
#[derive(Default)]
pub(crate) struct Text {
    /// Before all else.
    pub(crate) numbers: String,
    /// For each object that is near enough.
    pub(crate) objects: String,
    /// For each object whose nearest point is near enough to press a bumper.
    pub(crate) bumpers: String,
    /// Indices of sensors with a ray from the body's centre.
    pub(crate) rays: Vec<usize>,
    /// For each other robot that is near enough.
    pub(crate) others: String,
    /// For each other robot that is near enough to press a bumper.
    pub(crate) pressing: String,
    /// For each puck that is near enough, whose names are those of other robots.
    pub(crate) pucks: String,
    /// The widest range of a bumper.
    pub(crate) widest: String,
}

/// A sensor whose reading is written.
pub(crate) struct Each<'a> {
    pub(crate) sensor: &'a Sensor,
    pub(crate) index: usize,
    /// The first of its two cells.
    pub(crate) cell: usize,
    /// The first cell of its response and the number of its points.
    pub(crate) response: Option<[usize; 2]>,
    /// The column of the tables that it reads.
    pub(crate) column: usize,
    /// Whether the robot is an individual that differs from its description.
    pub(crate) is_individual: bool,
}

impl Each<'_> {
    /// Arguments of functions: its cell and where it looks.
    pub(super) fn arguments(&self) -> String {
        let index = self.index;
        format!("s{index}, looks{index}")
    }

    /// The direction from the body's centre to where it is.
    pub(super) fn outward(&self) -> String {
        let bearing = match self.sensor.bearing {
            Some(_) => format!("pose.z + numbers(world, {}u).x", self.cell + 1),
            None => format!("looks{}", self.index),
        };
        format!("cosine_sine({bearing})")
    }

    /// Where it is.
    pub(super) fn place(&self) -> String {
        format!("at + s{}.offset * {}", self.index, self.outward())
    }

    /// How strong an individual's is.
    pub(super) fn strength(&self) -> String {
        format!("numbers(world, {}u).y", self.cell + 1)
    }
}
