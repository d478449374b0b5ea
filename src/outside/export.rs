//! Controllers by themselves, without a simulator: described for other programs and robots, and printed in other languages.
//!
//! A controller is specialised to its genes and to its experiment's values. Printed controllers have the simulator's bits, which
//! [`Controller::record`] checks cycle by cycle.
//!
//! ```
//! use oneiro::export::Controller;
//! use oneiro::world::{World, WorldSpec};
//!
//! let world = World::new(WorldSpec::miglino1995())?;
//! let controller = Controller::new(&world, &[0.5; 18], 0)?;
//! let mut state = controller.reset([0, 0], 0);
//! let [left, right] = controller.step(&mut state, &[0.0; 8])?;
//! assert!(left == right && left > 0.5);
//! assert!(controller.wheels([left, right])?[0] > 0.0);
//! # Ok::<(), oneiro::parameter::Invalid>(())
//! ```

mod aseba;
mod c;
mod cpp;
mod objects;
mod onnx;
mod pieces;
mod plan;
mod rust;
mod scripts;
mod simulator;
mod systems;

use oneiro_shader_compiler::interpret::{self, Buffers};
use oneiro_shader_compiler::specialise::Known;
use oneiro_shader_compiler::tree::Program;
use oneiro_shader_compiler::{Generic, language};

use crate::batch::{KEY_WORDS, LEAST_GENE, Rollout, Trace, TraceRequest, Worlds};
use crate::evaluator::{Control, Evaluator};
use crate::foragers::foraging::{self, Foraging};
use crate::outside::export::simulator::Simulator;
pub use crate::outside::reported::Error;
use crate::outside::reported::check;
use crate::parameter::{Choice, Invalid};
use crate::parts::compose::{self, DetailKind, Exported, HEAD, Scalar};
use crate::random::{Key, pcg4d};
use crate::world::differential::{Differential, Genomes, Response};
use crate::world::tables::{MotorTable, SENSOR_NAMES};
use crate::world::{Build, Controller as Kind, Noise, Robot, World, WorldSpec};

pub use aseba::aseba;
pub use c::c;
pub use cpp::{arduino, cpp};
pub use objects::{javascript, lua, python, rust};
pub use onnx::onnx;
pub use simulator::Also;
pub use systems::{argos, ros2, webots};

/// Duration of a control cycle, s.
pub const PERIOD: f32 = 0.1;

/// Most words of a table that a controller asks for.
const GREATEST_TABLE: usize = 1 << 14;

/// Most turns of all loops of a cycle.
const TURNS: u64 = 10_000_000;

/// Prints a controller: the controller, its name, lines that say where it is from, and cycles to check it by.
pub type Print<Text> = fn(&Controller, &str, &[String], &[Recorded]) -> Text;

/// A language or system that a controller is printed for.
pub struct Target {
    /// Its name.
    pub name: &'static str,
    /// What is written.
    pub about: &'static str,
    /// What it is written as.
    pub form: Form,
    /// Whether it has the simulator's bits.
    pub is_exact: bool,
}

/// What a controller is written as.
pub enum Form {
    /// A file, the ends that its name may have, the usual one first.
    File(&'static [&'static str], Print<String>),
    /// The same, which some controllers are refused: their robots have no counterpart there.
    Fitting(&'static [&'static str], Print<Result<Fitted, Invalid>>),
    /// A folder with files, by their paths. The end of its usual name after the controller's, as two folders of one name would become one.
    Folder(&'static str, Print<Vec<(String, String)>>),
}

/// A file for a system, and what is to be said of it.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The file.
    pub bytes: Vec<u8>,
    /// How near it is to the simulator, if it hasn't its bits.
    pub note: Option<String>,
}

