//! Episodes whose wheels are commanded from outside, cycle by cycle: the simulator as an environment for reinforcement learning, or
//! for a controller in another language. Sensors, motion and task run in the same code as whole episodes: with a controller's
//! commands, an episode has the same bits as that controller's episode. In a swarm each robot is commanded.
//!
//! ```
//! use oneiro::cpu::Cpu;
//! use oneiro::evaluator::Control;
//! use oneiro::random::Key;
//! use oneiro::stepped::Stepped;
//! use oneiro::world::WorldSpec;
//!
//! let mut cpu = Cpu::new(Some(1))?;
//! let mut episodes = Stepped::new(&WorldSpec::miglino1995(), 2)?;
//! episodes.begin(&mut cpu, &Control::new(), &[(0, Key::rollout(1, 0, 0, 0)), (1, Key::rollout(1, 0, 1, 0))])?;
//! assert_eq!(episodes.readings().len(), 2 * 8);
//! // Both wheels forwards, and a turn on the spot.
//! episodes.step(&mut cpu, &Control::new(), &[0, 1], &[0.9, 0.9, 0.1, 0.9])?;
//! assert!(episodes.rewards()[0] >= 0.0 && episodes.cycles() == [1, 1]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use oneiro_shaders::episode::{Group, Record};
use rayon::prelude::*;

use crate::batch::{GREATEST_GENE, KEY_WORDS, LANES, LEAST_GENE, PartResult, Worlds, input_words};
use crate::differential::Genomes;
use crate::evaluator::{Control, Evaluator};
pub use crate::outside::reported::Error;
use crate::parameter::Invalid;
use crate::parts::compose::{Detail, DetailKind};
use crate::random::Key;
use crate::world::{Build, Controller, World, WorldSpec};

/// Commands of a robot in a cycle: the left and the right motor's.
pub const COMMANDS: usize = 2;

/// Most cycles of a stepped episode: one less than of any other, since its sensors are also read after the last one.
pub const GREATEST_CYCLES: u32 = 999_999;

/// Words of a record, which precede its details.
const RECORD: usize = size_of::<Record>() / size_of::<u32>();

/// So many episodes are packed and read on several threads.
pub const MANY: usize = 4096;

/// Genes of a robot: its commands, and the cycles that its episode has had after this one.
const GENES: usize = COMMANDS + 1;

/// Episodes in a world, in any of their cycles.
#[derive(Debug)]
pub struct Stepped {
    world: World,
    worlds: Worlds,
    /// Cycles of an episode.
    length: u32,
    /// Robots of an episode.
    robots: usize,
    /// Where the readings are in a line.
    places: Vec<usize>,
    keys: Vec<Key>,
    /// Cycles that each episode has had.
    cycles: Vec<u32>,
    /// Whether each episode has begun, and hasn't ended.
    alive: Vec<bool>,
    /// State of each episode, in the slot of its number, and of the idle slots that fill the last group.
    states: Vec<u32>,
    readings: Vec<f32>,
    rewards: Vec<f64>,
    /// Whether the task has a score that need not be the sum of all rewards: then a reward is its change.
    is_scored: bool,
    poses: Vec<[f32; 3]>,
    fitness: Vec<f32>,
    ended: Vec<bool>,
}

impl Stepped {
    /// Episodes in a world, of which none has begun. Its controller is left out.
    ///
    /// # Errors
    /// The first invalid value; no episode or more than 2^20; episodes of more than [`GREATEST_CYCLES`]. Without the feature
    /// `compose`, always.
    pub fn new(spec: &WorldSpec, episodes: usize) -> Result<Self, Invalid> {
        const MOST: usize = 1 << 20;
        if episodes == 0 || episodes > MOST {
            let problem = format!("are {episodes}; allowed: 1 to {MOST}");
            return Err(Invalid::new("episodes", problem));
        }
        if spec.cycles > GREATEST_CYCLES {
            let problem = format!(
                "is {}; allowed: 1 to {GREATEST_CYCLES} if episodes are stepped",
                spec.cycles
            );
            return Err(Invalid::new("cycles", problem));
        }
        let mut spec = WorldSpec {
            controller: Controller::Own,
            own: spec.own.with_commands()?,
            // The sensors are also read after the last cycle.
            ..spec.clone().seen_to_its_end()
        };
        if let Build::Differential(robot) = &mut spec.robot.build
            && robot.count.is_some()
        {
            robot.genomes = Genomes::Heterogeneous;
        }
        let length = spec.cycles - spec.cycles_after;
        let world = World::new(spec)?;
        let worlds = Worlds::new(std::slice::from_ref(&world))?;
        let details = world.details().iter().enumerate();
        let places: Vec<usize> = details
            .filter(|(_, detail)| detail.kind == DetailKind::Perceived)
            .map(|(index, _)| RECORD + index)
            .collect();
        let robots = world.robots() as usize;
        Ok(Self {
            length,
            robots,
            keys: vec![Key::default(); episodes],
            cycles: vec![0; episodes],
            alive: vec![false; episodes],
            states: vec![0; episodes.next_multiple_of(LANES) * worlds.state_words()],
            readings: vec![0.0; episodes * robots * places.len()],
            rewards: vec![0.0; episodes * robots],
            is_scored: world.is_scored(),
            poses: vec![[0.0; 3]; episodes * robots],
            fitness: vec![0.0; episodes],
            ended: vec![false; episodes],
            places,
            world,
            worlds,
        })
    }

