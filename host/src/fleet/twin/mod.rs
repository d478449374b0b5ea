//! The twin of a fleet: daemons as processes of this machine, each with an emulated e-puck behind the real driver and guard, in one
//! arena and on one virtual clock.

pub(crate) mod client;
mod clocks;
pub(crate) mod conductor;
mod disk;
mod epuck;
pub(crate) mod faults;
mod record;
pub(crate) mod replay;
#[cfg(test)]
mod tests;
mod wire;

/// The files of any twin's directory.
#[cfg(test)]
pub(crate) fn all_contents() -> Vec<crate::contents::Entry> {
    record::CONTENTS.clone()
}
