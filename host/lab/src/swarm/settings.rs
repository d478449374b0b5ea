//! Settings of a swarm whose simulators evolve with its controllers, each described by a row. The defaults are those of
//! O'Dowd, Studley and Winfield (2014), where the paper has them.

use oneiro::foraging::{self, AsForaging, Foraging, Light};
use oneiro::parameter::Allowed::{Any, Number, Whole, WholeUpTo};
use oneiro::parameter::{Choice, Choices, Datum, Parameter, row};
use oneiro::swarm::{self, Swarm};
use oneiro_evolve::encapsulated::{Boundary, Breeding, Mutation};
use serde::{Serialize, Serializer};

use crate::exchange::links::{Links, Topology};
use crate::exchange::pairs::{Key, Leaves, Rules};
use crate::exchange::radio::limits::Limits;
use crate::swarm::record::{Case, Credit};

/// All settings. Lengths in mm, times in s.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The experiment case, 1 to 6 of the paper.
    pub case: Case,
    /// Duration of foraging in minutes.
    pub minutes: u32,
    /// Minute in which the light moves, in the cases where it does.
    pub light_moves_minute: u32,
    /// Robots, arena, messages, and how the arena differs from the robots' simulators. Its times follow from `minutes`
    /// and `clock`.
    pub world: Swarm,
    /// How the number of items of food follows from that of the world.
    pub food_scales: FoodScales,
    /// The evolution of controllers on each robot.
    pub controllers: Controllers,
    /// The evolution of simulators among robots.
    pub simulators: Simulators,
    /// Who can hear whom.
    pub links: Links,
    /// Times of events.
    pub clock: Clock,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            case: Case::Over,
            minutes: 50,
            light_moves_minute: 25,
            world: world(),
            food_scales: FoodScales::Never,
            controllers: Controllers {
                population: 10,
                parents: 4,
                mutation_rate: 0.2,
                mutation_scale: 0.2,
                boundary: Boundary::Clamp,
                guests: 0,
            },
            simulators: Simulators {
                mutation_scale: 0.2,
                boundary: Boundary::Clamp,
                credit: Credit::Lagged,
                pairs: 10,
                key: Key::RobotAndInterval,
                leaves: Leaves::Lowest,
                says: Says::SoFar,
            },
            links: Links::ENCOUNTERS,
            clock: Clock {
                interval_s: 60,
                offset_s: 5,
                installed_s: 60,
            },
        }
    }
}

/// Robots of the paper's swarm.
const ROBOTS: u32 = 10;

/// The paper's swarm. Section 5.6 of the paper has "random movement behaviour in the absence of a light source": its robots seek and
/// flee only a light that they see, the minimum that ambient light and noise never reach.
fn world() -> Swarm {
    let mut world = Swarm::odowd2014(ROBOTS);
    world.forager.phototaxis_threshold = 0.16;
    world
}

/// What the number of items grows with, from that of the paper's robots and arena.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FoodScales {
    Never,
    WithRobots,
    WithArea,
}

/// The encapsulated evolution (section 4.2 of the paper).
#[derive(Clone, Debug, PartialEq)]
pub struct Controllers {
    pub population: u32,
    pub parents: u32,
    pub(crate) mutation_rate: f64,
    pub mutation_scale: f64,
    pub boundary: Boundary,
    pub guests: u32,
}

/// The distributed evolution (section 4.3 of the paper).
#[derive(Clone, Debug, PartialEq)]
pub struct Simulators {
    pub mutation_scale: f64,
    pub boundary: Boundary,
    pub credit: Credit,
    pub pairs: u32,
    pub key: Key,
    pub leaves: Leaves,
    pub says: Says,
}

/// The fitness that robots report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Says {
    SoFar,
    LastWhole,
}

/// Times of events.
#[derive(Clone, Debug, PartialEq)]
pub struct Clock {
    pub interval_s: u32,
    pub offset_s: u32,
    pub installed_s: u32,
}

