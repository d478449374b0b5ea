//! Episodes whose wheels are commanded from outside, cycle by cycle: the simulator as an environment for reinforcement learning, or
//! for a controller in another language. Sensors, motion and task run in the same kernels as whole episodes: with a controller's
//! commands, an episode has the same bits as that controller's episode.
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

use std::collections::BTreeMap;
use std::sync::Arc;

use oneiro_shaders::episode::Record;

use crate::batch::{GREATEST_GENE, LANES, LEAST_GENE, WorldKind, Worlds};
use crate::evaluator::{Control, Evaluator};
pub use crate::outside::reported::Error;
use crate::parameter::Invalid;
use crate::parts::compose::{DetailKind, Kind, OwnPart, Part};
use crate::random::Key;
use crate::world::{Controller, World, WorldSpec};

/// Commands of a cycle: the left and the right motor's.
pub const COMMANDS: usize = 2;

/// Most cycles of a stepped episode: one less than of any other, since its sensors are also read after the last one.
pub const GREATEST_CYCLES: u32 = 999_999;

/// Words of a record, which precede its details.
const RECORD: usize = size_of::<Record>() / size_of::<u32>();

/// Commands of the cycle that only reads the sensors. The outputs in its record tell it from that of an episode that is over,
/// which is all zero.
const AHEAD: [f32; COMMANDS] = [1.0; COMMANDS];

