//! The world of a controller, for those who check its simulator: what the sensors read, how robots move, and what the task gives, in C
//! with the simulator's bits.

mod robot;
mod swarm;

use std::collections::BTreeSet;
use std::fmt::Write;

use oneiro_shader_compiler::c;
use oneiro_shader_compiler::interpret;
use oneiro_shader_compiler::language::{self, Memory, touched};
use oneiro_shader_compiler::tree::{Program, Ty};
use oneiro_shaders::episode::Record;

use self::robot::Alone;
use self::swarm::Together;
use super::c::tables;
use super::{Controller, Source, TURNS, Table};
use crate::batch::{Rollout, Trace, TraceRequest, Worlds};
use crate::cpu::Cpu;
use crate::evaluator::{Control, Evaluator};
use crate::outside::reported::Error;
use crate::parameter::Invalid;
use crate::parts::compose::{self, DetailKind};
use crate::random::Key;
use crate::world::differential::Genomes;
use crate::world::{Build, Controller as Kind, World, WorldSpec};

/// The part of its world that is printed with a controller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Also {
    /// What the sensors read at a place.
    pub sensors: bool,
    /// How commands move the robot, and what the task gives for it.
    pub task: bool,
}

/// A world whose robots are commanded.
#[derive(Clone, Debug)]
pub(super) enum Simulator {
    Robot(Box<Alone>),
    Swarm(Box<Together>),
}

/// What is common to both: the kernel's buffers, with the words of those that it only reads.
#[derive(Clone, Debug)]
struct Buffers {
    tables: Vec<Table>,
    /// Where the readings are in a line of the trace.
    readings: Vec<usize>,
    cycles: u32,
    /// An episode that the file knows.
    key: Key,
}

/// Buffers of an episode.
const OF_CALLER: [&str; 4] = ["inputs", "state", "trace", "fitness"];

/// Words of a record, which precede its details.
const RECORD: usize = size_of::<Record>() / size_of::<u32>();

/// Most words of a table.
const GREATEST_TABLE: usize = 1 << 22;

/// A line of a robot's trace: its record, and the bits of its readings.
type Line = (Record, Vec<u32>);

impl Simulator {
    /// # Errors
    /// A world of foragers, and a part of a swarm's.
    pub(super) fn new(world: &World, also: Also, key: Key) -> Result<Self, Invalid> {
        let spec = world.spec();
        if matches!(spec.robot.build, Build::Forager(_)) {
            let problem = "is of foragers; allowed with sensors or task: any other";
            return Err(Invalid::new("world", problem));
        }
        let is_swarm = spec.robot.members().is_some();
        if is_swarm && !(also.sensors && also.task) {
            let problem = "is a swarm's, of which sensors and task are printed together; allowed: both";
            return Err(Invalid::new("world", problem));
        }
        let mut commanded = WorldSpec {
            controller: Kind::Own,
            own: spec.own.with_commands()?,
            ..spec.clone()
        };
        if let Build::Differential(robot) = &mut commanded.robot.build
            && is_swarm
        {
            robot.genomes = Genomes::Heterogeneous;
            // The sensors are also read after the last cycle.
            commanded = commanded.seen_to_its_end();
        }
        let commanded = World::new(commanded)?;
        let kernel = compose::simulated(commanded.kernel())?;
        let source = Source::of(kernel, &commanded, &[], None, &OF_CALLER)?;
        let program = |mode| source.program(mode, GREATEST_TABLE).map(|(program, _)| program);
        let details = commanded.details().iter().enumerate();
        let buffers = Buffers {
            tables: source.tables.clone(),
            readings: details
                .filter(|(_, detail)| detail.kind == DetailKind::Perceived)
                .map(|(at, _)| RECORD + at)
                .collect(),
            cycles: spec.cycles,
            key,
        };
        Ok(if is_swarm {
            let words = Worlds::new(&[&commanded])?.state_words() as u32;
            Self::Swarm(Box::new(Together::new(buffers, commanded.robots(), words, program(0)?)))
        } else {
            Self::Robot(Box::new(Alone::new(buffers, also, program)?))
        })
    }