/// Everything that controllers are printed for.
pub const TARGETS: &[Target] = &[
    Target {
        name: "c",
        about: "a C99 file without libraries, with a function that checks its own bits",
        form: Form::File(&["c", "h"], c),
        is_exact: true,
    },
    Target {
        name: "cpp",
        about: "a C++ header with a class",
        form: Form::File(&["hpp", "h"], cpp),
        is_exact: true,
    },
    Target {
        name: "arduino",
        about: "an Arduino library, a folder with an example",
        form: Form::Folder("", arduino),
        is_exact: true,
    },
    Target {
        name: "rust",
        about: "a Rust module without std",
        form: Form::File(&["rs"], rust),
        is_exact: true,
    },
    Target {
        name: "javascript",
        about: "a JavaScript module",
        form: Form::File(&["mjs", "js"], javascript),
        is_exact: true,
    },
    Target {
        name: "python",
        about: "a Python module without packages",
        form: Form::File(&["py"], python),
        is_exact: true,
    },
    Target {
        name: "lua",
        about: "a Lua module, for Lua 5.1 and newer",
        form: Form::File(&["lua"], lua),
        is_exact: true,
    },
    Target {
        name: "argos",
        about: "a Lua script for ARGoS's e-puck",
        form: Form::Fitting(&["lua"], argos),
        is_exact: true,
    },
    Target {
        name: "webots",
        about: "a controller for Webots, in C",
        form: Form::Fitting(&["c"], webots),
        is_exact: true,
    },
    Target {
        name: "aseba",
        about: "a program of Aseba for a Thymio II, of networks, in whole numbers",
        form: Form::Fitting(&["aesl"], aseba),
        is_exact: false,
    },
    Target {
        name: "onnx",
        about: "an ONNX model, of networks, without the simulator's bits",
        form: Form::Fitting(&["onnx"], onnx),
        is_exact: false,
    },
    Target {
        name: "ros2",
        about: "a ROS 2 package with a node in Python, a folder",
        form: Form::Folder("_ros2", ros2),
        is_exact: true,
    },
];

/// What a controller reads.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    /// Its name.
    pub name: String,
    /// What it measures, with unit and range.
    pub about: String,
}

/// A controller with its genes.
#[derive(Clone, Debug)]
pub struct Controller {
    /// Its kind, as experiments name it.
    pub kind: String,
    /// What it reads in a cycle, in order.
    pub inputs: Vec<Input>,
    /// What it remembers from cycle to cycle, with its type. Floats begin at 0 in most controllers.
    pub memory: Vec<(String, Scalar)>,
    /// Its genes by name.
    pub genes: Vec<(String, f32)>,
    /// Speed of a wheel that is commanded at 1, mm/s, if the experiment says so.
    pub full_speed: Option<f32>,
    world: World,
    genome: Vec<f32>,
    robot: u32,
    begin: Program,
    cycle: Program,
    /// Words of the buffers that these read at places that vary, by binding number; empty ones are not read.
    tables: Vec<Table>,
    wheels: Program,
    /// The same of the wheels.
    tables_of_wheels: Vec<Table>,
    /// Its world, if that is also printed.
    simulator: Option<Simulator>,
}

/// Words of a buffer.
#[derive(Clone, Debug, Default)]
struct Table {
    name: String,
    words: Vec<u32>,
    /// Words of an element.
    stride: u32,
}

/// What a controller keeps between cycles: the key of its random numbers, the number of its trial and of the next cycle, and its memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct State(Vec<u32>);

/// A recorded cycle.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded {
    /// The state before it.
    pub before: State,
    /// What the controller read.
    pub readings: Vec<f32>,
    /// Its outputs.
    pub outputs: [f32; 2],
    /// The state after it.
    pub after: State,
}

impl State {
    /// Its words, which [`Controller::restored`] takes.
    pub fn words(&self) -> &[u32] {
        &self.0
    }

    /// The number of the next cycle.
    pub fn cycle(&self) -> u32 {
        self.0[3]
    }
}

/// Tasks of a kernel: `EXPORT_BEGIN` and `EXPORT_CYCLE` of `exported.wgsl`, or neither.
const BEGIN: u32 = 0;
const CYCLE: u32 = 1;
const WHEELS: u32 = 2;

/// The kernel of a world's controller, and the words of its buffers.
struct Source {
    kernel: Generic,
    tables: Vec<Table>,
    signed_zeros: bool,
    /// Buffers that the caller has.
    of_caller: &'static [&'static str],
}

impl Source {
    /// `motors` leaves all tables out but that of these motors.
    fn new(
        world: &World,
        genome: &[f32],
        robot: u32,
        motors: Option<&MotorTable>,
    ) -> Result<(Self, Vec<(String, Scalar)>), Invalid> {
        let spec = world.spec();
        let has_states = motors.is_some_and(|motors| motors.full_speed().is_some());
        let fields = spec.robot.build.fields();
        let Exported { kernel, memory } = compose::exported(world.kernel(), &spec.own, &fields, robot, has_states)?;
        let source = Self::of(kernel, world, genome, motors, &["exported"])?;
        Ok((source, memory))
    }

