//! Swarms of foraging e-pucks in one arena, as in O'Dowd, Studley and Winfield (2014): the surrogate of the real arena,
//! in which individual robots meet, push and shade each other, share the food and exchange messages at close range.
//! [`Differences`] lists how it differs from the [on-board simulator](crate::foraging).
//!
//! One invocation of the kernel is a whole world, with its robots in a loop over words of its state. Lanes are worlds,
//! so a processor's vectors are full whatever the number of robots, nothing waits for anything, and a batch of a few
//! dozen worlds fills them.
//!
//! Worlds go on from stretch to stretch, and robots get new controllers in between: [`Arena`] is the interface to
//! them, and [`Simulated`] implements it with an evaluator.
//!
//! The robots of a [`Driven`] world are driven from outside, cycle by cycle, by what its sensors read.

mod driven;

use std::sync::LazyLock;

use oneiro_shaders::{Kernel, episode, swarm as kernel};

use crate::batch::{Batch, Buffers, Outcome, Rollout, TraceRequest, WorldKind, Worlds};
use crate::evaluator::{Control, Error, Evaluator};
use crate::foragers::foraging::{Foraging, Light, in_kernel};
use crate::parameter::Allowed::{Any, Number, Whole};
use crate::parameter::{self, Invalid, Parameter, integer, row};
use crate::random::Key;

pub use crate::foragers::foraging::Drive;
pub use driven::{Command, Driven, GREATEST_DRIVEN, robot_key};

/// Most robots of a world.
pub const GREATEST_ROBOTS: u32 = kernel::GREATEST_ROBOTS;
/// Cycles per second.
pub const SECOND: u32 = kernel::SECOND;

/// Differences between the arena and the on-board simulator. Each is off at 0 or false; all are our own choice.
///
/// In addition, robots in the arena have bodies. A proximity sensor sees another robot whose centre is in front of it
/// and no farther off its axis than a body's radius plus a quarter of the distance along the axis, and reads the gap
/// between the bodies; of several objects it reads the nearest. Overlapping bodies push each other apart by half of the
/// overlap, four times per cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Differences {
    /// Standard deviation of the wheels' speeds, as a fraction: a robot curves.
    pub wheels: f32,
    /// Standard deviation of the gains of proximity sensors.
    pub proximity: f32,
    /// Standard deviation of the gains of light sensors. They apply to light from the lamp and the walls, not to
    /// ambient light.
    pub light: f32,
    /// Maximum share of their travel that wheels lose in a cycle.
    pub slip: f32,
    /// Whether wheels execute commands one cycle late.
    pub latency: bool,
    /// Darkening of the lamp off its axis: its light is multiplied by `1 - beam sin^2`.
    pub beam: f32,
    /// Light reflected by the walls, from all sides, next to the lamp; there is none at the other end.
    pub reflection: f32,
    /// Share of the lamp's light that a robot blocks for one directly behind it. To the sides it blocks less, and
    /// nothing from two radii off the line to the lamp; a shadow is equally wide at any distance. Of several shadows
    /// the darkest counts.
    pub shadows: f32,
    /// Chance per cycle that the tracking system reports nothing to a robot, which then neither takes nor brings food.
    pub tracking_loss: f32,
}

impl Differences {
    /// Bodies that block each other, and no other differences.
    pub const NONE: Self = Self {
        wheels: 0.0,
        proximity: 0.0,
        light: 0.0,
        slip: 0.0,
        latency: false,
        beam: 0.0,
        reflection: 0.0,
        shadows: 0.0,
        tracking_loss: 0.0,
    };

    /// Differences of the 2014 study's surrogate.
    pub const ODOWD2014: Self = Self {
        wheels: 0.02,
        proximity: 0.1,
        light: 0.15,
        slip: 0.1,
        latency: true,
        beam: 0.5,
        reflection: 0.05,
        shadows: 0.7,
        tracking_loss: 0.05,
    };
}

/// A world of robots: lengths in mm, cycles of 100 ms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swarm {
    /// Number of robots.
    pub robots: u32,
    /// Arena, food, nest, body and behaviours. `cycles` is the length of the whole episode; `light` isn't used (see
    /// [`Lamp`]), and starts are random.
    pub forager: Foraging,
    /// Cycles of a robot's interval, after whose end food earns nothing: 600 (paper).
    pub interval: u32,
    /// Range of messages, between centres.
    pub range: f32,
    /// Chance that a robot within range is heard, once per second.
    pub heard: f32,
    /// Whether a third robot in the way blocks messages.
    pub line_of_sight: bool,
    /// Differences from the on-board simulator.
    pub differences: Differences,
    /// Seed of the differences between robots: worlds with equal numbers have the same robots.
    pub individuals: u64,
}

