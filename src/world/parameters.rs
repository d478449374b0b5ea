//! The values of a world, by their keys in an experiment's file.

use std::sync::LazyLock;

use oneiro_shaders::episode;

use crate::foragers::foraging::{self, AsForaging, Foraging};
use crate::parameter::Allowed::{Any, Number, Text, Whole};
use crate::parameter::{Allowed, Choice, Choices, Parameter, row};
use crate::parts::automode::Modules;
use crate::parts::network::{GREATEST_UNITS, Network};
use crate::world::arena::GREATEST_PATCHES;
use crate::world::differential::{Differential, GREATEST_MEMBERS, GREATEST_SEEN_MEMBERS};
use crate::world::pucks::GREATEST_YIELDS;
use crate::world::robot::{Build, Robot};
use crate::world::spec::{Activation, Controller, Difference, Speed, Task, WorldSpec};
use crate::world::start::{Poses, Start, Zone};
use crate::world::varied::GREATEST_DRAWN;

/// Range of coordinates, mm: beyond 100 m single precision is too coarse for a robot's steps.
pub const COORDINATE: Allowed = Number(-1e5, 1e5);
/// Range of directions, turns.
const TURNS: Allowed = Number(-1.0, 1.0);
/// Range of lengths of bodies, arenas and blocks, mm.
pub const LENGTH: Allowed = Number(1.0, 1e5);

const OURS: &str = "ours";
const ARGOS: &str = "ARGoS's e-puck";
const EVOSTICK: &str = "EvoStick (ARGoS3-NEAT)";
const CLASS: Allowed = Text("a class of the sensor tables");

