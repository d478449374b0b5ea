//! The twin of a fleet: daemons as processes of this machine, each with an emulated e-puck behind the real driver and guard, in one
//! arena and on one virtual clock.
//!
//! The daemon's side ([`client`]) is in every program, so that one for a robot can live in the twin of another; the rest only with
//! the feature `twin`.

pub(crate) mod client;
#[cfg(feature = "twin")]
mod clocks;
#[cfg(feature = "twin")]
pub(crate) mod conductor;
#[cfg(feature = "twin")]
mod disk;
#[cfg(feature = "twin")]
mod epuck;
#[cfg(feature = "twin")]
pub(crate) mod faults;
#[cfg(feature = "twin")]
mod guard;
mod lockstep;
#[cfg(feature = "twin")]
mod record;
#[cfg(feature = "twin")]
pub(crate) mod replay;
#[cfg(all(test, feature = "twin"))]
mod tests;
mod wire;

/// Whether a twin writes a file or a folder of this name.
#[cfg(feature = "twin")]
pub(crate) fn is_own(name: &str) -> bool {
    name == crate::contents::README || record::CONTENTS.iter().any(|entry| entry.is_called(name))
}

/// The files of any twin's directory.
#[cfg(all(test, feature = "twin"))]
pub(crate) fn all_contents() -> Vec<crate::contents::Entry> {
    record::CONTENTS.clone()
}
