//! Pictures, as SVG text, and a page that plays a swarm: each function takes data and returns a whole file.

mod arena;
mod bands;
mod curve;
mod journeys;
mod network;
mod plot;
mod svg;
#[cfg_attr(not(test), expect(dead_code, reason = "no command replays a swarm yet"))]
mod swarm;
mod tables;
mod views;

pub(crate) use arena::{arena, life};
pub(crate) use bands::{Band, Panel, Spread, bands};
pub(crate) use curve::{Series, learning_curve};
pub(crate) use journeys::{Journey, journeys};
pub(crate) use network::network;
pub(crate) use svg::escaped;
#[expect(unused_imports, reason = "no command replays a swarm yet")]
pub(crate) use swarm::{Genes, SwarmReplay, swarm_page};
pub(crate) use tables::sensor_table;
pub(crate) use views::points_of_view;