/// Rows of all values except tables and the size of the arena, which an experiment specifies otherwise.
#[rustfmt::skip]
pub fn parameters<T: AsMut<WorldSpec> + AsForaging>() -> Vec<Parameter<T>> {
    let mut rows: Vec<Parameter<T>> = vec![
        row("cycles", "cycles of 100 ms", Whole(1, 1_000_000), "Miglino et al. 1995, section 3.1",
            "Length of an episode; 500 cycles are 50 s.", |spec, _| Some(&mut spec.as_mut().cycles)),
        row("robot.kind", "", Any, OURS,
            "Kind of robot; default: sampled.", |spec, _| Some(&mut spec.as_mut().robot.build)),
        row("robot.body_radius_mm", "mm", LENGTH, "Miglino et al. 1995, section 3.1",
            "Radius of the round body.", |spec, _| match spec.as_mut().robot {
                Robot { build: Build::Forager(ref mut forager), .. } => Some(&mut forager.foraging.body_radius),
                Robot { ref mut body_radius, .. } => Some(body_radius),
            }),
        row("robot.wheel_base_mm", "mm", LENGTH, OURS,
            "Distance between the wheels; not with `motors`.", |spec, _| match spec.as_mut().robot.build {
                Build::Forager(ref mut forager) => Some(&mut forager.foraging.wheel_base),
                Build::Differential(ref mut robot) => Some(&mut robot.wheel_base),
                Build::Sampled => None,
            }),
        row("robot.greatest_speed_mm_s", "mm/s", Number(0.01, 1e5), OURS,
            "Maximum speed of a wheel; not with `motors`.", |spec, _| match spec.as_mut().robot.build {
                Build::Forager(ref mut forager) => Some(&mut forager.foraging.greatest_speed),
                Build::Differential(ref mut robot) => Some(&mut robot.greatest_speed),
                Build::Sampled => None,
            }),
        row("robot.speeds", "", Whole(0, 1024), OURS,
            "Number of speeds that a wheel has, evenly spaced from full speed backwards to full speed forwards; 0 for any speed.", |spec, _| Some(&mut described(spec)?.speeds)),
        row("robot.acceleration_mm_s2", "mm/s^2", Number(0.0, 1e6), OURS,
            "Maximum change of a wheel's speed in a second; 0 or not set: wheels obey at once.", |spec, _| Some(&mut described(spec)?.acceleration)),
        row("robot.latency_cycles", "cycles", Whole(0, 8), OURS,
            "Cycles from a command to its effect on the wheels, which stand still until the first one arrives; default: 0.", |spec, _| Some(&mut described(spec)?.latency)),
        row("robot.battery_s", "s", Number(0.1, 1e5), OURS,
            "Time that a full battery lasts; default: no battery.", |spec, _| Some(&mut described(spec)?.battery)),
        row("robot.battery_ends_life", "", Any, OURS,
            "Whether an episode ends when the battery is empty; default: false.", |spec, _| Some(&mut described(spec)?.battery_ends_life)),
        row("robot.wheel_noise", "", Number(0.0, 0.5), "Enki",
            "Noise of each wheel's travel in a cycle, as a fraction, distributed by wheel_noise_law; default for parametric robots: none.", |spec, _| match spec.as_mut().robot.build {
                Build::Forager(ref mut forager) => Some(&mut forager.foraging.wheel_noise),
                Build::Differential(ref mut robot) => Some(&mut robot.wheel_noise),
                Build::Sampled => None,
            }),
        row("robot.wheel_noise_law", "", Any, "ARGoS's e-puck: normal",
            "Distribution of wheel_noise; default: uniform.", |spec, _| Some(&mut described(spec)?.wheel_noise_law)),
        row("robot.count", "", Whole(1, GREATEST_MEMBERS.into()), OURS,
            "Number of robots of a swarm: see docs/swarms.md; default: a single robot.", |spec, _| Some(&mut described(spec)?.count)),
        row("robot.genomes", "", Text("homogeneous, heterogeneous, or a list with the team of each robot, from 0"), OURS,
            "Which robots of a swarm share their controller's genes: all, none, or those of a team; default: homogeneous.", |spec, _| Some(&mut described(spec)?.genomes)),
        row("robot.contact", "", Any, OURS,
            "What a swarm's bodies do when they meet; default: push.", |spec, _| Some(&mut described(spec)?.contact)),
        row("robot.starts_mm", "mm", Text("pairs of numbers, x and y of each robot"), OURS,
            "Starts of a swarm's robots, each with a random heading; default: random places.", |spec, _| Some(&mut described(spec)?.starts)),
        row("robot.model", "", Any, OURS,
            "Reference model of the e-puck, for swarms; its readings come after those of `sensors`: see docs/reference-models.md; default: none.", |spec, _| Some(&mut described(spec)?.model)),
        row("robot.proximity_noise", "", Number(0.0, 1.0), ARGOS,
            "Maximum error of a reference model's proximity readings, uniform; readings are clipped to 0 to 1; default: 0.05.", |spec, _| Some(&mut described(spec)?.reference.proximity_noise)),
        row("robot.light_noise", "", Number(0.0, 1.0), ARGOS,
            "Maximum error of its light readings; default: 0.05.", |spec, _| Some(&mut described(spec)?.reference.light_noise)),
        row("robot.ground_noise", "", Number(0.0, 1.0), ARGOS,
            "Maximum error of its three ground readings, which tell black from white; default: 0.05.", |spec, _| Some(&mut described(spec)?.reference.ground_noise)),
        row("robot.grey_left", "", Number(0.0, 1.0), EVOSTICK,
            "Mean and standard deviation of the left ground sensor's reading on neither black nor white, normal, clipped to 0 to 1; rm1.2 has only this sensor; default: [0.41, 0.18].", |spec, _| Some(&mut described(spec)?.reference.grey_left)),
        row("robot.grey_middle", "", Number(0.0, 1.0), EVOSTICK,
            "The same for the middle ground sensor; default: [0.34, 0.12].", |spec, _| Some(&mut described(spec)?.reference.grey_middle)),
        row("robot.grey_right", "", Number(0.0, 1.0), EVOSTICK,
            "The same for the right ground sensor; default: [0.42, 0.18].", |spec, _| Some(&mut described(spec)?.reference.grey_right)),
        row("robot.signal_range_mm", "mm", Number(1.0, 1e5), "Francesca et al. 2014: 700; ARGoS's e-puck: 800",
            "Maximum distance at which two robots receive each other's messages, between centres; default: 700.", |spec, _| Some(&mut described(spec)?.reference.signal_range)),
        row("robot.signal_loss", "", Number(0.0, 1.0), ARGOS,
            "Probability that another robot does not receive a message; default: 0.85.", |spec, _| Some(&mut described(spec)?.reference.signal_loss)),
        row("robot.signal_cycles", "cycles", Whole(1, 64), "demiurge-epuck-dao, RabMessageBuffer: ten cycles after the one that a message came in",
            "Cycles whose messages count for the attraction, including the current one; default: 11.", |spec, _| Some(&mut described(spec)?.reference.signal_cycles)),
        row("robot.attraction", "", Number(0.0, 1000.0), EVOSTICK,
            "Factor of the attraction; default: 1.", |spec, _| Some(&mut described(spec)?.reference.attraction)),
        row("robot.body_height_mm", "mm", LENGTH, ARGOS,
            "Body height, for hiding lamps from other robots; default: 76.", |spec, _| Some(&mut described(spec)?.reference.body_height)),
        row("pucks.count", "", Whole(1, u64::from(GREATEST_SEEN_MEMBERS) - 1), OURS,
            "Number of pucks that a swarm's robots push and carry, at most 1,024 with the robots: see docs/pucks.md; default: none.", |spec, _| Some(&mut spec.as_mut().pucks.count)),
        row("pucks.radius_mm", "mm", Number(1.0, 1e4), OURS,
            "Radius of a puck.", |spec, _| Some(&mut spec.as_mut().pucks.radius)),
        row("pucks.yields", "", Number(0.0, GREATEST_YIELDS), OURS,
            "Part of an overlap with a robot by which a puck gives way; the robot gives way by the rest; default: 0.8.", |spec, _| Some(&mut spec.as_mut().pucks.yields)),
        row("pucks.grip_mm", "mm", Number(0.0, 1e4), OURS,
            "Maximum gap between a robot and a puck in front of it that it can take; default: 0, robots only push.", |spec, _| Some(&mut spec.as_mut().pucks.grip)),
        row("pucks.places_mm", "mm", Text("pairs of numbers, x and y of each puck"), OURS,
            "Places of the pucks at the start; default: random places in the arena.", |spec, _| Some(&mut spec.as_mut().pucks.places)),
        row("robot.sensors", "", Any, OURS,
            "Sensors.", |spec, _| Some(&mut described(spec)?.sensors)),
        row("robot.sensors[].name", "", Text("letters from a to z, digits and _, a letter first"), "",
            "Name of a sensor.", |spec, index| Some(&mut described(spec)?.sensors.get_mut(index)?.name)),
        row("robot.sensors[].kind", "", Any, "",
            "What it measures.", |spec, index| Some(&mut described(spec)?.sensors.get_mut(index)?.kind)),
        row("robot.sensors[].heading_turns", "turns", TURNS, "",
            "Its direction, and its place on the body, counter-clockwise from straight ahead.", |spec, index| Some(&mut described(spec)?.sensors.get_mut(index)?.heading)),
        row("robot.sensors[].bearing_turns", "turns", TURNS, "",
            "Its place on the body, counter-clockwise from straight ahead; default: its direction.", |spec, index| Some(&mut described(spec)?.sensors.get_mut(index)?.bearing)),
        row("robot.sensors[].offset_mm", "mm", Number(0.0, 1e5), "",
            "Distance from the body's centre; default: the body's radius.", |spec, index| Some(&mut described(spec)?.sensors.get_mut(index)?.offset)),
        row("robot.sensors[].range_mm", "mm", Number(0.01, 1e5), "",
            "Range. Bumpers: the gap to an object below which they are pressed.", |spec, index| Some(&mut described(spec)?.sensors.get_mut(index)?.range)),
        row("robot.sensors[].width_turns", "turns", Number(0.001, 1.0), "",
            "Width; default: half a turn.", |spec, index| Some(&mut described(spec)?.sensors.get_mut(index)?.width)),
        row("robot.sensors[].law", "", Any, "",
            "How the reading falls with the distance in ranges, d; default: linear.", |spec, index| Some(&mut described(spec)?.sensors.get_mut(index)?.law)),
        row("robot.sensors[].response", "", Text("2 to 32 pairs of a distance in mm and a reading from 0 to 1"), "",
            "Readings at some distances, nearest first, with straight lines between them; default: a straight line from 1 at 0 to 0 at the range.", |spec, index| Some(&mut described(spec)?.sensors.get_mut(index)?.response)),
        row("robot.sensors[].column", "", Whole(0, 63), "",
            "Its column in the lines of the tables, from 0; default: its place among the sampled sensors.", |spec, index| Some(&mut described(spec)?.sensors.get_mut(index)?.column)),
        row("robot.collision", "", Any, "Evorobot",
            "What a collision does; default: undo.", |spec, _| Some(&mut spec.as_mut().robot.collision)),
        row("robot.turn_before_move", "", Number(0.0, 1.0), "Evorobot",
            "Fraction of a cycle's turn before its displacement, for sampled motors.", |spec, _| match spec.as_mut().robot {
                Robot { build: Build::Sampled, ref mut turn_before_move, .. } => Some(turn_before_move),
                Robot { build: Build::Differential(ref mut robot), .. } => Some(&mut robot.turn_before_move),
                Robot { build: Build::Forager(_), .. } => None,
            }),
        row("arena.walls", "", Any, OURS,
            "Walls of a custom arena. If any are listed, the four sides are not added: also list these. Without this key the \
             arena has its four sides, of the class wall.", |spec, _| Some(&mut spec.as_mut().arena.walls)),
        row("arena.walls[].from_mm", "mm", COORDINATE, "",
            "x and y of one end of a wall.", |spec, index| Some(&mut spec.as_mut().arena.walls.get_mut(index)?.from)),
        row("arena.walls[].to_mm", "mm", COORDINATE, "",
            "x and y of its other end.", |spec, index| Some(&mut spec.as_mut().arena.walls.get_mut(index)?.to)),
        row("arena.walls[].class", "", CLASS, "",
            "Its class, which selects the sensor table.", |spec, index| Some(&mut spec.as_mut().arena.walls.get_mut(index)?.class)),
        row("arena.obstacles", "", Any, OURS,
            "Round obstacles of a custom arena.", |spec, _| Some(&mut spec.as_mut().arena.obstacles)),
        row("arena.obstacles[].x_mm", "mm", COORDINATE, "",
            "x of an obstacle's centre.", |spec, index| Some(&mut spec.as_mut().arena.obstacles.get_mut(index)?.x)),
        row("arena.obstacles[].y_mm", "mm", COORDINATE, "",
            "y of its centre.", |spec, index| Some(&mut spec.as_mut().arena.obstacles.get_mut(index)?.y)),
        row("arena.obstacles[].radius_mm", "mm", Number(0.0, 1e5), "",
            "Its radius; the paper's obstacles have 27.5.", |spec, index| Some(&mut spec.as_mut().arena.obstacles.get_mut(index)?.radius)),
        row("arena.obstacles[].class", "", CLASS, "",
            "Its class, which selects the sensor table.", |spec, index| Some(&mut spec.as_mut().arena.obstacles.get_mut(index)?.class)),
        row("arena.blocks", "", Any, OURS,
            "Rectangular obstacles of a custom arena.", |spec, _| Some(&mut spec.as_mut().arena.blocks)),
        row("arena.blocks[].x_mm", "mm", COORDINATE, "",
            "x of a block's centre.", |spec, index| Some(&mut spec.as_mut().arena.blocks.get_mut(index)?.x)),
        row("arena.blocks[].y_mm", "mm", COORDINATE, "",
            "y of its centre.", |spec, index| Some(&mut spec.as_mut().arena.blocks.get_mut(index)?.y)),
        row("arena.blocks[].length_mm", "mm", LENGTH, "",
            "One of its sides.", |spec, index| Some(&mut spec.as_mut().arena.blocks.get_mut(index)?.length)),
        row("arena.blocks[].width_mm", "mm", LENGTH, "",
            "The other side.", |spec, index| Some(&mut spec.as_mut().arena.blocks.get_mut(index)?.width)),
        row("arena.blocks[].heading_turns", "turns", TURNS, "",
            "Direction of its length, counter-clockwise from the x axis.", |spec, index| Some(&mut spec.as_mut().arena.blocks.get_mut(index)?.heading)),
        row("arena.blocks[].class", "", CLASS, "",
            "Its class, which selects the sensor table; `oneiro robot sample` makes one, since none is built in.", |spec, index| Some(&mut spec.as_mut().arena.blocks.get_mut(index)?.class)),
        row("arena.lights", "", Any, OURS,
            "Lights, for a parametric robot's light sensors.", |spec, _| Some(&mut spec.as_mut().arena.lights)),
        row("arena.lights[].x_mm", "mm", COORDINATE, "",
            "x of a light.", |spec, index| Some(&mut spec.as_mut().arena.lights.get_mut(index)?.x)),
        row("arena.lights[].y_mm", "mm", COORDINATE, "",
            "y of it.", |spec, index| Some(&mut spec.as_mut().arena.lights.get_mut(index)?.y)),
        row("arena.lights[].brightness", "", Number(0.0, 1000.0), "",
            "Reading of a sensor that faces it from nearby; reference models use the intensity instead.", |spec, index| Some(&mut spec.as_mut().arena.lights.get_mut(index)?.brightness)),
        row("arena.lights[].height_mm", "mm", Number(0.0, 1e5), "",
            "Its height above the floor, for robots with a model; default: 0.", |spec, index| Some(&mut spec.as_mut().arena.lights.get_mut(index)?.height)),
        row("arena.lights[].intensity", "", Number(0.01, 1000.0), "",
            "Divisor of its distance, for robots with a model; default: 1.", |spec, index| Some(&mut spec.as_mut().arena.lights.get_mut(index)?.intensity)),
        row("arena.wall_height_mm", "mm", LENGTH, OURS,
            "Height of walls, blocks and obstacles, over which robots with a model sense lamps; default: they hide all lamps.", |spec, _| Some(&mut spec.as_mut().arena.wall_height)),
        row("arena.floor", "", Number(0.0, 1.0), OURS,
            "Grey of the floor, for a parametric robot's ground sensors, from 0 (black) to 1 (white); default: white.", |spec, _| Some(&mut spec.as_mut().arena.floor)),
        row("arena.patches", "", Any, OURS,
            "Patches of the floor, discs and rectangles; the last one counts where they overlap.", |spec, _| Some(&mut spec.as_mut().arena.patches)),
        row("arena.patches[].x_mm", "mm", COORDINATE, "",
            "x of a patch's centre.", |spec, index| Some(&mut spec.as_mut().arena.patches.get_mut(index)?.x)),
        row("arena.patches[].y_mm", "mm", COORDINATE, "",
            "y of its centre.", |spec, index| Some(&mut spec.as_mut().arena.patches.get_mut(index)?.y)),
        row("arena.patches[].radius_mm", "mm", LENGTH, "",
            "Radius of a disc.", |spec, index| Some(&mut spec.as_mut().arena.patches.get_mut(index)?.radius)),
        row("arena.patches[].sides_mm", "mm", LENGTH, "",
            "Both sides of a rectangle.", |spec, index| Some(&mut spec.as_mut().arena.patches.get_mut(index)?.sides)),
        row("arena.patches[].heading_turns", "turns", TURNS, "",
            "Direction of a rectangle's first side, counter-clockwise from the x axis.", |spec, index| Some(&mut spec.as_mut().arena.patches.get_mut(index)?.heading)),
        row("arena.patches[].grey", "", Number(0.0, 1.0), "",
            "Its grey: 0 for black, 1 for white.", |spec, index| Some(&mut spec.as_mut().arena.patches.get_mut(index)?.grey)),
        row("arena.patches[].charges", "", Any, "",
            "Whether it charges the battery of a robot whose centre is on it; default: false.", |spec, index| Some(&mut spec.as_mut().arena.patches.get_mut(index)?.charges)),
        row("noise.sensor", "", Number(-1.0, 1.0), "Miglino et al. 1995, section 4",
            "A uniform number from this range is added to each activation; the paper's sensor noise is [0.0, 0.4].", |spec, _| Some(&mut spec.as_mut().noise.sensor)),
        row("noise.walk_range_mm", "mm", Number(0.0, 1000.0), "Miglino et al. 1995, section 4",
            "Conservative noise: perception is displaced by a random walk within plus and minus this; 30 in the paper.", |spec, _| Some(&mut spec.as_mut().noise.walk_range)),
        row("noise.walk_step_mm", "mm", Number(0.0, 2000.0), "ours: \"a small random value\" in Miglino et al. 1995, section 3.2.1",
            "Maximum step of that walk in a cycle, in x and y each; at most twice the range.", |spec, _| Some(&mut spec.as_mut().noise.walk_step)),
        row("noise.motor", "", Number(0.0, 1.0), "ours: no amount in Miglino et al. 1995, section 3.2.2",
            "Relative uniform noise of each cycle's displacement and turn.", |spec, _| Some(&mut spec.as_mut().noise.motor)),
        row("noise.gain", "", Number(0.0, 1.0), OURS,
            "Relative uniform noise of each activation: it is multiplied by 1 plus or minus up to this, before noise.sensor is added; default: 0. With robot.kind = \"sampled\" only, as the next three.", |spec, _| Some(&mut spec.as_mut().noise.gain)),
        row("noise.veer_turns_per_m", "turns/m", Number(0.0, 10.0), OURS,
            "Maximum unwanted turn per metre of a robot's way, as with unequal wheels, uniform to either side; default: 0.", |spec, _| Some(&mut spec.as_mut().noise.veer)),
        row("noise.delay_cycles", "cycles", Number(0.0, 1.0), OURS,
            "Maximum delay of commands, as a fraction of a cycle, uniform; until then the wheels go on as before; default: 0.", |spec, _| Some(&mut spec.as_mut().noise.delay)),
        row("noise.drawn", "", Any, OURS,
            "How often the noise of readings and of motion is drawn (not of the walk: with noise.walk_step_mm = 0 perception stays displaced for an episode); default: cycle.", |spec, _| Some(&mut spec.as_mut().noise.drawn)),
        row("controller.kind", "", Any, "Miglino et al. 1995, section 3.3, figure 5",
            "How genes become wheel commands.", |spec, _| Some(&mut spec.as_mut().controller)),
        row("controller.units", "", Whole(1, episode::GREATEST_HIDDEN.into()), "ours: no hidden layer in Miglino et al. 1995, section 3.3",
            "Hidden units.", |spec, _| match &mut spec.as_mut().controller {
                Controller::Hidden { units } => Some(units),
                _ => None,
            }),
        row("controller.outputs", "", Any, OURS,
            "Source of the two outputs; default: weighted.", |spec, _| Some(&mut network(spec)?.outputs)),
        row("controller.activation", "", Any, OURS,
            "Activation function of weighted outputs; default: logistic.", |spec, _| Some(&mut network(spec)?.activation)),
        row("controller.slope", "", Number(0.001, 1000.0), OURS,
            "Factor of the sum in that function; default: 1.", |spec, _| Some(&mut network(spec)?.slope)),
        row("controller.interleaved", "", Any, OURS,
            "Without layers: whether genes are in the order of the inputs, the left and the right weight of each, as EvoStick has them; default: false.", |spec, _| Some(&mut network(spec)?.interleaved)),
        row("controller.layers", "", Any, OURS,
            "Layers between readings and outputs, in order.", |spec, _| Some(&mut network(spec)?.layers)),
        row("controller.layers[].kind", "", Any, "",
            "What its units are.", |spec, index| Some(&mut network(spec)?.layers.get_mut(index)?.kind)),
        row("controller.layers[].units", "", Whole(1, GREATEST_UNITS.into()), "",
            "Number of units; default: 4.", |spec, index| Some(&mut network(spec)?.layers.get_mut(index)?.units)),
        row("controller.layers[].activation", "", Any, "",
            "Activation function of dense and Elman layers; default: logistic.", |spec, index| Some(&mut network(spec)?.layers.get_mut(index)?.activation)),
        row("controller.layers[].slope", "", Number(0.001, 1000.0), "",
            "Factor of the sum in that function; default: 1.", |spec, index| Some(&mut network(spec)?.layers.get_mut(index)?.slope)),
        row("controller.layers[].biases", "", Any, "",
            "Whether each unit has a bias; default: true.", |spec, index| Some(&mut network(spec)?.layers.get_mut(index)?.biases)),
        row("controller.layers[].time_constants_s", "s", Number(0.1, 1e5), "ours: 0.1 to 5 s",
            "Minimum and maximum time constant of a continuous-time layer.", |spec, index| Some(&mut network(spec)?.layers.get_mut(index)?.time_constants)),
        row("controller.layers[].initial_strengths", "", Number(0.0, 1.0), "Floreano and Urzelai 2000: 0 to 0.1",
            "Minimum and maximum strength of a plastic layer's synapses when an episode begins, drawn for each.", |spec, index| Some(&mut network(spec)?.layers.get_mut(index)?.initial_strengths)),
        row("controller.obstacle", "", Number(0.0, 10.0), "AutoMoDe's program, AutoMoDeBehaviourExploration.cpp, commit 17d758bf",
            "Length of the vector of proximity from which on exploration turns away; default: 0.1.", |spec, _| Some(&mut modules(spec)?.obstacle)),
        row("controller.avoidance", "", Number(0.0, 100.0), "Francesca et al. 2014; AutoMoDe's program, commit 7e0b0c10",
            "Weight of that vector in phototaxis, anti-phototaxis and repulsion; default: 5.", |spec, _| Some(&mut modules(spec)?.avoidance)),
        row("controller.attraction_avoidance", "", Number(0.0, 100.0), "Francesca et al. 2014; AutoMoDe's program, commit c64bb88b",
            "The same in attraction; default: 6.", |spec, _| Some(&mut modules(spec)?.attraction_avoidance)),
        row("controller.least_vector", "", Number(0.001, 10.0), "AutoMoDe's program, commit 7e0b0c10",
            "Robots drive straight ahead instead of along shorter vectors; default: 0.1.", |spec, _| Some(&mut modules(spec)?.least_vector)),
        row("controller.slowest_wheel", "", Number(-1.0, 1.0), "AutoMoDe's program, AutoMoDeBehaviour.cpp, commit 0d870478; other revisions have -1",
            "The inner wheel's minimum speed in a curve, as a fraction of the outer one's; default: -0.5.", |spec, _| Some(&mut modules(spec)?.slowest_wheel)),
        row("task.kind", "", Any, "Miglino et al. 1995, section 3.1, equation 1",
            "What fitness rewards.", |spec, _| Some(&mut spec.as_mut().task)),
        row("task.speed", "", Any, "Miglino et al. 1995, section 5: driving to and fro \"will score relatively high\"",
            "V of equation 1.", |spec, _| match &mut spec.as_mut().task { Task::Avoidance { speed, .. } => Some(speed), _ => None }),
        row("task.difference", "", Any, "Floreano and Mondada, whose formula Miglino et al. 1995 take; their section 3.1, equation 1, prints the square",
            "DV of equation 1.", |spec, _| match &mut spec.as_mut().task { Task::Avoidance { difference, .. } => Some(difference), _ => None }),
        row("task.activation", "", Any, OURS,
            "I of equation 1.", |spec, _| match &mut spec.as_mut().task { Task::Avoidance { activation, .. } => Some(activation), _ => None }),
        row("task.new_cell", "", Number(0.0, 1000.0), "none in Miglino et al. 1995, whose section 5 proposes such a term",
            "Fitness for each cell of 50 mm that a robot enters for the first time; for fields of up to 128 such cells.", |spec, _| match &mut spec.as_mut().task { Task::Avoidance { new_cell, .. } => Some(new_cell), _ => None }),
        row("start.kind", "", Any, "Miglino et al. 1995, section 3.1",
            "Where episodes start.", |spec, _| Some(&mut spec.as_mut().start)),
        row("start.x_mm", "mm", COORDINATE, "",
            "x of the start.", |spec, _| match &mut spec.as_mut().start { Start::At { x, .. } => Some(x), Start::Zone(zone) => Some(&mut zone.x), _ => None }),
        row("start.y_mm", "mm", COORDINATE, "",
            "y of the start.", |spec, _| match &mut spec.as_mut().start { Start::At { y, .. } => Some(y), Start::Zone(zone) => Some(&mut zone.y), _ => None }),
        row("start.heading_turns", "turns", TURNS, OURS,
            "Heading at the start, counter-clockwise from the x axis.", |spec, _| match &mut spec.as_mut().start { Start::At { heading, .. } => Some(heading), _ => None }),
        row("start.poses", "mm, mm, turns", Text("1 to 1000 lists of three numbers: x and y in mm, and the heading in turns, -1 to 1"), OURS,
            "Poses, of which trial after trial takes the next one; in a swarm, one for each robot.", |spec, _| match &mut spec.as_mut().start { Start::Poses(poses) => Some(poses), _ => None }),
        row("start.sides_mm", "mm", LENGTH, OURS,
            "Sides of a rectangular zone, along the axes.", |spec, _| Some(&mut zone(spec)?.sides)),
        row("start.radius_mm", "mm", LENGTH, OURS,
            "Radius of a round zone.", |spec, _| Some(&mut zone(spec)?.radius)),
        row("start.inner_radius_mm", "mm", LENGTH, OURS,
            "Radius around its middle that a round zone leaves out; default: none.", |spec, _| Some(&mut zone(spec)?.inner)),
        row("start.patch", "", Whole(0, GREATEST_PATCHES as u64 - 1), OURS,
            "Number of a patch of the floor that is the zone, from 0, such as a nest.", |spec, _| Some(&mut zone(spec)?.patch)),
        row("worlds.vary", "", Text("for keys of numbers of arena, noise, pucks, robot and start, their ranges, [minimum, maximum]"), OURS,
            "Numbers drawn for each of the worlds, uniformly; a key with [] stands for each element of its list.", |spec, _| Some(&mut spec.as_mut().varied.vary)),
        row("worlds.choose", "", Text("for such keys, lists of values"), OURS,
            "Numbers of which each of the worlds takes one at random.", |spec, _| Some(&mut spec.as_mut().varied.choose)),
        row("worlds.count", "", Whole(1, GREATEST_DRAWN.into()), OURS,
            "Number of worlds drawn, of which each trial of a generation takes one at random; default: 100.", |spec, _| Some(&mut spec.as_mut().varied.count)),
        row("worlds.seed", "", Whole(0, i64::MAX as u64), OURS,
            "Seed of these worlds: another one gives other worlds; default: 0.", |spec, _| Some(&mut spec.as_mut().varied.seed)),
    ];
    let mut foragers = foraging::parameters();
    foragers.extend([
        row("arena.light", "", Any, "O'Dowd et al. 2014, Figure 2",
            "Where the lamp is.", |spec: &mut T, _| Some(&mut spec.as_foraging()?.light)),
        row("arena.food_earns_s", "s", Number(0.1, 1e5), "O'Dowd et al. 2014, section 4.5: an evaluation",
            "Time from the start of an episode in which food counts: it earns the remaining seconds.", |spec, _| match &mut spec.as_mut().robot.build {
                Build::Forager(forager) => Some(&mut forager.food_earns),
                _ => None,
            }),
    ]);
    foragers.retain(|forager| rows.iter().all(|row| row.key != forager.key));
    rows.extend(foragers);
    rows
}

