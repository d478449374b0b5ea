//! An experiment with a swarm: a file with a table `swarm`.

use std::path::Path;

use oneiro::swarm::GREATEST_ROBOTS;
use serde::{Deserialize, Serialize};

use super::check::{Checked, GREATEST_SEED, invalid, name, within};
use super::source::Source;
use crate::exit::Result;
use crate::files;
use crate::swarm::Plan;
use crate::swarm::lived::Kind;
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

/// Whether a file is an experiment with a swarm. What is no TOML is none: whoever reads it says why.
///
/// # Errors
/// Exit 3 when there is no such text file.
pub(crate) fn is_swarm(path: &Path) -> Result<bool> {
    let table: std::result::Result<toml::Table, _> = files::text(path)?.parse();
    Ok(table.is_ok_and(|table| table.contains_key("swarm")))
}

impl SwarmExperiment {
    /// Reads an experiment's file, with `key=value` settings that go before what it says.
    ///
    /// # Errors
    /// Exit 3: the file and the line and column in it (or the setting), the key, what it is, and what is allowed.
    pub(crate) fn read(path: &Path, set: &[String]) -> Result<Self> {
        let text = files::text(path)?;
        let (mut file, source): (File, _) = Source::read(&path.display().to_string(), text, set)?;
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

    /// What decides a run's results.
    pub(crate) fn identity(&self, seed: u64) -> blake3::Hash {
        blake3::hash(self.resolved_toml(seed).as_bytes())
    }
}

/// Checks every value.
fn check(file: &File) -> Checked {
    name(&file.name)?;
    within("seed", file.seed.unwrap_or(0), [0, GREATEST_SEED])?;
    let Settings {
        arena,
        robot,
        messages,
        differences,
        controllers,
        simulators,
        clock,
        ..
    } = &file.swarm;
    let own = &file.swarm;
    within("swarm.robots", own.robots, [1, GREATEST_ROBOTS])?;
    within("swarm.minutes", own.minutes, [1, GREATEST_MINUTES])?;
    within(
        "swarm.light_moves_minute",
        own.light_moves_minute,
        [0, GREATEST_MINUTES],
    )?;
    within("swarm.arena.radius_mm", arena.radius_mm, [100.0, 10_000.0])?;
    within(
        "swarm.arena.nest_radius_mm",
        arena.nest_radius_mm,
        [10.0, arena.radius_mm],
    )?;
    within("swarm.arena.food_items", arena.food_items, [0, 8])?;
    within(
        "swarm.arena.food_radius_mm",
        arena.food_radius_mm,
        [1.0, arena.radius_mm],
    )?;
    within(
        "swarm.arena.lamp_behind_wall_mm",
        arena.lamp_behind_wall_mm,
        [10.0, 10_000.0],
    )?;
    within("swarm.arena.light_decay", arena.light_decay, [0.001, 1000.0])?;
    within("swarm.arena.ambient", arena.ambient, [0.0, 1.0])?;
    within("swarm.arena.light_noise", arena.light_noise, [0.0, 1.0])?;
    within(
        "swarm.robot.body_radius_mm",
        robot.body_radius_mm,
        [1.0, 0.5 * arena.radius_mm],
    )?;
    within(
        "swarm.robot.wheel_base_mm",
        robot.wheel_base_mm,
        [1.0, 2.0 * robot.body_radius_mm],
    )?;
    within(
        "swarm.robot.greatest_speed_mm_s",
        robot.greatest_speed_mm_s,
        [1.0, 1000.0],
    )?;
    within("swarm.robot.wheel_noise", robot.wheel_noise, [0.0, 0.5])?;
    within(
        "swarm.robot.cruise_mm_s",
        robot.cruise_mm_s,
        [0.0, robot.greatest_speed_mm_s],
    )?;
    within("swarm.robot.turn_rad_s", robot.turn_rad_s, [0.01, 30.0])?;
    within("swarm.robot.phototaxis_gain", robot.phototaxis_gain, [0.0, 10.0])?;
    within(
        "swarm.robot.phototaxis_turn_rad_s",
        robot.phototaxis_turn_rad_s,
        [0.0, 30.0],
    )?;
    within("swarm.robot.near_mm", robot.near_mm, [0.0, 70.0])?;
    within("swarm.robot.escape_s", robot.escape_s, [0.0, 1000.0])?;
    within("swarm.robot.search_interval_s", robot.search_interval_s, [0.0, 1000.0])?;
    within("swarm.robot.individuals", robot.individuals, [0, GREATEST_SEED])?;
    within("swarm.messages.range_mm", messages.range_mm, [0.0, 10_000.0])?;
    within("swarm.messages.heard", messages.heard, [0.0, 1.0])?;
    for (key, value, most) in [
        ("wheels", differences.wheels, 0.2),
        ("proximity", differences.proximity, 0.2),
        ("light", differences.light, 0.2),
        ("slip", differences.slip, 1.0),
        ("beam", differences.beam, 1.0),
        ("reflection", differences.reflection, 1.0),
        ("shadows", differences.shadows, 1.0),
        ("tracking_loss", differences.tracking_loss, 1.0),
    ] {
        within(&format!("swarm.differences.{key}"), value, [0.0, most])?;
    }
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
    Ok(())
}
