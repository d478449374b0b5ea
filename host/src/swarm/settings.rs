//! What there is to choose of a swarm whose simulators evolve with its controllers: the values of an experiment's file,
//! and their defaults, those of O'Dowd, Studley and Winfield (2014) where the paper has them.

use oneiro::foraging::{Foraging, Light};
use oneiro::swarm::{Differences, Swarm};
use serde::{Deserialize, Serialize};

use crate::evolve::encapsulated::{Boundary, Breeding, Mutation};
use crate::exchange::pairs::{Key, Leaves, Rules};
use crate::swarm::record::{Case, Credit};

/// All of it. Lengths in mm, times in s.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Settings {
    /// The experiment case, 1 to 6 of the paper.
    pub(crate) case: Case,
    /// Robots: 10 (paper), 1 to 128.
    pub(crate) robots: u32,
    /// Minutes that they forage: 50 (paper).
    pub(crate) minutes: u32,
    /// The minute in which the light moves, in the cases where it does: 25 (paper).
    pub(crate) light_moves_minute: u32,
    /// Where they forage.
    pub(crate) arena: Arena,
    /// What they are.
    pub(crate) robot: Robot,
    /// What they hear of each other.
    pub(crate) messages: Messages,
    /// How the arena differs from their simulators.
    pub(crate) differences: Real,
    /// The evolution of controllers on board of each.
    pub(crate) controllers: Controllers,
    /// The evolution of simulators among them.
    pub(crate) simulators: Simulators,
    /// When what happens.
    pub(crate) clock: Clock,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            case: Case::Over,
            robots: 10,
            minutes: 50,
            light_moves_minute: 25,
            arena: Arena::default(),
            robot: Robot::default(),
            messages: Messages::default(),
            differences: Real::default(),
            controllers: Controllers::default(),
            simulators: Simulators::default(),
            clock: Clock::default(),
        }
    }
}

/// Arena, food and light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Arena {
    /// Radius of the wall: 600 (paper).
    pub(crate) radius_mm: f32,
    /// Radius of the nest, which is centred on the wall: 200 (paper).
    pub(crate) nest_radius_mm: f32,
    /// Items of food at all times: 7 (paper), at most 8.
    pub(crate) food_items: u32,
    /// How near a robot's centre must come to one: 50 (ours).
    pub(crate) food_radius_mm: f32,
    /// How far behind the wall the lamp is: 100 (ours).
    pub(crate) lamp_behind_wall_mm: f32,
    /// The light fades as `exp(-decay * metres)`: 2 (ARGoS).
    pub(crate) light_decay: f32,
    /// What light sensors read without a lamp, of 1: 0.1 (ours).
    pub(crate) ambient: f32,
    /// Uniform noise of their readings: 0.05 (ARGoS' form, our size).
    pub(crate) light_noise: f32,
}

impl Default for Arena {
    fn default() -> Self {
        let own = Foraging::odowd2014(Light::Nowhere);
        Self {
            radius_mm: own.arena_radius,
            nest_radius_mm: own.nest_radius,
            food_items: own.food_items,
            food_radius_mm: own.food_radius,
            lamp_behind_wall_mm: own.lamp_behind_wall,
            light_decay: own.light_decay,
            ambient: own.ambient,
            light_noise: own.light_noise,
        }
    }
}

/// An e-puck and its behaviours.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Robot {
    /// Radius of the body: 35 (ARGoS, GCtronic).
    pub(crate) body_radius_mm: f32,
    /// Distance of the wheels: 53 (ARGoS, GCtronic).
    pub(crate) wheel_base_mm: f32,
    /// Fastest a wheel goes, mm/s: 128.8 (Webots, GCtronic).
    pub(crate) greatest_speed_mm_s: f32,
    /// Uniform noise of each wheel's way in a cycle, as a share: 0.05 (Enki).
    pub(crate) wheel_noise: f32,
    /// Speed straight on, mm/s: 80 (ours).
    pub(crate) cruise_mm_s: f32,
    /// Turns on the spot, rad/s: 2 (ours).
    pub(crate) turn_rad_s: f32,
    /// Phototaxis turns so many rad/s for each rad off the light: 3 (ours).
    pub(crate) phototaxis_gain: f32,
    /// And at most so fast, rad/s: 2.4 (ours).
    pub(crate) phototaxis_turn_rad_s: f32,
    /// What is nearer makes it turn away: 30 (ours).
    pub(crate) near_mm: f32,
    /// How long it then goes straight on: 1 (ours).
    pub(crate) escape_s: f32,
    /// Mean time between turns of random search: 3 (ours).
    pub(crate) search_interval_s: f32,
    /// Draws how robots differ from each other.
    pub(crate) individuals: u64,
}