/// The zone that robots start in.
fn zone<T: AsMut<WorldSpec>>(spec: &mut T) -> Option<&mut Zone> {
    match &mut spec.as_mut().start {
        Start::Zone(zone) => Some(zone),
        _ => None,
    }
}

impl AsForaging for WorldSpec {
    fn as_foraging(&mut self) -> Option<&mut Foraging> {
        match &mut self.robot.build {
            Build::Forager(forager) => Some(&mut forager.foraging),
            _ => None,
        }
    }
}

/// The robot, if it is described rather than sampled.
fn described<T: AsMut<WorldSpec>>(spec: &mut T) -> Option<&mut Differential> {
    match &mut spec.as_mut().robot.build {
        Build::Sampled | Build::Forager(_) => None,
        Build::Differential(robot) => Some(robot),
    }
}

/// The controller, if it is a network described by its layers.
fn network<T: AsMut<WorldSpec>>(spec: &mut T) -> Option<&mut Network> {
    match &mut spec.as_mut().controller {
        Controller::Network(network) => Some(network),
        _ => None,
    }
}

/// The modules of the controller, if it is made of them.
fn modules<T: AsMut<WorldSpec>>(spec: &mut T) -> Option<&mut Modules> {
    match &mut spec.as_mut().controller {
        Controller::StateMachine(modules) | Controller::BehaviourTree(modules) => Some(modules),
        _ => None,
    }
}

