//! The kernels of `wgsl/`, for the build script and for tests that compile them again. This is the place to add one.

use oneiro_shader_compiler::Part;
use oneiro_shader_parts::PARTS;

/// A kernel: its constant's name, the module of its host structs, and its parts.
pub(crate) struct Entry {
    pub(crate) name: &'static str,
    pub(crate) module: &'static str,
    pub(crate) parts: &'static [&'static str],
}

/// An episode: its physics are those of the simulator made from samples, or of what stands in for the robot itself.
macro_rules! episode {
    ($name:literal, sampled, $controller:tt) => {
        episode!($name, "episode", $controller, "robot/differential", "sensor/sampled", "lib/walk", "physics/sliding", "physics/sampled")
    };
    ($name:literal, surrogate, $controller:tt) => {
        episode!($name, "surrogate", $controller, "lib/individual", "physics/sliding", "robot/wheels", "sensor/rays", "physics/surrogate")
    };
    ($name:literal, $module:literal, [$($controller:literal),+], $($physics:literal),+) => {
        Entry {
            name: $name,
            module: $module,
            parts: &[
                "lib/numerics",
                "lib/random",
                "lib/geometry",
                "lib/batch",
                "lib/episode",
                "lib/genes",
                "lib/motion",
                "robot/motors",
                "sensor/readings",
                "sensor/details",
                "sensor/no_others",
                "lib/interface",
                $($controller,)+
                "task/avoidance",
                $($physics,)+
                "episode",
            ],
        }
    };
}

/// A forager in its on-board simulator, with the food of one part.
macro_rules! forager {
    ($name:literal, $food:literal) => {
        Entry {
            name: $name,
            module: $name,
            parts: &[
                "lib/numerics",
                "lib/random",
                "lib/batch",
                "lib/episode",
                "lib/genes",
                "lib/forager",
                "lib/circle",
                "lib/food",
                "lib/food_eight",
                $food,
                "sensor/epuck",
                "robot/epuck_alone",
                "robot/epuck",
                "controller/behaviours",
                "task/foraging",
                "physics/foraging",
                "episode",
            ],
        }
    };
}

/// The catalogue of kernels: one part a slot (robot, sensor, physics, controller, task).
pub(crate) const CATALOGUE: &[Entry] = &[
    episode!(
        "life_perceptron",
        sampled,
        ["controller/memoryless", "controller/perceptron"]
    ),
    episode!("life_hidden", sampled, ["controller/memoryless", "controller/hidden"]),
    episode!("life_recurrent", sampled, ["controller/recurrent"]),
    episode!(
        "surrogate_perceptron",
        surrogate,
        ["controller/memoryless", "controller/perceptron"]
    ),
    episode!(
        "surrogate_hidden",
        surrogate,
        ["controller/memoryless", "controller/hidden"]
    ),
    episode!("surrogate_recurrent", surrogate, ["controller/recurrent"]),
    forager!("forager", "lib/food_few"),
    forager!("forager_many", "lib/food_many"),
    Entry {
        name: "swarm",
        module: "swarm",
        parts: &[
            "lib/numerics",
            "lib/random",
            "lib/batch",
            "lib/forager",
            "lib/circle",
            "lib/swarm",
            "lib/food",
            "sensor/epuck",
            "robot/epuck_among",
            "robot/epuck",
            "controller/behaviours",
            "task/shared_foraging",
            "physics/arena",
            "swarm",
        ],
    },
    Entry {
        name: "acting",
        module: "acting",
        parts: &[
            "lib/numerics",
            "lib/random",
            "lib/batch",
            "lib/episode",
            "lib/genes",
            "lib/forager",
            "lib/circle",
            "robot/epuck_reported",
            "robot/epuck",
            "controller/behaviours",
            "physics/acting",
            "episode",
        ],
    },
    Entry {
        name: "probe_numerics",
        module: "probe_numerics",
        parts: &["lib/numerics", "lib/random", "probe/buffers", "probe/numerics"],
    },
    Entry {
        name: "probe_operations",
        module: "probe_operations",
        parts: &["probe/buffers", "probe/operations"],
    },
];

/// The parts of a kernel.
pub(crate) fn parts(entry: &Entry) -> Vec<Part> {
    let find = |name: &&str| {
        let path = format!("{name}.wgsl");
        let found = PARTS.iter().find(|(shipped, _)| *shipped == path);
        let (_, text) = found.unwrap_or_else(|| panic!("wgsl/{path} is not in the list of files, wgsl/lib.rs"));
        Part {
            path,
            text: (*text).to_owned(),
        }
    };
    entry.parts.iter().map(find).collect()
}