/// Episodes in a world, in any of their cycles.
#[derive(Debug)]
pub struct Stepped {
    world: World,
    worlds: Worlds,
    /// Cycles of an episode.
    length: u32,
    /// Where the readings are in a line of a trace.
    places: Vec<usize>,
    keys: Vec<Key>,
    /// Cycles that each episode has had.
    cycles: Vec<u32>,
    /// Whether each episode has begun, and hasn't ended.
    alive: Vec<bool>,
    /// State of each episode, and of the idle slots that fill the last group.
    states: Vec<u32>,
    readings: Vec<f32>,
    rewards: Vec<f32>,
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
        if let Some(robots) = spec.robot.members() {
            let problem = format!("is {robots}; allowed: not set, since swarms can't be commanded from outside");
            return Err(Invalid::new("robot.count", problem));
        }
        if spec.cycles > GREATEST_CYCLES {
            let problem = format!(
                "is {}; allowed: 1 to {GREATEST_CYCLES} if episodes are stepped",
                spec.cycles
            );
            return Err(Invalid::new("cycles", problem));
        }
        let part = Part::new(Kind::Controller, "external.wgsl", include_str!("stepped/external.wgsl"));
        let part = part.map_err(|refused| Invalid::new("controller.kind", refused.to_string()))?;
        let mut parts = spec.own.clone();
        parts.insert(Arc::new(OwnPart::new(Arc::new(part), &[])?));
        let world = World::new(WorldSpec {
            controller: Controller::Own,
            own: parts,
            // The sensors are also read after the last cycle.
            ..spec.clone().seen_to_its_end()
        })?;
        let worlds = Worlds::new(std::slice::from_ref(&world))?;
        let details = world.details().iter().enumerate();
        let places: Vec<usize> = details
            .filter(|(_, detail)| detail.kind == DetailKind::Perceived)
            .map(|(index, _)| RECORD + index)
            .collect();
        Ok(Self {
            length: spec.cycles,
            keys: vec![Key::default(); episodes],
            cycles: vec![0; episodes],
            alive: vec![false; episodes],
            states: vec![0; episodes.next_multiple_of(LANES) * worlds.state_words()],
            readings: vec![0.0; episodes * places.len()],
            rewards: vec![0.0; episodes],
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

    /// Names of the readings: the robot's, then those of a user's sensors.
    pub fn names(&self) -> Vec<String> {
        let details = self.world.details().iter();
        let perceived = details.filter(|detail| detail.kind == DetailKind::Perceived);
        perceived.map(|detail| detail.name.clone()).collect()
    }

    /// Readings of each episode, as its controller would get them in its next cycle. All are 0 once it has ended early.
    pub fn readings(&self) -> &[f32] {
        &self.readings
    }

    /// Reward of each episode in its last cycle.
    pub fn rewards(&self) -> &[f32] {
        &self.rewards
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
        let who: Vec<usize> = episodes.iter().map(|(episode, _)| *episode).collect();
        self.check(&who, false)?;
        for &(episode, key) in episodes {
            self.keys[episode] = key;
            self.cycles[episode] = 0;
            self.alive[episode] = true;
            self.ended[episode] = false;
            (self.rewards[episode], self.fitness[episode]) = (0.0, 0.0);
        }
        self.sense(device, control, &who)
    }

    /// Simulates a cycle of episodes, with two commands each, from 0 (fastest backwards) to 1 (fastest forwards), and
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
        self.check(who, true)?;
        if commands.len() != who.len() * COMMANDS {
            let problem = format!("are {}; allowed: {COMMANDS} for each episode", commands.len());
            return Err(Invalid::new("commands", problem).into());
        }
        // Also false for NaN.
        let is_allowed = |command: &f32| command.abs() <= GREATEST_GENE;
        if let Some(index) = commands.iter().position(|command| !is_allowed(command)) {
            let problem = format!("is {}; allowed: 0 to 1", commands[index]);
            let place = format!("commands[{}][{}]", index / COMMANDS, index % COMMANDS);
            return Err(Invalid::new(place, problem).into());
        }
        for (cycle, members) in self.by_cycle(who) {
            let given = |member: usize| [commands[member * COMMANDS], commands[member * COMMANDS + 1]];
            self.cycle(device, control, cycle, (who, &members), given, true)?;
        }
        for &episode in who {
            self.cycles[episode] += 1;
            self.alive[episode] = self.cycles[episode] < self.length;
        }
        self.sense(device, control, who)
    }

    /// Reads the sensors of episodes at the beginning of their next cycle, and finds out which have ended.
    fn sense(&mut self, device: &mut dyn Evaluator, control: &Control, who: &[usize]) -> Result<(), Error> {
        for (cycle, members) in self.by_cycle(who) {
            self.cycle(device, control, cycle, (who, &members), |_| AHEAD, false)?;
        }
        Ok(())
    }

    /// Indices in `who` of the episodes in each cycle.
    fn by_cycle(&self, who: &[usize]) -> BTreeMap<u32, Vec<usize>> {
        let mut members: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        if let Some(&first) = who.first()
            && who.iter().all(|&episode| self.cycles[episode] == self.cycles[first])
        {
            members.insert(self.cycles[first], (0..who.len()).collect());
            return members;
        }
        for (member, &episode) in who.iter().enumerate() {
            members.entry(self.cycles[episode]).or_default().push(member);
        }
        members
    }

    /// A cycle of episodes that are in the same one: simulated, or only for its readings.
    fn cycle(
        &mut self,
        device: &mut dyn Evaluator,
        control: &Control,
        cycle: u32,
        (who, members): (&[usize], &[usize]),
        commands: impl Fn(usize) -> [f32; COMMANDS],
        episodes: bool,
    ) -> Result<(), Error> {
        let words = self.worlds.state_words();
        let slots = members.len().next_multiple_of(LANES);
        let are_all = members.len() == self.keys.len() && members.iter().all(|&member| who[member] == member);
        let states = if cycle == 0 {
            Vec::new()
        } else if are_all {
            if episodes {
                std::mem::take(&mut self.states)
            } else {
                self.states.clone()
            }
        } else {
            let mut states = Vec::with_capacity(slots * words);
            for &member in members {
                states.extend_from_slice(&self.states[who[member] * words..][..words]);
            }
            states.resize(slots * words, 0);
            states
        };
        let inputs = members
            .iter()
            .map(|&member| (self.keys[who[member]], commands(member).map(flushed)));
        let batch = self.worlds.cycle(inputs, cycle, states, episodes);
        let result = match device.evaluate_part(&batch.all(), control) {
            Ok(result) => result,
            Err(error) => {
                self.states.resize(self.keys.len().next_multiple_of(LANES) * words, 0);
                for &member in members {
                    self.alive[who[member]] = false;
                }
                return Err(error.into());
            }
        };
        let width = batch.record_words();
        let (reward, readings) = (
            std::mem::offset_of!(Record, reward) / size_of::<u32>(),
            self.places.len(),
        );
        let may_end = self.world.may_end_early();
        for (slot, &member) in members.iter().enumerate() {
            let episode = who[member];
            let line = &result.trace[slot * width..][..width];
            if episodes {
                self.rewards[episode] = f32::from_bits(line[reward]);
                self.fitness[episode] = result.fitness[slot];
                continue;
            }
            let readings_of_episode = &mut self.readings[episode * readings..][..readings];
            for (reading, &place) in readings_of_episode.iter_mut().zip(&self.places) {
                *reading = f32::from_bits(line[place]);
            }
            if may_end && line.iter().all(|word| *word == 0) {
                self.ended[episode] = true;
                self.alive[episode] = false;
            }
        }
        if episodes && are_all {
            self.states = result.states;
        } else if episodes {
            for (slot, &member) in members.iter().enumerate() {
                let state = &result.states[slot * words..][..words];
                self.states[who[member] * words..][..words].copy_from_slice(state);
            }
        }
        Ok(())
    }

    fn check(&self, who: &[usize], must_live: bool) -> Result<(), Invalid> {
        let all = self.keys.len();
        let mut seen = vec![false; all];
        for &episode in who {
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

/// A command as a gene: zero has one sign, and there is nothing small enough to become subnormal.
fn flushed(command: f32) -> f32 {
    if command.abs() < LEAST_GENE { 0.0 } else { command }
}