/// Rows for worlds by themselves.
pub(super) static PARAMETERS: LazyLock<Vec<Parameter<WorldSpec>>> = LazyLock::new(parameters);

impl AsMut<Self> for WorldSpec {
    fn as_mut(&mut self) -> &mut Self {
        self
    }
}

impl Choice for Controller {
    const CHOICES: Choices<Self> = &[
        (
            "perceptron",
            Self::Perceptron,
            "readings to 2 logistic outputs: 18 genes for 8 readings",
        ),
        (
            "hidden",
            Self::Hidden { units: 4 },
            "a layer of logistic units between: 11 genes a unit for 8 readings, and 2",
        ),
        (
            "recurrent",
            Self::Recurrent,
            "both outputs are fed back as inputs: 22 genes for 8 readings",
        ),
        (
            "network",
            Self::Network(Network {
                layers: Vec::new(),
                outputs: None,
                activation: None,
                slope: None,
                interleaved: None,
            }),
            "a network of the layers listed: see docs/controllers.md",
        ),
        (
            "state-machine",
            Self::StateMachine(Modules::DEFAULT),
            "a probabilistic finite state machine of AutoMoDe's modules: 97 genes; see docs/controllers.md",
        ),
        (
            "behaviour-tree",
            Self::BehaviourTree(Modules::DEFAULT),
            "a behaviour tree of the same modules: 29 genes; see docs/controllers.md",
        ),
        (
            "behaviours",
            Self::Behaviours,
            "a forager's: 2 genes choose what it does with food and without: see docs/epuck.md",
        ),
        ("own", Self::Own, "a custom controller, in WGSL: see docs/extend.md"),
    ];
}