    /// A kernel with a world's words; `motors` leaves all tables out but that of these motors.
    fn of(
        kernel: Generic,
        world: &World,
        genome: &[f32],
        motors: Option<&MotorTable>,
        of_caller: &'static [&'static str],
    ) -> Result<Self, Invalid> {
        let worlds = Worlds::new(&[world])?;
        let packed = worlds.packed();
        let mut first = packed.worlds[0];
        let mut cells = packed.tables.clone();
        if let Some(motors) = motors {
            let (begin, states) = (first.motor_table as usize, first.motor_states as usize);
            first.motor_table = 0;
            cells = cells[begin..begin + states * states].to_vec();
            if motors.full_speed().is_some() {
                let speed = |state: usize| [cells[state * (states + 1)][2], 0, 0, 0];
                cells = (0..states).map(speed).collect();
            }
        }
        let genes = genome
            .iter()
            .map(|gene| if gene.abs() < LEAST_GENE { 0 } else { gene.to_bits() });
        let inputs: Vec<u32> = [0; KEY_WORDS].into_iter().chain(genes).collect();
        let tables = kernel.bindings.iter().map(|binding| Table {
            name: binding.name.clone(),
            words: match binding.name.as_str() {
                name if of_caller.contains(&name) => Vec::new(),
                "worlds" => bytemuck::cast_slice(&[first]).to_vec(),
                "shapes" => bytemuck::cast_slice(&packed.shapes).to_vec(),
                "tables" => bytemuck::cast_slice(&cells).to_vec(),
                "inputs" => inputs.clone(),
                _ => Vec::new(),
            },
            stride: binding.stride / size_of::<u32>() as u32,
        });
        Ok(Self {
            tables: tables.collect(),
            // A user's part may look at zeros' signs.
            signed_zeros: world.kernel().variants.is_empty(),
            of_caller,
            kernel,
        })
    }

    /// What it does in this mode, and the tables that it reads then.
    fn program(&self, mode: u32, greatest_table: usize) -> Result<(Program, Vec<Table>), Invalid> {
        let word = |buffer: u32, element: Option<u32>, offset: u32| {
            let Table { name, words, stride } = &self.tables[buffer as usize];
            if name == "dispatch" {
                return (offset == 0).then_some(mode);
            }
            let last = (words.len() as u32).checked_div(*stride)?.checked_sub(1)?;
            Some(words[(element?.min(last) * stride + offset) as usize])
        };
        let program = self.kernel.alone(self.kernel.program(&Known {
            word: &word,
            signed_zeros: self.signed_zeros,
        }));
        let mut tables = vec![Table::default(); self.tables.len()];
        for buffer in language::touched(&program) {
            let table = &self.tables[buffer as usize];
            if self.of_caller.contains(&table.name.as_str()) {
                continue;
            }
            if table.name == "inputs" && table.words.len() > greatest_table {
                let problem = format!(
                    "has {} genes; allowed in a file: up to {}",
                    table.words.len() - KEY_WORDS,
                    greatest_table - KEY_WORDS
                );
                return Err(Invalid::new("controller", problem));
            }
            if table.words.is_empty() || table.words.len() > greatest_table {
                let problem = format!(
                    "asks for what only its simulator has (`{}`); allowed: its readings, its genes, its values and its memory",
                    table.name
                );
                return Err(Invalid::new("controller", problem));
            }
            tables[buffer as usize] = table.clone();
        }
        Ok((program, tables))
    }
}

impl Target {
    /// Whether the world can be printed with a controller.
    pub fn has_world(&self) -> bool {
        self.name == "c"
    }