    /// Compares what it does with the traces of an episode's robots.
    ///
    /// # Errors
    /// The first cycle in which it has other bits.
    pub(super) fn compared(&self, world: &World, traces: &[Trace], key: Key) -> Result<(), Error> {
        let details = world.details().iter().enumerate();
        let places: Vec<usize> = details
            .filter(|(_, detail)| detail.kind == DetailKind::Perceived)
            .map(|(place, _)| place)
            .collect();
        let line = |(record, details): (&Record, &[u32])| -> Line {
            (*record, places.iter().map(|&place| details[place]).collect())
        };
        let lines: Vec<Vec<Line>> = traces.iter().map(|trace| trace.lines().map(line).collect()).collect();
        let wrong = match self {
            Self::Robot(own) => own.differs(&lines[0], key),
            Self::Swarm(own) => own.differs(&lines, key),
        };
        let problem = |cycle| format!("has other bits in cycle {cycle} than its simulator; please report it");
        wrong.map_or(Ok(()), |cycle| Err(Invalid::new("world", problem(cycle)).into()))
    }

    /// Its functions, after those of its controller.
    pub(super) fn c(&self, controller: &Controller, name: &str) -> String {
        match self {
            Self::Robot(own) => own.c(controller, name),
            Self::Swarm(own) => own.c(controller, name),
        }
    }
}

/// A world's part of a file: what is said of it, its types, declarations and constants, and its functions.
#[derive(Debug, Default)]
struct File {
    types: String,
    declarations: String,
    constants: String,
    functions: String,
}

impl File {
    /// Adds a function for whoever includes the file.
    fn function(&mut self, about: &str, head: &str, body: &str) {
        // Writing to a string can't fail.
        let _ = write!(self.declarations, "\n/* {about} */\n{head};\n");
        self.own_function(head, body);
    }

    /// Adds a function that only others here call.
    fn own_function(&mut self, head: &str, body: &str) {
        let _ = write!(self.functions, "\n{head}\n{{\n{body}}}\n");
    }

    fn text(self) -> String {
        let Self {
            types,
            declarations,
            constants,
            functions,
        } = self;
        let constants = constants.trim_end();
        let between = if constants.is_empty() { "" } else { "\n" };
        format!("{types}{declarations}{between}{constants}{between}{functions}")
    }
}

impl Buffers {
    fn place_of(&self, buffer: &str) -> usize {
        let place = self.tables.iter().position(|table| table.name == buffer);
        place.expect("all kernels have it")
    }

    /// Words of an element of a buffer.
    fn stride(&self, buffer: &str) -> u32 {
        self.tables[self.place_of(buffer)].stride
    }

    /// The words of an episode that has not begun, with so many elements of the caller's buffers.
    fn words(&self, of_caller: [usize; OF_CALLER.len()]) -> Vec<Vec<u32>> {
        let words = |table: &Table| match OF_CALLER.iter().position(|name| *name == table.name) {
            Some(own) => vec![0; of_caller[own] * table.stride as usize],
            None if table.words.is_empty() => vec![0],
            None => table.words.clone(),
        };
        self.tables.iter().map(words).collect()
    }

    /// The constants that name the known episode.
    fn known(&self, name: &str) -> String {
        let [key_0, key_1, trial] = [self.key.words[0], self.key.words[1], self.key.trial].map(word);
        format!(
            "/* The random numbers and the trial of a known episode. */
#define {name}_world_KEY_0 {key_0}
#define {name}_world_KEY_1 {key_1}
#define {name}_world_TRIAL {trial}
"
        )
    }

