//! The WGSL parts that kernels are composed from, as text. A crate of its own, because a change of a part that only kernels
//! composed at run time have should not recompile the kernels that ship.

macro_rules! parts {
    ($($path:literal),* $(,)?) => {
        /// Every part: its path, and its text.
        pub const PARTS: &[(&str, &str)] = &[$(($path, include_str!($path))),*];
    };
}

parts![
    "controller/behaviours.wgsl",
    "controller/hidden.wgsl",
    "controller/memoryless.wgsl",
    "controller/perceptron.wgsl",
    "controller/recurrent.wgsl",
    "lib/batch.wgsl",
    "lib/circle.wgsl",
    "lib/food.wgsl",
    "lib/forager.wgsl",
    "lib/genes.wgsl",
    "lib/geometry.wgsl",
    "lib/individual.wgsl",
    "lib/interface.wgsl",
    "lib/motion.wgsl",
    "lib/numerics.wgsl",
    "lib/random.wgsl",
    "lib/rollout.wgsl",
    "lib/swarm.wgsl",
    "lib/user.wgsl",
    "lib/walk.wgsl",
    "life.wgsl",
    "physics/arena.wgsl",
    "physics/foraging.wgsl",
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
    "robot/motors.wgsl",
    "robot/wheels.wgsl",
    "sensor/details.wgsl",
    "sensor/epuck.wgsl",
    "sensor/kinds.wgsl",
    "sensor/no_others.wgsl",
    "sensor/rays.wgsl",
    "sensor/readings.wgsl",
    "sensor/sampled.wgsl",
    "sensor/tables.wgsl",
    "swarm.wgsl",
    "task/avoidance.wgsl",
    "task/foraging.wgsl",
    "task/shared_foraging.wgsl",
];