/// Maximum duration of a run in minutes: a kernel counts up to a million cycles.
const GREATEST_MINUTES: u64 = 1_666;

/// Rows of all values, for any type that holds them.
pub fn parameters<T: AsMut<Settings> + AsMut<Swarm> + AsForaging>() -> Vec<Parameter<T>> {
    let mut rows = own_parameters();
    rows.splice(1..1, foraging::parameters().into_iter().chain(swarm::parameters()));
    rows
}

#[rustfmt::skip]
fn own_parameters<T: AsMut<Settings>>() -> Vec<Parameter<T>> {
    vec![
        row("case", "", Any, "O'Dowd et al. 2014, section 4.1: one of six",
            "The experiment case.", |own, _| Some(&mut own.as_mut().case)),
        row("minutes", "min", Whole(1, GREATEST_MINUTES), "O'Dowd et al. 2014, section 4.5",
            "How long robots forage.", |own, _| Some(&mut own.as_mut().minutes)),
        row("light_moves_minute", "min", Whole(0, GREATEST_MINUTES), "O'Dowd et al. 2014, section 4.5",
            "When the light moves, in the cases where it does.", |own, _| Some(&mut own.as_mut().light_moves_minute)),
        row("arena.food_scales", "", Any, "ours: 7 items for 10 robots in 1.13 m2 in O'Dowd et al. 2014, section 4.5",
            "What the number of items grows with, in the arena and in the simulators; arena.food_items is that of the paper's swarm.", |own, _| Some(&mut own.as_mut().food_scales)),
        row("controllers.population", "", Whole(1, 1000), "O'Dowd et al. 2014, section 4.2",
            "Controller genotypes on each robot.", |own, _| Some(&mut own.as_mut().controllers.population)),
        row("controllers.parents", "", WholeUpTo(1, "controllers.population"), "O'Dowd et al. 2014, section 4.2",
            "How many of them overwrite the others.", |own, _| Some(&mut own.as_mut().controllers.parents)),
        row("controllers.mutation_rate", "", Number(0.0, 1.0), "O'Dowd et al. 2014, section 4.2",
            "Chance that a gene of a copy changes.", |own, _| Some(&mut own.as_mut().controllers.mutation_rate)),
        row("controllers.mutation_scale", "", Number(0.0, 10.0), "ours: 2 in O'Dowd et al. 2014, section 4.2, which forgets the parent; 2, 0.2 and 0.02 side by side",
            "Standard deviation of the change; genes go from 0 to 0.99.", |own, _| Some(&mut own.as_mut().controllers.mutation_scale)),
        row("controllers.boundary", "", Any, "ours; arms",
            "What holds genes within 0 to 0.99.", |own, _| Some(&mut own.as_mut().controllers.boundary)),
        row("controllers.guests", "", WholeUpTo(0, "controllers.population"), "ours; arms",
            "How many controllers received from other robots, the best first, replace the last copies in the robot's simulator.", |own, _| Some(&mut own.as_mut().controllers.guests)),
        row("simulators.mutation_scale", "", Number(0.0, 10.0), "as controllers.mutation_scale; 2 in O'Dowd et al. 2014, section 4.3",
            "Standard deviation of the change of a simulator's gene; every copy's gene changes.", |own, _| Some(&mut own.as_mut().simulators.mutation_scale)),
        row("simulators.boundary", "", Any, "ours; arms",
            "What holds genes within 0 to 0.99.", |own, _| Some(&mut own.as_mut().simulators.boundary)),
        row("simulators.credit", "", Any, "O'Dowd et al. 2014, section 4.3: lagged; lagged and matched side by side",
            "Which simulator a robot's fitness is credited to.", |own, _| Some(&mut own.as_mut().simulators.credit)),
        row("simulators.pairs", "", Whole(1, 1000), "O'Dowd et al. 2014, section 4.3; arms",
            "Pairs (a simulator and its fitness) that a robot stores.", |own, _| Some(&mut own.as_mut().simulators.pairs)),
        row("simulators.key", "", Any, "ours; arm",
            "What identifies a pair received again.", |own, _| Some(&mut own.as_mut().simulators.key)),
        row("simulators.leaves", "", Any, "ours; arm",
            "Which pair a new one replaces.", |own, _| Some(&mut own.as_mut().simulators.leaves)),
        row("simulators.says", "", Any, "O'Dowd et al. 2014, section 4.3: so far; arm",
            "Which fitness robots report.", |own, _| Some(&mut own.as_mut().simulators.says)),
        row("messages.topology", "", Any, "ours; section 6 of O'Dowd et al. 2014 asks for island models",
            "The robots whose messages can reach a robot. Simulated swarms only.", |own, _| Some(&mut own.as_mut().links.topology)),
        row("messages.migration", "", Number(0.0, 1.0), "ours; as messages.topology",
            "Chance that messages of one robot can reach another one during an interval, drawn for each of the two directions. Simulated swarms only.", |own, _| Some(&mut own.as_mut().links.migration)),
        row("clock.interval_s", "s", Whole(10, 180), "O'Dowd et al. 2014, section 4.3",
            "Length of an interval.", |own, _| Some(&mut own.as_mut().clock.interval_s)),
        row("clock.offset_s", "s", WholeUpTo(0, "clock.interval_s"), "ours; arms",
            "Robots are switched on one after the other within this time.", |own, _| Some(&mut own.as_mut().clock.offset_s)),
        row("clock.installed_s", "s", WholeUpTo(1, "clock.interval_s"), "ours: at the interval's end; arm",
            "When in an interval the best simulated controller takes over, not before all robots are on; the 34 s of computing of section 4.3 would allow 34.", |own, _| Some(&mut own.as_mut().clock.installed_s)),
    ]
}

