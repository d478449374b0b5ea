//! Tests that wait for robots in real time.

mod fleets;
mod guard;
mod khepera;
mod playground;
mod sample_wire;
mod transfer;
mod wire;
#[cfg(feature = "compose")]
mod wired;