impl Default for Robot {
    fn default() -> Self {
        let own = Foraging::odowd2014(Light::Nowhere);
        Self {
            body_radius_mm: own.body_radius,
            wheel_base_mm: own.wheel_base,
            greatest_speed_mm_s: own.greatest_speed,
            wheel_noise: own.wheel_noise,
            cruise_mm_s: own.cruise,
            turn_rad_s: own.turn,
            phototaxis_gain: own.phototaxis_gain,
            phototaxis_turn_rad_s: own.phototaxis_turn,
            near_mm: own.near,
            escape_s: own.escape,
            search_interval_s: own.search_interval,
            individuals: 1,
        }
    }
}

/// Messages between robots.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Messages {
    /// How far they reach, between centres: 250 (paper).
    pub(crate) range_mm: f32,
    /// The chance that one is heard, once a second: 0.5 (ours).
    pub(crate) heard: f32,
    /// Whether bodies are in the way: yes (ours).
    pub(crate) line_of_sight: bool,
}

impl Default for Messages {
    fn default() -> Self {
        let own = Swarm::odowd2014(1);
        Self {
            range_mm: own.range,
            heard: own.heard,
            line_of_sight: own.line_of_sight,
        }
    }
}

/// What the arena has and the simulators on board do not, see [`Differences`]; all ours.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Real {
    /// Standard deviation of wheels.
    pub(crate) wheels: f32,
    /// Standard deviation of proximity sensors.
    pub(crate) proximity: f32,
    /// Standard deviation of light sensors.
    pub(crate) light: f32,
    /// Greatest slip of wheels.
    pub(crate) slip: f32,
    /// Whether wheels obey a cycle late.
    pub(crate) latency: bool,
    /// How much darker the lamp is across its axis.
    pub(crate) beam: f32,
    /// Light thrown back by the walls.
    pub(crate) reflection: f32,
    /// Share of light that a body takes from one behind it.
    pub(crate) shadows: f32,
    /// Chance that the tracking is silent in a cycle.
    pub(crate) tracking_loss: f32,
}

impl Default for Real {
    fn default() -> Self {
        Differences::ODOWD2014.into()
    }
}

impl Real {
    /// Bodies alone.
    pub(crate) fn none() -> Self {
        Differences::NONE.into()
    }
}

impl From<Differences> for Real {
    fn from(own: Differences) -> Self {
        Self {
            wheels: own.wheels,
            proximity: own.proximity,
            light: own.light,
            slip: own.slip,
            latency: own.latency,
            beam: own.beam,
            reflection: own.reflection,
            shadows: own.shadows,
            tracking_loss: own.tracking_loss,
        }
    }
}

/// The encapsulated evolution (section 4.2 of the paper).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Controllers {
    /// Genotypes: 10 (paper).
    pub(crate) population: u32,
    /// How many of them overwrite the others: 4 (paper).
    pub(crate) parents: u32,
    /// The chance that a gene of a copy changes: 0.2 (paper).
    pub(crate) mutation_rate: f64,
    /// Standard deviation of the change. The paper's 2 forgets the parent where genes go from 0 to 0.99; 0.2 is our
    /// choice, and the study has 2, 0.2 and 0.02 side by side.
    pub(crate) mutation_scale: f64,
    /// What holds genes within 0 to 0.99: clamping (ours).
    pub(crate) boundary: Boundary,
    /// How many controllers of robots that were heard, the better first, are tried in one's own simulator in place of
    /// the last copies: 0 (the paper's introduction and its section 6 speak of both 6 and 1).
    pub(crate) guests: u32,
}

impl Default for Controllers {
    fn default() -> Self {
        Self {
            population: 10,
            parents: 4,
            mutation_rate: 0.2,
            mutation_scale: 0.2,
            boundary: Boundary::Clamp,
            guests: 0,
        }
    }
}

