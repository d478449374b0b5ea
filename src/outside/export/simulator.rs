//! The world of a single robot beside its controller, for those who check its simulator: what the sensors read, how the robot moves, and what
//! its task gives, in C with the simulator's bits.

use std::collections::BTreeSet;
use std::fmt::Write;

use oneiro_shader_compiler::c;
use oneiro_shader_compiler::interpret::{self, Memory as Words};
use oneiro_shader_compiler::language::{self, Memory, touched};
use oneiro_shader_compiler::tree::{Program, Ty};
use oneiro_shaders::episode::Record;

use super::c::{arguments_of_reset, tables};
use super::{Controller, Recorded, Source, State, TURNS, Table};
use crate::parameter::Invalid;
use crate::parts::compose::{self, DetailKind};
use crate::world::{Build, Controller as Kind, World, WorldSpec};

/// What of its world is printed with a controller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Also {
    /// What the sensors read at a place.
    pub sensors: bool,
    /// How commands move the robot, and what the task gives for it.
    pub task: bool,
}

/// Tasks of its kernel, in `simulated.wgsl`.
const BEGIN: u32 = 0;
const PLACE: u32 = 1;
const SENSE: u32 = 2;
const DRIVE: u32 = 3;

/// Buffers of an episode, and the inputs' places in C.
const OF_CALLER: [&str; 4] = ["inputs", "state", "trace", "fitness"];
const INPUTS: [(&str, Ty); 9] = [
    ("world->key_0", Ty::U32),
    ("world->key_1", Ty::U32),
    ("world->trial", Ty::U32),
    ("outputs[0]", Ty::F32),
    ("outputs[1]", Ty::F32),
    ("world->cycle", Ty::U32),
    ("pose[0]", Ty::F32),
    ("pose[1]", Ty::F32),
    ("pose[2]", Ty::F32),
];
/// The place of the commands there, and of the cycle.
const COMMANDS: usize = 3;
const CYCLE: usize = 5;

/// Words of a record, which precede its details.
const RECORD: usize = size_of::<Record>() / size_of::<u32>();

/// A world.
#[derive(Clone, Debug)]
pub(super) struct Simulator {
    also: Also,
    begin: Program,
    place: Program,
    sense: Program,
    drive: Program,
    tables: Vec<Table>,
    /// Where the readings are in a line of the trace.
    readings: Vec<usize>,
    cycles: u32,
}

/// An episode that was simulated.
#[derive(Clone, Copy, Debug)]
pub(super) struct Episode {
    pub(super) cycles: u32,
    pub(super) fitness: f32,
}

/// Most words of a table.
const GREATEST_TABLE: usize = 1 << 22;

impl Simulator {
    /// # Errors
    /// A world of several robots, or of foragers.
    pub(super) fn new(world: &World, also: Also) -> Result<Self, Invalid> {
        let spec = world.spec();
        if spec.robot.members().is_some() || matches!(spec.robot.build, Build::Forager(_)) {
            let problem = "is of a swarm or of foragers, whose world isn't printed; allowed with sensors or task: a single robot's";
            return Err(Invalid::new("world", problem));
        }
        let commanded = World::new(WorldSpec {
            controller: Kind::Own,
            own: spec.own.with_commands()?,
            ..spec.clone()
        })?;
        let source = Source::of(
            compose::simulated(commanded.kernel())?,
            &commanded,
            &[],
            None,
            &OF_CALLER,
        )?;
        let program = |mode| source.program(mode, GREATEST_TABLE).map(|(program, _)| program);
        let [begin, place, sense, drive] = [program(BEGIN)?, program(PLACE)?, program(SENSE)?, program(DRIVE)?];
        let of_readings = commanded.details().iter().enumerate();
        Ok(Self {
            also,
            readings: of_readings
                .filter(|(_, detail)| detail.kind == DetailKind::Perceived)
                .map(|(at, _)| RECORD + at)
                .collect(),
            tables: source.tables,
            begin,
            place,
            sense,
            drive,
            cycles: spec.cycles,
        })
    }

