//! The WGSL parts that kernels are composed from, as text. A crate of its own, because a change of a part only kernels
//! composed at run time have should not recompile the kernels that ship.

macro_rules! parts {
    ($($path:literal),* $(,)?) => {
        /// Every part: its path, and its text.
        pub const PARTS: &[(&str, &str)] = &[$(($path, include_str!($path))),*];
    };
}

/// A file: its path, and its text.
macro_rules! file {
    ($path:literal) => {
        ($path, include_str!($path))
    };
}

/// The files of a controller that is composed like a user's; users' parts may have the same names.
pub const STATE_MACHINE: [(&str, &str); 2] = [file!("controller/modules.wgsl"), file!("controller/state_machine.wgsl")];
/// The same.
pub const BEHAVIOUR_TREE: [(&str, &str); 2] = [
    file!("controller/modules.wgsl"),
    file!("controller/behaviour_tree.wgsl"),
];

parts![
    "controller/behaviours.wgsl",
    "controller/foraging.wgsl",
    "controller/hidden.wgsl",
    "controller/memoryless.wgsl",
    "controller/outputs.wgsl",
    "controller/perceptron.wgsl",
    "controller/recurrent.wgsl",
    "commanded.wgsl",
    "driven.wgsl",
    "exported.wgsl",
    "lib/batch.wgsl",
    "lib/circle.wgsl",
    "lib/circle_given.wgsl",
    "lib/circle_rays.wgsl",
    "lib/differences.wgsl",
    "lib/food.wgsl",
    "lib/food_eight.wgsl",
    "lib/food_few.wgsl",
    "lib/food_many.wgsl",
    "lib/forager.wgsl",
    "lib/genes.wgsl",
    "lib/geometry.wgsl",
    "lib/given.wgsl",
    "lib/individual.wgsl",
    "lib/interface.wgsl",
    "lib/members.wgsl",
    "lib/motion.wgsl",
    "lib/near.wgsl",
    "lib/neighbours.wgsl",
    "lib/numerics.wgsl",
    "lib/ordinary.wgsl",
    "lib/patches.wgsl",
    "lib/pucks.wgsl",
    "lib/picture.wgsl",
    "lib/pictured.wgsl",
    "lib/random.wgsl",
    "lib/episode.wgsl",
    "lib/squares.wgsl",
    "lib/swarm.wgsl",
    "lib/user.wgsl",
    "lib/walk.wgsl",
    "episode.wgsl",
    "members.wgsl",
    "physics/acting.wgsl",
    "physics/arena.wgsl",
    "physics/commanded.wgsl",
    "physics/contacts.wgsl",
    "physics/first.wgsl",
    "physics/forager.wgsl",
    "physics/foraging.wgsl",
    "physics/individual.wgsl",
    "physics/members.wgsl",
    "physics/observed.wgsl",
    "physics/reported.wgsl",
    "physics/sampled.wgsl",
    "physics/sliding.wgsl",
    "physics/surrogate.wgsl",
    "probe/buffers.wgsl",
    "probe/numerics.wgsl",
    "probe/operations.wgsl",
    "robot/arcs.wgsl",
    "robot/between.wgsl",
    "robot/differential.wgsl",
    "robot/drive.wgsl",
    "robot/epuck.wgsl",
    "robot/epuck_alone.wgsl",
    "robot/epuck_among.wgsl",
    "robot/epuck_given.wgsl",
    "robot/epuck_reported.wgsl",
    "robot/motors.wgsl",
    "robot/varied.wgsl",
    "robot/wheels.wgsl",
    "sensor/details.wgsl",
    "sensor/epuck.wgsl",
    "sensor/foraging.wgsl",
    "sensor/kinds.wgsl",
    "sensor/no_others.wgsl",
    "sensor/others.wgsl",
    "sensor/picture.wgsl",
    "sensor/rays.wgsl",
    "sensor/readings.wgsl",
    "sensor/reference.wgsl",
    "sensor/rm11.wgsl",
    "sensor/rm12.wgsl",
    "sensor/sampled.wgsl",
    "sensor/tables.wgsl",
    "sensor/vectors.wgsl",
    "simulated.wgsl",
    "simulated_members.wgsl",
    "swarm.wgsl",
    "task/avoidance.wgsl",
    "task/bringing.wgsl",
    "task/foraging.wgsl",
    "task/shared_foraging.wgsl",
];