    /// The world, with commands from outside as its controller, and a cycle more than an episode has.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Robots of an episode.
    pub fn robots(&self) -> usize {
        self.robots
    }

    /// Names of a robot's readings: the robot's, then those of a user's sensors.
    pub fn names(&self) -> Vec<String> {
        let readings = self.world.spec().robot.build.readings();
        let details = self.world.details().iter();
        let perceived = details.filter(|detail| detail.kind == DetailKind::Perceived);
        // Sampled sensors are numbered there.
        let name = |detail: &Detail| {
            let number = detail.name.parse::<usize>().ok();
            number.map_or_else(|| detail.name.clone(), |number| readings[number].clone())
        };
        perceived.map(name).collect()
    }

    /// Readings of each robot of each episode, as its controller would get them in its next cycle. All are 0 once the episode has
    /// ended early.
    pub fn readings(&self) -> &[f32] {
        &self.readings
    }

    /// Reward of each robot of each episode in its last cycle. In a swarm it is what the robot has earned, plus what the mission gives for
    /// all of them together; if the mission has a score, it is the score's change.
    pub fn rewards(&self) -> &[f64] {
        &self.rewards
    }

    /// Pose of each robot of each episode: x and y in mm, and the heading in turns.
    pub fn poses(&self) -> &[[f32; 3]] {
        &self.poses
    }

    /// Fitness of each episode so far: what it would be if the episode ended now.
    pub fn fitness(&self) -> &[f32] {
        &self.fitness
    }

    /// Cycles that each episode has had.
    pub fn cycles(&self) -> &[u32] {
        &self.cycles
    }

    /// Whether each episode has been ended early, by its task or an empty battery.
    pub fn ended(&self) -> &[bool] {
        &self.ended
    }

    /// Whether each episode has begun, and has cycles left.
    pub fn alive(&self) -> &[bool] {
        &self.alive
    }

    /// All that changes, as words: [`Stepped::restore`] takes them.
    pub fn saved(&self) -> Vec<u32> {
        let flags = |flags: &[bool]| flags.iter().map(|&flag| flag.into()).collect::<Vec<u32>>();
        let keys = self.keys.iter();
        let keys = keys.flat_map(|key| [key.words[0], key.words[1], key.trial, key.generation]);
        [
            &keys.collect::<Vec<u32>>()[..],
            &self.cycles,
            &flags(&self.alive),
            &flags(&self.ended),
            &self.states,
            bytemuck::cast_slice(&self.readings),
            bytemuck::cast_slice(&self.rewards),
            bytemuck::cast_slice(&self.poses),
            bytemuck::cast_slice(&self.fitness),
        ]
        .concat()
    }

    /// Continues from the words of episodes in the same world, as many as these.
    ///
    /// # Errors
    /// Another number of words; then nothing has changed.
    pub fn restore(&mut self, words: &[u32]) -> Result<(), Invalid> {
        let allowed = self.saved().len();
        if words.len() != allowed {
            let problem = format!("has {} words; allowed: {allowed}", words.len());
            return Err(Invalid::new("state", problem));
        }
        let mut rest = words;
        let mut next = |count: usize| {
            let (taken, after) = rest.split_at(count);
            rest = after;
            taken
        };
        let episodes = self.keys.len();
        for (key, &[low, high, trial, generation]) in self.keys.iter_mut().zip(next(4 * episodes).as_chunks().0) {
            *key = Key {
                words: [low, high],
                trial,
                generation,
            };
        }
        self.cycles.copy_from_slice(next(episodes));
        for flags in [&mut self.alive, &mut self.ended] {
            *flags = next(episodes).iter().map(|&word| word != 0).collect();
        }
        let mut fill = |values: &mut [u32]| values.copy_from_slice(next(values.len()));
        fill(&mut self.states);
        fill(bytemuck::cast_slice_mut(&mut self.readings));
        fill(bytemuck::cast_slice_mut(&mut self.rewards));
        fill(bytemuck::cast_slice_mut(&mut self.poses));
        fill(bytemuck::cast_slice_mut(&mut self.fitness));
        Ok(())
    }