    /// Whether names in its file can't begin with a name: it is a word of a language or of its library, or a module that the file imports.
    pub fn is_reserved(&self, name: &str) -> bool {
        /// Of C++ classes, and modules of Python and ROS 2.
        const OTHERS: &str = "INPUTS OUTPUTS PERIOD_MS check state None True False array errno math struct time zlib signal rclpy std_msgs \
                              geometry_msgs setuptools main";
        /// Of C's and C++'s usual headers, and modules of Lua.
        const OF_LIBRARIES: &str = "std abs div labs exit abort atexit malloc calloc realloc free qsort rand srand system getenv printf \
                                    puts putchar getchar scanf remove rename memcpy memset strlen size_t ptrdiff_t NULL NAN EOF INFINITY \
                                    INT_MAX stdin stdout stderr sin cos tan exp log pow sqrt floor ceil y0 y1 yn j0 j1 jn string table \
                                    io os coroutine package debug utf8 bit32";
        let is_in = |words: &str| words.split_whitespace().any(|word| word == name);
        let is_wrong =
            self.names_packages() && (name.contains("__") || name.ends_with('_') || name.to_lowercase() != name);
        is_in(pieces::KEYWORDS) || is_in(OTHERS) || is_in(OF_LIBRARIES) || is_wrong
    }

    /// The characters of names in its file.
    pub fn letters(&self) -> &'static str {
        if self.names_packages() {
            "lower-case letters, digits and single _"
        } else {
            "letters, digits and _"
        }
    }

    /// Whether a name is also that of a package of ROS 2.
    fn names_packages(&self) -> bool {
        self.name == "ros2"
    }
}

impl Controller {
    /// The controller of a world's robot with a genome. In a world whose numbers vary, its numbers are those of the first variant.
    ///
    /// # Errors
    /// Another number of genes, or some that aren't allowed; a robot that there isn't; a controller that needs its simulator.
    pub fn new(world: &World, genome: &[f32], robot: u32) -> Result<Self, Invalid> {
        let world = &world.variants()[0];
        if genome.len() != world.genes() {
            let problem = format!("are {}; allowed: {}", genome.len(), world.genes());
            return Err(Invalid::new("genes", problem));
        }
        check("genes", genome)?;
        if robot >= world.robots() {
            let problem = format!("is {robot}; allowed: 0 to {}", world.robots() - 1);
            return Err(Invalid::new("robot", problem));
        }
        let whole = genome;
        let genome = &whole[world.genes_of(robot)];
        let (source, memory) = Source::new(world, genome, robot, None)?;
        let (begin, of_begin) = source.program(BEGIN, GREATEST_TABLE)?;
        let (cycle, of_cycle) = source.program(CYCLE, GREATEST_TABLE)?;
        let robot_of_world = &world.spec().robot;
        let motors = match &robot_of_world.build {
            Build::Sampled => Some(&*robot_of_world.motors),
            Build::Differential(described) => described.sampled_motors.then_some(&*robot_of_world.motors),
            Build::Forager(_) => None,
        };
        let (of_motors, _) = Source::new(&at_once(world)?, genome, robot, motors)?;
        let (wheels, tables_of_wheels) = of_motors.program(WHEELS, GREATEST_TABLE)?;
        let names = world.gene_layout().controller().iter().map(|gene| gene.name.clone());
        Ok(Self {
            kind: world.spec().controller.word().to_owned(),
            inputs: inputs(world.spec()),
            memory,
            genes: names.zip(genome.iter().copied()).collect(),
            full_speed: full_speed(robot_of_world),
            world: world.clone(),
            genome: whole.to_vec(),
            robot,
            begin,
            cycle,
            tables: joined([of_begin, of_cycle]),
            wheels,
            tables_of_wheels,
            simulator: None,
        })
    }

    /// The same with its world, or a part of it, which targets that [have one](Target::has_world) print too, with the key of an episode.
    ///
    /// # Errors
    /// The world of foragers, and a part of a swarm's.
    pub fn with_world(self, also: Also, known: Key) -> Result<Self, Invalid> {
        let simulator = Simulator::new(&self.world, also, known)?;
        Ok(Self {
            simulator: Some(simulator),
            ..self
        })
    }

    /// Whether it draws random numbers, by the key that it begins with.
    pub fn draws(&self) -> bool {
        self.reads(0) || self.reads(1)
    }

    /// Whether all robots of its world have this controller, and none draws random numbers, which differ from robot to robot. A user's may
    /// know its robot's number.
    fn is_every_robots(&self) -> bool {
        let described = self.world.spec().robot.build.described();
        let is_shared = described.is_some_and(|robot| robot.genomes == Genomes::Homogeneous);
        is_shared && self.world.spec().controller != Kind::Own && !self.draws()
    }

