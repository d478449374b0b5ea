//! The robots of O'Dowd, Studley and Winfield (2014): one in its on-board simulator, and swarms.

pub(crate) mod foraging;
pub mod swarm;
