//! Settings of an experiment, each described by a row. The defaults are the study of Miglino, Lund and Nolfi, "Evolving
//! mobile robots in simulated and real environments", Artificial Life 2(4), 1995, without noise.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::LazyLock;
use std::time::Duration;

use oneiro::arena::{Arena, Corners};
use oneiro::compose::Kind;
use oneiro::differential::Build;
use oneiro::foraging::{AsForaging, Foraging};
use oneiro::parameter::Allowed::{Any, Number, Text, Whole, WholeUpTo};
use oneiro::parameter::{Choice, Choices, Datum, Field, Parameter, Select, row};
use oneiro::surrogate::{Difference, Differences};
use oneiro::tables::MotorStates;
use oneiro::world::{self, Controller, LENGTH, Noise, Task, WorldSpec};
use oneiro_evolve::settings as evolution;
use oneiro_evolve::{GivenGenomes, given_genomes};
use oneiro_robots::address::Address;
use oneiro_robots::tracker;

use super::robots::{self, Preset};
use super::values::Described;
use crate::reality::site::{SEVERITY, Site};
use crate::reality::wired;

/// A whole experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Name of the experiment's runs.
    pub name: String,
    /// Seed of the run; the command line's takes precedence.
    pub seed: Option<u64>,
    /// Episodes of each individual in each generation.
    pub trials: u32,
    /// How the fitness of several episodes is combined.
    pub trial_score: TrialScore,
    /// The robot's name, or the samples that it is made from.
    pub robot: Robot,
    /// Name or size of the arena.
    pub arena: ArenaSize,
    /// Everything else about the world; its arena has only the objects that the experiment lists.
    pub world: WorldSpec,
    /// Custom sensors, and the controller and the task if the world's are custom.
    pub sensor: PartFile,
    pub controller: PartFile,
    pub task: PartFile,
    /// The optimiser.
    pub evolution: evolution::Settings,
    /// Individuals that are re-evaluated after the last generation.
    pub finalists: Finalists,
    /// The robot that evaluates the last generations.
    pub reality: Transfer,
    /// Files that a run writes, and when.
    pub record: Record,
    /// Values of these keys in tests, instead of those in the evolution.
    pub test: Overrides,
    /// BLAKE3 hashes of the named files.
    pub files: BTreeMap<String, String>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            name: String::new(),
            seed: None,
            trials: 1,
            trial_score: TrialScore::Mean,
            robot: Robot {
                preset: Preset::default(),
                tables: SensorFiles::BuiltIn,
                motors: BUILT_IN.into(),
                states: MotorStates::Symmetric20,
                described: Samples::default(),
            },
            arena: ArenaSize {
                preset: Some(Arena::miglino1995().name),
                width_mm: None,
                height_mm: None,
                open: None,
                corners: None,
                start_radius: None,
                picture: PictureFile::default(),
            },
            world: WorldSpec {
                arena: Arena::default(),
                noise: Noise {
                    walk_step: Noise::CONSERVATIVE.walk_step,
                    ..Noise::NONE
                },
                ..WorldSpec::miglino1995()
            },
            sensor: PartFile::default(),
            controller: PartFile::default(),
            task: PartFile::default(),
            evolution: evolution::Settings::default(),
            finalists: Finalists { count: 20, lives: 100 },
            reality: Transfer::default(),
            record: Record {
                checkpoint_every: 50,
                individuals: true,
            },
            test: Overrides::default(),
            files: BTreeMap::new(),
        }
    }
}

impl Settings {
    /// The custom part of a kind.
    pub(super) fn part_mut(&mut self, kind: Kind) -> &mut PartFile {
        match kind {
            Kind::Sensor => &mut self.sensor,
            Kind::Controller => &mut self.controller,
            Kind::Task => &mut self.task,
        }
    }
}

impl AsMut<WorldSpec> for Settings {
    fn as_mut(&mut self) -> &mut WorldSpec {
        &mut self.world
    }
}

impl AsMut<evolution::Settings> for Settings {
    fn as_mut(&mut self) -> &mut evolution::Settings {
        &mut self.evolution
    }
}

impl AsForaging for Settings {
    fn as_foraging(&mut self) -> Option<&mut Foraging> {
        self.world.as_foraging()
    }
}

