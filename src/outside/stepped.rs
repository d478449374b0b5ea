//! Lives whose wheels are commanded from outside, cycle by cycle: the simulator as an environment for reinforcement learning, or for a
//! controller in another language. Sensors, motion and task run in the same kernels as in whole lives, so a life that gets the commands
//! of a controller has the bits of that controller's life.
//!
//! ```
//! use oneiro::cpu::Cpu;
//! use oneiro::evaluator::Control;
//! use oneiro::random::Key;
//! use oneiro::stepped::Stepped;
//! use oneiro::world::WorldSpec;
//!
//! let mut cpu = Cpu::new(Some(1))?;
//! let mut lives = Stepped::new(&WorldSpec::miglino1995(), 2)?;
//! lives.begin(&mut cpu, &Control::new(), &[(0, Key::rollout(1, 0, 0, 0)), (1, Key::rollout(1, 0, 1, 0))])?;
//! assert_eq!(lives.readings().len(), 2 * 8);
//! // Both wheels forwards, and a turn on the spot.
//! lives.step(&mut cpu, &Control::new(), &[0, 1], &[0.9, 0.9, 0.1, 0.9])?;
//! assert!(lives.rewards()[0] >= 0.0 && lives.cycles() == [1, 1]);
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

/// Most cycles of a stepped life: one less than of any other, since its sensors are also read after the last one.
pub const GREATEST_CYCLES: u32 = 999_999;

/// Words of a record, which precede its details.
const RECORD: usize = size_of::<Record>() / size_of::<u32>();

/// Commands of the cycle that only reads the sensors. The outputs in its record tell it from that of a life that is over,
/// which is all zero.
const AHEAD: [f32; COMMANDS] = [1.0; COMMANDS];

/// Lives in a world, in any of their cycles.
#[derive(Debug)]
pub struct Stepped {
    world: World,
    worlds: Worlds,
    /// Cycles of a life.
    length: u32,
    /// Where the readings are in a line of a trace.
    places: Vec<usize>,
    keys: Vec<Key>,
    /// Cycles that each life has lived.
    cycles: Vec<u32>,
    /// Whether each life has begun, and hasn't ended.
    alive: Vec<bool>,
    /// State of each life, and of the idle slots that fill the last group.
    states: Vec<u32>,
    readings: Vec<f32>,
    rewards: Vec<f32>,
    fitness: Vec<f32>,
    ended: Vec<bool>,
}

impl Stepped {
    /// Lives in a world, of which none has begun. Its controller is left out.
    ///
    /// # Errors
    /// The first invalid value; no life or more than 2^20; lives of more than [`GREATEST_CYCLES`]. Without the feature
    /// `compose`, always.
    pub fn new(spec: &WorldSpec, lives: usize) -> Result<Self, Invalid> {
        const MOST: usize = 1 << 20;
        if lives == 0 || lives > MOST {
            let problem = format!("are {lives}; allowed: 1 to {MOST}");
            return Err(Invalid::new("lives", problem));
        }
        if let Some(robots) = spec.robot.members() {
            let problem = format!(
                "is {robots}; allowed: not set, since robots that share a world by it can't be commanded from outside"
            );
            return Err(Invalid::new("robot.count", problem));
        }
        if spec.cycles > GREATEST_CYCLES {
            let problem = format!(
                "is {}; allowed: 1 to {GREATEST_CYCLES} if lives are stepped",
                spec.cycles
            );
            return Err(Invalid::new("cycles", problem));
        }
        let part = Part::new(Kind::Controller, "external.wgsl", include_str!("stepped/external.wgsl"));
        let part = part.map_err(|refused| Invalid::new("controller.kind", refused.to_string()))?;
        let mut own = spec.own.clone();
        own.insert(Arc::new(OwnPart::new(Arc::new(part), &[])?));
        let world = World::new(WorldSpec {
            controller: Controller::Own,
            own,
            // The sensors are also read after the last cycle.
            cycles: spec.cycles + 1,
            ..spec.clone()
        })?;
        let worlds = Worlds::new(std::slice::from_ref(&world))?;
        let details = world.details().iter().enumerate();
        let places: Vec<usize> = details
            .filter(|(_, own)| own.kind == DetailKind::Perceived)
            .map(|(index, _)| RECORD + index)
            .collect();
        Ok(Self {
            length: spec.cycles,
            keys: vec![Key::default(); lives],
            cycles: vec![0; lives],
            alive: vec![false; lives],
            states: vec![0; lives.next_multiple_of(LANES) * worlds.state_words()],
            readings: vec![0.0; lives * places.len()],
            rewards: vec![0.0; lives],
            fitness: vec![0.0; lives],
            ended: vec![false; lives],
            places,
            world,
            worlds,
        })
    }

    /// The world, with commands from outside as its controller, and a cycle more than a life has.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Names of the readings: the robot's, then those of a user's sensors.
    pub fn names(&self) -> Vec<String> {
        let details = self.world.details().iter();
        let perceived = details.filter(|own| own.kind == DetailKind::Perceived);
        perceived.map(|own| own.name.clone()).collect()
    }

    /// Readings of each life, as its controller would get them in its next cycle. All are 0 once it has ended early.
    pub fn readings(&self) -> &[f32] {
        &self.readings
    }

    /// Reward of each life in its last cycle.
    pub fn rewards(&self) -> &[f32] {
        &self.rewards
    }

    /// Fitness of each life so far: what it would be if the life ended now.
    pub fn fitness(&self) -> &[f32] {
        &self.fitness
    }