/// Maximum number of items that a robot can bring in some cycles: one every other cycle, since it has to take each before.
pub fn most_items(cycles: u32) -> u32 {
    cycles.div_ceil(2)
}

impl Choice for Case {
    const CHOICES: Choices<Self> = &[
        ("no-light", Self::NoLight, "1: no light source"),
        ("over", Self::Over, "2: the light stays over the nest"),
        ("opposite", Self::Opposite, "3: the light stays opposite the nest"),
        (
            "over-then-opposite",
            Self::OverThenOpposite,
            "4: over the nest, later opposite",
        ),
        (
            "opposite-then-over",
            Self::OppositeThenOver,
            "5: opposite the nest, later over it",
        ),
        ("random", Self::Random, "6: no evolution, all robots search at random"),
    ];
}

impl Choice for FoodScales {
    const CHOICES: Choices<Self> = &[
        ("never", Self::Never, "nothing, food_items are there"),
        (
            "with_robots",
            Self::WithRobots,
            "the number of robots, food_items for each 10 of them",
        ),
        (
            "with_area",
            Self::WithArea,
            "the arena's area, food_items in a radius of 600 mm",
        ),
    ];
}

impl Choice for Credit {
    const CHOICES: Choices<Self> = &[
        (
            "lagged",
            Self::Lagged,
            "the one that the robot has while it earns the fitness, as the paper says",
        ),
        (
            "matched",
            Self::Matched,
            "the one in which the controller was chosen that earns it",
        ),
    ];
}

impl Choice for Key {
    const CHOICES: Choices<Self> = &[
        (
            "robot_and_interval",
            Self::RobotAndInterval,
            "that of a robot's interval",
        ),
        ("robot", Self::Robot, "that of a robot"),
    ];
}

impl Choice for Leaves {
    const CHOICES: Choices<Self> = &[
        (
            "lowest",
            Self::Lowest,
            "the one of the lowest fitness, if the other's is higher",
        ),
        ("oldest", Self::Oldest, "the one received first"),
    ];
}

impl Choice for Says {
    const CHOICES: Choices<Self> = &[
        ("so_far", Self::SoFar, "what they have earned in this interval so far"),
        (
            "last_whole",
            Self::LastWhole,
            "what they earned in the interval before, and in which simulator",
        ),
    ];
}

