//! Kernels composed at run time: a shipped kernel with a user's sensors, controller or task.
//! Nothing is rebuilt, and results are the same bits on every device, like those of the kernels that ship.
//!
//! Each is one WGSL part, see `docs/extend.md`:
//!
//! ```
//! use std::sync::Arc;
//! use oneiro::compose::{Kind, OwnPart, OwnParts, Part};
//! use oneiro::world::{Task, World, WorldSpec};
//!
//! let part = Part::new(Kind::Task, "turn.wgsl", "
//!     struct TaskValues {
//!         most: f32, // 0.1, 0 to 0.5 turns: maximum turn that counts in a cycle
//!     }
//!     fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
//!         return Reward(min(abs(now.moved.turn), task_values(episode).most), before);
//!     }")?;
//! let task = OwnPart::new(Arc::new(part), &[("most", 0.2)])?;
//! let world = World::new(WorldSpec {
//!     task: Task::Own,
//!     own: OwnParts::from([task]),
//!     ..WorldSpec::miglino1995()
//! })?;
//! assert_eq!(world.genes(), 18);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod owner;
#[cfg_attr(not(feature = "compose"), path = "compose/absent.rs")]
mod part;

use std::collections::BTreeMap;
use std::sync::Arc;

use oneiro_shaders::Kernel;

use crate::genes::{Gene, SENSORS};
use crate::parameter::{Allowed, Datum, Invalid};
use crate::parts::automode::Modules;
use crate::parts::network::Network;

#[cfg(feature = "compose")]
pub(crate) use owner::{Described, Hearing, Together};
pub(crate) use owner::{Grids, Make, Owner};
pub(crate) use part::too_many_turns;
#[cfg(feature = "compose")]
pub(crate) use part::{Exported, HEAD, TAIL, is_of_user, parts_of};
pub use part::{Part, Rule};

/// Stands for the path of a network, which is not in a file.
const NETWORK: &str = "network";
/// The same of controllers of `AutoMoDe`'s modules.
const STATE_MACHINE: &str = "state-machine";
const BEHAVIOUR_TREE: &str = "behaviour-tree";
/// The same of commands from outside.
const COMMANDED: &str = "commands";

/// Most genes of a network or of a user's controller, and of all genomes of a team.
pub const GREATEST_GENES: u32 = 65_536;

/// Most robots of a world whose poses are in the first robot's trace.
const POSES: u32 = 128;

/// A kind of part that a user may write.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Sensors besides the robot's eight sensors of proximity.
    Sensor,
    /// Mapping from readings to commands of the wheels.
    Controller,
    /// Rewards, and the end of an episode.
    Task,
}

impl Kind {
    /// The word that its functions' names and its keys in an experiment begin with.
    pub fn word(self) -> &'static str {
        match self {
            Self::Sensor => "sensor",
            Self::Controller => "controller",
            Self::Task => "task",
        }
    }
}

/// Reasons why a part is refused: one line for each problem, with file, line, column, what to write instead, and the name of
/// the [`Rule`] that it breaks.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", .0.join("\n"))]
pub struct Refused(Vec<String>);

/// A value that a part declares: a field of its struct `TaskValues` (or `ControllerValues`, `SensorValues`), with the comment
/// `DEFAULT, LEAST to GREATEST UNIT: MEANING`.
#[derive(Clone, Debug, PartialEq)]
pub struct Value {
    /// Its name.
    pub name: String,
    /// Its default.
    pub default: f32,
    /// The allowed values.
    pub allowed: Allowed,
    /// Its unit; empty for counts and shares.
    pub unit: String,
    /// Its meaning.
    pub about: String,
}

/// A type of numbers that parts remember.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scalar {
    /// `f32`
    Float,
    /// `u32`
    Unsigned,
    /// `i32`
    Signed,
}

impl Scalar {
    /// Its name in WGSL.
    pub fn wgsl(self) -> &'static str {
        match self {
            Self::Float => "f32",
            Self::Unsigned => "u32",
            Self::Signed => "i32",
        }
    }
}

/// The function with which a task's part scores each robot by itself.
const OF_EACH: &str = "task_cycle";

/// Kind of a trace detail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DetailKind {
    /// A reading that the controller got.
    Perceived,
    /// A reading before sensor noise.
    Real,
    /// What a part remembered after the cycle.
    Memory(Kind),
    /// The pose at the start of the cycle of another robot of the world: x and y in mm, and z, the heading in turns.
    Other,
    /// The place at the start of the cycle of a puck of the world: x and y in mm.
    Puck,
    /// Robots whose messages it has heard since the record before, a bit for each, 32 in a word. Of observed worlds.
    Heard,
    /// Its task's rewards since the record before, if the task's part scores each robot. Of observed worlds.
    Earned,
}