    /// Cycles that each life has lived.
    pub fn cycles(&self) -> &[u32] {
        &self.cycles
    }

    /// Whether each life has been ended early, by its task or an empty battery.
    pub fn ended(&self) -> &[bool] {
        &self.ended
    }

    /// Whether each life has begun, and has cycles left.
    pub fn alive(&self) -> &[bool] {
        &self.alive
    }

    /// Begins lives anew, each with the key of its random numbers, and reads their sensors.
    ///
    /// # Errors
    /// An unknown life, or one named twice; those of the device.
    pub fn begin(
        &mut self,
        device: &mut dyn Evaluator,
        control: &Control,
        lives: &[(usize, Key)],
    ) -> Result<(), Error> {
        let who: Vec<usize> = lives.iter().map(|(life, _)| *life).collect();
        self.check(&who, false)?;
        for &(life, key) in lives {
            self.keys[life] = key;
            self.cycles[life] = 0;
            self.alive[life] = true;
            self.ended[life] = false;
            (self.rewards[life], self.fitness[life]) = (0.0, 0.0);
        }
        self.sense(device, control, &who)
    }

    /// Lets lives live for a cycle, with two commands each, from 0 (fastest backwards) to 1 (fastest forwards), and
    /// reads their sensors. Commands beyond are clipped; those of a magnitude below [`LEAST_GENE`] count as 0.
    ///
    /// # Errors
    /// An unknown life, one named twice, or one that hasn't begun or has ended; another number of commands, or one that isn't
    /// finite or beyond [`GREATEST_GENE`]: the lives are then as before. Those of the device, after which these lives have to begin
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
            let problem = format!("are {}; allowed: {COMMANDS} for each life", commands.len());
            return Err(Invalid::new("commands", problem).into());
        }
        // False for what is not a number, too.
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
        for &life in who {
            self.cycles[life] += 1;
            self.alive[life] = self.cycles[life] < self.length;
        }
        self.sense(device, control, who)
    }

    /// Reads the sensors of lives at the beginning of their next cycle, and finds out which have ended.
    fn sense(&mut self, device: &mut dyn Evaluator, control: &Control, who: &[usize]) -> Result<(), Error> {
        for (cycle, members) in self.by_cycle(who) {
            self.cycle(device, control, cycle, (who, &members), |_| AHEAD, false)?;
        }
        Ok(())
    }

    /// Indices in `who` of the lives in each cycle.
    fn by_cycle(&self, who: &[usize]) -> BTreeMap<u32, Vec<usize>> {
        let mut members: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        if let Some(&first) = who.first()
            && who.iter().all(|&life| self.cycles[life] == self.cycles[first])
        {
            members.insert(self.cycles[first], (0..who.len()).collect());
            return members;
        }
        for (member, &life) in who.iter().enumerate() {
            members.entry(self.cycles[life]).or_default().push(member);
        }
        members
    }

    /// A cycle of lives that are in the same: lived, or only for its readings.
    fn cycle(
        &mut self,
        device: &mut dyn Evaluator,
        control: &Control,
        cycle: u32,
        (who, members): (&[usize], &[usize]),
        commands: impl Fn(usize) -> [f32; COMMANDS],
        lives: bool,
    ) -> Result<(), Error> {
        let words = self.worlds.state_words();
        let slots = members.len().next_multiple_of(LANES);
        let are_all = members.len() == self.keys.len() && members.iter().all(|&member| who[member] == member);
        let states = if cycle == 0 {
            Vec::new()
        } else if are_all {
            if lives {
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
        let own = members
            .iter()
            .map(|&member| (self.keys[who[member]], commands(member).map(flushed)));
        let batch = self.worlds.cycle(own, cycle, states, lives);
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
            let life = who[member];
            let line = &result.trace[slot * width..][..width];
            if lives {
                self.rewards[life] = f32::from_bits(line[reward]);
                self.fitness[life] = result.fitness[slot];
                continue;
            }
            let own = &mut self.readings[life * readings..][..readings];
            for (reading, &place) in own.iter_mut().zip(&self.places) {
                *reading = f32::from_bits(line[place]);
            }
            if may_end && line.iter().all(|word| *word == 0) {
                self.ended[life] = true;
                self.alive[life] = false;
            }
        }
        if lives && are_all {
            self.states = result.states;
        } else if lives {
            for (slot, &member) in members.iter().enumerate() {
                let own = &result.states[slot * words..][..words];
                self.states[who[member] * words..][..words].copy_from_slice(own);
            }
        }
        Ok(())
    }

    fn check(&self, who: &[usize], must_live: bool) -> Result<(), Invalid> {
        let all = self.keys.len();
        let mut seen = vec![false; all];
        for &life in who {
            let problem = match seen.get_mut(life) {
                None => format!("is {life}; allowed: 0 to {}", all - 1),
                Some(true) => format!("names life {life} twice; allowed: each once"),
                Some(_) if must_live && !self.alive[life] => {
                    format!("names life {life}, which has ended or not begun; allowed: lives that go on")
                }
                Some(seen) => {
                    *seen = true;
                    continue;
                }
            };
            return Err(Invalid::new("lives", problem));
        }
        Ok(())
    }
}

/// A command as a gene: zero has one sign, and there is nothing small enough to become subnormal.
fn flushed(command: f32) -> f32 {
    if command.abs() < LEAST_GENE { 0.0 } else { command }
}