    /// Whether it asks for the number of its trial.
    pub fn asks_for_trial(&self) -> bool {
        self.reads(2)
    }

    /// Whether a word of what the caller has matters to it.
    fn reads(&self, word: u32) -> bool {
        let exported = self.exported();
        [&self.begin, &self.cycle]
            .iter()
            .any(|program| language::loads(program, exported, word))
    }

    /// The number of the buffer that the caller has.
    fn exported(&self) -> u32 {
        self.tables.len() as u32 - 1
    }

    fn readings_begin(&self) -> usize {
        HEAD.len() + self.memory.len()
    }

    /// The state before the first cycle of an episode.
    pub fn reset(&self, key: [u32; 2], trial: u32) -> State {
        let mut words = vec![0; self.readings_begin() + self.inputs.len() + compose::TAIL.len()];
        words[..3].copy_from_slice(&[key[0], key[1], trial]);
        run(&self.begin, &self.tables, &mut words);
        words.truncate(self.readings_begin());
        State(words)
    }

    /// The state before the first cycle of the episode with this key. In a swarm, it is that of its robot.
    pub fn begin(&self, key: Key) -> State {
        let mut words = key.words;
        if self.world.spec().robot.members().is_some() {
            // As physics/members.wgsl gives each robot its key.
            let [first, second, ..] = pcg4d([words[0], words[1], 0, 0xff00 + self.robot]);
            words = [first, second];
        }
        self.reset(words, key.trial)
    }

    /// A state that was saved as words.
    ///
    /// # Errors
    /// Another number of words than this controller's states have.
    pub fn restored(&self, words: &[u32]) -> Result<State, Invalid> {
        if words.len() == self.readings_begin() {
            return Ok(State(words.to_vec()));
        }
        let problem = format!("has {} words; allowed: {}", words.len(), self.readings_begin());
        Err(Invalid::new("state", problem))
    }

    /// The outputs of a cycle, 0 to 1 each: for the left and for the right wheel.
    ///
    /// # Errors
    /// Another number of readings, or one that isn't finite or beyond [`GREATEST_GENE`](crate::batch::GREATEST_GENE).
    pub fn step(&self, state: &mut State, readings: &[f32]) -> Result<[f32; 2], Invalid> {
        if readings.len() != self.inputs.len() {
            let problem = format!("are {}; allowed: {}", readings.len(), self.inputs.len());
            return Err(Invalid::new("readings", problem));
        }
        check("readings", readings)?;
        let mut words = given(state, readings);
        let outputs = words.len() - compose::TAIL.len();
        run(&self.cycle, &self.tables, &mut words);
        state.0.copy_from_slice(&words[..self.readings_begin()]);
        Ok([0, 1].map(|output| f32::from_bits(words[outputs + output])))
    }

    /// Whether a cycle would give other bits if sums took products unrounded, as compilers fuse them.
    pub fn shows_fusing(&self, cycle: &Recorded) -> bool {
        let mut exact = given(&cycle.after, &cycle.readings);
        let outputs = exact.len() - compose::TAIL.len();
        exact[outputs..][..2].copy_from_slice(&cycle.outputs.map(f32::to_bits));
        [true, false].into_iter().any(|is_left| {
            let mut fused = given(&cycle.before, &cycle.readings);
            let mut memory = Memory {
                tables: &self.tables,
                exported: &mut fused,
            };
            // A program may go elsewhere then, as far as for ever.
            interpret::run_fused(&self.cycle, &mut memory, is_left, TURNS).is_err() || fused != exact
        })
    }

    /// The speeds of the left and the right wheel that outputs command, as fractions of full speed, -1 to 1.
    ///
    /// # Errors
    /// Outputs that are not from 0 to 1.
    pub fn wheels(&self, outputs: [f32; 2]) -> Result<[f32; 2], Invalid> {
        if let Some(output) = outputs.iter().find(|output| !(0.0..=1.0).contains(*output)) {
            return Err(Invalid::new("outputs", format!("has {output}; allowed: 0 to 1")));
        }
        let mut words = vec![0; self.readings_begin() + self.inputs.len()];
        words.extend(outputs.map(f32::to_bits));
        words.extend([0; 2]);
        run(&self.wheels, &self.tables_of_wheels, &mut words);
        let speeds = words.len() - 2;
        Ok([0, 1].map(|wheel| f32::from_bits(words[speeds + wheel])))
    }