/// A trace detail, see [`Trace::details`](crate::batch::Trace::details).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Detail {
    /// Its name: the sensor's number or name, or the field of a part's memory.
    pub name: String,
    /// What it is.
    pub kind: DetailKind,
    /// Type of its word.
    pub scalar: Scalar,
    /// Its value in a cycle, in WGSL.
    pub(crate) expression: String,
}

/// A part with its values.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnPart {
    part: Arc<Part>,
    values: Vec<f32>,
}

impl OwnPart {
    /// Sets values by name; the others have their defaults.
    ///
    /// # Errors
    /// A value that the part doesn't declare, or that isn't allowed.
    pub fn new(part: Arc<Part>, given: &[(&str, f64)]) -> Result<Self, Invalid> {
        let key = |name: &str| format!("{}.values.{name}", part.kind().word());
        for (name, _) in given {
            if !part.values().iter().any(|value| value.name == *name) {
                let names: Vec<_> = part.values().iter().map(|value| value.name.as_str()).collect();
                let allowed = if names.is_empty() {
                    "none".to_owned()
                } else {
                    names.join(", ")
                };
                let problem = format!("isn't a value of {}; allowed: {allowed}", part.path());
                return Err(Invalid::new(key(name), problem));
            }
        }
        let checked = |value: &Value| {
            let given = given.iter().find(|(name, _)| *name == value.name);
            let number = given.map_or(value.default, |(_, number)| *number as f32);
            let checked = value.allowed.check(&Datum::Single(number), |_| None);
            checked.map_err(|problem| Invalid::new(key(&value.name), problem))?;
            // Zero has one sign.
            Ok(if number == 0.0 { 0.0 } else { number })
        };
        let values = part.values().iter().map(checked).collect::<Result<_, Invalid>>()?;
        Ok(Self { part, values })
    }

    /// The part.
    pub fn part(&self) -> &Part {
        &self.part
    }

    /// Each value by its name.
    pub fn named_values(&self) -> BTreeMap<String, f64> {
        let names = self.part.values().iter().map(|value| value.name.clone());
        names.zip(self.values.iter().map(|value| shortest(*value))).collect()
    }

    /// The key in an experiment that it comes from.
    pub(crate) fn key(&self) -> String {
        match self.part.path() {
            NETWORK => "controller.layers".to_owned(),
            STATE_MACHINE | BEHAVIOUR_TREE => "controller.kind".to_owned(),
            _ => format!("{}.part", self.part.kind().word()),
        }
    }

    /// The values as cells of four words.
    fn cells(&self) -> impl Iterator<Item = [u32; 4]> {
        let cell = |values: &[f32]| std::array::from_fn(|at| values.get(at).map_or(0, |value| value.to_bits()));
        self.values.chunks(4).map(cell)
    }
}

/// The parts of a world that a user wrote, at most one of each kind.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OwnParts(BTreeMap<Kind, Arc<OwnPart>>);

impl<const N: usize> From<[OwnPart; N]> for OwnParts {
    /// Of several parts of one kind, takes the last.
    fn from(parts: [OwnPart; N]) -> Self {
        let mut all = Self::default();
        for part in parts {
            all.insert(Arc::new(part));
        }
        all
    }
}

impl OwnParts {
    /// Adds a part, instead of the one of its kind.
    pub fn insert(&mut self, part: Arc<OwnPart>) {
        self.0.insert(part.part.kind(), part);
    }

    /// The part of a kind.
    pub fn get(&self, kind: Kind) -> Option<&OwnPart> {
        self.0.get(&kind).map(|part| &**part)
    }

    /// Whether everything is shipped.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// All parts, in the order of their kinds.
    pub fn iter(&self) -> impl Iterator<Item = &OwnPart> {
        self.0.values().map(|part| &**part)
    }

    /// Names of the readings of a user's sensors.
    pub(crate) fn readings(&self) -> Arc<[String]> {
        self.get(Kind::Sensor)
            .map_or_else(Arc::default, |part| part.part.readings().into())
    }

    /// Names of all readings of a robot with these parts: its own, then those of a user's sensors.
    pub(crate) fn readings_of(&self, robot: &[String]) -> Vec<String> {
        [robot, &self.readings()].concat()
    }

    /// The fields of the kernel's `Readings`, in order: the robot's, and those of a user's sensors.
    fn readings_in(&self, robot: &[String]) -> Vec<String> {
        let readings = self.readings();
        let readings = readings.iter().map(|name| format!("own.{name}"));
        robot.iter().cloned().chain(readings).collect()
    }

