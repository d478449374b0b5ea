//! What runs on a robot's own computer: its controller acts, its simulator evolves the next one beside, and both are exchanged with
//! robots that it meets.
//!
//! | file | content |
//! |---|---|
//! | [`settings`] | the daemon's file |
//! | [`control`] | the control thread: a cycle every 100 ms |
//! | [`member`] | the robot as a member of its swarm: schedule, fitness, messages; without clock, files or sockets |
//! | [`evolution`] | the thread that evaluates its controllers in its simulator |
//! | [`epuck`] | the robot's readings as its behaviours have them |
//! | [`keeper`] | checkpoint and table of intervals |
//! | [`activity`] | what it does and what is in its way |
//! | [`air`] | what carries datagrams |
//! | [`log`] | a line of JSON for each event |
//! | [`notify`] | what systemd is told |

pub(crate) mod activity;
pub(crate) mod air;
#[cfg(unix)]
pub(crate) mod control;
pub(crate) mod epuck;
pub(crate) mod evolution;
pub(crate) mod keeper;
#[cfg(unix)]
pub(crate) mod log;
pub(crate) mod member;
#[cfg(unix)]
pub(crate) mod notify;
pub(crate) mod settings;