    /// Simulates an episode in its world, and returns its cycles, each with the states around it. In a swarm, they are those of its robot.
    ///
    /// # Errors
    /// Those of the device; the first cycle in which its outputs are not the simulator's.
    pub fn record(&self, device: &mut dyn Evaluator, key: Key) -> Result<Vec<Recorded>, Error> {
        let robots = self.world.robots();
        let is_swarm = self.world.spec().robot.members().is_some();
        let world = if is_swarm {
            self.world.observed()?
        } else {
            self.world.clone()
        };
        let rollout = Rollout {
            world: 0,
            genes: &self.genome,
            key,
        };
        let batch = Worlds::new(&[&world])?.batch(&[rollout], Some(TraceRequest { every: 1 }))?;
        let mut outcome = device.evaluate(&batch, &Control::new())?;
        let mut traces = vec![outcome.traces.pop().unwrap_or_default()];
        if is_swarm {
            traces = traces[0].by_robot(robots);
        }
        let own = if is_swarm { self.robot as usize } else { 0 };
        let cycles = self.compared(&world, &traces[own], self.begin(key))?;
        if let Some(simulator) = &self.simulator {
            simulator.compared(&world, &traces, key)?;
        }
        Ok(cycles)
    }

    /// The cycles of a trace.
    fn compared(&self, world: &World, trace: &Trace, mut after: State) -> Result<Vec<Recorded>, Error> {
        let details = world.details().iter().enumerate();
        let of_readings = details.filter(|(_, detail)| detail.kind == DetailKind::Perceived);
        let places: Vec<usize> = of_readings.map(|(place, _)| place).collect();
        let mut cycles = Vec::with_capacity(trace.len());
        for (record, details) in trace.lines() {
            let before = after.clone();
            let readings: Vec<f32> = places.iter().map(|place| f32::from_bits(details[*place])).collect();
            let outputs = self.step(&mut after, &readings)?;
            if outputs.map(f32::to_bits) != [record.left, record.right].map(f32::to_bits) {
                let problem = format!(
                    "gives {outputs:?} in cycle {} where its simulator has {:?}; please report it",
                    before.cycle(),
                    [record.left, record.right]
                );
                return Err(Invalid::new("controller", problem).into());
            }
            cycles.push(Recorded {
                before,
                readings,
                outputs,
                after: after.clone(),
            });
        }
        Ok(cycles)
    }
}

/// The tables that any of them has.
fn joined<const N: usize>(all: [Vec<Table>; N]) -> Vec<Table> {
    let mut joined = vec![Table::default(); all[0].len()];
    for (at, table) in all.into_iter().flat_map(|tables| tables.into_iter().enumerate()) {
        if !table.words.is_empty() {
            joined[at] = table;
        }
    }
    joined
}

/// The world of a robot whose wheels do at once and exactly what outputs command.
fn at_once(world: &World) -> Result<World, Invalid> {
    let spec = world.spec();
    let build = match &spec.robot.build {
        Build::Differential(robot) => Build::Differential(Differential {
            acceleration: None,
            latency: None,
            wheel_noise: None,
            wheel_noise_law: None,
            ..robot.clone()
        }),
        other => other.clone(),
    };
    World::new(WorldSpec {
        robot: Robot {
            build,
            ..spec.robot.clone()
        },
        surrogate: None,
        noise: Noise::NONE,
        ..spec.clone()
    })
}