    /// Details in the trace of a robot with these parts.
    pub(crate) fn details(&self, owner: &Owner) -> Vec<Detail> {
        let fields = &owner.fields;
        let name = |index: usize| match owner.make {
            Make::Sampled => index.to_string(),
            Make::Described(_) | Make::Forager { .. } => fields[index].clone(),
        };
        let mut details = Vec::new();
        let kinds = [(DetailKind::Perceived, "perceived"), (DetailKind::Real, "real")];
        for (kind, of) in kinds.into_iter().take(if self.are_commanded() { 1 } else { 2 }) {
            details.extend(fields.iter().enumerate().map(|(index, place)| Detail {
                name: name(index),
                kind,
                scalar: Scalar::Float,
                expression: format!("{of}.{place}"),
            }));
        }
        details.extend(self.readings().iter().map(|name| Detail {
            name: name.clone(),
            kind: DetailKind::Perceived,
            scalar: Scalar::Float,
            expression: format!("perceived.own.{name}"),
        }));
        if self.are_commanded() {
            return details;
        }
        for part in self.iter() {
            let kind = part.part.kind();
            if owner.together().is_some() {
                details.extend(part.part.mission().iter().map(|(name, scalar)| Detail {
                    name: name.clone(),
                    kind: DetailKind::Memory(kind),
                    scalar: *scalar,
                    expression: format!("after.mission.{name}"),
                }));
            }
            details.extend(part.part.memory().iter().map(|(name, scalar)| Detail {
                name: name.clone(),
                kind: DetailKind::Memory(kind),
                scalar: *scalar,
                expression: format!("after.{}.{name}", kind.word()),
            }));
        }
        details.extend(self.details_of_others(owner));
        details
    }

    /// Whether robots are commanded from outside, cycle by cycle: see [`crate::stepped`].
    pub(crate) fn are_commanded(&self) -> bool {
        let controller = self.get(Kind::Controller);
        controller.is_some_and(|own| own.part.path() == COMMANDED)
    }

    /// These parts, and commands from outside as the controller.
    ///
    /// # Errors
    /// Without the feature `compose`, always.
    pub(crate) fn with_commands(&self) -> Result<Self, Invalid> {
        let text = include_str!("compose/commands.wgsl");
        self.with_controller(COMMANDED, text, |part| OwnPart::new(part, &[]))
    }

    /// Details that have to do with the other robots of a world.
    fn details_of_others(&self, owner: &Owner) -> Vec<Detail> {
        let count = owner.robots();
        let pucks = owner.together().map_or(0, |together| together.pucks);
        let place = |puck| {
            ["x", "y"].map(|part| Detail {
                name: format!("puck_{puck}.{part}"),
                kind: DetailKind::Puck,
                scalar: Scalar::Float,
                expression: format!("member_started(after.episode, {}u).{part}", count + puck),
            })
        };
        let pucks = (0..pucks).flat_map(place);
        if owner.episodes != EpisodeKind::Observed {
            // The first robot's pose is in the record.
            let pose = |robot| {
                ["x", "y", "z"].map(|part| Detail {
                    name: format!("robot_{robot}.{part}"),
                    kind: DetailKind::Other,
                    scalar: Scalar::Float,
                    expression: format!("member_started(after.episode, {robot}u).{part}"),
                })
            };
            return (1..count.min(POSES)).flat_map(pose).chain(pucks).collect();
        }
        let heard = |word| Detail {
            name: format!("heard_{word}"),
            kind: DetailKind::Heard,
            scalar: Scalar::Unsigned,
            expression: format!("word(after.episode.member_words, MEMBER_SENDERS + {word}u)"),
        };
        let earned = Detail {
            name: "earned".to_owned(),
            kind: DetailKind::Earned,
            scalar: Scalar::Float,
            expression: "number(after.episode.member_words, MEMBER_EARNED)".to_owned(),
        };
        let hears = owner.together().is_some_and(|together| together.hearing.is_some());
        let words = if hears { count.div_ceil(u32::BITS) } else { 0 };
        let heard = (0..words).map(heard);
        heard.chain(self.scores_each().then_some(earned)).chain(pucks).collect()
    }

    /// Whether the task scores each robot of a world by itself: a mission alone scores all of them together.
    pub fn scores_each(&self) -> bool {
        let task = self.get(Kind::Task);
        task.is_none_or(|part| part.part.functions().contains(&OF_EACH))
    }

    /// These parts, and a network as the controller of a robot whose readings are in these fields.
    pub(crate) fn with_network(&self, network: &Network, robot: &[String]) -> Result<Self, Invalid> {
        let values = network.values().into_iter().map(|(_, value)| value).collect();
        let text = network.wgsl(&self.readings_in(robot));
        self.with_controller(NETWORK, &text, |part| Ok(OwnPart { part, values }))
    }