/// Rows of the values that experiments can set in addition to those of [`Foraging`].
#[rustfmt::skip]
pub fn parameters<T: AsMut<Swarm>>() -> Vec<Parameter<T>> {
    vec![
        row("robots", "", Whole(1, GREATEST_ROBOTS.into()), "O'Dowd et al. 2014, section 4.5",
            "Robots.", |spec, _| Some(&mut spec.as_mut().robots)),
        row("robot.individuals", "", Whole(0, i64::MAX as u64), "ours: the seed of how robots differ",
            "The seed from which the differences between robots are drawn.", |spec, _| Some(&mut spec.as_mut().individuals)),
        row("messages.range_mm", "mm", Number(0.0, 10_000.0), "O'Dowd et al. 2014, section 4.3",
            "Range of messages, between centres.", |spec, _| Some(&mut spec.as_mut().range)),
        row("messages.heard", "", Number(0.0, 1.0), "ours; arm",
            "Probability, once a second, of receiving a robot in range.", |spec, _| Some(&mut spec.as_mut().heard)),
        row("messages.line_of_sight", "", Any, "ours; arm",
            "Whether a robot between two others blocks their messages.", |spec, _| Some(&mut spec.as_mut().line_of_sight)),
        row("differences.wheels", "", Number(0.0, 0.2), "ours; arm without differences",
            "Standard deviation of the wheels' sizes, as a fraction: a robot curves.", |spec, _| Some(&mut spec.as_mut().differences.wheels)),
        row("differences.proximity", "", Number(0.0, 0.2), "ours; arm without differences",
            "Standard deviation of the gains of proximity sensors.", |spec, _| Some(&mut spec.as_mut().differences.proximity)),
        row("differences.light", "", Number(0.0, 0.2), "ours; arm without differences",
            "Standard deviation of the gains of light sensors.", |spec, _| Some(&mut spec.as_mut().differences.light)),
        row("differences.slip", "", Number(0.0, 1.0), "ours; arm without differences",
            "Maximum fraction of its travel that a wheel loses in a cycle.", |spec, _| Some(&mut spec.as_mut().differences.slip)),
        row("differences.latency", "", Any, "ours; arm without differences",
            "Whether wheels execute commands one cycle late.", |spec, _| Some(&mut spec.as_mut().differences.latency)),
        row("differences.beam", "", Number(0.0, 1.0), "ours; arm without differences",
            "Fraction by which the lamp is darker across its axis.", |spec, _| Some(&mut spec.as_mut().differences.beam)),
        row("differences.reflection", "", Number(0.0, 1.0), "ours; arm without differences",
            "Light reflected by the walls next to the lamp, from 0 to 1.", |spec, _| Some(&mut spec.as_mut().differences.reflection)),
        row("differences.shadows", "", Number(0.0, 1.0), "ours; arm without differences",
            "Fraction of the lamp's light that a robot blocks for one directly behind it.", |spec, _| Some(&mut spec.as_mut().differences.shadows)),
        row("differences.tracking_loss", "", Number(0.0, 1.0), "ours; arm without differences",
            "Probability that the tracking system sends a robot nothing in a cycle.", |spec, _| Some(&mut spec.as_mut().differences.tracking_loss)),
    ]
}

static PARAMETERS: LazyLock<Vec<Parameter<Swarm>>> = LazyLock::new(parameters);

impl AsMut<Self> for Swarm {
    fn as_mut(&mut self) -> &mut Self {
        self
    }
}

impl Swarm {
    /// The surrogate of the 2014 study's arena.
    pub fn odowd2014(robots: u32) -> Self {
        Self {
            robots,
            forager: Foraging {
                cycles: 30_000,
                ..Foraging::odowd2014(Light::Nowhere)
            },
            interval: 600,
            range: 250.0,
            heard: 0.5,
            line_of_sight: true,
            differences: Differences::ODOWD2014,
            individuals: 1,
        }
    }

