//! Experiments, sweeps and studies that ship with Oneiro, with the files that they name: `oneiro new --example` writes them. They are a
//! crate, because a package holds only what is in its folder.

/// An experiment or a sweep, and the files that it names.
pub struct Example {
    /// Path of its own file in the folder, without `.toml`.
    pub name: &'static str,
    /// What a robot learns in it, or what a sweep asks.
    pub about: &'static str,
    /// Relative paths and contents; its own file comes first.
    pub files: &'static [(&'static str, &'static [u8])],
}

impl Example {
    /// Whether it is a sweep.
    pub fn is_sweep(&self) -> bool {
        self.name.starts_with("sweeps/")
    }
}

/// A file here: its path, and its content.
macro_rules! file {
    ($path:literal) => {
        ($path, include_bytes!($path))
    };
}

/// A paper's study, and the experiment that it changes.
pub struct Study {
    /// Path of the study's file in the repository.
    pub path: &'static str,
    /// Its content.
    pub text: &'static str,
    /// Path of the experiment's file in the repository.
    pub experiment_path: &'static str,
    /// Its content.
    pub experiment: &'static str,
    /// The paper's claims.
    pub claims: &'static str,
}

/// The study of 1995.
pub const MIGLINO1995: Study = Study {
    path: "experiments/miglino1995/study.toml",
    text: include_str!("miglino1995/study.toml"),
    experiment_path: "experiments/khepera-avoidance.toml",
    experiment: include_str!("khepera-avoidance.toml"),
    claims: include_str!("miglino1995/claims.toml"),
};

/// The 1995 study's claims: the chance that five runs of one robot show them.
pub const MIGLINO1995_PLANNED: &str = include_str!("miglino1995/planned.toml");

/// The study of 2014.
pub const ODOWD2014: Study = Study {
    path: "experiments/odowd2014/study.toml",
    text: include_str!("odowd2014/study.toml"),
    experiment_path: "experiments/odowd2014-over.toml",
    experiment: include_str!("odowd2014-over.toml"),
    claims: include_str!("odowd2014/claims.toml"),
};

