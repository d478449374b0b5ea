//! An experiment with a swarm: a file with a table `swarm`.

use std::path::Path;

use oneiro::batch::Worlds;
use serde::{Deserialize, Serialize};

use super::Identities;
use super::check::{Checked, GREATEST_SEED, invalid, name, within};
use super::source::{Parsed, Setting, Source};
use crate::exit::Result;
use crate::swarm::Plan;
use crate::swarm::record::Kind;
use crate::swarm::settings::Settings;

/// A checked experiment with a swarm.
#[derive(Clone, Debug)]
pub(crate) struct SwarmExperiment(File);

/// What may stand in its file.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    /// What runs are called; the file's name where it is not given.
    #[serde(default)]
    name: String,
    /// The run's seed where the command line gives none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    seed: Option<u64>,
    /// All else.
    swarm: Settings,
}

/// Minutes of a run: a kernel's cycles are numbers up to a million.
const GREATEST_MINUTES: u32 = 1_666;

impl SwarmExperiment {
    /// Reads the values of an experiment's file.
    ///
    /// # Errors
    /// Exit 3: the file and the line and column in it (or the setting), the key, what it is, and what is allowed.
    pub(crate) fn of(path: &Path, values: &Parsed<'_>, set: &[Setting]) -> Result<Self> {
        let (mut file, source): (File, _) = Source::read(values, set)?;
        if file.name.is_empty() {
            file.name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        }
        check(&file).map_err(|invalid| source.invalid(&invalid.field, &invalid.problem))?;
        Ok(Self(file))
    }

    /// Its name.
    pub(crate) fn name(&self) -> &str {
        &self.0.name
    }

    /// The seed of its file.
    pub(crate) fn seed(&self) -> Option<u64> {
        self.0.seed
    }

    /// All its values.
    pub(crate) fn settings(&self) -> &Settings {
        &self.0.swarm
    }

    /// Its run from a seed.
    pub(crate) fn plan(&self, seed: u64) -> Plan {
        Plan {
            settings: self.0.swarm.clone(),
            kind: Kind::Evolved,
            number: 0,
            seed,
        }
    }

    /// The experiment of a run with every default written out, as TOML.
    pub(crate) fn resolved_toml(&self, seed: u64) -> String {
        let file = File {
            seed: Some(seed),
            ..self.0.clone()
        };
        toml::to_string(&file).expect("settings are tables of numbers, words and lists")
    }

    /// What decides the results of its runs.
    pub(crate) fn identities(&self) -> Identities {
        Identities::new(&self.resolved_toml(0))
    }
}

/// Checks every value.
fn check(file: &File) -> Checked {
    name(&file.name)?;
    within("seed", file.seed.unwrap_or(0), [0, GREATEST_SEED])?;
    let Settings {
        robot,
        controllers,
        simulators,
        clock,
        ..
    } = &file.swarm;
    let own = &file.swarm;
    within("swarm.minutes", own.minutes, [1, GREATEST_MINUTES])?;
    within(
        "swarm.light_moves_minute",
        own.light_moves_minute,
        [0, GREATEST_MINUTES],
    )?;
    within("swarm.robot.individuals", robot.individuals, [0, GREATEST_SEED])?;
    within("swarm.controllers.population", controllers.population, [1, 1000])?;
    within(
        "swarm.controllers.parents",
        controllers.parents,
        [1, controllers.population],
    )?;
    within("swarm.controllers.mutation_rate", controllers.mutation_rate, [0.0, 1.0])?;
    within(
        "swarm.controllers.mutation_scale",
        controllers.mutation_scale,
        [0.0, 10.0],
    )?;
    within(
        "swarm.controllers.guests",
        controllers.guests,
        [0, controllers.population],
    )?;
    within(
        "swarm.simulators.mutation_scale",
        simulators.mutation_scale,
        [0.0, 10.0],
    )?;
    within("swarm.simulators.pairs", simulators.pairs, [1, 1000])?;
    within("swarm.clock.interval_s", clock.interval_s, [10, 180])?;
    within("swarm.clock.offset_s", clock.offset_s, [0, clock.interval_s])?;
    within("swarm.clock.installed_s", clock.installed_s, [1, clock.interval_s])?;
    if clock.installed_s < clock.offset_s {
        return invalid(
            "swarm.clock.installed_s",
            format_args!(
                "is {}; allowed: {} to {}, no less than the time in which robots are switched on",
                clock.installed_s, clock.offset_s, clock.interval_s
            ),
        );
    }
    // The rest is for the worlds to say, by names of their own.
    match Worlds::new(&[own.swarm()]) {
        Ok(_) => Ok(()),
        Err(problem) => invalid(&key(&problem.field), problem.problem),
    }
}

/// The key of a world's value, such as `swarm.arena.radius_mm` of `worlds[0].arena_radius`.
fn key(field: &str) -> String {
    const KEYS: [(&str, &str); 24] = [
        ("arena_radius", "arena.radius_mm"),
        ("nest_radius", "arena.nest_radius_mm"),
        ("food_items", "arena.food_items"),
        ("food_radius", "arena.food_radius_mm"),
        ("lamp_behind_wall", "arena.lamp_behind_wall_mm"),
        ("light_decay", "arena.light_decay"),
        ("ambient", "arena.ambient"),
        ("light_noise", "arena.light_noise"),
        ("body_radius", "robot.body_radius_mm"),
        ("wheel_base", "robot.wheel_base_mm"),
        ("greatest_speed", "robot.greatest_speed_mm_s"),
        ("wheel_noise", "robot.wheel_noise"),
        ("cruise", "robot.cruise_mm_s"),
        ("turn", "robot.turn_rad_s"),
        ("phototaxis_gain", "robot.phototaxis_gain"),
        ("phototaxis_turn", "robot.phototaxis_turn_rad_s"),
        ("near", "robot.near_mm"),
        ("escape", "robot.escape_s"),
        ("search_interval", "robot.search_interval_s"),
        ("cycles", "minutes"),
        ("interval", "clock.interval_s"),
        ("range", "messages.range_mm"),
        ("heard", "messages.heard"),
        ("robots", "robots"),
    ];
    let field = field.rsplit("].").next().unwrap_or(field);
    let known = KEYS.iter().find(|(own, _)| *own == field);
    // Those of the differences have their own names.
    format!("swarm.{}", known.map_or(field, |(_, key)| key))
}