/// TOML has only signed integers.
pub const GREATEST_SEED: u64 = i64::MAX as u64;

impl Described for Settings {
    fn rows() -> &'static [Parameter<Self>] {
        static ROWS: LazyLock<Vec<Parameter<Settings>>> = LazyLock::new(rows);
        &ROWS
    }

    fn reason(&self, key: &str) -> Option<String> {
        match given_genomes(&self.evolution) {
            GivenGenomes::None(reason) if key == "evolution.init" => {
                Some(format!("with {} {reason}", self.evolution.kind.word()))
            }
            _ => None,
        }
    }
}

#[rustfmt::skip]
fn rows() -> Vec<Parameter<Settings>> {
    const OURS: &str = "ours";
    let mut rows = head(|own: &mut Settings, _| Some(&mut own.name), |own, _| Some(&mut own.seed));
    rows.extend(world::parameters());
    insert(&mut rows, "cycles", [
        row("trials", "", Whole(1, 10_000), "Miglino et al. 1995, section 3.1",
            "Episodes of each individual in each generation.", |own, _| Some(&mut own.trials)),
        row("trial_score", "", Any, OURS,
            "How fitness over several episodes is combined.", |own, _| Some(&mut own.trial_score)),
    ]);
    insert(&mut rows, "robot.kind", [
        row("robot.preset", "", Text(robots::names().leak()), OURS,
            "Name of a robot that ships with Oneiro. Other keys override its values. A run's `config.toml` has the values instead of the name: see docs/robots.md.", |own, _| Some(&mut own.robot.preset)),
    ]);
    insert(&mut rows, "robot.body_radius_mm", [
        row("robot.tables", "", Text("\"khepera\", \"reality\", \"surrogate:SEED\" or a list of files"), OURS,
            "Sampled sensors: the built-in Khepera, samples of a surrogate (`reality`: the one of `reality.robot`) as `oneiro robot sample` takes them, or a file for each class of object. Parametric robots: for their sensors of the kind sampled.", |own, _| match own.world.robot.build {
                Build::Sampled => Some(&mut own.robot.tables),
                Build::Differential(_) => Some(&mut own.robot.described.tables),
                Build::Forager(_) => None,
            }),
        row("robot.motors", "", Text("\"khepera\", \"reality\", \"surrogate:SEED\" or a file"), OURS,
            "Sampled motors: the built-in Khepera, samples of a surrogate (`reality`: the one of `reality.robot`), or a file. Parametric robots: instead of `wheel_base_mm` and `greatest_speed_mm_s`.", |own, _| match own.world.robot.build {
                Build::Sampled => Some(&mut own.robot.motors),
                Build::Differential(_) => Some(&mut own.robot.described.motors),
                Build::Forager(_) => None,
            }),
        row("robot.states", "", Any, "ours: which 20; 20 x 20 states in Miglino et al. 1995, section 3.2.2",
            "Which of the sampled speeds are a wheel's states.", |own, _| match own.world.robot.build {
                Build::Sampled => Some(&mut own.robot.states),
                Build::Differential(_) => Some(&mut own.robot.described.states),
                Build::Forager(_) => None,
            }),
    ]);
    let file = Text("a file, .wgsl");
    let values = Text("a table of numbers, by the names that the part declares");
    insert(&mut rows, "noise.motor", [
        row("sensor.part", "", file, OURS,
            "Custom sensors, in WGSL, in addition to the robot's: see docs/extend.md.", |own, _| Some(&mut own.sensor.part)),
        row("sensor.values", "", values, OURS,
            "Values of the custom sensors; the part declares their defaults.", |own, _| Some(&mut own.sensor.values)),
    ]);
    insert(&mut rows, "controller.kind", [
        row("controller.part", "", file, OURS,
            "A custom controller, in WGSL: see docs/extend.md.", |own, _| (own.world.controller == Controller::Own).then_some(&mut own.controller.part)),
        row("controller.values", "", values, OURS,
            "Values of the custom controller; the part declares their defaults.", |own, _| (own.world.controller == Controller::Own).then_some(&mut own.controller.values)),
    ]);
    insert(&mut rows, "task.kind", [
        row("task.part", "", file, OURS,
            "A custom task, in WGSL: see docs/extend.md.", |own, _| (own.world.task == Task::Own).then_some(&mut own.task.part)),
        row("task.values", "", values, OURS,
            "Values of a task; its part declares their defaults.", |own, _| own.world.task.is_part().then_some(&mut own.task.values)),
    ]);
    insert(&mut rows, "robot.turn_before_move", [
        row("arena.preset", "", Text(Arena::NAMES.join(", ").leak()), "Miglino et al. 1995, section 3.1; where its obstacles stand is ours",
            "Name of an arena in the catalogue; the keys below define another one instead.", |own, _| Some(&mut own.arena.preset)),
        row("arena.width_mm", "mm", LENGTH, OURS,
            "Width of a rectangular arena; its lower left corner is at (0, 0).", |own, _| Some(&mut own.arena.width_mm)),
        row("arena.height_mm", "mm", LENGTH, OURS,
            "Height of a rectangular arena.", |own, _| Some(&mut own.arena.height_mm)),
        row("arena.open", "", Any, OURS,
            "Whether the arena has no sides, so that robots may leave the field they start in; default: false.", |own, _| Some(&mut own.arena.open)),
        row("arena.corners_mm", "mm", Text("3 pairs of numbers and more, x and y of each corner"), OURS,
            "Corners of a convex polygon, counter-clockwise, instead of width and height. Its sides are walls of the class wall.", |own, _| Some(&mut own.arena.corners)),
        row("arena.start_radius_mm", "mm", LENGTH, OURS,
            "Radius of the disc in the arena's middle where a swarm's robots start. Default: anywhere in a rectangular field, or the largest disc inside a polygon.", |own, _| Some(&mut own.arena.start_radius)),
    ]);
    insert(&mut rows, "arena.floor", [
        row("arena.picture.file", "", Text("a file, .png"), OURS,
            "A picture on the floor, for what reads the floor's grey: see docs/worlds.md. Patches lie on it.", |own, _| Some(&mut own.arena.picture.file)),
        row("arena.picture.x_mm", "mm", world::COORDINATE, OURS,
            "x of its centre. Default: the middle of the arena.", |own, _| Some(&mut own.arena.picture.x)),
        row("arena.picture.y_mm", "mm", world::COORDINATE, OURS,
            "y of its centre. Default: the middle of the arena.", |own, _| Some(&mut own.arena.picture.y)),
        row("arena.picture.sides_mm", "mm", LENGTH, OURS,
            "Its width and its height. Default: those of the rectangle around the arena's walls.", |own, _| Some(&mut own.arena.picture.sides)),
        row("arena.picture.cell_mm", "mm", Number(0.1, 1e4), OURS,
            "About the side of a cell of the floor. Each cell has one of 256 greys, the mean of its pixels; at most 1048576 cells; default: 5.", |own, _| Some(&mut own.arena.picture.cell)),
    ]);
    rows.extend(evolution::rows());
    insert(&mut rows, "evolution.limits", [
        row("evolution.finalists", "", Whole(0, 10_000), OURS,
            "How many of the last generation's best, or of a whole grid's, are re-evaluated with the luckiest of the run. The best mean is the champion, whose reported mean is that of as many episodes again; 0: no re-evaluation.", |own, _| Some(&mut own.finalists.count)),
        row("evolution.finalist_lives", "", Whole(2, 10_000), OURS,
            "Episodes of each finalist, with common random numbers that evolution never used.", |own, _| Some(&mut own.finalists.lives)),
    ]);
    rows.extend([
        row("reality.robot", "", Text("an address, such as surrogate:1 or serial:/dev/ttyUSB0, or a list of several connected robots"), OURS,
            "The robot that evaluates the last generations, after the simulated ones: connected (docs/robots-on-the-wire.md), or a surrogate, which stands in for a Khepera. Several connected robots, as a list, share a generation's episodes. Episodes on connected robots are recorded in the run's folder `lives`, and never repeated.", |own: &mut Settings, _| Some(&mut own.reality.robot)),
        row("reality.generations", "", WholeUpTo(1, "evolution.generations"), "Miglino et al. 1995, section 4",
            "How many of the last generations are evaluated and selected there. Default: 20, or all if there are fewer.", |own, _| Some(&mut own.reality.generations)),
        row("reality.severity", "", Number(0.0, 2.0), "ours: the 1995 study was calibrated to it",
            "How much a surrogate differs from the simulator made from its samples. Default: 1.75.", |own, _| Some(&mut own.reality.severity)),
        row("reality.motion_severity", "", Number(0.0, 2.0), OURS,
            "How much a surrogate differs in latency, motors and collisions, instead of `reality.severity`, which then applies only to its sensors.", |own, _| Some(&mut own.reality.motion_severity)),
        row("reality.differences.geometry", "", Number(0.0, 2.0), OURS,
            "Severity of geometry, instead of `reality.severity`. At 1 rays meet all objects at once and exactly, instead of one by one on the samples' grid. For a parametric robot: its sensors' directions and strengths.", |own, _| Some(own.reality.difference(Difference::Geometry))),
        row("reality.differences.reflectivity", "", Number(0.0, 2.0), OURS,
            "Severity of reflectivity, instead of `reality.severity`. At 1 each object reflects up to 20 % more or less.", |own, _| Some(own.reality.difference(Difference::Reflectivity))),
        row("reality.differences.illumination", "", Number(0.0, 2.0), OURS,
            "Severity of illumination, instead of `reality.severity`. At 1 light over the arena varies by up to 30 %, and adds up to 0.02 to each activation.", |own, _| Some(own.reality.difference(Difference::Illumination))),
        row("reality.differences.read_noise", "", Number(0.0, 2.0), OURS,
            "Severity of reading noise, instead of `reality.severity`. At 1 readings have noise, with a standard deviation of 3.4 of 1023 and 3 % of the reading.", |own, _| Some(own.reality.difference(Difference::ReadNoise))),
        row("reality.differences.latency", "", Number(0.0, 2.0), OURS,
            "Severity of latency, instead of `reality.motion_severity`. At 1 readings are 20 to 40 ms old.", |own, _| Some(own.reality.difference(Difference::Latency))),
        row("reality.differences.motor_lag", "", Number(0.0, 2.0), OURS,
            "Severity of motor lag, instead of `reality.motion_severity`. At 1 wheels follow their commands with a time constant of 20 ms.", |own, _| Some(own.reality.difference(Difference::MotorLag))),
        row("reality.differences.wheels", "", Number(0.0, 2.0), OURS,
            "Severity of unequal wheels, instead of `reality.motion_severity`. At 1 each wheel turns up to 1 % faster or slower than it should.", |own, _| Some(own.reality.difference(Difference::Wheels))),
        row("reality.differences.arcs", "", Number(0.0, 2.0), OURS,
            "Severity of arcs, instead of `reality.motion_severity`. At 1 the robot drives arcs, instead of straight lines each followed by a turn. Parametric robots need sampled motors for it.", |own, _| Some(own.reality.difference(Difference::Arcs))),
        row("reality.differences.slip", "", Number(0.0, 2.0), OURS,
            "Severity of slip, instead of `reality.motion_severity`. At 1 a blocked robot moves and turns half as far as if it slid along the object, instead of not at all. Parametric robots need `robot.collision` undo or keep_turn for it.", |own, _| Some(own.reality.difference(Difference::Slip))),
        row("reality.starts", "", Any, OURS,
            "How episodes on a connected robot get their starts. Default: \"walk\".", |own, _| Some(&mut own.reality.starts)),
        row("reality.speed_mm_s", "mm/s", Number(wired::SPEEDS_MM_S[0], wired::SPEEDS_MM_S[1]), OURS,
            "Wheel speed of a connected robot at the controller's maximum output. Default: the parametric robot's maximum speed, else 80.", |own, _| Some(&mut own.reality.speed)),
        row("reality.walk_s", "s", Number(0.0, wired::LONGEST_WALK_S), OURS,
            "How long a connected robot drives at random before each episode. Default: 10. 0: an episode starts where the last one ended.", |own, _| Some(&mut own.reality.walk)),
        row("reality.sensors", "", Text("a table of the robot's names, by the experiment's"), OURS,
            "Sensors whose names on the connected robot differ from the experiment's: the robot's name by the experiment's.", |own, _| Some(&mut own.reality.sensors)),
        row("reality.tracker", "", Text("udp:HOST:PORT or udp:HOST:PORT#ID, or a list of as many as there are robots"), OURS,
            "Where to receive a connected robot's pose from a tracker; for several robots, in the order of `reality.robot`. Default: poses are from odometers.", |own, _| Some(&mut own.reality.tracker)),
        row("reality.tracker_age_ms", "ms", Number(*tracker::AGES_MS.start() as f64, *tracker::AGES_MS.end() as f64), OURS,
            "Age of the tracker's last sighting at which the robot counts as lost and is stopped. Default: 300.", |own, _| Some(&mut own.reality.tracker_age)),
        row("reality.guard", "", Text("a table of the guard's values, by their names"), OURS,
            "Values of a connected robot's guard, listed in docs/robots-on-the-wire.md.", |own, _| Some(&mut own.reality.guard)),
        row("record.checkpoint_every", "generations", Whole(1, u32::MAX.into()), OURS,
            "Generations from one checkpoint to the next: the most that a power cut loses.", |own, _| Some(&mut own.record.checkpoint_every)),
        row("record.individuals", "", Any, OURS,
            "Whether every individual is recorded, so that `oneiro verify --recompute` can re-evaluate any of them; false with race.", |own, _| Some(&mut own.record.individuals)),
        row("test", "", Text("a table of keys of episodes, such as \"noise.sensor\" or \"worlds.seed\", and their values"), OURS,
            "The values of these keys in `oneiro evaluate --test`, instead of those in the evolution: see docs/worlds.md.", |own, _| Some(&mut own.test)),
        row("files", "", Text("a table of BLAKE3 hashes, by the names of files"), OURS,
            "Hashes of the files named above, checked if given. A run's `config.toml` has them all.", |own, _| Some(&mut own.files)),
    ]);
    rows
}

