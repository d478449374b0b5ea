//! Tasks without code: each is a part in ordinary WGSL, in a file of its own, as a user could have written it.

use std::collections::BTreeMap;

use crate::parameter::Invalid;
use crate::parts::compose::{Kind, Part};
use crate::world::arena::Arena;
use crate::world::pucks::Pucks;
use crate::world::spec::Task;

/// A task that an experiment only has to name.
#[derive(Debug)]
pub struct Ready {
    /// Its value.
    pub task: Task,
    /// Its word in an experiment, and the name of its file.
    pub word: &'static str,
    /// Its part.
    pub text: &'static str,
    /// What a world needs for it.
    needs: Needs,
}

/// What a world needs for a task.
#[derive(Clone, Copy, Debug)]
enum Needs {
    Nothing,
    Patches(usize),
    Line,
    Lights,
    Objects,
    Pucks,
    /// Pucks, a patch of the floor, and grippers.
    Nest,
}

/// A row of [`READY`]; its file has the name of its word.
macro_rules! ready {
    ($task:ident, $word:literal, $needs:expr) => {
        Ready {
            task: Task::$task,
            word: $word,
            text: include_str!(concat!("tasks/", $word, ".wgsl")),
            needs: $needs,
        }
    };
}

/// Their values that are the number of a patch.
const PATCHES: [&str; 2] = ["goal", "nest"];

/// All of them.
#[rustfmt::skip]
pub const READY: &[Ready] = &[
    ready!(Reach, "reach", Needs::Patches(1)),
    ready!(Visit, "visit", Needs::Patches(1)),
    ready!(Collect, "collect", Needs::Patches(2)),
    ready!(Cover, "cover", Needs::Nothing),
    ready!(FollowLine, "follow-line", Needs::Line),
    ready!(FollowWall, "follow-wall", Needs::Objects),
    ready!(StayTogether, "stay-together", Needs::Nothing),
    ready!(Phototaxis, "phototaxis", Needs::Lights),
    ready!(GatherPucks, "gather-pucks", Needs::Pucks),
    ready!(BringPucks, "bring-pucks", Needs::Nest),
];

impl Task {
    /// Its row, if it is one of these.
    pub fn ready(&self) -> Option<&'static Ready> {
        READY.iter().find(|ready| ready.task == *self)
    }

    /// Whether it is a part: a user's, or one of these.
    pub fn is_part(&self) -> bool {
        *self == Self::Own || self.ready().is_some()
    }
}

impl Ready {
    /// The one with a word.
    pub fn named(word: &str) -> Option<&'static Self> {
        READY.iter().find(|ready| ready.word == word)
    }

    /// Its part, whose file is called after it.
    ///
    /// # Errors
    /// This program can't compose kernels.
    pub fn part(&self) -> Result<Part, Invalid> {
        let part = Part::new(Kind::Task, &format!("{}.wgsl", self.word), self.text);
        part.map_err(|refused| Invalid::new("task.kind", refused.to_string()))
    }

    /// Whether only swarms have it.
    pub fn is_for_swarms(&self) -> bool {
        self.task == Task::StayTogether || self.has_pucks()
    }

    /// Whether it is about pucks.
    pub fn has_pucks(&self) -> bool {
        matches!(self.needs, Needs::Pucks | Needs::Nest)
    }

    /// Checks that a world has what it needs, and the patches that values number.
    pub(crate) fn check(&self, arena: &Arena, pucks: &Pucks, values: &BTreeMap<String, f64>) -> Result<(), Invalid> {
        let objects = arena.walls.len() + arena.obstacles.len() + arena.blocks.len();
        let (has, allowed) = match self.needs {
            Needs::Nothing => return Ok(()),
            Needs::Patches(least) => {
                let allowed = match least {
                    1 => "a patch of the floor (arena.patches)".to_owned(),
                    _ => format!("at least {least} patches of the floor (arena.patches)"),
                };
                (arena.patches.len() >= least, allowed)
            }
            Needs::Line => {
                let allowed = "a patch of the floor (arena.patches) or a picture on it (arena.picture)".to_owned();
                (!arena.patches.is_empty() || arena.picture.is_some(), allowed)
            }
            Needs::Lights => (!arena.lights.is_empty(), "a light (arena.lights)".to_owned()),
            Needs::Objects => (objects > 0, "walls, obstacles or blocks".to_owned()),
            Needs::Pucks => (pucks.count.is_some(), "pucks (pucks.count)".to_owned()),
            Needs::Nest => {
                let grips = pucks.grip.is_some_and(|grip| grip > 0.0);
                let allowed = "a patch of the floor (arena.patches), and pucks that can be taken (pucks.grip_mm)";
                (grips && !arena.patches.is_empty(), allowed.to_owned())
            }
        };
        if !has {
            let problem = format!("is `{}`; allowed: only in an arena with {allowed}", self.word);
            return Err(Invalid::new("task.kind", problem));
        }
        for (name, number) in values.iter().filter(|(name, _)| PATCHES.contains(&name.as_str())) {
            if number.fract() != 0.0 || *number >= arena.patches.len() as f64 {
                let last = arena.patches.len() - 1;
                let problem = format!("is {number}; allowed: the number of a patch, whole numbers from 0 to {last}");
                return Err(Invalid::new(format!("task.values.{name}"), problem));
            }
        }
        Ok(())
    }
}