    /// These parts, and a state machine as the controller.
    pub(crate) fn with_state_machine(&self, modules: &Modules) -> Result<Self, Invalid> {
        self.with_modules(STATE_MACHINE, &part::STATE_MACHINE, modules)
    }

    /// These parts, and a behaviour tree as the controller.
    pub(crate) fn with_behaviour_tree(&self, modules: &Modules) -> Result<Self, Invalid> {
        self.with_modules(BEHAVIOUR_TREE, &part::BEHAVIOUR_TREE, modules)
    }

    fn with_modules(&self, path: &str, files: &[(&str, &str)], modules: &Modules) -> Result<Self, Invalid> {
        let text: String = files.iter().map(|(_, text)| *text).collect();
        let given = modules.given();
        self.with_controller(path, &text, |part| OwnPart::new(part, &given))
    }

    /// These parts, and a controller that Oneiro wrote; `own` gives it its values.
    fn with_controller(
        &self,
        path: &str,
        text: &str,
        with_values: impl FnOnce(Arc<Part>) -> Result<OwnPart, Invalid>,
    ) -> Result<Self, Invalid> {
        let part = Part::of_oneiro(path, text);
        let part = part.map_err(|refused| Invalid::new("controller.kind", refused.to_string()))?;
        let mut all = self.clone();
        all.insert(Arc::new(with_values(Arc::new(part))?));
        Ok(all)
    }

    /// All values, in cells of four words; those of each part begin a cell.
    pub(crate) fn cells(&self) -> Vec<[u32; 4]> {
        self.iter().flat_map(OwnPart::cells).collect()
    }

    /// A kernel with these parts and their owner's sensors and motors.
    ///
    /// # Errors
    /// `KIND.part`: everything that is wrong with the parts. `robot.sensors` and `robot.sensors[N].name`: names that WGSL doesn't
    /// allow. `controller.layers`: a network that can't be compiled.
    pub(crate) fn compose(&self, base: &'static Kernel, owner: &Owner) -> Result<Composed, Invalid> {
        part::compose(base, self, owner)
    }
}

/// The controller of a kernel by itself, for a robot with readings in these fields; of a swarm, the one with this number. `has_states` is whether `tables` has, of each state of the
/// motors, the speed as the first word of a cell.
///
/// # Errors
/// A controller that can't stand by itself.
#[cfg(feature = "compose")]
pub(crate) fn exported(
    kernel: &Kernel,
    own: &OwnParts,
    fields: &[String],
    robot: u32,
    has_states: bool,
) -> Result<Exported, Invalid> {
    part::exported(kernel, own, fields, robot, has_states)
}

/// The world of a kernel of robots that are commanded from outside, by itself.
///
/// # Errors
/// A world that can't stand by itself.
#[cfg(feature = "compose")]
pub(crate) fn simulated(kernel: &Kernel) -> Result<oneiro_shader_compiler::Generic, Invalid> {
    part::simulated(kernel)
}

/// The kernel of swarms whose robots are driven from outside, see [`crate::swarm::Driven`].
///
/// # Errors
/// This program can't compose kernels.
pub(crate) fn driven() -> Result<&'static Kernel, Invalid> {
    part::driven()
}

/// The kind of episodes that a kernel has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EpisodeKind {
    /// By its own physics: those of the simulator, or of a Khepera's surrogate.
    Simulated,
    /// Outside of it: reality is reported to it, see [`crate::reported`].
    Reported,
    /// As an individual that differs from its description.
    Individual,
    /// As in the simulator, with a trace of every robot: see [`crate::world::World::observed`].
    Observed,
}

/// A kernel composed at run time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Composed {
    pub(crate) kernel: &'static Kernel,
    /// Genes of a user's controller, if there is one.
    pub(crate) genes: Option<&'static [Gene]>,
    /// The paths of the files that its text is made of, and where each begins, in bytes; none of a kernel that ships.
    #[cfg_attr(not(feature = "compose"), expect(dead_code, reason = "no kernel is composed"))]
    pub(crate) files: &'static [(String, usize)],
    /// In swarms, the words that the kernel keeps of a world and of each robot.
    pub(crate) words: Option<[u32; 2]>,
}

/// The fields of the kernel's `Readings` that have a sampled robot's, in order.
pub(crate) fn sampled_fields() -> Vec<String> {
    let field = |sensor: usize| format!("{}.{}", ["first", "last"][sensor / 4], ["x", "y", "z", "w"][sensor % 4]);
    (0..SENSORS).map(field).collect()
}

/// The number with the fewest digits that is this one in single precision.
fn shortest(value: f32) -> f64 {
    value.to_string().parse().unwrap_or_else(|_| value.into())
}
