//! What runs on a robot's own computer: its controller acts, its simulator evolves the next one beside, and both are exchanged with
//! robots that it meets.
//!
//! | file | content |
//! |---|---|
//! | [`settings`] | the daemon's file |
//! | [`member`] | the robot as a member of its swarm: schedule, fitness, messages; without clock, files or sockets |
//! | [`evolution`] | the thread that evaluates its controllers in its simulator |
//! | [`air`] | what carries datagrams |

pub(crate) mod air;
pub(crate) mod evolution;
pub(crate) mod member;
pub(crate) mod settings;
