//! Experiments that ship, with the files that they name: `oneiro new --example` writes them.

/// An experiment and the files that it names.
pub struct Example {
    pub name: &'static str,
    /// What a robot learns in it.
    pub about: &'static str,
    /// Relative paths and contents; the experiment's own file comes first.
    pub files: &'static [(&'static str, &'static [u8])],
}

/// A file of `experiments/`: its path there, and its content.
macro_rules! file {
    ($path:literal) => {
        ($path, include_bytes!(concat!("../../../../experiments/", $path)))
    };
}

/// All of them.
pub static EXAMPLES: [Example; 25] = [
    Example {
        name: "homing",
        about: "a Khepera with a battery returns to its charger",
        files: &[
            file!("homing.toml"),
            file!("homing/sensors.wgsl"),
            file!("homing/controller.wgsl"),
            file!("homing/task.wgsl"),
        ],
    },
    Example {
        name: "road-sign",
        about: "a Khepera passes a lamp in a corridor, and turns to the lamp's side at the end",
        files: &[
            file!("road-sign.toml"),
            file!("road-sign/sensors.wgsl"),
            file!("road-sign/ctrnn.wgsl"),
            file!("road-sign/task.wgsl"),
        ],
    },
    Example {
        name: "kheperax",
        about: "a robot with three lasers and two bumpers finds its way through a maze",
        files: &[
            file!("kheperax.toml"),
            file!("kheperax/network.wgsl"),
            file!("kheperax/task.wgsl"),
        ],
    },
    Example {
        name: "phototaxis",
        about: "a parametric robot finds a light behind obstacles",
        files: &[file!("phototaxis.toml"), file!("phototaxis/task.wgsl")],
    },
    Example {
        name: "wall-following",
        about: "a robot drives along the walls of a room at a distance",
        files: &[file!("wall-following.toml"), file!("wall-following/task.wgsl")],
    },
    Example {
        name: "line-follower",
        about: "an e-puck follows a line of a picture on the floor",
        files: &[file!("line-follower.toml"), file!("line-follower/track.png")],
    },
    Example {
        name: "map-maze",
        about: "an e-puck finds its way through rooms that were imported from a map",
        files: &[file!("map-maze.toml")],
    },
    Example {
        name: "discrimination",
        about: "a Khepera finds a cylinder and stays near it, in a room whose walls look similar",
        files: &[file!("discrimination.toml"), file!("discrimination/task.wgsl")],
    },
    Example {
        name: "aggregation",
        about: "ten robots with one bit of sight gather in one place",
        files: &[
            file!("aggregation.toml"),
            file!("aggregation/controller.wgsl"),
            file!("aggregation/mission.wgsl"),
        ],
    },
    Example {
        name: "gather",
        about: "ten robots gather on a dark patch of the floor",
        files: &[file!("gather.toml"), file!("gather/mission.wgsl")],
    },
    Example {
        name: "predator-prey",
        about: "a predator and a prey evolve against each other: two populations",
        files: &[
            file!("predator-prey.toml"),
            file!("predator-prey/sensors.wgsl"),
            file!("predator-prey/controller.wgsl"),
            file!("predator-prey/mission.wgsl"),
        ],
    },
    Example {
        name: "evostick-aggregation",
        about: "twenty e-pucks gather on one of two black spots",
        files: &[file!("evostick-aggregation.toml"), file!("evostick/aggregation.wgsl")],
    },
    Example {
        name: "evostick-foraging",
        about: "twenty e-pucks bring items from two black spots to a white nest",
        files: &[file!("evostick-foraging.toml"), file!("evostick/foraging.wgsl")],
    },
    Example {
        name: "evostick-cues",
        about: "twenty e-pucks gather on the black spot in front of a lamp",
        files: &[file!("evostick-cues.toml"), file!("evostick/cues.wgsl")],
    },
    Example {
        name: "evostick-shelter",
        about: "twenty e-pucks find a shelter with one open side",
        files: &[file!("evostick-shelter.toml"), file!("evostick/shelter.wgsl")],
    },
    Example {
        name: "evostick-network",
        about: "twenty e-pucks cover a large area as a connected network",
        files: &[file!("evostick-network.toml"), file!("evostick/network.wgsl")],
    },
    Example {
        name: "evostick-coverage",
        about: "twenty e-pucks spread over an arena except its black spots",
        files: &[file!("evostick-coverage.toml"), file!("evostick/coverage.wgsl")],
    },
    Example {
        name: "evostick-exploration",
        about: "twenty e-pucks visit all cells of an arena again and again",
        files: &[file!("evostick-exploration.toml"), file!("evostick/exploration.wgsl")],
    },
    Example {
        name: "automode-aggregation",
        about: "twenty e-pucks gather on one of two black spots, as state machines",
        files: &[file!("automode-aggregation.toml"), file!("evostick/aggregation.wgsl")],
    },
    Example {
        name: "automode-cues",
        about: "twenty e-pucks gather on a black spot in front of a lamp, as state machines",
        files: &[file!("automode-cues.toml"), file!("evostick/cues.wgsl")],
    },
    Example {
        name: "automode-foraging",
        about: "twenty e-pucks bring items to a nest, as state machines",
        files: &[file!("automode-foraging.toml"), file!("evostick/foraging.wgsl")],
    },
    Example {
        name: "puck-clustering",
        about: "five e-pucks push twenty pucks together",
        files: &[file!("puck-clustering.toml")],
    },
    Example {
        name: "puck-foraging",
        about: "six e-pucks carry pucks to the nest that they start in",
        files: &[file!("puck-foraging.toml")],
    },
    Example {
        name: "five-starts",
        about: "an e-puck drives to a lamp from each of five starts",
        files: &[file!("five-starts.toml")],
    },
    Example {
        name: "odowd2014-over",
        about: "ten e-pucks forage, and evolve in their on-board simulators: the foraging study of 2014",
        files: &[file!("odowd2014-over.toml")],
    },
];