    /// Values in the kernel's form.
    fn cells(&self) -> Vec<[u32; 4]> {
        let Self { differences, .. } = self;
        // The lamp's side is an input of a world; the cells have its position if it is opposite.
        let forager = Foraging {
            light: Light::OppositeNest,
            ..self.forager
        };
        let seconds = f64::from(self.interval) / f64::from(SECOND);
        let mut cells = forager.cells(kernel::SWARM_CELLS, self.robots, seconds);
        let flag = |on: bool| if on { 1.0 } else { 0.0 };
        let of = |number: f32| in_kernel(f64::from(number));
        cells.put(
            kernel::MEETING,
            kernel::MeetingCell {
                squared_range: in_kernel(f64::from(self.range) * f64::from(self.range)),
                heard: of(self.heard),
                line_of_sight: flag(self.line_of_sight),
                ..kernel::MeetingCell::default()
            },
        );
        cells.put(
            kernel::DELAYS,
            kernel::DelaysCell {
                latency: flag(differences.latency),
                slip: of(differences.slip),
                tracking_loss: of(differences.tracking_loss),
                ..kernel::DelaysCell::default()
            },
        );
        cells.put(
            kernel::FIELD,
            kernel::FieldCell {
                beam: of(differences.beam),
                reflection: of(differences.reflection),
                shadows: of(differences.shadows),
                ..kernel::FieldCell::default()
            },
        );
        cells.put(
            kernel::SPREAD,
            kernel::SpreadCell {
                wheels: of(differences.wheels),
                proximity: of(differences.proximity),
                light: of(differences.light),
                ..kernel::SpreadCell::default()
            },
        );
        let [low, high] = Key::rollout(self.individuals, 0, 0, 0).words;
        cells.put(kernel::WHO, [low, high, 0, 0]);
        cells.into_table()
    }

    fn robot_line_words(&self) -> u32 {
        kernel::LINE_WORDS + self.robots.div_ceil(u32::BITS)
    }

    /// Words of all food items in a line of the trace.
    fn food_words(&self) -> u32 {
        kernel::LINE_ITEM_WORDS * self.forager.food_items
    }

    /// Packs the lamp and orders into the kernel's genes of a world's episode.
    pub fn inputs(&self, lamp: &Lamp, orders: &[Order]) -> Vec<f32> {
        let words = kernel::ORDERS as usize + kernel::ORDER_WORDS as usize * orders.len();
        let mut inputs = vec![0.0; words];
        inputs[kernel::LAMP_FIRST as usize] = side(lamp.first);
        inputs[kernel::LAMP_THEN as usize] = side(lamp.then);
        inputs[kernel::LAMP_MOVES as usize] = lamp.moves as f32;
        let each = inputs[kernel::ORDERS as usize..].chunks_exact_mut(kernel::ORDER_WORDS as usize);
        for (input, order) in each.zip(orders) {
            let mut put =
                |first: u32, numbers: &[f32]| input[first as usize..][..numbers.len()].copy_from_slice(numbers);
            put(kernel::ORDER_BEFORE, &order.before.unwrap_or([-1.0; 2]));
            put(kernel::ORDER_AFTER, &order.after);
            put(kernel::ORDER_AT, &[order.at as f32]);
            put(kernel::ORDER_BEGINS, &[order.begins.map_or(-1.0, |cycle| cycle as f32)]);
        }
        inputs
    }

    /// Decodes a world's trace with `line_words` words per line: as many as the largest world of its batch needs.
    pub fn lines(&self, words: &[u32], line_words: usize) -> Vec<Line> {
        let robot_words = self.robot_line_words() as usize;
        let robots = self.robots as usize;
        words
            .chunks_exact(line_words)
            .map(|line| {
                let robot = |words: &[u32]| {
                    let number = |word: u32| f32::from_bits(words[word as usize]);
                    let does = words[kernel::LINE_DOES as usize];
                    Seen {
                        x: number(kernel::LINE_X),
                        y: number(kernel::LINE_Y),
                        heading: number(kernel::LINE_HEADING),
                        behaviour: Behaviour::of(does & ((1 << kernel::LINE_CARRIES) - 1)),
                        carries: does >> kernel::LINE_CARRIES & 1 == 1,
                        brought: does >> kernel::LINE_BROUGHT,
                        earned: number(kernel::LINE_EARNED),
                        heard: words[kernel::LINE_WORDS as usize..]
                            .iter()
                            .rev()
                            .fold(0, |mask, &word| mask << u32::BITS | u128::from(word)),
                    }
                };
                let food = &line[robots * robot_words..][..self.food_words() as usize];
                Line {
                    robots: line[..robots * robot_words]
                        .chunks_exact(robot_words)
                        .map(robot)
                        .collect(),
                    food: food
                        .as_chunks::<2>()
                        .0
                        .iter()
                        .map(|place| place.map(f32::from_bits))
                        .collect(),
                }
            })
            .collect()
    }
}