    /// The functions that simulate a whole episode and the known one, by `name_live`.
    fn episodes(&self, file: &mut File, controller: &Controller, name: &str) {
        let [cycles, fitness, poses] = simulated(controller, self.key)
            .expect("its world was simulated before")
            .map(word);
        file.function(
            "A whole episode: what the task gives, and in `cycles` how many it had.",
            &format!("float {name}_episode(uint32_t key_0, uint32_t key_1, uint32_t trial, uint32_t *cycles)"),
            &format!(
                "    {name}_world world;
    {name}_live(&world, key_0, key_1, trial);
    *cycles = world.cycle;
    return world.fitness;
"
            ),
        );
        file.function(
            "0 if the known episode has as many cycles, the same fitness and the same poses here, else 1.",
            &format!("int {name}_check_world(void)"),
            &format!(
                "    {name}_world world;
    {name}_live(&world, {name}_world_KEY_0, {name}_world_KEY_1, {name}_world_TRIAL);
    return world.cycle != {cycles} || bits_of(world.fitness) != {fitness} || world.hash != {poses};
"
            ),
        );
    }

    fn run(&self, program: &Program, words: &mut [Vec<u32>]) {
        let strides: Vec<u32> = self.tables.iter().map(|table| table.stride).collect();
        let mut memory = interpret::Memory {
            buffers: words,
            strides: &strides,
        };
        interpret::run(program, &mut memory, 0, 0, TURNS).expect("it ends");
    }

    /// Programs as statements in C, whose tables' names begin with `name`, and these tables.
    fn printed<const N: usize>(
        &self,
        programs: [&Program; N],
        name: &str,
        of_caller: &[Memory; OF_CALLER.len()],
    ) -> ([String; N], String) {
        let memory = |table: &Table| {
            let elements = (table.words.len() as u32).checked_div(table.stride).unwrap_or(0);
            let own = OF_CALLER.iter().position(|own| *own == table.name);
            own.map_or_else(
                || Memory::Constants(format!("{name}_{}", table.name), elements),
                |own| of_caller[own].clone(),
            )
        };
        let memory: Vec<Memory> = self.tables.iter().map(memory).collect();
        let used: BTreeSet<u32> = programs.iter().flat_map(|program| touched(program)).collect();
        let of_constants = (0..).zip(&self.tables).filter(|(at, _)| used.contains(at));
        let constants: Vec<Table> = of_constants.map(|(_, table)| table.clone()).collect();
        let body = |program: &Program| language::print(program, &c::C, &memory, 1);
        (programs.map(body), tables(&constants, name))
    }
}

/// The number of cycles of an episode, the bits of its fitness, and the hash of the robots' poses before all cycles (FNV-1a, by words).
fn simulated(controller: &Controller, key: Key) -> Result<[u32; 3], Error> {
    let is_swarm = controller.world.spec().robot.members().is_some();
    let world = if is_swarm {
        controller.world.observed()?
    } else {
        controller.world.clone()
    };
    let rollout = Rollout {
        world: 0,
        genes: &controller.genome,
        key,
    };
    let batch = Worlds::new(&[&world])?.batch(&[rollout], Some(TraceRequest { every: 1 }))?;
    let outcome = Cpu::new(Some(1))?.evaluate(&batch, &Control::new())?;
    let trace = &outcome.traces[0];
    let traces = if is_swarm {
        trace.by_robot(world.robots())
    } else {
        vec![trace.clone()]
    };
    let poses = (0..trace.len()).flat_map(|cycle| traces.iter().map(move |trace| trace[cycle]));
    let words = poses.flat_map(|record| [record.x, record.y, record.heading]);
    let hash = words.fold(FNV, |hash, number| (hash ^ number.to_bits()).wrapping_mul(FNV_PRIME));
    Ok([trace.len() as u32, outcome.fitness[0].to_bits(), hash])
}

/// Of the FNV-1a hash.
const FNV: u32 = 0x811c_9dc5;
const FNV_PRIME: u32 = 0x0100_0193;

/// A word in C.
fn word(bits: u32) -> String {
    c::constant(bits, Ty::U32)
}