    /// Begins episodes anew, each with the key of its random numbers, and reads their sensors.
    ///
    /// # Errors
    /// An unknown episode, or one named twice; those of the device.
    pub fn begin(
        &mut self,
        device: &mut dyn Evaluator,
        control: &Control,
        episodes: &[(usize, Key)],
    ) -> Result<(), Error> {
        self.step_and_begin(device, control, &[], &[], episodes)
    }

    /// Simulates a cycle of episodes, with two commands for each robot, from 0 (fastest backwards) to 1 (fastest forwards), and
    /// reads their sensors. Commands beyond are clipped; those of a magnitude below [`LEAST_GENE`] count as 0.
    ///
    /// # Errors
    /// An unknown episode, one named twice, or one that hasn't begun or has ended; another number of commands, or one that isn't
    /// finite or beyond [`GREATEST_GENE`]: the episodes are then as before. Those of the device, after which these episodes have to begin
    /// anew.
    pub fn step(
        &mut self,
        device: &mut dyn Evaluator,
        control: &Control,
        who: &[usize],
        commands: &[f32],
    ) -> Result<(), Error> {
        self.step_and_begin(device, control, who, commands, &[])
    }

    /// [`Stepped::step`], and at the same time [`Stepped::begin`] of others, which takes as long as if all were stepped.
    ///
    /// # Errors
    /// As both.
    pub fn step_and_begin(
        &mut self,
        device: &mut dyn Evaluator,
        control: &Control,
        who: &[usize],
        commands: &[f32],
        begin: &[(usize, Key)],
    ) -> Result<(), Error> {
        self.check(who, begin)?;
        let each = self.robots * COMMANDS;
        if commands.len() != who.len() * each {
            let problem = format!("are {}; allowed: {each} for each episode", commands.len());
            return Err(Invalid::new("commands", problem).into());
        }
        // Also false for NaN.
        let is_allowed = |command: &f32| command.abs() <= GREATEST_GENE;
        if let Some(index) = commands.iter().position(|command| !is_allowed(command)) {
            let problem = format!("is {}; allowed: 0 to 1", commands[index]);
            let place = format!("commands[{}][{}]", index / COMMANDS, index % COMMANDS);
            return Err(Invalid::new(place, problem).into());
        }
        for &(episode, key) in begin {
            self.keys[episode] = key;
            self.cycles[episode] = 0;
            self.ended[episode] = false;
        }
        let given = who.iter().zip(commands.chunks(each));
        let mut turns: Vec<Turn<'_>> = given
            .map(|(&episode, commands)| Turn {
                episode,
                cycles: self.cycles[episode] + 1,
                commands,
            })
            .chain(begin.iter().map(|&(episode, _)| Turn {
                episode,
                cycles: 0,
                commands: &[],
            }))
            .collect();
        if turns.is_empty() {
            return Ok(());
        }
        let is_one = self.world.variants().len() == 1;
        let are_all = turns.len() == self.keys.len() && is_one;
        if are_all && !turns.is_sorted_by_key(|turn| turn.episode) {
            turns.sort_by_key(|turn| turn.episode);
        }
        let groups: Vec<(usize, &[Turn<'_>])> = if is_one {
            turns.chunks(LANES).map(|group| (0, group)).collect()
        } else {
            let variant = |turn: &Turn<'_>| self.world.variant(self.keys[turn.episode]);
            turns.sort_by_key(variant);
            turns
                .chunk_by(|one, other| variant(one) == variant(other))
                .flat_map(|of_variant| of_variant.chunks(LANES).map(|group| (variant(&group[0]), group)))
                .collect()
        };
        let states = if are_all {
            std::mem::take(&mut self.states)
        } else {
            self.gathered(&groups)
        };
        let batch = self
            .worlds
            .commanded(groups_of(&groups, self.robots), self.inputs(&groups), states);
        match device.evaluate_part(&batch.all(), control) {
            Ok(result) => {
                self.take(&groups, result, are_all, batch.record_words());
                Ok(())
            }
            Err(error) => {
                let slots = self.keys.len().next_multiple_of(LANES);
                self.states.resize(slots * self.worlds.state_words(), 0);
                for turn in &turns {
                    self.alive[turn.episode] = false;
                }
                Err(error.into())
            }
        }
    }

    /// The inputs of groups: for each field 64 values, first the words of the keys, then of each robot its commands and the number of
    /// cycles.
    fn inputs(&self, groups: &[(usize, &[Turn<'_>])]) -> Vec<u32> {
        let words = input_words_of(self.robots) * LANES;
        let mut inputs = vec![0; groups.len() * words];
        let fill = |((_, turns), inputs): (&(usize, &[Turn<'_>]), &mut [u32])| {
            for (lane, turn) in turns.iter().enumerate() {
                let mut put = |field: usize, word: u32| inputs[field * LANES + lane] = word;
                for (field, word) in input_words(self.keys[turn.episode]).into_iter().enumerate() {
                    put(field, word);
                }
                // The world's number of cycles is the first robot's.
                put(KEY_WORDS + COMMANDS, turn.cycles);
                for (robot, commands) in turn.commands.chunks_exact(COMMANDS).enumerate() {
                    for (field, &command) in commands.iter().enumerate() {
                        put(KEY_WORDS + robot * GENES + field, flushed(command).to_bits());
                    }
                }
            }
        };
        if groups.len() * LANES >= MANY {
            groups.par_iter().zip(inputs.par_chunks_exact_mut(words)).for_each(fill);
        } else {
            groups.iter().zip(inputs.chunks_exact_mut(words)).for_each(fill);
        }
        inputs
    }

    /// States of episodes in the slots of these groups.
    fn gathered(&self, groups: &[(usize, &[Turn<'_>])]) -> Vec<u32> {
        let words = self.worlds.state_words();
        let place = self.worlds.places("state", words);
        let mut states = vec![0; groups.len() * LANES * words];
        for (slot, turn) in in_slots(groups).filter(|(_, turn)| turn.cycles > 0) {
            for word in 0..words {
                states[place(slot, word)] = self.states[place(turn.episode, word)];
            }
        }
        states
    }

    /// Takes the results of groups.
    fn take(&mut self, groups: &[(usize, &[Turn<'_>])], result: PartResult, are_all: bool, record_words: usize) {
        let readings = self.robots * self.places.len();
        let lines = Lines {
            robots: self.robots,
            places: &self.places,
            is_scored: self.is_scored,
            length: self.length,
        };
        if are_all && self.keys.len() >= MANY && readings > 0 {
            let turns: Vec<u32> = groups
                .iter()
                .flat_map(|(_, turns)| turns.iter().map(|turn| turn.cycles))
                .collect();
            let each = (
                self.readings.par_chunks_mut(readings),
                self.rewards.par_chunks_mut(self.robots),
                self.poses.par_chunks_mut(self.robots),
                self.fitness.par_iter_mut(),
                self.cycles.par_iter_mut(),
                self.ended.par_iter_mut(),
                self.alive.par_iter_mut(),
                &turns,
                result.trace.par_chunks_exact(record_words),
                &result.fitness,
            );
            each.into_par_iter().with_min_len(MANY / 4).for_each(
                |(readings, rewards, poses, fitness, cycles, ended, alive, turn, words, score)| {
                    let mut episode = Place {
                        readings,
                        rewards,
                        poses,
                        fitness,
                        cycles,
                        ended,
                        alive,
                    };
                    lines.take(&mut episode, *turn, words, *score);
                },
            );
        } else {
            for (slot, turn) in in_slots(groups) {
                let (episode, first) = (turn.episode, turn.episode * self.robots);
                let mut place = Place {
                    readings: &mut self.readings[episode * readings..][..readings],
                    rewards: &mut self.rewards[first..][..self.robots],
                    poses: &mut self.poses[first..][..self.robots],
                    fitness: &mut self.fitness[episode],
                    cycles: &mut self.cycles[episode],
                    ended: &mut self.ended[episode],
                    alive: &mut self.alive[episode],
                };
                let words = &result.trace[slot * record_words..][..record_words];
                lines.take(&mut place, turn.cycles, words, result.fitness[slot]);
            }
        }
        if are_all {
            self.states = result.states;
            return;
        }
        let words = self.worlds.state_words();
        let place = self.worlds.places("state", words);
        for (slot, turn) in in_slots(groups) {
            for word in 0..words {
                self.states[place(turn.episode, word)] = result.states[place(slot, word)];
            }
        }
    }

    fn check(&self, who: &[usize], begin: &[(usize, Key)]) -> Result<(), Invalid> {
        let all = self.keys.len();
        // Most often they are all, in order.
        let is_next = |(at, &episode): (usize, &usize)| at == episode && self.alive[at];
        if begin.is_empty() && who.len() == all && who.iter().enumerate().all(is_next) {
            return Ok(());
        }
        let mut seen = vec![false; all];
        let stepped = who.iter().map(|&episode| (episode, true));
        for (episode, must_live) in stepped.chain(begin.iter().map(|&(episode, _)| (episode, false))) {
            let problem = match seen.get_mut(episode) {
                None => format!("is {episode}; allowed: 0 to {}", all - 1),
                Some(true) => format!("names episode {episode} twice; allowed: each once"),
                Some(_) if must_live && !self.alive[episode] => {
                    format!("names episode {episode}, which has ended or not begun; allowed: running episodes")
                }
                Some(seen) => {
                    *seen = true;
                    continue;
                }
            };
            return Err(Invalid::new("episodes", problem));
        }
        Ok(())
    }
}

/// An episode's next step, and the number of cycles that it has had afterwards, 0 if it begins.
struct Turn<'a> {
    episode: usize,
    cycles: u32,
    commands: &'a [f32],
}

/// How the lines of episodes are read.
struct Lines<'a> {
    robots: usize,
    places: &'a [usize],
    is_scored: bool,
    length: u32,
}

/// What is kept of an episode.
struct Place<'a> {
    readings: &'a mut [f32],
    rewards: &'a mut [f64],
    poses: &'a mut [[f32; 3]],
    fitness: &'a mut f32,
    cycles: &'a mut u32,
    ended: &'a mut bool,
    alive: &'a mut bool,
}

impl Lines<'_> {
    /// Takes an episode's lines, one of each robot, and its fitness after so many cycles.
    fn take(&self, episode: &mut Place<'_>, cycles: u32, words: &[u32], fitness: f32) {
        const REWARD: usize = std::mem::offset_of!(Record, reward) / size_of::<u32>();
        // The kernel says there whether the episode has ended.
        const ENDED: usize = std::mem::offset_of!(Record, speed_right) / size_of::<u32>();
        let change = f64::from(fitness) - f64::from(*episode.fitness);
        for (robot, line) in words.chunks_exact(words.len() / self.robots).enumerate() {
            let number = |word: usize| f32::from_bits(line[word]);
            episode.rewards[robot] = match (cycles, self.is_scored) {
                (0, _) => 0.0,
                (_, true) => change,
                (_, false) => number(REWARD).into(),
            };
            episode.poses[robot] = [0, 1, 2].map(number);
            let readings = &mut episode.readings[robot * self.places.len()..][..self.places.len()];
            for (reading, &place) in readings.iter_mut().zip(self.places) {
                *reading = number(place);
            }
        }
        *episode.fitness = fitness;
        *episode.cycles = cycles;
        *episode.ended = words[ENDED] != 0;
        *episode.alive = cycles < self.length && !*episode.ended;
    }
}

/// Words of an episode's inputs.
fn input_words_of(robots: usize) -> usize {
    KEY_WORDS + robots * GENES
}

/// The groups of a batch.
fn groups_of(groups: &[(usize, &[Turn<'_>])], robots: usize) -> Vec<Group> {
    let words = input_words_of(robots) * LANES;
    let group = |(index, (variant, turns)): (usize, &(usize, &[Turn<'_>]))| Group {
        world: *variant as u32,
        rollouts: turns.len() as u32,
        inputs: (index * words) as u32,
    };
    groups.iter().enumerate().map(group).collect()
}

/// Each episode of groups, and its slot.
fn in_slots<'a>(groups: &'a [(usize, &'a [Turn<'a>])]) -> impl Iterator<Item = (usize, &'a Turn<'a>)> {
    let of_group = |(index, (_, turns)): (usize, &'a (usize, &'a [Turn<'a>]))| {
        turns.iter().zip(index * LANES..).map(|(turn, slot)| (slot, turn))
    };
    groups.iter().enumerate().flat_map(of_group)
}

/// A command as a gene: zero has one sign, and there is nothing small enough to become subnormal.
fn flushed(command: f32) -> f32 {
    if command.abs() < LEAST_GENE { 0.0 } else { command }
}
