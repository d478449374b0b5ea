//! One world of a swarm whose robots are driven from outside, cycle by cycle: for a process that plays the arena to others.

use oneiro_shaders::{Kernel, episode};

use super::{Drive, Lamp, Line, Order, Readings, Swarm, Trouble};
use crate::batch::{Buffers, GREATEST_GENE, Rollout, TraceRequest, WorldKind, Worlds};
use crate::evaluator::{Control, Evaluator};
use crate::parameter::{Invalid, integer};
use crate::parts::compose;
use crate::random::{Key, pcg4d};

/// Most robots of a world that is driven: with more, its loops would be longer than those of kernels composed at run time may be.
pub const GREATEST_DRIVEN: u32 = 80;

/// Readings of a robot, which follow the swarm's own words of state.
const READINGS: usize = 12;

/// Key of a robot's own random numbers in a world with a key: what its [mind](crate::acting::Mind) draws from.
pub fn robot_key(world: Key, robot: u32) -> Key {
    // As `begin` in `physics/arena.wgsl` draws it: the stream of starts at step 0, from this block on.
    const FIRST_BLOCK: u32 = 0xff00;
    let [low, high] = world.words;
    let [low, high, ..] = pcg4d([low, high, 0, FIRST_BLOCK + robot]);
    Key {
        words: [low, high],
        ..world
    }
}

/// A robot's command for a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Command {
    /// Its way and turn; `None` if it isn't switched on. It then stands, takes no food, and sends and receives nothing.
    pub drive: Option<Drive>,
    /// Whether one of its intervals begins: its fitness restarts from 0.
    pub begins: bool,
}

/// A world of robots that are driven from outside. It has the bits of a [`Simulated`](super::Simulated) one whose robots
/// want to drive the same.
///
/// ```
/// use oneiro::acting::Acting;
/// use oneiro::cpu::Cpu;
/// use oneiro::foraging::Light;
/// use oneiro::random::Key;
/// use oneiro::swarm::{Command, Driven, Lamp, Swarm, robot_key};
///
/// let swarm = Swarm::odowd2014(2);
/// let key = Key::rollout(1, 0, 0, 0);
/// let mut cpu = Cpu::new(Some(1))?;
/// let mut world = Driven::new(&mut cpu, &swarm, Lamp::fixed(Light::OverNest), key)?;
/// // One robot searches for food, the other is not switched on.
/// let acting = Acting::new(&swarm.forager)?;
/// let mut mind = Acting::begin(robot_key(key, 0));
/// let mut carries = false;
/// for _ in 0..10 {
///     let deed = acting.cycle(&mut mind, &mut cpu, [0.99, 0.5], &world.readings()[0], carries)?;
///     let command = Command { drive: Some(deed.drive()), begins: false };
///     let line = world.cycle(&mut cpu, &[command, Command::default()])?;
///     carries = line.robots[0].carries;
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Driven {
    swarm: Swarm,
    lamp: Lamp,
    key: Key,
    worlds: Worlds,
    /// Cycles that have passed.
    now: u32,
    state: Vec<u32>,
    readings: Vec<Readings>,
    /// The state last seen.
    line: Line,
}

impl Driven {
    /// Makes a world before its first cycle.
    ///
    /// # Errors
    /// The first invalid value of the swarm; more than [`GREATEST_DRIVEN`] robots; those of the device. Without the feature `compose`,
    /// always.
    pub fn new(device: &mut dyn Evaluator, swarm: &Swarm, lamp: Lamp, key: Key) -> Result<Self, Trouble> {
        swarm.check()?;
        integer("robots", swarm.robots, 1..=GREATEST_DRIVEN)?;
        let packed = Packed {
            swarm: *swarm,
            kernel: compose::driven()?,
        };
        let mut driven = Self {
            swarm: *swarm,
            lamp,
            key,
            worlds: Worlds::new(&[packed])?,
            now: 0,
            state: Vec::new(),
            readings: Vec::new(),
            line: Line {
                robots: Vec::new(),
                food: Vec::new(),
            },
        };
        let off = vec![Command::default(); swarm.robots as usize];
        driven.line = driven.step(device, 0, &off)?;
        Ok(driven)
    }

    /// The current world; after [`Driven::at`] it is empty until the next cycle.
    pub fn line(&self) -> &Line {
        &self.line
    }

    /// What the sensors of each robot will read in the next cycle.
    pub fn readings(&self) -> &[Readings] {
        &self.readings
    }