impl Choice for Task {
    const CHOICES: Choices<Self> = &[
        (
            "avoidance",
            Self::AVOIDANCE,
            "the sum over an episode's cycles of V (1 - sqrt(DV)) (1 - I), and 0 for a cycle that ends in a collision: equation 1 of Miglino et al. 1995 with other choices, see docs/miglino1995.md",
        ),
        (
            "foraging",
            Self::Foraging,
            "a forager's: the seconds left when food is brought to the nest",
        ),
        (
            "reach",
            Self::Reach,
            "get to a patch of the floor: this and the next nine are in docs/tasks.md",
        ),
        ("visit", Self::Visit, "visit all patches of the floor in their order"),
        (
            "collect",
            Self::Collect,
            "bring food from patches of the floor to one that is the nest",
        ),
        ("cover", Self::Cover, "get everywhere"),
        (
            "follow-line",
            Self::FollowLine,
            "drive forwards on the dark patches of the floor",
        ),
        (
            "follow-wall",
            Self::FollowWall,
            "drive along walls, obstacles and blocks",
        ),
        ("stay-together", Self::StayTogether, "a swarm's: be in one cluster"),
        ("phototaxis", Self::Phototaxis, "get to a light and stay there"),
        ("gather-pucks", Self::GatherPucks, "a swarm's: push pucks together"),
        (
            "bring-pucks",
            Self::BringPucks,
            "a swarm's: bring pucks to a patch of the floor",
        ),
        ("own", Self::Own, "a custom task, in WGSL: see docs/extend.md"),
    ];
}