/// What a world's robot reads.
fn inputs(spec: &WorldSpec) -> Vec<Input> {
    let of_kinds = spec.robot.described_sensors().iter().map(|sensor| {
        let range = sensor
            .range
            .map_or_else(String::new, |range| format!(", range {range} mm"));
        let about = sensor.kind.entry().about;
        let about = match (&sensor.response, &sensor.law) {
            (Some(Response(points)), _) => {
                let points: Vec<_> = points
                    .iter()
                    .map(|[near, reading]| format!("{reading} at {near} mm"))
                    .collect();
                format!(
                    "0 to 1, by the distance to the nearest object along a ray: {}{range}",
                    points.join(", ")
                )
            }
            (None, Some(law)) => format!("0 to 1: {about}, law `{}`{range}", law.word()),
            (None, None) => format!("0 to 1: {about}{range}"),
        };
        let name = sensor.name.clone();
        Input { name, about }
    });
    let mut inputs: Vec<Input> = match &spec.robot.build {
        Build::Sampled => {
            let activation = |name: &&str| Input {
                name: (*name).to_owned(),
                about: "0 to 1: activation of the sensor of proximity in this direction, degrees from straight ahead"
                    .to_owned(),
            };
            SENSOR_NAMES.iter().map(activation).collect()
        }
        Build::Forager(own) => foraging::READINGS
            .iter()
            .map(|name| of_forager(&own.foraging, name))
            .collect(),
        Build::Differential(_) => of_kinds.collect(),
    };
    let known: Vec<String> = inputs.iter().map(|input| input.name.clone()).collect();
    let others = spec.readings().into_iter().filter(|name| !known.contains(name));
    let of_user = spec.own.readings();
    let other = |name: String| Input {
        about: if of_user.contains(&name) {
            "-1000 to 1000: reading of the experiment's custom sensors".to_owned()
        } else {
            of_model(&name).to_owned()
        },
        name,
    };
    inputs.extend(others.map(other));
    inputs
}

/// A reading of a forager, whose sensors are named by their bearings.
fn of_forager(foraging: &Foraging, name: &str) -> Input {
    let about = match name.split('_').next() {
        Some("near") => {
            let points = foraging::proximity_points().map(|[mm, reading]| format!("{reading:.4} at {mm} mm"));
            format!(
                "0 to 1, by the distance to the nearest object in this direction: {}",
                points.join(", ")
            )
        }
        Some("light") => format!(
            "0 to 1: the light in this direction; {} without a lamp, more where one is nearer and straighter ahead",
            foraging.ambient
        ),
        _ => "1 if the robot carries food, 0 if not".to_owned(),
    };
    Input {
        name: name.to_owned(),
        about,
    }
}

/// A reading of a reference model.
fn of_model(name: &str) -> &'static str {
    let is_component = name.ends_with("_ahead") || name.ends_with("_left");
    match name.split('_').next() {
        Some("ground") => "0 for black to 1 for white: the reference model's floor",
        Some("prox" | "light") if !is_component => "0 to 1: the reference model's reading in this direction",
        _ => "the reference model's reading, which docs/reference-models.md defines",
    }
}

/// Speed of a wheel that is commanded at 1, mm/s.
fn full_speed(robot: &Robot) -> Option<f32> {
    match &robot.build {
        Build::Sampled => robot.motors.full_speed(),
        Build::Differential(described) if described.sampled_motors => robot.motors.full_speed(),
        Build::Differential(described) => described.greatest_speed,
        Build::Forager(forager) => Some(forager.foraging.greatest_speed),
    }
}

/// The caller's words for a cycle.
fn given(state: &State, readings: &[f32]) -> Vec<u32> {
    let readings = readings.iter().map(|reading| reading.to_bits());
    let words = state.0.iter().copied().chain(readings);
    words.chain([0; compose::TAIL.len()]).collect()
}

fn run(program: &Program, tables: &[Table], exported: &mut [u32]) {
    let mut memory = Memory { tables, exported };
    // Loops of controllers are bounded, and values are set before they are used.
    interpret::run(program, &mut memory, 0, 0, TURNS).expect("it ends");
}

/// The buffers that a controller's program reads, and that of its caller.
struct Memory<'a> {
    tables: &'a [Table],
    exported: &'a mut [u32],
}

impl Memory<'_> {
    fn is_exported(&self, buffer: u32) -> bool {
        buffer as usize == self.tables.len() - 1
    }
}

impl Buffers for Memory<'_> {
    fn elements(&self, buffer: u32) -> u32 {
        if self.is_exported(buffer) {
            return 1;
        }
        let table = &self.tables[buffer as usize];
        table.words.len() as u32 / table.stride
    }

    fn load(&self, buffer: u32, index: usize) -> u32 {
        if self.is_exported(buffer) {
            self.exported[index]
        } else {
            self.tables[buffer as usize].words[index]
        }
    }

    fn store(&mut self, buffer: u32, index: usize, value: u32) {
        debug_assert!(self.is_exported(buffer));
        self.exported[index] = value;
    }
}