/// Rows that all kinds of experiments begin with.
pub(super) fn head<T>(name: Select<T>, seed: Select<T>) -> Vec<Parameter<T>> {
    let plain = Text("letters, digits, - and _, since directories are named so");
    let about = "Name of the runs. Default: the file's name.";
    let seeds = "Default seed if `--seed` is absent; otherwise one is drawn and reported.";
    vec![
        row("name", "", plain, "ours", about, name),
        row("seed", "", Whole(0, GREATEST_SEED), "ours", seeds, seed),
    ]
}

/// Inserts rows after that of a key.
fn insert<const N: usize>(rows: &mut Vec<Parameter<Settings>>, key: &str, more: [Parameter<Settings>; N]) {
    let at = rows.iter().position(|row| row.key == key).expect("the key has a row");
    rows.splice(at + 1..=at, more);
}

/// How the fitness of an individual's several episodes is combined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrialScore {
    Mean,
    Least,
}

impl Choice for TrialScore {
    const CHOICES: Choices<Self> = &[
        ("mean", Self::Mean, "the mean of their fitness"),
        ("least", Self::Least, "the minimum of their fitness"),
    ];
}

/// The robot's name, or the samples that it is made from.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// Robot by name that the experiment changes.
    pub preset: Preset,
    pub tables: SensorFiles,
    pub motors: String,
    pub states: MotorStates,
    /// Samples of a parametric robot.
    pub described: Samples,
}

