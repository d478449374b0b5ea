//! The world of a rollout: robot, arena, noise, controller, task and start as plain data, and the validated [`World`]
//! that is made from them.

pub mod arena;
pub(crate) mod check;
pub mod differential;
mod noise;
mod pack;
mod parameters;
mod reach;
pub mod reference;
pub mod surrogate;
pub mod tables;

use std::ops::Range;
use std::sync::Arc;

use oneiro_shaders::{Kernel, life};

use crate::batch::{Buffers, WorldKind, Worlds};
use crate::foragers::foraging::{self, Forager};
use crate::genes::PREVIOUS;
use crate::parameter::Invalid;
use crate::parts::automode::{self, Modules};
use crate::parts::compose::{self, Composed, Detail, GREATEST_GENES, Kind, Lives, OwnPart, OwnParts};
use crate::parts::network::Network;
use crate::world::arena::Arena;
use crate::world::differential::{Build, Genomes, Sensor};
use crate::world::surrogate::Surrogate;
use crate::world::tables::{MotorStates, MotorTable, SENSOR_NAMES, SensorTables};

pub use crate::genes::{Gene, GeneKind, GeneLayout};
pub use noise::{Drawn, Noise};
pub use parameters::{COORDINATE, LENGTH, parameters};

/// A robot with two wheels.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// Radius of the round body, mm. Khepera: 27.5 (Miglino et al. 1995).
    pub body_radius: f32,
    /// Measured readings of its proximity sensors; of a described robot those of its sensors of the kind sampled.
    pub sensors: Arc<SensorTables>,
    /// Measured motions of its motors; of a described robot if it has no wheels of its own.
    pub motors: Arc<MotorTable>,
    /// Share of a cycle's turn made before its displacement, 0 to 1. With 0 it moves along the old heading. Described robots
    /// have their own.
    pub turn_before_move: f32,
    /// Effect of a collision.
    pub collision: Collision,
    /// Whether sensors and motors are those that were sampled, or described.
    pub build: Build,
}

/// Effect of a collision: a cycle after which the robot's body would touch something. Such a cycle earns nothing in any
/// case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Collision {
    /// Undoes both move and turn, as Evorobot does: without noise, a robot that touches something stays where it is.
    #[default]
    Undo,
    /// Keeps the turn and undoes the move.
    KeepTurn,
    /// Lets the body slide along what it would touch, and turn. In a corner it stops.
    Slide,
    /// Lets the body move into contact, and stick there for the rest of its life, as Kheperax does.
    Stick,
}

impl Robot {
    /// The compiled-in Khepera with its symmetric motor states.
    pub fn khepera() -> Self {
        Self {
            body_radius: 27.5,
            sensors: SensorTables::khepera(),
            motors: MotorTable::khepera(MotorStates::Symmetric20),
            turn_before_move: 0.0,
            collision: Collision::Undo,
            build: Build::Sampled,
        }
    }

    /// Number of such robots that live together in one world, if they do.
    pub(crate) fn members(&self) -> Option<u32> {
        self.build.members()
    }

    /// Whether robots that live together start at places of their own.
    pub fn has_starts(&self) -> bool {
        !self.start_places().is_empty()
    }

    /// Where robots that live together start, if that is given: x and y of each, mm.
    pub(crate) fn start_places(&self) -> &[[f32; 2]] {
        match &self.build {
            Build::Sampled | Build::Forager(_) => &[],
            Build::Differential(own) => own.start_places(),
        }
    }

    /// The sensors of a described robot, in the order of their readings; none of a sampled one.
    pub fn described_sensors(&self) -> &[Sensor] {
        match &self.build {
            Build::Sampled | Build::Forager(_) => &[],
            Build::Differential(own) => &own.sensors,
        }
    }

    /// The tables that its sensors read, if any does.
    pub fn tables(&self) -> Option<&SensorTables> {
        match &self.build {
            Build::Differential(own) if !own.has_sampled_sensors() => None,
            Build::Forager(_) => None,
            _ => Some(&self.sensors),
        }
    }
}