    /// Simulates a cycle, with a command for each robot. All robots that are switched on are said to search.
    ///
    /// # Errors
    /// Another number of commands than robots; a drive that isn't finite or beyond [`GREATEST_GENE`]; the end of the swarm's cycles; those
    /// of the device. The world is then as before.
    pub fn cycle(&mut self, device: &mut dyn Evaluator, commands: &[Command]) -> Result<Line, Trouble> {
        let robots = self.swarm.robots as usize;
        if commands.len() != robots {
            let problem = format!("are {}; allowed: {robots}, one for each robot", commands.len());
            return Err(Invalid::new("commands", problem).into());
        }
        for (robot, command) in commands.iter().enumerate() {
            let drive = command.drive.unwrap_or_default();
            for (field, number) in [("forward", drive.forward), ("turn", drive.turn)] {
                let is_allowed = number.abs() <= GREATEST_GENE;
                if !is_allowed {
                    let problem = format!("is {number}; allowed: up to {GREATEST_GENE} either way");
                    return Err(Invalid::new(format!("commands[{robot}].drive.{field}"), problem).into());
                }
            }
        }
        self.line = self.step(device, self.now + 1, commands)?;
        self.now += 1;
        Ok(self.line.clone())
    }

    /// Takes a step of the kernel: step 0 begins the world, and each later one simulates the cycle before it.
    fn step(&mut self, device: &mut dyn Evaluator, step: u32, commands: &[Command]) -> Result<Line, Trouble> {
        let orders: Vec<Order> = commands.iter().map(|command| self.order(command)).collect();
        let inputs = self.swarm.inputs(&self.lamp, &orders);
        let rollout = Rollout {
            world: 0,
            genes: &inputs,
            key: self.key,
        };
        let states = if step == 0 {
            &[][..]
        } else {
            std::slice::from_ref(&self.state)
        };
        let trace = Some(TraceRequest { every: 1 });
        let batch = self.worlds.stretch(&[rollout], step..step + 1, states, trace)?;
        let mut outcome = device.evaluate(&batch, &Control::new())?;
        self.hold(outcome.states.swap_remove(0));
        Ok(self.swarm.lines(&outcome.logs[0], batch.record_words()).swap_remove(0))
    }

    /// A command in the form of an order: instead of the genes of later cycles, which never come, it has the drive.
    fn order(&self, command: &Command) -> Order {
        const NEVER: u32 = GREATEST_GENE as u32;
        let drive = command.drive.unwrap_or_default();
        Order {
            before: command.drive.map(|_| [0.0; 2]),
            after: [drive.forward, drive.turn],
            at: NEVER,
            begins: command.begins.then_some(self.now),
        }
    }

    /// Takes a state, and the readings in it.
    fn hold(&mut self, state: Vec<u32>) {
        let first = self.swarm.state_words() as usize;
        let each = state[first..].as_chunks::<READINGS>().0;
        let readings = each.iter().map(|words| {
            let number = |word: usize| f32::from_bits(words[word]);
            Readings {
                near: std::array::from_fn(number),
                light: std::array::from_fn(|sensor| number(4 + sensor)),
            }
        });
        self.readings = readings.collect();
        self.state = state;
    }

    /// Cycles that have passed, and the state that the world keeps between cycles.
    pub fn state(&self) -> (u32, &[u32]) {
        (self.now, &self.state)
    }

    /// Continues from [`Driven::state`].
    ///
    /// # Errors
    /// A state of another length.
    pub fn at(mut self, now: u32, state: Vec<u32>) -> Result<Self, Invalid> {
        if state.len() != self.worlds.state_words() {
            let problem = format!("has {} words; allowed: {}", state.len(), self.worlds.state_words());
            return Err(Invalid::new("state", problem));
        }
        self.now = now;
        self.line.robots.clear();
        self.line.food.clear();
        self.hold(state);
        Ok(self)
    }
}

/// A swarm's world in the kernel of driven robots: one step more than it has cycles, and readings after its own words of state.
struct Packed {
    swarm: Swarm,
    kernel: &'static Kernel,
}

impl WorldKind for Packed {
    fn check(&self) -> Result<(), Invalid> {
        self.swarm.check()
    }

    fn kernel(&self) -> &'static Kernel {
        self.kernel
    }

    fn genes(&self) -> usize {
        self.swarm.genes()
    }

    fn robots(&self) -> u32 {
        self.swarm.robots
    }

    fn pack(&self, variant: usize, buffers: &mut Buffers) -> episode::World {
        let world = self.swarm.pack(variant, buffers);
        episode::World {
            steps: world.steps + 1,
            ..world
        }
    }

    fn state_words(&self) -> u32 {
        self.swarm.state_words() + READINGS as u32 * self.swarm.robots
    }

    fn record_words(&self) -> u32 {
        self.swarm.record_words()
    }
}
