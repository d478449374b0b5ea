//! An experiment's values: what may stand in its TOML file, and what holds where nothing does. The defaults are the
//! study of Miglino, Lund and Nolfi, "Evolving mobile robots in simulated and real environments", Artificial Life
//! 2(4), 1995, without noise; where the paper leaves a choice open, the comment says what was chosen and why.

use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer, Serialize};

/// A whole experiment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Settings {
    /// What runs are called; the file's name where it is not given.
    pub(crate) name: String,
    /// The run's seed where the command line gives none; one is drawn where neither does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) seed: Option<u64>,
    /// Length of a life, cycles of 100 ms: 500 in the paper.
    pub(crate) cycles: u32,
    /// Lives of each individual in each generation: 1 in the paper.
    pub(crate) trials: u32,
    /// What several lives count as.
    pub(crate) trial_score: TrialScore,
    /// The body.
    pub(crate) robot: Robot,
    /// What stands around it.
    pub(crate) arena: Arena,
    /// The noise of the simulation.
    pub(crate) noise: Noise,
    /// How genes become wheel commands.
    pub(crate) controller: Controller,
    /// What fitness is given for.
    pub(crate) task: Task,
    /// Where lives start.
    pub(crate) start: Start,
    /// The genetic algorithm.
    pub(crate) evolution: Evolution,
    /// What a run writes, and when.
    pub(crate) record: Record,
    /// BLAKE3 hashes of the files that are named above, checked where they are given. A run's own `config.toml` has
    /// them all.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub(crate) files: BTreeMap<String, String>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            name: String::new(),
            seed: None,
            cycles: 500,
            trials: 1,
            trial_score: TrialScore::Mean,
            robot: Robot::default(),
            arena: Arena::default(),
            noise: Noise::default(),
            controller: Controller::default(),
            task: Task::default(),
            start: Start::default(),
            evolution: Evolution::default(),
            record: Record::default(),
            files: BTreeMap::new(),
        }
    }
}

/// What several lives of one individual count as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum TrialScore {
    /// The mean of their fitness.
    Mean,
    /// The least of their fitness.
    Least,
}

/// The body, its sensors and motors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Robot {
    /// Radius of the round body: 27.5 mm, half of the paper's 55 mm.
    pub(crate) body_radius_mm: f64,
    /// Sensor tables: those compiled in, a Khepera synthesised from published statistics, or a file for each class
    /// of object.
    pub(crate) tables: SensorFiles,
    /// Motor table: the one compiled in (0.82 mm per unit of speed and cycle, as Evorobot's), or a file.
    pub(crate) motors: String,
    /// Which of the sampled speeds are a wheel's states. The paper says 20 x 20.
    pub(crate) states: MotorStates,
    /// Share of a cycle's turn that is made before its displacement: 0, as Evorobot moves.
    pub(crate) turn_before_move: f64,
}

/// The name of the tables that are compiled in.
pub(crate) const BUILT_IN: &str = "khepera";

impl Default for Robot {
    fn default() -> Self {
        Self {
            body_radius_mm: 27.5,
            tables: SensorFiles::BuiltIn,
            motors: BUILT_IN.into(),
            states: MotorStates::Symmetric,
            turn_before_move: 0.0,
        }
    }
}

/// Where sensor tables come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum SensorFiles {
    /// `"khepera"`
    BuiltIn,
    /// `["wall.sam", "round.sam"]`
    Files(Vec<String>),
}

impl Serialize for SensorFiles {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::BuiltIn => serializer.serialize_str(BUILT_IN),
            Self::Files(files) => files.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for SensorFiles {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl<'de> serde::de::Visitor<'de> for Visitor {
            type Value = SensorFiles;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                write!(f, "\"{BUILT_IN}\" or a list of files")
            }

            fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<SensorFiles, E> {
                if name == BUILT_IN {
                    Ok(SensorFiles::BuiltIn)
                } else {
                    Err(E::invalid_value(serde::de::Unexpected::Str(name), &self))
                }
            }

            fn visit_seq<A: serde::de::SeqAccess<'de>>(self, list: A) -> Result<SensorFiles, A::Error> {
                Vec::deserialize(serde::de::value::SeqAccessDeserializer::new(list)).map(SensorFiles::Files)
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

/// A wheel's states.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum MotorStates {
    /// -10 to 10 without 0. The default: no way of driving is faster than its reverse, so that driving backwards pays
    /// no better.
    Symmetric,
    /// -10 to 9.
    Asymmetric,
    /// -10 to 10, 21 states, as Evorobot has it.
    Evorobot,
}

/// Walls, obstacles and blocks: an arena of the catalogue, or one's own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Arena {
    /// A name of the catalogue. `miglino1995`, 600 x 350 mm with three obstacles, where nothing else is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) preset: Option<String>,
    /// Width of one's own arena; its lower left corner is at (0, 0).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) width_mm: Option<f64>,
    /// Its height.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) height_mm: Option<f64>,
    /// Its walls; the four sides, of the class `wall`, where none are given.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) walls: Vec<Wall>,
    /// Its round obstacles.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) obstacles: Vec<Obstacle>,
    /// Its rectangular obstacles.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) blocks: Vec<Block>,
}