/// Samples of a parametric robot, each if the experiment has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    pub tables: Option<SensorFiles>,
    pub motors: Option<String>,
    pub states: Option<MotorStates>,
}

/// Name of the compiled-in tables.
pub(crate) const BUILT_IN: &str = "khepera";
/// Name of tables sampled from the surrogate of `[reality]`.
pub(crate) const FROM_REALITY: &str = "reality";

/// The seed of tables sampled from a surrogate, `surrogate:SEED`.
pub(super) fn surrogate(word: &str) -> Option<u64> {
    match word.parse() {
        Ok(Address::Surrogate(seed)) => Some(seed),
        _ => None,
    }
}

/// Source of the sensor tables.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum SensorFiles {
    /// `"khepera"`
    #[default]
    BuiltIn,
    /// `"reality"`
    FromReality,
    /// `"surrogate:1"`
    Surrogate(u64),
    /// `["wall.sam", "round.sam"]`
    Files(Vec<String>),
}

impl Field for SensorFiles {
    fn get(&self) -> Option<Datum> {
        Some(match self {
            Self::BuiltIn => Datum::Word(BUILT_IN.into()),
            Self::FromReality => Datum::Word(FROM_REALITY.into()),
            Self::Surrogate(seed) => Datum::Word(format!("surrogate:{seed}")),
            Self::Files(files) => Datum::List(files.iter().cloned().map(Datum::Word).collect()),
        })
    }

