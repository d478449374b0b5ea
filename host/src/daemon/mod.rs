//! What runs on a robot's own computer: its controller acts, its simulator evolves the next one beside, and both are exchanged with
//! robots that it meets.

pub(crate) mod air;
pub(crate) mod epuck;