    /// An episode in its world, with the controller; `seen` gets the readings of each cycle and what came of it.
    ///
    /// # Errors
    /// Those of the controller.
    pub(super) fn run(
        &self,
        controller: &Controller,
        mut state: State,
        mut seen: impl FnMut(&[f32], &Record),
    ) -> Result<Episode, Invalid> {
        let strides: Vec<u32> = self.tables.iter().map(|table| table.stride).collect();
        let words = |table: &Table| match table.name.as_str() {
            "inputs" => vec![0; INPUTS.len()],
            name if OF_CALLER.contains(&name) => vec![0; table.stride as usize],
            _ if table.words.is_empty() => vec![0],
            _ => table.words.clone(),
        };
        let mut buffers: Vec<Vec<u32>> = self.tables.iter().map(words).collect();
        let [inputs, trace, over] = ["inputs", "trace", "fitness"].map(|name| self.place_of(name));
        buffers[inputs][..COMMANDS].copy_from_slice(&state.words()[..COMMANDS]);
        let run = |program: &Program, buffers: &mut Vec<Vec<u32>>| {
            let mut memory = Words {
                buffers,
                strides: &strides,
            };
            interpret::run(program, &mut memory, 0, 0, TURNS).expect("it ends");
        };
        run(&self.begin, &mut buffers);
        let mut episode = Episode {
            cycles: 0,
            fitness: 0.0,
        };
        while episode.cycles < self.cycles && buffers[over][0] == 0 {
            buffers[inputs][CYCLE] = episode.cycles;
            run(&self.sense, &mut buffers);
            let line = &buffers[trace];
            let readings: Vec<f32> = self.readings.iter().map(|&at| f32::from_bits(line[at])).collect();
            let outputs = controller.step(&mut state, &readings)?;
            buffers[inputs][COMMANDS..CYCLE].copy_from_slice(&outputs.map(f32::to_bits));
            run(&self.drive, &mut buffers);
            let after: Record = bytemuck::pod_read_unaligned(bytemuck::cast_slice(&buffers[trace][..RECORD]));
            seen(&readings, &after);
            episode.cycles += 1;
            episode.fitness = after.fitness;
        }
        Ok(episode)
    }

    fn place_of(&self, buffer: &str) -> usize {
        let place = self.tables.iter().position(|table| table.name == buffer);
        place.expect("all kernels have it")
    }