    fn set(&mut self, datum: &Datum) -> bool {
        let file = |datum: &Datum| match datum {
            Datum::Word(file) => Some(file.clone()),
            _ => None,
        };
        let own = match datum {
            Datum::Word(word) if word == BUILT_IN => Some(Self::BuiltIn),
            Datum::Word(word) if word == FROM_REALITY => Some(Self::FromReality),
            Datum::Word(word) => surrogate(word).map(Self::Surrogate),
            Datum::List(files) => files.iter().map(file).collect::<Option<_>>().map(Self::Files),
            _ => None,
        };
        let is_set = own.is_some();
        if let Some(own) = own {
            *self = own;
        }
        is_set
    }

    fn kind(&self) -> &'static str {
        "a word or a list"
    }
}

/// A custom part.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PartFile {
    /// Its file.
    pub part: Option<String>,
    /// Values that the part declares, by name.
    pub values: BTreeMap<String, f64>,
}

/// An arena of the catalogue by name, or the size of a custom arena.
#[derive(Clone, Debug, PartialEq)]
pub struct ArenaSize {
    pub preset: Option<String>,
    pub(crate) width_mm: Option<f32>,
    pub(crate) height_mm: Option<f32>,
    /// Whether it has no sides.
    pub open: Option<bool>,
    /// Corners of a convex polygon instead of its width and height.
    pub corners: Option<Corners>,
    /// Radius of the disc in its middle that robots start in.
    pub(crate) start_radius: Option<f32>,
    pub(crate) picture: PictureFile,
}

