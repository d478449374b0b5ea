//! The world of a single robot.

use std::fmt::Write;

use oneiro_shader_compiler::language::Memory;
use oneiro_shader_compiler::tree::{Program, Ty};
use oneiro_shaders::episode::Record;

use super::{Also, Buffers, FNV, FNV_PRIME, File, Line, RECORD};
use crate::outside::export::Controller;
use crate::outside::export::c::arguments_of_reset;
use crate::parameter::Invalid;
use crate::random::Key;

/// Tasks of its kernel, in `simulated.wgsl`.
const BEGIN: u32 = 0;
const PLACE: u32 = 1;
const SENSE: u32 = 2;
const DRIVE: u32 = 3;

/// Its inputs in C.
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

/// A robot's world.
#[derive(Clone, Debug)]
pub(in crate::outside::export) struct Alone {
    buffers: Buffers,
    also: Also,
    begin: Program,
    place: Program,
    sense: Program,
    drive: Program,
}

impl Alone {
    pub(super) fn new(
        buffers: Buffers,
        also: Also,
        program: impl Fn(u32) -> Result<Program, Invalid>,
    ) -> Result<Self, Invalid> {
        Ok(Self {
            buffers,
            also,
            begin: program(BEGIN)?,
            place: program(PLACE)?,
            sense: program(SENSE)?,
            drive: program(DRIVE)?,
        })
    }

    /// The first cycle of a trace in which it has other bits.
    pub(super) fn differs(&self, lines: &[Line], key: Key) -> Option<usize> {
        let own = &self.buffers;
        let mut words = own.words([INPUTS.len(), 1, 1, 1]);
        let [inputs, trace] = ["inputs", "trace"].map(|buffer| own.place_of(buffer));
        words[inputs][..COMMANDS].copy_from_slice(&[key.words[0], key.words[1], key.trial]);
        own.run(&self.begin, &mut words);
        let bits = |floats: &[f32]| floats.iter().map(|float| float.to_bits()).collect::<Vec<u32>>();
        let pose = |record: &Record| bits(&[record.x, record.y, record.heading]);
        let done = |record: &Record| bits(&[record.speed_left, record.speed_right, record.collided, record.reward]);
        (0..lines.len()).find(|&cycle| {
            let (record, readings) = &lines[cycle];
            words[inputs][CYCLE] = cycle as u32;
            own.run(&self.sense, &mut words);
            let reads: Vec<u32> = own.readings.iter().map(|&at| words[trace][at]).collect();
            words[inputs][COMMANDS..CYCLE].copy_from_slice(&[record.left, record.right].map(f32::to_bits));
            own.run(&self.drive, &mut words);
            let after: Record = bytemuck::pod_read_unaligned(bytemuck::cast_slice(&words[trace][..RECORD]));
            let next = lines.get(cycle + 1);
            let is_there = next.is_none_or(|(next, _)| pose(next) == pose(&after));
            !(reads == *readings && done(record) == done(&after) && is_there)
        })
    }