impl AsMut<Self> for Settings {
    fn as_mut(&mut self) -> &mut Self {
        self
    }
}

impl AsMut<Swarm> for Settings {
    fn as_mut(&mut self) -> &mut Swarm {
        &mut self.world
    }
}

impl AsForaging for Settings {
    fn as_foraging(&mut self) -> Option<&mut Foraging> {
        Some(&mut self.world.forager)
    }
}

/// Every value by its key.
impl Serialize for Settings {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.listed().into_iter().map(|(key, value, _)| (key, value)))
    }
}

impl Settings {
    /// Every value by its key, with its source.
    pub fn listed(&self) -> Vec<(String, String, &'static str)> {
        let mut own = self.clone();
        let value = |row: &Parameter<Self>| {
            let value = match (row.field)(&mut own, 0)?.get()? {
                Datum::Word(word) => word,
                other => other.to_string(),
            };
            Some((row.key.to_owned(), value, row.source))
        };
        parameters().iter().filter_map(value).collect()
    }

    /// Seconds in all.
    pub fn seconds(&self) -> u32 {
        60 * self.minutes
    }

    /// The second in which the light moves.
    pub(crate) fn light_moves(&self) -> u32 {
        60 * self.light_moves_minute
    }

    /// Items of food in the arena, and in each robot's simulator: the nearest whole number, of two the greater one.
    pub fn food_items(&self) -> u32 {
        let items = self.world.forager.food_items;
        match self.food_scales {
            FoodScales::Never => items,
            FoodScales::WithRobots => (items * self.world.robots + ROBOTS / 2) / ROBOTS,
            FoodScales::WithArea => {
                let usual = world().forager.arena_radius;
                let times = f64::from(self.world.forager.arena_radius) / f64::from(usual);
                (f64::from(items) * times * times + 0.5) as u32
            }
        }
    }

    /// The robot's simulator.
    pub fn simulator(&self, light: Light) -> Foraging {
        Foraging {
            light,
            cycles: 10 * self.clock.interval_s,
            food_items: self.food_items(),
            ..self.world.forager
        }
    }

    /// World of the real robots.
    pub fn swarm(&self) -> Swarm {
        Swarm {
            forager: Foraging {
                cycles: 10 * self.seconds(),
                ..self.simulator(Light::Nowhere)
            },
            interval: 10 * self.clock.interval_s,
            ..self.world
        }
    }

    /// How controllers are bred.
    pub fn breeding(&self) -> Breeding {
        let own = &self.controllers;
        Breeding {
            parents: own.parents as usize,
            rate: own.mutation_rate,
            mutation: Mutation {
                deviation: own.mutation_scale,
                boundary: own.boundary,
            },
        }
    }

    /// How simulators change.
    pub(crate) fn simulator_mutation(&self) -> Mutation {
        Mutation {
            deviation: self.simulators.mutation_scale,
            boundary: self.simulators.boundary,
        }
    }

    /// Limits of what robots may broadcast. An item earns the rest of the interval in seconds.
    pub fn limits(&self) -> Limits {
        let interval = self.clock.interval_s;
        Limits {
            robots: self.world.robots as u16,
            interval,
            offset: self.clock.offset_s,
            lag: u32::from(self.simulators.says == Says::LastWhole),
            fitness: (most_items(swarm::SECOND * interval) * interval) as f32 / 2.0,
            seconds: self.seconds(),
            food: most_items(swarm::SECOND * self.seconds()),
        }
    }

    /// Whether robots hear those that they meet.
    pub fn meet(&self) -> bool {
        self.links.topology == Topology::Encounters
    }

    /// How pairs are kept.
    pub(crate) fn pair_rules(&self) -> Rules {
        let own = &self.simulators;
        Rules {
            room: own.pairs as usize,
            key: own.key,
            leaves: own.leaves,
        }
    }
}
