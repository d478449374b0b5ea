//! The robot and the world that a kernel is composed for, as its parts see them.

use super::EpisodeKind;
#[cfg(feature = "compose")]
use crate::genes::SENSOR_NAMES;

/// Handed to the parts by whoever composes a kernel: they know no world.
#[derive(Debug)]
pub(crate) struct Owner {
    /// Source of the robot's parts.
    pub(crate) make: Make,
    /// The fields of the kernel's `Readings` that have its readings.
    pub(crate) fields: Vec<String>,
    /// The kind of its episodes.
    pub(crate) episodes: EpisodeKind,
    /// What its kernel looks up in grids.
    #[cfg_attr(not(feature = "compose"), expect(dead_code, reason = "only kernels that ship"))]
    pub(crate) grids: Grids,
    /// Whether its floor has a picture.
    #[cfg_attr(not(feature = "compose"), expect(dead_code, reason = "only kernels that ship"))]
    pub(crate) has_picture: bool,
    /// Whether its world has noise that the shipped kernels don't have.
    pub(crate) is_varied: bool,
}

/// What a kernel looks up in grids; it looks at all of the rest.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Grids {
    /// Which objects are near a place.
    pub(crate) objects: bool,
    /// Which patches of the floor are at a place.
    pub(crate) patches: bool,
}

/// Source of a robot's parts.
#[derive(Debug)]
#[cfg_attr(not(feature = "compose"), expect(dead_code, reason = "only kernels that ship"))]
pub(crate) enum Make {
    /// Samples, in shipped kernels.
    Sampled,
    /// Numbers, from which WGSL was generated.
    Described(Described),
    /// A forager's parts.
    Forager {
        /// Whether a forager's behaviours control it.
        behaves: bool,
        /// Whether its task is to bring food.
        brings: bool,
        /// Whether its arena has more items than the shorter part has room for.
        has_many_items: bool,
    },
}

/// A parametric robot.
#[derive(Debug)]
#[cfg_attr(not(feature = "compose"), expect(dead_code, reason = "only kernels that ship"))]
pub(crate) struct Described {
    /// WGSL of its sensors and its drive, instead of shipped declarations of the same names.
    pub(crate) text: String,
    /// Number of sensors in its list.
    pub(crate) sensors: usize,
    /// Whether one of them was sampled.
    pub(crate) has_sampled_sensors: bool,
    /// Whether its motors were.
    pub(crate) has_sampled_motors: bool,
    /// Values of robots that share a world.
    pub(crate) together: Option<Together>,
}

/// Robots that share a world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Together {
    /// Number of robots.
    pub(crate) count: u32,
    /// Number of pucks.
    pub(crate) pucks: u32,
    /// Most squares of the arena by which bodies find those near them; 0: each looks at all.
    #[cfg_attr(not(feature = "compose"), expect(dead_code, reason = "only kernels that ship"))]
    pub(crate) squares: u32,
    /// Most rows of them.
    #[cfg_attr(not(feature = "compose"), expect(dead_code, reason = "only kernels that ship"))]
    pub(crate) rows: u32,
    /// How they hear each other, if they do.
    pub(crate) hearing: Option<Hearing>,
}

/// How robots hear each other: by a reference model.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(not(feature = "compose"), expect(dead_code, reason = "only kernels that ship"))]
pub(crate) struct Hearing {
    /// The model's name.
    pub(crate) model: &'static str,
    /// The path of its part.
    pub(crate) part: &'static str,
    /// Cycles whose messages count.
    pub(crate) cycles: u32,
}

impl Owner {
    /// Names of its readings.
    #[cfg(feature = "compose")]
    pub(crate) fn readings(&self) -> Vec<String> {
        match self.make {
            Make::Sampled => SENSOR_NAMES.map(str::to_owned).into(),
            Make::Described(_) | Make::Forager { .. } => self.fields.clone(),
        }
    }

    /// Values of robots that share a world.
    pub(crate) fn together(&self) -> Option<Together> {
        match &self.make {
            Make::Described(robot) => robot.together,
            Make::Sampled | Make::Forager { .. } => None,
        }
    }

    /// Number of robots in a world.
    pub(crate) fn robots(&self) -> u32 {
        self.together().map_or(1, |together| together.count)
    }
}
