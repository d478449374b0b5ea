//! The world of a swarm. All robots read at the end of the cycle before, as sensors may remember what they read.

use std::fmt::Write;

use oneiro_shader_compiler::language::Memory;
use oneiro_shader_compiler::tree::Program;
use oneiro_shaders::episode::Record;

use super::{Buffers, FNV, FNV_PRIME, File, Line, RECORD};
use crate::batch::KEY_WORDS;
use crate::outside::export::Controller;
use crate::random::Key;

/// Inputs of a robot: the commands of its wheels, and the number of cycles that the episode has had when this one is over.
const EACH: usize = 3;

/// Cycles that are compared with a trace: they are interpreted, of all robots.
const COMPARED: usize = 12;

/// A swarm's world.
#[derive(Clone, Debug)]
pub(in crate::outside::export) struct Together {
    buffers: Buffers,
    robots: usize,
    /// Words of its state.
    words: u32,
    cycle: Program,
}

impl Together {
    pub(super) fn new(buffers: Buffers, robots: u32, words: u32, cycle: Program) -> Self {
        Self {
            buffers,
            robots: robots as usize,
            words,
            cycle,
        }
    }

    /// The first cycle of the robots' traces in which it has other bits.
    pub(super) fn differs(&self, lines: &[Vec<Line>], key: Key) -> Option<usize> {
        let own = &self.buffers;
        let of_inputs = KEY_WORDS + EACH * self.robots;
        let mut words = own.words([of_inputs, self.words as usize, self.robots, 1]);
        let [inputs, trace] = ["inputs", "trace"].map(|buffer| own.place_of(buffer));
        let width = own.stride("trace") as usize;
        words[inputs][..KEY_WORDS].copy_from_slice(&[key.words[0], key.words[1], key.trial]);
        own.run(&self.cycle, &mut words);
        (0..lines[0].len().min(COMPARED)).find(|&cycle| {
            let mut is_same = true;
            for (robot, lines) in lines.iter().enumerate() {
                let (record, readings) = &lines[cycle];
                let now = &words[trace][robot * width..][..width];
                let reads: Vec<u32> = own.readings.iter().map(|&at| now[at]).collect();
                let there: Record = bytemuck::pod_read_unaligned(bytemuck::cast_slice(&now[..RECORD]));
                let pose = |record: &Record| [record.x, record.y, record.heading].map(f32::to_bits);
                is_same &= reads == *readings && pose(record) == pose(&there);
                let outputs = [record.left.to_bits(), record.right.to_bits(), cycle as u32 + 1];
                words[inputs][KEY_WORDS + EACH * robot..][..EACH].copy_from_slice(&outputs);
            }
            own.run(&self.cycle, &mut words);
            !is_same
        })
    }