/// A picture on the floor.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PictureFile {
    pub(crate) file: Option<String>,
    /// Its centre and sides, mm.
    pub(crate) x: Option<f32>,
    pub(crate) y: Option<f32>,
    pub(crate) sides: Option<[f32; 2]>,
    /// About the side of a cell, mm.
    pub(crate) cell: Option<f32>,
}

/// Individuals that are re-evaluated after the last generation, so that the champion is chosen by the mean of many episodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finalists {
    /// Number of the last generation's best to take, besides the luckiest individual of the run. 0 switches finalists
    /// off.
    pub count: u32,
    /// Episodes of each finalist.
    pub lives: u32,
}

/// Addresses: none, one as a word, or several as a list.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Addresses(pub Vec<String>);

impl Field for Addresses {
    fn get(&self) -> Option<Datum> {
        match &self.0[..] {
            [] => None,
            [one] => Some(Datum::Word(one.clone())),
            all => Some(Datum::List(all.iter().cloned().map(Datum::Word).collect())),
        }
    }

    fn set(&mut self, datum: &Datum) -> bool {
        let one = |datum: &Datum| match datum {
            Datum::Word(word) => Some(word.clone()),
            _ => None,
        };
        let own: Option<Vec<String>> = match datum {
            Datum::List(list) if !list.is_empty() => list.iter().map(one).collect(),
            _ => one(datum).map(|one| vec![one]),
        };
        let is_set = own.is_some();
        self.0 = own.unwrap_or_default();
        is_set
    }

    fn kind(&self) -> &'static str {
        "a word or a list"
    }
}

/// Values by key.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overrides(pub Vec<(String, Datum)>);

impl Field for Overrides {
    fn get(&self) -> Option<Datum> {
        (!self.0.is_empty()).then(|| Datum::Table(self.0.clone()))
    }

    fn set(&mut self, datum: &Datum) -> bool {
        let Datum::Table(table) = datum else { return false };
        self.0.clone_from(table);
        true
    }

    fn kind(&self) -> &'static str {
        "a table of keys and their values"
    }
}