/// A wall, at any angle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Wall {
    /// x and y of one end.
    #[serde(deserialize_with = "pair")]
    pub(crate) from_mm: [f64; 2],
    /// x and y of the other.
    #[serde(deserialize_with = "pair")]
    pub(crate) to_mm: [f64; 2],
    /// Class of object, by which the sensor table is chosen.
    #[serde(default = "wall")]
    pub(crate) class: String,
}

/// A round obstacle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Obstacle {
    /// x of the centre.
    pub(crate) x_mm: f64,
    /// y of the centre.
    pub(crate) y_mm: f64,
    /// The paper's obstacles have 27.5 mm.
    pub(crate) radius_mm: f64,
    /// Class of object, by which the sensor table is chosen.
    #[serde(default = "round")]
    pub(crate) class: String,
}

/// A rectangular obstacle, at any angle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Block {
    /// x of the centre.
    pub(crate) x_mm: f64,
    /// y of the centre.
    pub(crate) y_mm: f64,
    /// One side.
    pub(crate) length_mm: f64,
    /// The other.
    pub(crate) width_mm: f64,
    /// The direction of its length, counter-clockwise from the x axis, 0 to 1.
    #[serde(default)]
    pub(crate) heading_turns: f64,
    /// Class of object, by which the sensor table is chosen. None is compiled in: `oneiro sample` makes one.
    #[serde(default = "block")]
    pub(crate) class: String,
}

fn wall() -> String {
    "wall".into()
}

fn round() -> String {
    "round".into()
}

fn block() -> String {
    "block".into()
}

/// Noise. The default is the paper's condition without any; its other two are `sensor = [0.0, 0.4]` and
/// `walk_range_mm = 30`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Noise {
    /// A uniform number from this range is added to each activation, which is then clipped to 0 to 1.
    #[serde(deserialize_with = "pair")]
    pub(crate) sensor: [f64; 2],
    /// Conservative noise: what is perceived is displaced by a walk within plus and minus this.
    pub(crate) walk_range_mm: f64,
    /// Greatest step of that walk in a cycle, x and y each. The paper says "a small random value"; 1.5 is our choice.
    pub(crate) walk_step_mm: f64,
    /// Relative uniform noise on displacement and turn. The paper gives no amount; none is our choice.
    pub(crate) motor: f64,
}

impl Default for Noise {
    fn default() -> Self {
        Self {
            sensor: [0.0, 0.0],
            walk_range_mm: 0.0,
            walk_step_mm: 1.5,
            motor: 0.0,
        }
    }
}

/// The controller.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Controller {
    /// Its kind: the paper's is a perceptron.
    pub(crate) kind: ControllerKind,
    /// Hidden units, for the kind that has them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) units: Option<u32>,
}

impl Default for Controller {
    fn default() -> Self {
        Self {
            kind: ControllerKind::Perceptron,
            units: None,
        }
    }
}

/// Hidden units where none are given: a choice of ours, the paper has no hidden layer.
pub(crate) const DEFAULT_UNITS: u32 = 4;

/// The controllers of the catalogue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum ControllerKind {
    /// 8 inputs, 2 logistic outputs: 18 genes.
    Perceptron,
    /// A layer of logistic units between: 11 genes a unit, and 2.
    Hidden,
    /// The outputs are fed back as inputs: 22 genes.
    Recurrent,
}

/// Equation 1, fitness = sum of V (1 - sqrt(DV)) (1 - I), and what the paper leaves open in it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Task {
    /// What to do.
    pub(crate) kind: TaskKind,
    /// V: unsigned, since the paper says that driving to and fro "will score relatively high".
    pub(crate) speed: Speed,
    /// DV: the root of "the same formula" of Floreano and Mondada; the paper prints the square.
    pub(crate) difference: Difference,
    /// I: without the added sensor noise.
    pub(crate) activation: Activation,
    /// Besides, what each cell of 50 mm is worth that the robot enters for the first time: the term that the paper's
    /// conclusion proposes. 0 as the paper did.
    pub(crate) new_cell: f64,
}

