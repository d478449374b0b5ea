//! Variants of kernels for one world each, and when they are made.

#[cfg(all(
    feature = "compose",
    any(feature = "gpu", feature = "native"),
    not(target_family = "wasm")
))]
mod compiled;

use std::str::FromStr;

#[cfg(all(
    feature = "compose",
    any(feature = "gpu", feature = "native"),
    not(target_family = "wasm")
))]
pub(super) use compiled::*;

/// When kernels of GPUs, and those that processors run by code compiled at run time, are specialised: compiled again for one world,
/// whose values are constants of the code then. Results don't depend on it, and it needs the feature `compose`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Specialise {
    /// For worlds that have kept a GPU busy by the generic kernel for as long as compiling takes, or processors for 8 times as long; in
    /// the background.
    #[default]
    Auto,
    /// For every world, before its first cycle.
    Always,
    /// Not at all.
    Never,
}

impl FromStr for Specialise {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            "always" => Ok(Self::Always),
            "never" => Ok(Self::Never),
            _ => Err("allowed: auto, always, never".into()),
        }
    }
}