/// The distributed evolution (section 4.3 of the paper).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Simulators {
    /// Standard deviation of the change of a gene, which always changes: see `controllers.mutation_scale`.
    pub(crate) mutation_scale: f64,
    /// What holds genes within 0 to 0.99: clamping (ours).
    pub(crate) boundary: Boundary,
    /// Which simulator fitness is credited to: as the paper says it, that which a robot has while it earns it.
    pub(crate) credit: Credit,
    /// Pairs that a robot remembers: 10 (paper).
    pub(crate) pairs: u32,
    /// What is the same pair, heard again: that of a robot's interval (ours).
    pub(crate) key: Key,
    /// Which pair makes room: the lowest (ours).
    pub(crate) leaves: Leaves,
    /// What robots say of their fitness.
    pub(crate) says: Says,
}

impl Default for Simulators {
    fn default() -> Self {
        Self {
            mutation_scale: 0.2,
            boundary: Boundary::Clamp,
            credit: Credit::Lagged,
            pairs: 10,
            key: Key::RobotAndInterval,
            leaves: Leaves::Lowest,
            says: Says::SoFar,
        }
    }
}

/// What robots say of their fitness.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Says {
    /// What they have earned in this interval so far.
    SoFar,
    /// What they earned in the interval before, and in which simulator.
    LastWhole,
}

/// When what happens.
#[expect(clippy::struct_field_names, reason = "the unit of each")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Clock {
    /// An interval: 60 (paper).
    pub(crate) interval_s: u32,
    /// Robots are switched on one after the other within so many seconds, whole ones: 5 (ours).
    pub(crate) offset_s: u32,
    /// When in an interval the best of its simulations takes over: at its end, 60 (ours); the paper's 34 s of
    /// computing would allow 34.
    pub(crate) installed_s: u32,
}

impl Default for Clock {
    fn default() -> Self {
        Self {
            interval_s: 60,
            offset_s: 5,
            installed_s: 60,
        }
    }
}

impl Settings {
    /// Every value by its key, with where it is from.
    pub(crate) fn listed(&self) -> Vec<(String, String, &'static str)> {
        let table = toml::Table::try_from(self).expect("settings are tables of numbers and words");
        let value = |key: &str| {
            let mut parts = key.split('.');
            let first = parts.next().and_then(|part| table.get(part));
            parts.fold(first, |value, part| value?.get(part))
        };
        let words = |value: Option<&toml::Value>| match value {
            Some(toml::Value::String(word)) => word.clone(),
            // Single precision, as it was given.
            Some(toml::Value::Float(number)) => (*number as f32).to_string(),
            Some(other) => other.to_string(),
            None => String::new(),
        };
        SOURCES
            .iter()
            .map(|&(key, source)| (key.to_owned(), words(value(key)), source))
            .collect()
    }

    /// Seconds in all.
    pub(crate) fn seconds(&self) -> u32 {
        60 * self.minutes
    }

    /// The second in which the light moves.
    pub(crate) fn light_moves(&self) -> u32 {
        60 * self.light_moves_minute
    }

    /// The simulator that a robot has on board.
    pub(crate) fn simulator(&self, light: Light) -> Foraging {
        let Self {
            arena, robot, clock, ..
        } = self;
        Foraging {
            arena_radius: arena.radius_mm,
            nest_radius: arena.nest_radius_mm,
            food_items: arena.food_items,
            food_radius: arena.food_radius_mm,
            light,
            lamp_behind_wall: arena.lamp_behind_wall_mm,
            light_decay: arena.light_decay,
            ambient: arena.ambient,
            light_noise: arena.light_noise,
            body_radius: robot.body_radius_mm,
            wheel_base: robot.wheel_base_mm,
            greatest_speed: robot.greatest_speed_mm_s,
            wheel_noise: robot.wheel_noise,
            cruise: robot.cruise_mm_s,
            turn: robot.turn_rad_s,
            phototaxis_gain: robot.phototaxis_gain,
            phototaxis_turn: robot.phototaxis_turn_rad_s,
            near: robot.near_mm,
            escape: robot.escape_s,
            search_interval: robot.search_interval_s,
            start: None,
            cycles: 10 * clock.interval_s,
        }
    }

