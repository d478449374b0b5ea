//! Tests that wait for robots in real time.

mod fleets;
mod guard;
mod khepera;
mod playground;
mod sample_wire;
mod transfer;
#[cfg(feature = "native")]
mod tutorial;
mod wire;
#[cfg(feature = "compose")]
mod wired;
