//! What each kind of part declares and may use. `shaders/wgsl/lib/interface.wgsl` has the kernel's side.

use crate::parts::compose::Kind;

/// A function of a part.
pub(super) struct Function {
    /// Its head.
    pub(super) text: &'static str,
    /// The body that it has if the part leaves it out; `None` if the part must have it.
    pub(super) default: Option<&'static str>,
}

impl Function {
    pub(super) fn name(&self) -> &'static str {
        let name = self.text.trim_start_matches("fn ");
        name.split_once('(').map_or(name, |(name, _)| name)
    }
}

/// The struct that says which episode a function works for.
pub(super) const EPISODE: &str = "Episode";
/// The struct's name in parts for earlier versions.
pub(super) const FORMER_EPISODE: &str = "Life";

/// The interface of a kind of part.
pub(super) struct Interface {
    pub(super) kind: Kind,
    /// The word that its structs' names begin with.
    pub(super) title: &'static str,
    pub(super) functions: &'static [Function],
    /// More functions that it may declare for swarms; the first makes it a mission.
    pub(super) mission: &'static [Function],
    /// Other declarations that it must have, or that are generated, and their form.
    pub(super) others: &'static [(&'static str, &'static str)],
    /// Structs of the kernel that it declares, all or some.
    pub(super) structs: &'static [&'static str],
    /// Functions and structs of the kernel that only parts of this kind may call or construct.
    pub(super) calls: &'static [&'static str],
}

impl Interface {
    /// Name of the constant with the first cell of a part's values, counted from the first part's.
    pub(super) fn first_value(&self) -> String {
        format!("FIRST_{}_VALUE", self.kind.word().to_uppercase())
    }
}

impl Interface {
    /// All functions that it may declare for Oneiro to call.
    pub(super) fn known(&self) -> impl Iterator<Item = &'static Function> + use<> {
        self.functions.iter().chain(self.mission)
    }

    /// Whether a name is of a function that gives another kind's memory.
    pub(super) fn is_of_another(&self, name: &str) -> bool {
        let kinds = [Kind::Sensor, Kind::Controller, Kind::Task];
        let mut others = kinds.into_iter().filter(|kind| *kind != self.kind).map(Kind::word);
        others.any(|word| {
            ["begin", "state", "kept", "cycle"]
                .iter()
                .any(|end| name == format!("{word}_{end}"))
        })
    }
}

/// The interface of a kind.
pub(super) fn of(kind: Kind) -> Interface {
    match kind {
        Kind::Sensor => SENSOR,
        Kind::Controller => CONTROLLER,
        Kind::Task => TASK,
    }
}

const SENSOR: Interface = Interface {
    kind: Kind::Sensor,
    title: "Sensor",
    functions: &[
        Function {
            text: "fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed",
            default: None,
        },
        Function {
            text: "fn sensor_begin(episode: Episode, pose: vec3<f32>) -> SensorState",
            default: Some("return SensorState();"),
        },
        Function {
            text: "fn sensor_ends(episode: Episode, memory: SensorState) -> bool",
            default: Some("return false;"),
        },
    ],
    mission: &[],
    others: &[("SensorReadings", "struct SensorReadings { NAME: f32, .. }")],
    structs: &["SensorReadings", "SensorState"],
    calls: &["Sensed"],
};

/// The number of a controller's genes, and the struct in which it may name them instead.
pub(super) const GENE_COUNT: &str = "CONTROLLER_GENES";
pub(super) const GENES: &str = "ControllerGenes";

const CONTROLLER: Interface = Interface {
    kind: Kind::Controller,
    title: "Controller",
    functions: &[
        Function {
            text: "fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command",
            default: None,
        },
        Function {
            text: "fn controller_begin(episode: Episode) -> ControllerState",
            default: Some("return ControllerState();"),
        },
        Function {
            text: "fn controller_ends(episode: Episode, memory: ControllerState) -> bool",
            default: Some("return false;"),
        },
    ],
    mission: &[],
    others: &[(GENE_COUNT, "const CONTROLLER_GENES: u32 = NUMBER;")],
    structs: &["ControllerState", GENES],
    calls: &["Command", "gene", "weighed"],
};

const TASK: Interface = Interface {
    kind: Kind::Task,
    title: "Task",
    functions: &[
        Function {
            text: "fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward",
            default: None,
        },
        Function {
            text: "fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState",
            default: Some("return TaskState();"),
        },
        Function {
            text: "fn task_ends(episode: Episode, memory: TaskState) -> bool",
            default: Some("return false;"),
        },
        Function {
            text: "fn task_score(episode: Episode, memory: TaskState, sum: f32) -> f32",
            default: Some("return sum;"),
        },
    ],
    mission: &[
        Function {
            text: "fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally",
            default: Some("return Tally(0.0f, before);"),
        },
        Function {
            text: "fn mission_begin(episode: Episode) -> MissionState",
            default: Some("return MissionState();"),
        },
        Function {
            text: "fn mission_ends(episode: Episode, memory: MissionState) -> bool",
            default: Some("return false;"),
        },
        Function {
            text: "fn mission_score(episode: Episode, memory: MissionState, sum: f32) -> f32",
            default: Some("return sum;"),
        },
    ],
    others: &[],
    structs: &["TaskState", MISSION_STATE],
    calls: &["Reward", "Tally"],
};

/// The function with which a task has a mission, and the struct of what that remembers.
pub(super) const MISSION: &str = "mission_cycle";
pub(super) const MISSION_STATE: &str = "MissionState";