/// Mapping from sensors to wheel commands, with weights and biases as genes.
#[derive(Clone, Debug, PartialEq)]
pub enum Controller {
    /// All readings to 2 logistic outputs: 18 genes for 8 readings.
    Perceptron,
    /// All readings to `units` hidden logistic units to 2 logistic outputs: `11 units + 2` genes for 8 readings.
    Hidden {
        /// Number of hidden units, 1 to 32.
        units: u32,
    },
    /// All readings and the 2 previous outputs to 2 logistic outputs: 22 genes for 8 readings.
    Recurrent,
    /// A network that is described by its layers. Needs the feature `compose`.
    Network(Network),
    /// A probabilistic finite state machine of `AutoMoDe`'s modules: 97 genes. Only for [`Model::Vectors`]. Needs the feature
    /// `compose`.
    ///
    /// [`Model::Vectors`]: crate::reference::Model::Vectors
    StateMachine(Modules),
    /// A behaviour tree of the same modules: 29 genes. Likewise.
    BehaviourTree(Modules),
    /// A forager's behaviours: 2 genes choose between seeking the light, fleeing it and searching at random, with food and
    /// without. Only for [`Build::Forager`].
    Behaviours,
    /// A user's controller, in [`WorldSpec::own`].
    Own,
}

impl Controller {
    /// Genes of a controller with these readings, unless it is a user's.
    fn genes(&self, readings: &[String]) -> Vec<Gene> {
        const OUTPUTS: [&str; 2] = ["left", "right"];
        let weights = |inputs: &[String], to: &str| -> Vec<Gene> {
            let weights = inputs.iter().map(|input| format!("{input}_to_{to}"));
            weights.chain([format!("bias_{to}")]).map(Gene::new).collect()
        };
        match self {
            Self::Perceptron => OUTPUTS.iter().flat_map(|to| weights(readings, to)).collect(),
            Self::Hidden { units } => {
                let unit = |unit: u32| {
                    let to_outputs = OUTPUTS.map(|to| Gene::new(format!("unit_{unit}_to_{to}")));
                    weights(readings, &format!("unit_{unit}")).into_iter().chain(to_outputs)
                };
                let biases = OUTPUTS.map(|to| Gene::new(format!("bias_{to}")));
                (0..*units).flat_map(unit).chain(biases).collect()
            }
            Self::Recurrent => {
                let inputs = [readings, &PREVIOUS.map(str::to_owned)].concat();
                OUTPUTS.iter().flat_map(|to| weights(&inputs, to)).collect()
            }
            Self::Network(network) => network.genes(readings),
            Self::StateMachine(_) => automode::machine_genes(),
            Self::BehaviourTree(_) => automode::tree_genes(),
            Self::Behaviours => foraging::genes(),
            Self::Own => Vec::new(),
        }
    }

    /// Genes of a shipped controller that reads the eight sampled sensors of proximity.
    pub fn layout(&self) -> GeneLayout {
        GeneLayout::new(self.genes(&SENSOR_NAMES.map(str::to_owned)))
    }
}

/// The role of speed in equation 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Speed {
    /// `(|left| + |right|) / 2`: driving backwards earns as much as driving forwards.
    Unsigned,
    /// `(left + right) / 2`.
    Signed,
}

/// Power of the wheels' difference in equation 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Difference {
    /// `1 - sqrt(DV)`, as in Floreano and Mondada and in Evorobot.
    Root,
    /// `1 - DV^2`, as printed in the 1995 paper.
    Square,
}

/// Activation that counts in equation 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activation {
    /// Without the added sensor noise.
    Real,
    /// With the added sensor noise.
    Perceived,
    /// No sensor term (the two-term formula of Jakobi et al. 1995).
    None,
}

/// Task that fitness measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Task {
    /// A user's task, in [`WorldSpec::own`].
    Own,
    /// The seconds that are left when food is brought to the nest: equation 1 of O'Dowd et al. 2014. Only for
    /// [`Build::Forager`].
    Foraging,
    /// Equation 1 of Miglino et al. 1995, summed over the cycles of a life.
    Avoidance {
        /// Signed or unsigned V.
        speed: Speed,
        /// Root or square of DV.
        difference: Difference,
        /// Activation in (1 - I).
        activation: Activation,
        /// Additional value of each 50 mm cell that the robot's centre enters for the first time, 0 to 1000. The
        /// paper's conclusion proposes such a term, only for simulations, where the robot's position is known. Must be
        /// 0 for fields of more than 128 cells.
        new_cell: f32,
    },
}