    /// Where robots really are.
    pub(crate) fn swarm(&self) -> Swarm {
        let own = &self.differences;
        Swarm {
            robots: self.robots,
            forager: Foraging {
                cycles: 10 * self.seconds(),
                ..self.simulator(Light::Nowhere)
            },
            interval: 10 * self.clock.interval_s,
            range: self.messages.range_mm,
            heard: self.messages.heard,
            line_of_sight: self.messages.line_of_sight,
            differences: Differences {
                wheels: own.wheels,
                proximity: own.proximity,
                light: own.light,
                slip: own.slip,
                latency: own.latency,
                beam: own.beam,
                reflection: own.reflection,
                shadows: own.shadows,
                tracking_loss: own.tracking_loss,
            },
            individuals: self.robot.individuals,
        }
    }

    /// How controllers are bred.
    pub(crate) fn breeding(&self) -> Breeding {
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

/// Where each value is from, by its key.
pub(crate) const SOURCES: [(&str, &str); 52] = [
    ("case", "paper: one of six"),
    ("robots", "paper"),
    ("minutes", "paper"),
    ("light_moves_minute", "paper"),
    ("arena.radius_mm", "paper"),
    ("arena.nest_radius_mm", "paper; its centre on the wall"),
    ("arena.food_items", "paper"),
    ("arena.food_radius_mm", "ours: the paper gives no size"),
    ("arena.lamp_behind_wall_mm", "ours"),
    ("arena.light_decay", "ARGoS; arms"),
    ("arena.ambient", "ours"),
    ("arena.light_noise", "ARGoS' form, our size; arms"),
    ("robot.body_radius_mm", "ARGoS, GCtronic"),
    ("robot.wheel_base_mm", "ARGoS, GCtronic"),
    ("robot.greatest_speed_mm_s", "Webots, GCtronic"),
    ("robot.wheel_noise", "Enki"),
    ("robot.cruise_mm_s", "ours; arms"),
    ("robot.turn_rad_s", "ours"),
    ("robot.phototaxis_gain", "ours"),
    ("robot.phototaxis_turn_rad_s", "ours"),
    ("robot.near_mm", "ours"),
    ("robot.escape_s", "ours; arms"),
    ("robot.search_interval_s", "ours"),
    ("robot.individuals", "ours: the seed of how robots differ"),
    ("messages.range_mm", "paper"),
    ("messages.heard", "ours; arm"),
    ("messages.line_of_sight", "ours; arm"),
    ("differences.wheels", "ours; arm without differences"),
    ("differences.proximity", "ours; arm without differences"),
    ("differences.light", "ours; arm without differences"),
    ("differences.slip", "ours; arm without differences"),
    ("differences.latency", "ours; arm without differences"),
    ("differences.beam", "ours; arm without differences"),
    ("differences.reflection", "ours; arm without differences"),
    ("differences.shadows", "ours; arm without differences"),
    ("differences.tracking_loss", "ours; arm without differences"),
    ("controllers.population", "paper"),
    ("controllers.parents", "paper"),
    ("controllers.mutation_rate", "paper"),
    (
        "controllers.mutation_scale",
        "paper: 2, which forgets the parent; 2, 0.2 and 0.02 side by side",
    ),
    ("controllers.boundary", "ours; arms"),
    ("controllers.guests", "ours; arms"),
    ("simulators.mutation_scale", "as controllers.mutation_scale"),
    ("simulators.boundary", "ours; arms"),
    ("simulators.credit", "paper: lagged; lagged and matched side by side"),
    ("simulators.pairs", "paper; arms"),
    ("simulators.key", "ours; arm"),
    ("simulators.leaves", "ours; arm"),
    ("simulators.says", "paper: so far; arm"),
    ("clock.interval_s", "paper"),
    ("clock.offset_s", "ours; arms"),
    ("clock.installed_s", "ours: at the interval's end; arm"),
];

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(table: &toml::Table, prefix: &str, all: &mut Vec<String>) {
        for (key, value) in table {
            match value {
                toml::Value::Table(table) => keys(table, &format!("{prefix}{key}."), all),
                _ => all.push(format!("{prefix}{key}")),
            }
        }
    }

    #[test]
    fn every_value_says_where_it_is_from() {
        let settings = Settings::default();
        let mut all = Vec::new();
        keys(&toml::Table::try_from(&settings).unwrap(), "", &mut all);
        let mut listed: Vec<String> = settings.listed().into_iter().map(|(key, ..)| key).collect();
        all.sort();
        listed.sort();
        assert_eq!(all, listed);
        assert!(
            settings
                .listed()
                .iter()
                .all(|(_, value, source)| !value.is_empty() && !source.is_empty())
        );
    }
}
