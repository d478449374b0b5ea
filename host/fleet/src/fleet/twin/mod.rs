//! The twin of a fleet: daemons as processes of this machine, each with an emulated e-puck behind the real driver and
//! guard, in one arena and on one virtual clock.
//!
//! The daemon's side ([`client`]) is in every program, so that a robot's program can run in the twin of another; the
//! rest only with the feature `twin`.

pub mod client;
#[cfg(feature = "twin")]
mod clocks;
#[cfg(feature = "twin")]
pub mod conductor;
#[cfg(feature = "twin")]
mod disk;
#[cfg(feature = "twin")]
mod epuck;
#[cfg(feature = "twin")]
pub mod faults;
#[cfg(feature = "twin")]
mod guard;
mod lockstep;
#[cfg(feature = "twin")]
mod record;
#[cfg(feature = "twin")]
pub mod replay;
#[cfg(all(test, feature = "twin"))]
mod tests;
mod wire;

/// Whether a twin writes a file or a folder of this name.
#[cfg(feature = "twin")]
pub fn is_own(name: &str) -> bool {
    name == oneiro_base::contents::README || record::CONTENTS.iter().any(|entry| entry.is_called(name))
}

/// The files of any twin's directory.
#[cfg(any(test, feature = "testing"))]
pub fn all_contents() -> Vec<oneiro_base::contents::Entry> {
    record::CONTENTS.clone()
}
