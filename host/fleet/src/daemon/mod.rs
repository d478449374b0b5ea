//! The daemon on a robot's computer: a controller acts while a simulator evolves the next one. A member of a swarm exchanges
//! both with robots that it meets; a robot without a swarm ([`single`]) measures its simulator's proposals.
//!
//! | file | content |
//! |---|---|
//! | [`settings`] | the daemon's file |
//! | [`control`] | the control thread: a cycle every 100 ms |
//! | [`member`] | the robot as a member of its swarm: schedule, fitness, messages; without clock, files or sockets |
//! | [`evolution`] | the evaluation of its controllers in its simulator |
//! | [`epuck`] | the robot's readings as its behaviours have them |
//! | [`intervals`] | what is saved of a member, and the table of its intervals |
//! | [`single`] | a robot without a swarm |
//! | [`beside`] | a thread of low priority for what evolves |
//! | [`keeper`] | checkpoints, and the tables that follow from them |
//! | [`activity`] | what it does and what is in its way |
//! | [`air`] | what carries datagrams |
//! | [`log`] | a line of JSON for each event |
//! | [`notify`] | what systemd is told |

pub(crate) mod activity;
pub mod air;
mod beside;
#[cfg(unix)]
pub mod control;
pub(crate) mod epuck;
mod evolution;
pub(crate) mod intervals;
mod keeper;
#[cfg(unix)]
mod log;
mod member;
#[cfg(unix)]
pub(crate) mod notify;
pub mod settings;
#[cfg(all(unix, feature = "compose"))]
pub mod single;