    pub(super) fn c(&self, controller: &Controller, name: &str) -> String {
        let world = format!("{name}_world");
        let inputs = INPUTS.map(|(place, ty)| (place.to_owned(), ty)).to_vec();
        let of_caller = [
            Memory::Places(inputs),
            Memory::Words("world->words".to_owned(), 1),
            Memory::Words("line".to_owned(), 1),
            Memory::Places(vec![("over".to_owned(), Ty::F32)]),
        ];
        let programs = [&self.begin, &self.place, &self.sense, &self.drive];
        let ([begin, place, sense, drive], constants) = self.buffers.printed(programs, &world, &of_caller);
        let [state, line] = ["state", "trace"].map(|buffer| self.buffers.stride(buffer));
        // Where the robot is now, and what the task has given.
        let now = "    world->pose[0] = number_of(line[0]);
    world->pose[1] = number_of(line[1]);
    world->pose[2] = number_of(line[2]);
    world->fitness = number_of(line[11]);
";
        let mut file = File {
            types: format!(
                "
/* The world that the controller was evolved in, with the simulator's bits. Lengths are in mm. */
enum {{
    {world}_CYCLES = {}
}};

{}
/* An episode: the key of its random numbers, its trial, its next cycle, where the robot is, what the task gives so far, whether it is over,
   a hash of its poses, and what is remembered. */
typedef struct {{
    uint32_t key_0;
    uint32_t key_1;
    uint32_t trial;
    uint32_t cycle;
    float pose[3];
    float fitness;
    bool is_over;
    uint32_t hash;
    uint32_t words[{state}];
}} {world};
",
                self.buffers.cycles,
                self.buffers.known(name),
            ),
            constants,
            ..File::default()
        };
        file.function(
            "Begins an episode: the robot is at its start.",
            &format!("void {world}_begin({world} *world, uint32_t key_0, uint32_t key_1, uint32_t trial)"),
            &format!(
                "    uint32_t line[{line}];
    float over;
    world->key_0 = key_0;
    world->key_1 = key_1;
    world->trial = trial;
    world->cycle = 0u;
    world->hash = {FNV}u;
{begin}{now}    world->is_over = over != 0.0f;
"
            ),
        );
        file.function(
            "Puts the robot to a pose: x, y, and the heading in turns, counter-clockwise from the x axis.",
            &format!("void {world}_place({world} *world, const float *pose)"),
            &format!(
                "    world->pose[0] = pose[0];
    world->pose[1] = pose[1];
    world->pose[2] = pose[2];
{place}"
            ),
        );
        if self.also.sensors {
            let mut body = format!(
                "    static const float outputs[2] = {{0.5f, 0.5f}};
    uint32_t line[{line}];
    (void)outputs;
{sense}"
            );
            for (input, at) in self.buffers.readings.iter().enumerate() {
                let _ = writeln!(body, "    inputs[{input}] = number_of(line[{at}]);");
            }
            file.function(
                "What the sensors read in this cycle where the robot is, with their noise: the controller's inputs.",
                &format!("void {world}_sense(const {world} *world, float *inputs)"),
                &body,
            );
        }
        if self.also.task {
            let _ = write!(
                file.types,
                "
/* What came of a cycle: where the robot is, the speeds of its wheels as fractions of full speed, whether it touches something, what the
   task gives for the cycle, what it gives for all so far, and whether the episode is over. */
typedef struct {{
    float pose[3];
    float speeds[2];
    bool collided;
    float reward;
    float fitness;
    bool is_over;
}} {world}_cycle;
"
            );
            file.function(
                "A cycle in which the wheels are commanded by the controller's outputs.",
                &format!("void {world}_drive({world} *world, const float *outputs, {world}_cycle *after)"),
                &format!(
                    "    uint32_t line[{line}];
    float over;
    int i;
    for (i = 0; i < 3; i++) {{
        world->hash = (world->hash ^ bits_of(world->pose[i])) * {FNV_PRIME}u;
    }}
{drive}{now}    after->pose[0] = world->pose[0];
    after->pose[1] = world->pose[1];
    after->pose[2] = world->pose[2];
    after->speeds[0] = number_of(line[7]);
    after->speeds[1] = number_of(line[8]);
    after->collided = number_of(line[9]) != 0.0f;
    after->reward = number_of(line[10]);
    after->fitness = world->fitness;
    world->cycle = world->cycle + 1u;
    world->is_over = over != 0.0f || world->cycle >= {world}_CYCLES;
    after->is_over = world->is_over;
"
                ),
            );
        }
        if self.also.sensors && self.also.task {
            let seeds = arguments_of_reset(controller);
            file.own_function(
                &format!("static void {name}_live({world} *world, uint32_t key_0, uint32_t key_1, uint32_t trial)"),
                &format!(
                    "    {world}_cycle after;
    {name}_state state;
    float inputs[{name}_INPUTS + 1];
    float outputs[2];
    {world}_begin(world, key_0, key_1, trial);
    {name}_reset(&state{seeds});
    while (!world->is_over) {{
        {world}_sense(world, inputs);
        {name}_step(&state, inputs, outputs);
        {world}_drive(world, outputs, &after);
    }}
"
                ),
            );
            self.buffers.episodes(&mut file, controller, name);
        }
        file.text()
    }
}