impl Task {
    /// Equation 1 with unsigned V, the root of DV and the activation without added noise.
    pub const AVOIDANCE: Self = Self::Avoidance {
        speed: Speed::Unsigned,
        difference: Difference::Root,
        activation: Activation::Real,
        new_cell: 0.0,
    };

    /// Sets the value of a new cell, if the task has one.
    #[must_use]
    pub fn with_new_cell(mut self, value: f32) -> Self {
        if let Self::Avoidance { new_cell, .. } = &mut self {
            *new_cell = value;
        }
        self
    }
}

/// Start of a life.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// A free pose, drawn uniformly over the arena's field and all headings with the rollout's own key.
    Random,
    /// A fixed pose: x and y in mm, heading in turns counter-clockwise from the x axis.
    At {
        /// x in mm.
        x: f32,
        /// y in mm.
        y: f32,
        /// Heading in turns, -1 to 1; a world has it from 0 to less than 1.
        heading: f32,
    },
}

/// Everything about a life except genes and seed.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldSpec {
    /// The body, its sensors and motors.
    pub robot: Robot,
    /// The individual that lives, by its own physics. `None`: the simulator made from the robot's tables or description.
    pub surrogate: Option<Arc<Surrogate>>,
    /// Walls and obstacles.
    pub arena: Arena,
    /// Noise of the simulation.
    pub noise: Noise,
    /// Mapping from sensors to wheel commands.
    pub controller: Controller,
    /// Task that fitness measures.
    pub task: Task,
    /// Sensors that a user wrote, the controller if `controller` is [`Controller::Own`], and the task if `task` is
    /// [`Task::Own`].
    pub own: OwnParts,
    /// Start of lives.
    pub start: Start,
    /// Length of a life in cycles of 100 ms, 1 to 1,000,000.
    pub cycles: u32,
}

impl WorldSpec {
    /// The main conditions of Miglino et al. 1995, without noise: a Khepera, its arena with three obstacles, a
    /// perceptron, 500 cycles from a random free pose.
    pub fn miglino1995() -> Self {
        Self {
            robot: Robot::khepera(),
            surrogate: None,
            arena: Arena::miglino1995(),
            noise: Noise::NONE,
            controller: Controller::Perceptron,
            task: Task::AVOIDANCE,
            own: OwnParts::default(),
            start: Start::Random,
            cycles: 500,
        }
    }

    /// A forager in its arena, with its behaviours, its task and the start and the length of its lives.
    pub fn foraging(forager: Forager) -> Self {
        let own = forager.foraging;
        Self {
            robot: Robot {
                body_radius: own.body_radius,
                build: Build::Forager(forager),
                ..Robot::khepera()
            },
            arena: Arena::default(),
            controller: Controller::Behaviours,
            task: Task::Foraging,
            start: own
                .start
                .map_or(Start::Random, |[x, y, heading]| Start::At { x, y, heading }),
            cycles: own.cycles,
            ..Self::miglino1995()
        }
    }

    /// Names of all readings: the robot's, then those of a user's sensors.
    fn readings(&self) -> Vec<String> {
        self.own.readings_of(&self.robot.build)
    }
}

/// A checked world, ready for lives. Cheap to clone.
#[derive(Clone, Debug)]
pub struct World(Arc<Checked>);

#[derive(Debug)]
struct Checked {
    spec: WorldSpec,
    kernel: &'static Kernel,
    genes: GeneLayout,
    details: Vec<Detail>,
    /// Words of a world of several robots.
    words: Option<u32>,
    /// Lines of a record in its traces.
    lines: u32,
    packed: pack::Packed,
}

impl World {
    /// Checks every number and prepares the kernels' data.
    ///
    /// ```
    /// use oneiro::world::{World, WorldSpec};
    ///
    /// let world = World::new(WorldSpec { cycles: 100, ..WorldSpec::miglino1995() })?;
    /// assert_eq!(world.genes(), 18);
    ///
    /// let error = World::new(WorldSpec { cycles: 0, ..WorldSpec::miglino1995() }).unwrap_err();
    /// assert_eq!(error.to_string(), "cycles: is 0; allowed: 1 to 1000000");
    /// # Ok::<(), oneiro::parameter::Invalid>(())
    /// ```
    ///
    /// # Errors
    /// The first invalid value: its path, the value itself, and the allowed values.
    pub fn new(spec: WorldSpec) -> Result<Self, Invalid> {
        let lives = match (&spec.surrogate, &spec.robot.build) {
            (Some(_), Build::Differential(_)) => Lives::Individual,
            _ => Lives::Simulated,
        };
        Self::composed(spec, lives)
    }