/// All experiments, then all sweeps.
pub static EXAMPLES: &[Example] = &[
    Example {
        name: "khepera-avoidance",
        about: "a Khepera learns to avoid obstacles: the study of 1995",
        files: &[file!("khepera-avoidance.toml")],
    },
    Example {
        name: "khepera-hidden",
        about: "the same with four hidden units",
        files: &[file!("khepera-hidden.toml"), file!("khepera-avoidance.toml")],
    },
    Example {
        name: "khepera-recurrent",
        about: "the same with a recurrent controller",
        files: &[file!("khepera-recurrent.toml"), file!("khepera-avoidance.toml")],
    },
    Example {
        name: "khepera-block",
        about: "the same around a block that looks different from different sides",
        files: &[file!("khepera-block.toml"), file!("khepera-avoidance.toml")],
    },
    Example {
        name: "khepera-sensor-noise",
        about: "the same with sensor noise",
        files: &[file!("khepera-sensor-noise.toml"), file!("khepera-avoidance.toml")],
    },
    Example {
        name: "khepera-conservative-noise",
        about: "the same with conservative noise",
        files: &[
            file!("khepera-conservative-noise.toml"),
            file!("khepera-avoidance.toml"),
        ],
    },
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
        name: "light-switching",
        about: "a Khepera learns within each episode to switch a lamp on and to stay under it",
        files: &[
            file!("light-switching.toml"),
            file!("light-switching/sensors.wgsl"),
            file!("light-switching/task.wgsl"),
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
        name: "kheperax-elites",
        about: "which places a robot can reach in the maze of Kheperax, by MAP-Elites",
        files: &[
            file!("kheperax-elites.toml"),
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
        files: &[
            file!("map-maze.toml"),
            file!("map-maze/map.yaml"),
            file!("map-maze/map.png"),
        ],
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
    Example {
        name: "odowd2014-no-light",
        about: "the foraging study without a light",
        files: &[file!("odowd2014-no-light.toml")],
    },
    Example {
        name: "odowd2014-opposite",
        about: "the foraging study with the light opposite the nest",
        files: &[file!("odowd2014-opposite.toml")],
    },
    Example {
        name: "odowd2014-over-then-opposite",
        about: "the foraging study with the light over the nest, then opposite",
        files: &[file!("odowd2014-over-then-opposite.toml")],
    },
    Example {
        name: "odowd2014-opposite-then-over",
        about: "the foraging study with the light opposite the nest, then over it",
        files: &[file!("odowd2014-opposite-then-over.toml")],
    },
    Example {
        name: "odowd2014-random",
        about: "the foraging study with robots that search at random: the control",
        files: &[file!("odowd2014-random.toml")],
    },
    Example {
        name: "sweeps/small",
        about: "a sweep to try: two seconds",
        files: &[file!("sweeps/small.toml"), file!("khepera-avoidance.toml")],
    },
    Example {
        name: "sweeps/khepera-sensor-noise",
        about: "which range of sensor noise transfers best",
        files: &[
            file!("sweeps/khepera-sensor-noise.toml"),
            file!("khepera-avoidance.toml"),
        ],
    },
    Example {
        name: "sweeps/khepera-conservative-noise",
        about: "which range of conservative noise transfers best",
        files: &[
            file!("sweeps/khepera-conservative-noise.toml"),
            file!("khepera-avoidance.toml"),
        ],
    },
    Example {
        name: "sweeps/kheperax-elites",
        about: "ten seeds of MAP-Elites in the maze of Kheperax",
        files: &[
            file!("sweeps/kheperax-elites.toml"),
            file!("kheperax-elites.toml"),
            file!("kheperax/network.wgsl"),
            file!("kheperax/task.wgsl"),
        ],
    },
    Example {
        name: "sweeps/road-sign",
        about: "ten seeds of the road sign",
        files: &[
            file!("sweeps/road-sign.toml"),
            file!("road-sign.toml"),
            file!("road-sign/sensors.wgsl"),
            file!("road-sign/ctrnn.wgsl"),
            file!("road-sign/task.wgsl"),
        ],
    },
    Example {
        name: "sweeps/evostick",
        about: "EvoStick with its published budget",
        files: &[
            file!("sweeps/evostick.toml"),
            file!("evostick-foraging.toml"),
            file!("evostick/foraging.wgsl"),
            file!("evostick-cues.toml"),
            file!("evostick/cues.wgsl"),
        ],
    },
    Example {
        name: "sweeps/pseudo-reality-networks",
        about: "networks in pseudo-reality",
        files: &[
            file!("sweeps/pseudo-reality-networks.toml"),
            file!("evostick-cues.toml"),
            file!("evostick/cues.wgsl"),
        ],
    },
    Example {
        name: "sweeps/pseudo-reality-machines",
        about: "state machines in pseudo-reality",
        files: &[
            file!("sweeps/pseudo-reality-machines.toml"),
            file!("automode-cues.toml"),
            file!("evostick/cues.wgsl"),
        ],
    },
    Example {
        name: "sweeps/optimisers",
        about: "which optimiser is best in 20,000 episodes",
        files: &[file!("sweeps/optimisers.toml"), file!("khepera-avoidance.toml")],
    },
    Example {
        name: "sweeps/optimisers-equal-budget",
        about: "the same with equal budgets for all",
        files: &[
            file!("sweeps/optimisers-equal-budget.toml"),
            file!("khepera-avoidance.toml"),
        ],
    },
    Example {
        name: "sweeps/optimisers-behaviour",
        about: "the same for optimisers that use behaviour",
        files: &[
            file!("sweeps/optimisers-behaviour.toml"),
            file!("khepera-avoidance.toml"),
        ],
    },
    Example {
        name: "sweeps/optimisers-longer",
        about: "optimisers with five times the episodes",
        files: &[file!("sweeps/optimisers-longer.toml"), file!("khepera-avoidance.toml")],
    },
    Example {
        name: "sweeps/optimisers-range",
        about: "the same with wider ranges of weights",
        files: &[file!("sweeps/optimisers-range.toml"), file!("khepera-avoidance.toml")],
    },
    Example {
        name: "sweeps/optimisers-range-genetic",
        about: "the same for the genetic algorithm of 1995",
        files: &[
            file!("sweeps/optimisers-range-genetic.toml"),
            file!("khepera-avoidance.toml"),
        ],
    },
    Example {
        name: "sweeps/optimisers-hidden",
        about: "the same for a network with hidden units",
        files: &[
            file!("sweeps/optimisers-hidden.toml"),
            file!("khepera-hidden.toml"),
            file!("khepera-avoidance.toml"),
        ],
    },
    Example {
        name: "sweeps/odowd2014-density",
        about: "foragers: swarms of five sizes in arenas of three",
        files: &[file!("sweeps/odowd2014-density.toml"), file!("odowd2014-over.toml")],
    },
    Example {
        name: "sweeps/odowd2014-mutation",
        about: "foragers: choices that the paper leaves open",
        files: &[file!("sweeps/odowd2014-mutation.toml"), file!("odowd2014-over.toml")],
    },
];
