//! What parts know of the robot and the world that their kernel is composed for.

use super::Lives;
#[cfg(feature = "compose")]
use crate::genes::SENSOR_NAMES;

/// It is handed to them: parts know no world.
#[derive(Debug)]
pub(crate) struct Owner {
    /// What the robot is made of.
    pub(crate) make: Make,
    /// The fields of the kernel's `Readings` that have its readings.
    pub(crate) fields: Vec<String>,
    /// How it lives.
    pub(crate) lives: Lives,
    /// Whether its world has noise that the shipped kernels don't have.
    pub(crate) is_varied: bool,
}

/// What a robot is made of.
#[derive(Debug)]
#[cfg_attr(not(feature = "compose"), expect(dead_code, reason = "only kernels that ship"))]
pub(crate) enum Make {
    /// Samples: the shipped kernels have it.
    Sampled,
    /// What is generated for its description.
    Described(Described),
    /// A forager's parts.
    Forager {
        /// Whether a forager's behaviours control it.
        behaves: bool,
        /// Whether its task is to bring food.
        brings: bool,
    },
}

/// A robot that is described.
#[derive(Debug)]
#[cfg_attr(not(feature = "compose"), expect(dead_code, reason = "only kernels that ship"))]
pub(crate) struct Described {
    /// WGSL of its sensors and its drive, in place of shipped declarations of the same names.
    pub(crate) text: String,
    /// Number of sensors in its list.
    pub(crate) sensors: usize,
    /// Whether one of them was sampled.
    pub(crate) has_sampled_sensors: bool,
    /// Whether its motors were.
    pub(crate) has_sampled_motors: bool,
    /// What it has if several live together.
    pub(crate) together: Option<Together>,
}

/// What robots have that live together.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Together {
    /// Number of robots.
    pub(crate) count: u32,
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

    /// What several robots have that live together.
    pub(crate) fn together(&self) -> Option<Together> {
        match &self.make {
            Make::Described(own) => own.together,
            Make::Sampled | Make::Forager { .. } => None,
        }
    }

    /// Number of robots in a world.
    pub(crate) fn robots(&self) -> u32 {
        self.together().map_or(1, |together| together.count)
    }
}