    /// The same, with a kernel in which robots live so.
    pub(crate) fn composed(mut spec: WorldSpec, lives: Lives) -> Result<Self, Invalid> {
        check::check(&mut spec)?;
        let readings = spec.readings();
        let parts = match &spec.controller {
            Controller::Network(network) => spec.own.with_network(network, &spec.robot.build)?,
            Controller::StateMachine(modules) => spec.own.with_state_machine(modules)?,
            Controller::BehaviourTree(modules) => spec.own.with_behaviour_tree(modules)?,
            _ => spec.own.clone(),
        };
        let together = spec.robot.members().is_some();
        if together && ![Lives::Simulated, Lives::Observed].contains(&lives) {
            let problem = "is given; allowed: only in the simulator, where all robots live together";
            return Err(Invalid::new("robot.count", problem));
        }
        let Composed {
            kernel, genes, words, ..
        } = parts.compose(kernel(&spec), &spec, lives)?;
        let members = spec.robot.members().unwrap_or(0);
        let genes = match (&spec.controller, genes) {
            (Controller::Own, Some(own)) => own.to_vec(),
            (controller, _) => controller.genes(&readings),
        };
        let packed = pack::Packed::new(&spec, &parts, genes.len())?;
        let world = Self(Arc::new(Checked {
            genes: layout(genes, &spec.robot.build)?,
            details: parts.details(&spec.robot.build, lives),
            lines: if lives == Lives::Observed { members } else { 1 },
            words: words.map(|[world, member]| world + members * member),
            spec,
            kernel,
            packed,
        }));
        if world.kernel().variants.is_empty() {
            // The turns of its loops depend on the world.
            Worlds::new(&[&world]).map_err(|invalid| {
                let key = key_of_turns(world.spec(), &parts);
                Invalid::new(key, compose::too_many_turns(&invalid.problem))
            })?;
        }
        Ok(world)
    }

    /// The same world of robots that live together, observed: its lives have the same bits, and each record of their traces has a
    /// line for each robot, which [`Trace::by_robot`](crate::batch::Trace::by_robot) takes apart. The records' fitness is that of a
    /// life that ends there.
    ///
    /// # Errors
    /// Robots that don't live together; loops that turn too often, as for [`World::new`].
    pub fn observed(&self) -> Result<Self, Invalid> {
        if self.0.spec.robot.members().is_none() {
            let problem = "is not given; allowed: only robots that live together are observed";
            return Err(Invalid::new("robot.count", problem));
        }
        Self::composed(self.0.spec.clone(), Lives::Observed)
    }

    /// Specification that it was made from.
    pub fn spec(&self) -> &WorldSpec {
        &self.0.spec
    }

    /// Number of genes of a controller that lives in it.
    pub fn genes(&self) -> usize {
        self.0.genes.genes()
    }

    /// Details of each record in a trace of its lives.
    pub fn details(&self) -> &[Detail] {
        &self.0.details
    }

    /// Genes of its controller.
    pub fn gene_layout(&self) -> &GeneLayout {
        &self.0.genes
    }

    /// A robot's part of a genome; robots of a team have the same.
    pub fn genes_of(&self, robot: u32) -> Range<usize> {
        let (genes, genome) = (
            self.0.genes.controller().len(),
            self.0.spec.robot.build.genomes().of(robot),
        );
        let first = genome as usize * genes;
        first..first + genes
    }

    /// Number of cycles of a life.
    pub fn cycles(&self) -> u32 {
        self.0.spec.cycles
    }

    /// Number of robots that live in it together; 1 of a single robot.
    pub fn robots(&self) -> u32 {
        self.0.spec.robot.members().unwrap_or(1)
    }

    /// Whether walls and objects keep a robot within the arena, as far as a grid of half the body's radius shows; `None` if the
    /// arena is too large for such a grid.
    pub fn is_enclosed(&self) -> Option<bool> {
        reach::is_enclosed(self.spec())
    }