impl WorldKind for Swarm {
    fn check(&self) -> Result<(), Invalid> {
        parameter::check(&PARAMETERS, &mut self.clone())?;
        self.forager.check()?;
        if self.forager.start.is_some() {
            return Err(Invalid::new(
                "start",
                "is given; allowed: none, since a swarm's robots start anywhere",
            ));
        }
        integer("interval", self.interval, 1..=1_000_000)
    }

    fn kernel(&self) -> &'static Kernel {
        &oneiro_shaders::SWARM
    }

    fn genes(&self) -> usize {
        (kernel::ORDERS + kernel::ORDER_WORDS * self.robots) as usize
    }

    fn robots(&self) -> u32 {
        self.robots
    }

    fn pack(&self, _: usize, buffers: &mut Buffers) -> episode::World {
        let numbers = buffers.add_table(self.cells());
        episode::World {
            numbers,
            ..self.forager.world()
        }
    }

    fn state_words(&self) -> u32 {
        kernel::WORLD_WORDS + kernel::ROBOT_WORDS * self.robots + kernel::ITEM_WORDS * self.forager.food_items
    }

    fn record_words(&self) -> u32 {
        self.robots * self.robot_line_words() + self.food_words()
    }
}

fn side(light: Light) -> f32 {
    match light {
        Light::OverNest => -1.0,
        Light::Nowhere => 0.0,
        Light::OppositeNest => 1.0,
    }
}

/// Position of a world's lamp over time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lamp {
    /// Position at first.
    pub first: Light,
    /// Position later.
    pub then: Light,
    /// Cycle from which the later position holds.
    pub moves: u32,
}

impl Lamp {
    /// A lamp that stays in place.
    pub fn fixed(light: Light) -> Self {
        Self {
            first: light,
            then: light,
            moves: 0,
        }
    }
}

/// Instructions for one robot in a stretch of its episode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Order {
    /// Genes that control it at first, each from 0 to 0.99; `None` if it isn't switched on yet.
    pub before: Option<[f32; 2]>,
    /// Genes that control it later.
    pub after: [f32; 2],
    /// Cycle from which the later genes hold.
    pub at: u32,
    /// Cycle of this stretch in which an interval begins, if any: its fitness restarts from 0.
    pub begins: Option<u32>,
}

impl Order {
    /// The same genes throughout.
    pub fn always(genes: [f32; 2]) -> Self {
        Self {
            before: Some(genes),
            after: genes,
            at: 0,
            begins: None,
        }
    }
}

/// Behaviour of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Behaviour {
    /// Flees the light.
    FleeLight,
    /// Searches at random.
    Search,
    /// Seeks the light.
    SeekLight,
    /// Avoids an obstacle.
    Avoid,
    /// Isn't switched on.
    Off,
}

impl Behaviour {
    pub(crate) fn of(number: u32) -> Self {
        match number {
            kernel::FLEE_LIGHT => Self::FleeLight,
            kernel::SEARCH => Self::Search,
            kernel::SEEK_LIGHT => Self::SeekLight,
            kernel::AVOID => Self::Avoid,
            _ => Self::Off,
        }
    }
}

/// What a robot's sensors read in a cycle, each from 0 to 1 as in the simulator. Less than [`LEAST_GENE`](crate::batch::LEAST_GENE)
/// counts as 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Readings {
    /// Proximity: 17 and 50 degrees to the left, 50 and 17 degrees to the right.
    pub near: [f32; 4],
    /// Light: 17 and 50 degrees to the left, 50 and 17 to the right, 90 and 150 to the left, 150 and 90 to the right.
    pub light: [f32; 8],
}

/// A robot as seen after a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Position, mm.
    pub x: f32,
    /// Position, mm.
    pub y: f32,
    /// Turns, counter-clockwise from the x axis.
    pub heading: f32,
    /// Behaviour in that cycle.
    pub behaviour: Behaviour,
    /// Whether it carries food.
    pub carries: bool,
    /// Food that it has brought since the previous line.
    pub brought: u32,
    /// Fitness in this interval so far.
    pub earned: f32,
    /// Robots that it has heard since the previous line, one bit each.
    pub heard: u128,
}

