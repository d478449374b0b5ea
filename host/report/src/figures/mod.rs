//! Pictures as SVG text, and pages that play a swarm: each function takes data and returns a whole file.

mod arena;
mod bands;
#[cfg(any(test, feature = "testing"))]
#[cfg_attr(not(test), allow(clippy::disallowed_methods, reason = "for tests"))]
pub mod browser;
#[cfg(test)]
mod colours;
mod curve;
mod elites;
mod episode;
mod factor;
mod foraging;
mod frames;
mod heat;
mod journeys;
mod khepera;
mod network;
mod player;
pub mod plot;
pub mod svg;
mod swarm;
mod tables;
mod tournament;

pub use crate::numbers::Spread;
pub use arena::{Path, arena, life, paths};
pub use bands::{Band, Ground, Panel, bands, evenly, grid, panel};
pub use curve::{Series, learning_curve};
pub use elites::{Axis, ElitesReplay, ShownElite, elites_page};
pub use episode::{Compared, EpisodeReplay, bytes_of_record, episode_page};
pub use factor::{Column, Outcomes, Scale, factor, level_styles};
pub use foraging::{ForagersFrames, foragers, scenarios};
pub use frames::{Film, Frames};
pub use heat::{HeatMap, Side, Square, heat_map};
pub use journeys::{Journey, journeys};
pub use khepera::{Eye, khepera};
pub use network::network;
pub use player::{packed, turns};
pub use svg::escaped;
pub use swarm::{
    Act, BEHAVIOURS, ForagersReplay, Genes, Moment, Sight, Teller, foragers_page, foragers_script, live_page,
    live_script, moments,
};
pub use tables::{HEAT, sensor_table};
pub use tournament::tournament;

/// Why an object that isn't round needs a sample for each point of view: Figure 4 of the 1995 study.
pub const POINTS_OF_VIEW: &str = include_str!("points_of_view.svg");
/// How a simulator and its controllers evolve on a robot, numbered as in the caption of Figure 1 of the 2014 study.
pub const COEVOLUTION: &str = include_str!("coevolution.svg");
/// Layers of behaviours, of which higher ones override lower ones: Figure 3 of the 2014 study.
pub const SUBSUMPTION: &str = include_str!("subsumption.svg");