    /// Its functions, after those of its controller; `cycles` are the controller's.
    pub(super) fn c(&self, controller: &Controller, name: &str, cycles: &[Recorded]) -> String {
        let own = format!("{name}_world");
        let mut printed = vec![("begin", &self.begin), ("place", &self.place)];
        if self.also.sensors {
            printed.push(("sense", &self.sense));
        }
        if self.also.task {
            printed.push(("drive", &self.drive));
        }
        let inputs: Vec<_> = INPUTS.iter().map(|(place, ty)| ((*place).to_owned(), *ty)).collect();
        let memory = |table: &Table| match table.name.as_str() {
            "inputs" => Memory::Places(inputs.clone()),
            "state" => Memory::Words("world->words".to_owned(), 1),
            "trace" => Memory::Words("line".to_owned(), 1),
            "fitness" => Memory::Places(vec![("over".to_owned(), Ty::F32)]),
            other => {
                let elements = (table.words.len() as u32).checked_div(table.stride).unwrap_or(0);
                Memory::Constants(format!("{own}_{other}"), elements)
            }
        };
        let memory: Vec<_> = self.tables.iter().map(memory).collect();
        let used: BTreeSet<u32> = printed.iter().flat_map(|(_, program)| touched(program)).collect();
        let constants = self.tables.iter().enumerate().map(|(at, table)| Table {
            words: if used.contains(&(at as u32)) {
                table.words.clone()
            } else {
                Vec::new()
            },
            ..table.clone()
        });
        let constants = tables(&constants.collect::<Vec<_>>(), &own);
        let body = |program: &Program| language::print(program, &c::C, &memory, 1);
        let [state, line] = ["state", "trace"].map(|buffer| self.tables[self.place_of(buffer)].stride);
        let mut text = format!(
            "
/* The world that the controller was evolved in, with the simulator's bits: an episode of up to {cycles} cycles. Lengths are in mm. */
enum {{
    {own}_CYCLES = {cycles}
}};

/* An episode: the key of its random numbers, its trial, its next cycle, and what is remembered. */
typedef struct {{
    uint32_t key_0, key_1, trial, cycle;
    uint32_t words[{state}];
}} {own};

{constants}/* Begins an episode: the robot is at its start. */
void {own}_begin({own} *world, uint32_t key_0, uint32_t key_1, uint32_t trial)
{{
    world->key_0 = key_0;
    world->key_1 = key_1;
    world->trial = trial;
    world->cycle = 0;
{}}}

/* Puts the robot to a pose: x, y, and the heading in turns, counter-clockwise from the x axis. */
void {own}_place({own} *world, const float *pose)
{{
{}}}
",
            body(&self.begin),
            body(&self.place),
            cycles = self.cycles,
        );
        if self.also.sensors {
            let _ = writeln!(
                text,
                "
/* What the sensors read in this cycle where the robot is, with their noise: the controller's inputs. */
void {own}_sense(const {own} *world, float *inputs)
{{
    static const float outputs[2] = {{0.5f, 0.5f}};
    uint32_t line[{line}];
    (void)outputs;
{}",
                body(&self.sense)
            );
            for (input, at) in self.readings.iter().enumerate() {
                let _ = writeln!(text, "    inputs[{input}] = number_of(line[{at}]);");
            }
            text += "}\n";
        }
        if self.also.task {
            let _ = write!(
                text,
                "
/* What came of a cycle: where the robot is, the speeds of its wheels as fractions of full speed, whether it touches something, what the
   task gives for the cycle, what it gives for all so far, and whether the episode is over. */
typedef struct {{
    float pose[3], speeds[2];
    bool collided;
    float reward, fitness;
    bool is_over;
}} {own}_cycle;

/* A cycle in which the wheels are commanded by the controller's outputs. */
void {own}_drive({own} *world, const float *outputs, {own}_cycle *after)
{{
    uint32_t line[{line}];
    float over;
{}    after->pose[0] = number_of(line[0]);
    after->pose[1] = number_of(line[1]);
    after->pose[2] = number_of(line[2]);
    after->speeds[0] = number_of(line[7]);
    after->speeds[1] = number_of(line[8]);
    after->collided = number_of(line[9]) != 0.0f;
    after->reward = number_of(line[10]);
    after->fitness = number_of(line[11]);
    world->cycle = world->cycle + 1;
    after->is_over = over != 0.0f || world->cycle >= {own}_CYCLES;
}}
",
                body(&self.drive)
            );
        }
        if self.also.sensors && self.also.task {
            text += &self.episode(controller, name, cycles);
        }
        text
    }

    /// The functions that need both.
    fn episode(&self, controller: &Controller, name: &str, cycles: &[Recorded]) -> String {
        let begin = cycles[0].before.words();
        let state = controller.reset([begin[0], begin[1]], begin[2]);
        let episode = self.run(controller, state, |_, _| ());
        let Episode { cycles, fitness } = episode.expect("it was simulated before");
        let [key_0, key_1, trial, fitness] =
            [begin[0], begin[1], begin[2], fitness.to_bits()].map(|word| c::constant(word, Ty::U32));
        let seeds = arguments_of_reset(controller);
        format!(
            "
/* A whole episode: what it gives, and in `cycles` how many it had. */
float {name}_episode(uint32_t key_0, uint32_t key_1, uint32_t trial, uint32_t *cycles)
{{
    {name}_world world;
    {name}_world_cycle after;
    {name}_state state;
    float inputs[{name}_INPUTS + 1], outputs[2];
    {name}_world_begin(&world, key_0, key_1, trial);
    {name}_reset(&state{seeds});
    do {{
        {name}_world_sense(&world, inputs);
        {name}_step(&state, inputs, outputs);
        {name}_world_drive(&world, outputs, &after);
    }} while (!after.is_over);
    *cycles = world.cycle;
    return after.fitness;
}}

/* 0 if a recorded episode has the same cycles and the same fitness here, else 1. */
int {name}_check_world(void)
{{
    uint32_t cycles;
    const float fitness = {name}_episode({key_0}, {key_1}, {trial}, &cycles);
    return cycles != {cycles}u || bits_of(fitness) != {fitness};
}}
"
        )
    }
}
