//! Stands in for users' parts in builds without the feature `compose`.

use oneiro_shaders::Kernel;

use super::{Composed, EpisodeKind, Kind, OwnParts, Owner, Refused, Scalar, Value};
use crate::parameter::Invalid;

/// The text of a controller, which this program can't compose.
pub(super) const STATE_MACHINE: [(&str, &str); 0] = [];
pub(super) const BEHAVIOUR_TREE: [(&str, &str); 0] = [];

/// A user's part. This program has none.
#[derive(Clone, Debug, PartialEq)]
pub enum Part {}

impl Part {
    /// Refuses every part.
    ///
    /// # Errors
    /// Always.
    pub fn new(_: Kind, path: &str, _: &str) -> Result<Self, Refused> {
        Err(Refused(vec![format!(
            "{path}: this program can't compose kernels; allowed: what ships with it"
        )]))
    }

    pub(super) fn of_oneiro(path: &str, text: &str) -> Result<Self, Refused> {
        Self::new(Kind::Controller, path, text)
    }

    /// Its kind.
    pub fn kind(&self) -> Kind {
        match *self {}
    }

    /// The path of its file.
    pub fn path(&self) -> &str {
        match *self {}
    }

    /// The values that it declares.
    pub fn values(&self) -> &[Value] {
        match *self {}
    }

    /// Names of the readings of sensors; none of other kinds.
    pub fn readings(&self) -> &[String] {
        match *self {}
    }

    /// The functions that the kernel calls and that it has.
    pub fn functions(&self) -> &[&'static str] {
        match *self {}
    }

    /// The function by which it may end a single robot's episode, if it has that.
    pub fn end_function(&self) -> Option<&'static str> {
        match *self {}
    }

    /// Whether it has a mission, for swarms.
    pub fn has_mission(&self) -> bool {
        match *self {}
    }

    /// Scalars of its mission's memory, and their types.
    pub fn mission(&self) -> &[(String, Scalar)] {
        match *self {}
    }

    /// Its memory's scalars, and their types.
    pub fn memory(&self) -> &[(String, Scalar)] {
        match *self {}
    }
}

/// A rule that a part may break. This program has no parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {}

impl Rule {
    /// All rules.
    pub const ALL: &[Self] = &[];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {}
    }

    /// What it says, in one line.
    pub fn about(self) -> &'static str {
        match self {}
    }

    /// Why it exists.
    pub fn why(self) -> &'static str {
        match self {}
    }

    /// WGSL that breaks it, and the same as it should be.
    pub fn examples(self) -> Option<[&'static str; 2]> {
        match self {}
    }
}

/// The problem with a kernel whose loops turn too often.
pub(crate) fn too_many_turns(problem: &str) -> String {
    problem.to_owned()
}

pub(super) fn driven() -> Result<&'static Kernel, Invalid> {
    Err(Invalid::new(
        "robots",
        "are driven from outside of a kernel, but this program can't compose the kernel for that",
    ))
}

pub(super) fn compose(kernel: &'static Kernel, _: &OwnParts, owner: &Owner) -> Result<Composed, Invalid> {
    if owner.episodes == EpisodeKind::Reported {
        return Err(Invalid::new(
            "robot",
            "is outside the kernels, but this program can't compose the kernel for that",
        ));
    }
    if owner.is_varied {
        return Err(Invalid::new(
            "noise",
            "has gain, veer, delay or draws of an episode, but this program can't compose the kernel for that",
        ));
    }
    Ok(Composed {
        kernel,
        genes: None,
        files: &[],
        words: None,
    })
}
