//! Pictures as SVG text, and pages that play a swarm: each function takes data and returns a whole file.

mod archive;
mod arena;
mod bands;
#[cfg(test)]
pub(crate) mod browser;
mod curve;
mod factor;
mod foraging;
mod heat;
mod journeys;
mod mission;
mod network;
mod player;
mod plot;
mod svg;
mod swarm;
mod tables;
mod tournament;

pub(crate) use archive::archive;
pub(crate) use arena::{arena, life, stage};
pub(crate) use bands::{Band, Ground, Panel, Spread, bands, evenly, grid};
pub(crate) use curve::{Series, learning_curve};
pub(crate) use factor::{Column, Outcomes, Scale, factor, level_styles};
pub(crate) use foraging::{scenarios, swarm};
pub(crate) use heat::{HeatMap, Side, Square, heat_map};
pub(crate) use journeys::{Journey, journeys};
pub(crate) use mission::{MissionReplay, bytes_of_record, mission_page};
pub(crate) use network::network;
pub(crate) use player::{packed, turns};
pub(crate) use svg::escaped;
pub(crate) use swarm::{
    Act, BEHAVIOURS, Genes, Moment, Sight, SwarmReplay, Teller, live_page, live_script, moments, swarm_page,
};
pub(crate) use tables::sensor_table;
pub(crate) use tournament::tournament;

/// Why an object that isn't round needs a sample for each point of view: Figure 4 of the 1995 study.
pub(crate) const POINTS_OF_VIEW: &str = include_str!("points_of_view.svg");
/// How a simulator and its controllers evolve on a robot, numbered as in the caption of Figure 1 of the 2014 study.
pub(crate) const COEVOLUTION: &str = include_str!("coevolution.svg");
/// Layers of behaviours, of which higher ones override lower ones: Figure 3 of the 2014 study.
pub(crate) const SUBSUMPTION: &str = include_str!("subsumption.svg");