/// A world as seen after a cycle.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Its robots, in their order.
    pub robots: Vec<Seen>,
    /// Positions of the food, mm.
    pub food: Vec<[f32; 2]>,
}

/// Worlds of robots, simulated stretch by stretch.
pub trait Arena {
    /// Simulates all worlds until a cycle, each robot under its order. Returns for each world a line every `every`
    /// cycles, which must divide both a second and the stretch.
    ///
    /// # Errors
    /// Why the worlds couldn't be simulated.
    fn live(&mut self, until: u32, orders: &[Vec<Order>], every: u32) -> Result<Vec<Vec<Line>>, Trouble>;
}

/// Why worlds couldn't be simulated.
#[derive(Debug, thiserror::Error)]
pub enum Trouble {
    /// Error of the evaluator.
    #[error(transparent)]
    Evaluation(#[from] Error),
    /// Invalid orders.
    #[error(transparent)]
    Invalid(#[from] Invalid),
}

/// Runs batches.
type Evaluate<'a> = Box<dyn FnMut(&Batch) -> Result<Outcome, Error> + 'a>;

/// An [`Arena`] simulated by an evaluator.
pub struct Simulated<'a> {
    evaluate: Evaluate<'a>,
    worlds: Worlds,
    swarms: Vec<Swarm>,
    episodes: Vec<World>,
    now: u32,
    states: Vec<Vec<u32>>,
}

/// One world of an arena.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct World {
    /// Index of its swarm.
    pub swarm: usize,
    /// Its light.
    pub lamp: Lamp,
    /// Key of its random numbers.
    pub key: Key,
}

impl<'a> Simulated<'a> {
    /// Makes worlds before their first cycle.
    ///
    /// # Errors
    /// The first invalid value of a swarm.
    pub fn new(
        evaluator: &'a mut dyn Evaluator,
        control: &'a Control,
        swarms: &[Swarm],
        episodes: &[World],
    ) -> Result<Self, Invalid> {
        Self::with(move |batch| evaluator.evaluate(batch, control), swarms, episodes)
    }

    /// Makes worlds before their first cycle, with a function that runs batches.
    ///
    /// # Errors
    /// As [`Simulated::new`].
    pub fn with(
        evaluate: impl FnMut(&Batch) -> Result<Outcome, Error> + 'a,
        swarms: &[Swarm],
        episodes: &[World],
    ) -> Result<Self, Invalid> {
        Ok(Self {
            evaluate: Box::new(evaluate),
            worlds: Worlds::new(swarms)?,
            swarms: swarms.to_vec(),
            episodes: episodes.to_vec(),
            now: 0,
            states: Vec::new(),
        })
    }

    /// Next cycle, and the states that all worlds keep between stretches.
    pub fn state(&self) -> (u32, &[Vec<u32>]) {
        (self.now, &self.states)
    }

    /// Continues from [`Simulated::state`].
    #[must_use]
    pub fn at(mut self, now: u32, states: Vec<Vec<u32>>) -> Self {
        self.now = now;
        self.states = states;
        self
    }
}

impl Arena for Simulated<'_> {
    fn live(&mut self, until: u32, orders: &[Vec<Order>], every: u32) -> Result<Vec<Vec<Line>>, Trouble> {
        let inputs: Vec<Vec<f32>> = self
            .episodes
            .iter()
            .zip(orders)
            .map(|(episode, orders)| self.swarms[episode.swarm].inputs(&episode.lamp, orders))
            .collect();
        let rollouts: Vec<Rollout<'_>> = self
            .episodes
            .iter()
            .zip(&inputs)
            .map(|(episode, genes)| Rollout {
                world: episode.swarm,
                genes,
                key: episode.key,
            })
            .collect();
        let batch = self
            .worlds
            .stretch(&rollouts, self.now..until, &self.states, Some(TraceRequest { every }))?;
        let outcome = (self.evaluate)(&batch)?;
        self.states = outcome.states;
        self.now = until;
        let lines = self.episodes.iter().zip(&outcome.logs);
        Ok(lines
            .map(|(episode, words)| self.swarms[episode.swarm].lines(words, batch.record_words()))
            .collect())
    }
}