    /// Keys of the walls, obstacles, blocks and patches that no robot gets near enough to notice, such as `arena.patches[2]`, and of
    /// starts outside of the arena (`start`, `robot.starts_mm`), as far as the same grid shows. None in an arena that is too large for
    /// it, and none of a forager's.
    pub fn unreached(&self) -> Vec<String> {
        reach::unreached(self.spec())
    }

    /// Estimated share of the field, 0 to 1, where a robot's body touches nothing.
    pub fn free_share(&self) -> f32 {
        self.0.packed.free_share
    }

    /// Kernel that simulates it.
    pub fn kernel(&self) -> &'static Kernel {
        self.0.kernel
    }
}

/// Genes of all controllers of a world.
fn layout(controller: Vec<Gene>, robot: &Build) -> Result<GeneLayout, Invalid> {
    let names = robot.genomes().names(robot.members().unwrap_or(1));
    if names.is_empty() {
        return Ok(GeneLayout::new(controller));
    }
    let [genomes, genes] = [names.len(), controller.len()];
    if genomes * genes > GREATEST_GENES as usize {
        let problem = format!(
            "makes {genomes} genomes of {genes} genes each, {}; allowed: up to {GREATEST_GENES} genes in all, with fewer teams or a \
             smaller controller",
            genomes * genes
        );
        return Err(Invalid::new("robot.genomes", problem));
    }
    Ok(GeneLayout::several(controller, &names))
}

/// The key of what makes a cycle's loops turn too often: the robot's sensors, if they do so without these parts, which are a
/// user's and a network.
fn key_of_turns(spec: &WorldSpec, parts: &OwnParts) -> String {
    let without = || {
        let mut own = WorldSpec {
            controller: Controller::Perceptron,
            task: Task::AVOIDANCE,
            own: OwnParts::default(),
            ..spec.clone()
        };
        if let Build::Differential(robot) = &mut own.robot.build {
            robot.genomes = Genomes::Homogeneous;
        }
        own
    };
    match spec.own.iter().last().or(parts.iter().last()) {
        Some(own) if World::new(without()).is_ok() => own.key(),
        _ => "robot.sensors".to_owned(),
    }
}

/// The shipped kernel of a world, with a perceptron in place of a controller that is composed.
fn kernel(spec: &WorldSpec) -> &'static Kernel {
    // A described robot's surrogate is composed from the simulator's parts.
    let surrogate = spec.surrogate.as_ref().filter(|_| spec.robot.build == Build::Sampled);
    match (&spec.controller, surrogate) {
        (Controller::Hidden { .. }, None) => &oneiro_shaders::LIFE_HIDDEN,
        (Controller::Recurrent, None) => &oneiro_shaders::LIFE_RECURRENT,
        (_, None) => &oneiro_shaders::LIFE_PERCEPTRON,
        (Controller::Hidden { .. }, Some(_)) => &oneiro_shaders::SURROGATE_HIDDEN,
        (Controller::Recurrent, Some(_)) => &oneiro_shaders::SURROGATE_RECURRENT,
        (_, Some(_)) => &oneiro_shaders::SURROGATE_PERCEPTRON,
    }
}

impl WorldKind for World {
    /// A world was checked when it was made.
    fn check(&self) -> Result<(), Invalid> {
        Ok(())
    }

    fn kernel(&self) -> &'static Kernel {
        self.kernel()
    }

    fn genes(&self) -> usize {
        self.genes()
    }

    fn robots(&self) -> u32 {
        self.robots()
    }

    fn state_words(&self) -> u32 {
        let own = (self.0.kernel.stride("state") / size_of::<u32>()) as u32;
        self.0.words.unwrap_or(own)
    }

    fn record_words(&self) -> u32 {
        self.0.lines * (self.0.kernel.stride("trace") / size_of::<u32>()) as u32
    }

    fn may_end_early(&self) -> bool {
        let WorldSpec { own, robot, .. } = &self.0.spec;
        let task = own.get(Kind::Task).map(OwnPart::part);
        if self.0.words.is_some() {
            return task.is_some_and(|part| part.functions().contains(&"mission_ends"));
        }
        task.is_some() || robot.build.may_end_life()
    }

    fn pack(&self, buffers: &mut Buffers) -> life::World {
        let Checked { spec, packed, .. } = &*self.0;
        packed.in_buffers(spec, buffers)
    }
}
