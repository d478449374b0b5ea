//! Pictures, as SVG text, and a page that plays a swarm: each function takes data and returns a whole file.

mod arena;
mod bands;
mod curve;
mod diagram;
mod factor;
mod foraging;
mod heat;
mod journeys;
mod network;
mod plot;
mod svg;
mod swarm;
mod tables;
mod views;

pub(crate) use arena::{arena, life};
pub(crate) use bands::{Band, Ground, Panel, Spread, bands, evenly, grid};
pub(crate) use curve::{Series, learning_curve};
pub(crate) use diagram::{coevolution, subsumption};
pub(crate) use factor::{Column, Outcomes, Scale, factor, level_styles};
pub(crate) use foraging::{scenarios, swarm};
pub(crate) use heat::{HeatMap, Side, Square, heat_map};
pub(crate) use journeys::{Journey, journeys};
pub(crate) use network::network;
pub(crate) use svg::escaped;
pub(crate) use swarm::{Genes, SwarmReplay, swarm_page};
pub(crate) use tables::sensor_table;
pub(crate) use views::points_of_view;