impl Choice for Speed {
    const CHOICES: Choices<Self> = &[
        (
            "unsigned",
            Self::Unsigned,
            "(|left| + |right|) / 2: driving backwards counts like driving forwards",
        ),
        ("signed", Self::Signed, "(left + right) / 2"),
    ];
}

impl Choice for Difference {
    const CHOICES: Choices<Self> = &[
        ("root", Self::Root, "1 - sqrt(DV)"),
        ("square", Self::Square, "1 - DV^2"),
    ];
}

impl Choice for Activation {
    const CHOICES: Choices<Self> = &[
        ("real", Self::Real, "the maximum activation without the added noise"),
        ("perceived", Self::Perceived, "the maximum activation with its noise"),
        ("none", Self::None, "no term for it"),
    ];
}

impl Choice for Start {
    const CHOICES: Choices<Self> = &[
        ("random", Self::Random, "a free pose for each episode"),
        (
            "at",
            Self::At {
                x: f32::NAN,
                y: f32::NAN,
                heading: 0.0,
            },
            "one pose for all episodes",
        ),
        (
            "poses",
            Self::Poses(Poses(Vec::new())),
            "a list of poses, one for each trial",
        ),
        (
            "zone",
            Self::Zone(Zone {
                x: None,
                y: None,
                sides: None,
                radius: None,
                inner: None,
                patch: None,
            }),
            "a free pose in a part of the arena",
        ),
    ];
}