    pub(super) fn c(&self, controller: &Controller, name: &str) -> String {
        let world = format!("{name}_world");
        let of_inputs = KEY_WORDS + EACH * self.robots;
        let of_caller = [
            Memory::Words("inputs".to_owned(), of_inputs as u32),
            Memory::Words("world->words".to_owned(), self.words),
            Memory::Words("world->lines".to_owned(), self.robots as u32),
            Memory::Words("fitness".to_owned(), 1),
        ];
        let ([cycle], constants) = self.buffers.printed([&self.cycle], &world, &of_caller);
        let (robots, line) = (self.robots, self.buffers.stride("trace"));
        let mut readings = String::new();
        for (input, at) in self.buffers.readings.iter().enumerate() {
            let _ = writeln!(readings, "    inputs[{input}] = number_of(line[{at}]);");
        }
        let mut file = File {
            types: format!(
                "
/* The world that the controllers were evolved in, with the simulator's bits. Lengths are in mm. */
enum {{
    {world}_CYCLES = {cycles},
    {world}_ROBOTS = {robots}
}};

{known}
/* An episode: the key of its random numbers, its trial, its next cycle, where the robots are, what the task gives so far, whether it is over,
   a hash of their poses, what is remembered, and what all robots read. */
typedef struct {{
    uint32_t key_0;
    uint32_t key_1;
    uint32_t trial;
    uint32_t cycle;
    float poses[{world}_ROBOTS][3];
    float fitness;
    bool is_over;
    uint32_t hash;
    uint32_t words[{words}];
    uint32_t lines[{lines}];
}} {world};

/* What came of a cycle for a robot: where it is, whether it touches something, and what the task gives it for the cycle; what the task gives
   for all so far, and whether the episode is over. */
typedef struct {{
    float pose[3];
    bool collided;
    float reward;
    float fitness;
    bool is_over;
}} {world}_cycle;
",
                cycles = self.buffers.cycles,
                known = self.buffers.known(name),
                words = self.words,
                lines = line as usize * robots,
            ),
            constants,
            ..File::default()
        };
        file.own_function(
            &format!("static void {world}_run({world} *world, const float *outputs)"),
            &format!(
                "    uint32_t inputs[{of_inputs}];
    uint32_t fitness[1];
    int robot;
    inputs[0] = world->key_0;
    inputs[1] = world->key_1;
    inputs[2] = world->trial;
    for (robot = 0; robot < {robots}; robot++) {{
        inputs[{KEY_WORDS} + {EACH} * robot] = bits_of(outputs[2 * robot]);
        inputs[{KEY_WORDS} + {EACH} * robot + 1] = bits_of(outputs[2 * robot + 1]);
        inputs[{KEY_WORDS} + {EACH} * robot + 2] = world->cycle;
    }}
{cycle}    world->fitness = number_of(fitness[0]);
    world->is_over = number_of(world->lines[8]) != 0.0f || world->cycle >= {world}_CYCLES;
    for (robot = 0; robot < {robots}; robot++) {{
        world->poses[robot][0] = number_of(world->lines[{line} * robot]);
        world->poses[robot][1] = number_of(world->lines[{line} * robot + 1]);
        world->poses[robot][2] = number_of(world->lines[{line} * robot + 2]);
    }}
"
            ),
        );
        file.function(
            "Begins an episode: the robots are at their starts.",
            &format!("void {world}_begin({world} *world, uint32_t key_0, uint32_t key_1, uint32_t trial)"),
            &format!(
                "    static const float outputs[2 * {world}_ROBOTS] = {{0.0f}};
    world->key_0 = key_0;
    world->key_1 = key_1;
    world->trial = trial;
    world->cycle = 0u;
    world->hash = {FNV}u;
    {world}_run(world, outputs);
"
            ),
        );
        file.function(
            "What a robot's sensors read in this cycle, with their noise: its controller's inputs.",
            &format!("void {world}_sense(const {world} *world, int robot, float *inputs)"),
            &format!(
                "    const uint32_t *line = world->lines + {line} * robot;
    (void)line;
{readings}"
            ),
        );
        file.function(
            "A cycle in which all wheels are commanded, by two outputs of each robot's controller.",
            &format!("void {world}_drive({world} *world, const float *outputs, {world}_cycle *after)"),
            &format!(
                "    int robot;
    int i;
    for (robot = 0; robot < {robots}; robot++) {{
        for (i = 0; i < 3; i++) {{
            world->hash = (world->hash ^ bits_of(world->poses[robot][i])) * {FNV_PRIME}u;
        }}
    }}
    world->cycle = world->cycle + 1u;
    {world}_run(world, outputs);
    for (robot = 0; robot < {robots}; robot++) {{
        const uint32_t *line = world->lines + {line} * robot;
        after[robot].pose[0] = world->poses[robot][0];
        after[robot].pose[1] = world->poses[robot][1];
        after[robot].pose[2] = world->poses[robot][2];
        after[robot].collided = number_of(line[9]) != 0.0f;
        after[robot].reward = number_of(line[10]);
        after[robot].fitness = world->fitness;
        after[robot].is_over = world->is_over;
    }}
"
            ),
        );
        if controller.is_every_robots() {
            let seeds = if controller.asks_for_trial() { ", trial" } else { "" };
            // Robots that all have this controller.
            file.own_function(
                &format!("static void {name}_live({world} *world, uint32_t key_0, uint32_t key_1, uint32_t trial)"),
                &format!(
                    "    {world}_cycle after[{world}_ROBOTS];
    {name}_state states[{world}_ROBOTS];
    float inputs[{name}_INPUTS + 1];
    float outputs[2 * {world}_ROBOTS];
    int robot;
    {world}_begin(world, key_0, key_1, trial);
    for (robot = 0; robot < {robots}; robot++) {{
        {name}_reset(&states[robot]{seeds});
    }}
    while (!world->is_over) {{
        for (robot = 0; robot < {robots}; robot++) {{
            {world}_sense(world, robot, inputs);
            {name}_step(&states[robot], inputs, outputs + 2 * robot);
        }}
        {world}_drive(world, outputs, after);
    }}
"
                ),
            );
            self.buffers.episodes(&mut file, controller, name);
        }
        file.text()
    }
}