/// The robot that evaluates the last generations of an evolution.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Transfer {
    /// Its address, if there is one, or those of several.
    pub robot: Addresses,
    /// Number of those generations; given if there is a robot.
    pub generations: Option<u32>,
    /// How much a surrogate differs from its simulator; given if there is one.
    pub severity: Option<f32>,
    /// How much it differs in motion and in the age of its readings, if not by the same severity.
    pub motion_severity: Option<f32>,
    /// How much it differs in single ways, in the order of [`Difference::ALL`], if not by the same severity.
    pub differences: [Option<f32>; Difference::ALL.len()],
    /// How episodes on a connected robot get their starts, and the speed of its wheels at the controller's maximum output, mm/s; if
    /// they are given.
    pub starts: Option<wired::Starts>,
    pub speed: Option<f32>,
    /// Time that it drives about before an episode, s.
    pub walk: Option<f32>,
    /// Names of its sensors, by the experiment's, where they differ.
    pub sensors: BTreeMap<String, String>,
    /// Addresses of trackers, one for each robot, and the age of the last sighting from which a robot counts as lost, ms.
    pub tracker: Addresses,
    pub tracker_age: Option<f32>,
    /// Values of its guard.
    pub guard: BTreeMap<String, f64>,
}

impl Transfer {
    /// Sets missing values to their defaults, if there is a robot.
    pub(super) fn complete(&mut self, generations: u32) {
        /// As in Miglino et al. 1995.
        const GENERATIONS: u32 = 20;
        if !self.robot.0.is_empty() {
            self.generations.get_or_insert(GENERATIONS.min(generations));
        }
        if let Ok(Some(Site::Surrogate { .. })) = self.site() {
            self.severity.get_or_insert(SEVERITY);
        }
    }

    /// Values of episodes on a connected robot. The run says where they are recorded.
    pub fn values(&self) -> Result<wired::Values, String> {
        let age = self.tracker_age.map_or(tracker::AGE_MS as f64, f64::from);
        let limit = Duration::from_secs_f64(age / 1000.0);
        let trackers = self.tracker.0.iter();
        let trackers = trackers.map(|tracker| tracker::Values::parse(tracker, limit));
        let sensors = self.sensors.iter().map(|(own, robot)| (own.clone(), robot.clone()));
        Ok(wired::Values {
            starts: self.starts.unwrap_or_default(),
            walk: wired::Values::cycles(self.walk.map_or(wired::WALK_S, f64::from)),
            speed_mm_s: self.speed.map(f64::from),
            sensors: sensors.collect(),
            directory: PathBuf::new(),
            trackers: trackers.collect::<Result<_, _>>()?,
        })
    }

    /// Whether simulators are made from samples of that robot.
    pub fn is_sampled(robot: &Robot) -> bool {
        robot.tables == SensorFiles::FromReality || robot.motors == FROM_REALITY
    }

    /// The setting of one difference.
    fn difference(&mut self, difference: Difference) -> &mut dyn Field {
        &mut self.differences[difference as usize]
    }

    /// How much a surrogate differs from its simulator.
    fn differences(&self) -> Differences {
        let severity = self.severity.unwrap_or_default();
        let shared = Differences::all(severity).with_motion(self.motion_severity.unwrap_or(severity));
        let own = Difference::ALL.into_iter().zip(self.differences);
        own.filter_map(|(difference, own)| Some((difference, own?)))
            .fold(shared, |all, (difference, own)| all.with(difference, own))
    }

    /// The robot, if there is one.
    ///
    /// # Errors
    /// The problem of its address, or of its tracker's.
    pub fn site(&self) -> Result<Option<Site>, String> {
        if self.robot.0.is_empty() {
            return Ok(None);
        }
        let guard: Vec<String> = self.guard.iter().map(|(key, value)| format!("{key}={value}")).collect();
        Site::at(&self.robot.0, self.differences(), self.values()?, &guard).map(Some)
    }
}

/// Files that a run writes, and when. None of this affects results.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Generations between checkpoints.
    pub checkpoint_every: u32,
    /// Whether to keep every individual's genes and fitness, for `oneiro verify --recompute`.
    pub individuals: bool,
}