impl Default for Task {
    fn default() -> Self {
        Self {
            kind: TaskKind::Avoidance,
            speed: Speed::Unsigned,
            difference: Difference::Root,
            activation: Activation::Real,
            new_cell: 0.0,
        }
    }
}

/// The tasks of the catalogue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum TaskKind {
    /// Go fast, go straight, keep away from things.
    Avoidance,
}

/// How speed counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Speed {
    /// V = (|left| + |right|) / 2
    Unsigned,
    /// V = (left + right) / 2
    Signed,
}

/// The power of the wheels' difference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Difference {
    /// 1 - sqrt(DV)
    Root,
    /// 1 - DV^2
    Square,
}

/// Which activation counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Activation {
    /// Without the added sensor noise.
    Real,
    /// With it.
    Perceived,
    /// No term for it.
    None,
}

/// Where lives start: the paper's is "a random position".
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Start {
    /// Random or given.
    pub(crate) kind: StartKind,
    /// x of a given start.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) x_mm: Option<f64>,
    /// y of a given start.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) y_mm: Option<f64>,
    /// Heading of a given start, counter-clockwise from the x axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) heading_turns: Option<f64>,
}

impl Default for Start {
    fn default() -> Self {
        Self {
            kind: StartKind::Random,
            x_mm: None,
            y_mm: None,
            heading_turns: None,
        }
    }
}

/// How starts are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum StartKind {
    /// A free pose for each life, uniform over the arena's field and all headings.
    Random,
    /// One pose for all.
    At,
}

/// The genetic algorithm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Evolution {
    /// Individuals: 100 in the paper.
    pub(crate) population: u32,
    /// How many of the best are copied, each equally often: 20 in the paper, 5 copies each.
    pub(crate) parents: u32,
    /// Generations that are evaluated: 200 in the paper, 0 to 199.
    pub(crate) generations: u32,
    /// How many of the best are also copied once without mutation: the paper mentions none.
    pub(crate) elite: u32,
    /// Range of the uniform initial genes, which the paper does not give.
    #[serde(deserialize_with = "pair")]
    pub(crate) initial: [f64; 2],
    /// Instead of random genes, those of this file: `.npy`, individuals x genes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) init: Option<String>,
    /// Range that genes are kept within, where one is given.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "some_pair")]
    pub(crate) limits: Option<[f64; 2]>,
    /// How copies change.
    pub(crate) mutation: Mutation,
}

impl Default for Evolution {
    fn default() -> Self {
        Self {
            population: 100,
            parents: 20,
            generations: 200,
            elite: 0,
            initial: [-1.0, 1.0],
            init: None,
            limits: None,
            mutation: Mutation::default(),
        }
    }
}

/// How copies change. The paper says "25 %", and not of what: each gene, by a uniform number up to 1, is our choice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Mutation {
    /// What becomes of a gene.
    pub(crate) kind: MutationKind,
    /// The chance of a change.
    pub(crate) rate: f64,
    /// What the chance is drawn for.
    pub(crate) per: MutationUnit,
    /// Size of the change: the greatest that is added, or its standard deviation.
    pub(crate) amount: f64,
}

impl Default for Mutation {
    fn default() -> Self {
        Self {
            kind: MutationKind::AddUniform,
            rate: 0.25,
            per: MutationUnit::Gene,
            amount: 1.0,
        }
    }
}

/// What mutation does to a gene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum MutationKind {
    /// Adds a uniform number between minus and plus the amount.
    AddUniform,
    /// Adds a normal number with the amount as its standard deviation.
    AddNormal,
    /// Draws it anew from the initial range.
    Replace,
}

/// What the chance of mutation is drawn for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum MutationUnit {
    /// Each gene by itself.
    Gene,
    /// Each individual: all its genes change, or none.
    Individual,
}

/// What a run writes, and when. Nothing of it reaches a result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Record {
    /// Generations from one checkpoint to the next.
    pub(crate) checkpoint_every: u32,
    /// Whether every individual is kept, its genes and its fitness, for `audit`.
    pub(crate) individuals: bool,
}

impl Default for Record {
    fn default() -> Self {
        Self {
            checkpoint_every: 50,
            individuals: true,
        }
    }
}

/// Two numbers and not one more: a list's own reader would not look at what follows.
fn pair<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 2], D::Error> {
    let numbers = Vec::<f64>::deserialize(deserializer)?;
    let count = numbers.len();
    numbers
        .try_into()
        .map_err(|_| serde::de::Error::invalid_length(count, &"two numbers"))
}

fn some_pair<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<[f64; 2]>, D::Error> {
    pair(deserializer).map(Some)
}
