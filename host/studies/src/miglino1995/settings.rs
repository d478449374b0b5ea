//! Settings of the study: the values of its file under an arm, made into worlds, evolutions and realities.

use std::collections::BTreeMap;
use std::sync::Arc;

use oneiro::parameter::{Choice, Invalid};
use oneiro::surrogate::{Difference, Differences, Individual, Surrogate};
use oneiro::tables::{MotorStates, SensorTables};
use oneiro::world::{Noise, Robot, Start, Task, World, WorldSpec};
use oneiro_base::exit::{Failure, Result};
use oneiro_evolve as evolve;
use oneiro_lab::experiment::source::{Parsed, Setting, Source};
use oneiro_lab::experiment::values::Described;
use oneiro_lab::experiment::{self, Experiment, Files, settings};
use oneiro_lab::reality::site::Site;
use oneiro_robots::address::{Address, Wire};
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use super::interpolation::interpolate;
use super::results::{Condition, Family};
use super::study::SHARED_START;
use crate::assumptions::Assumption;
use crate::file::{self, Arm, Earlier, Edition, StudyFile};

/// Values from the command line.
#[derive(Clone, Debug)]
pub struct Asked {
    /// Seed of everything random except the robot.
    pub seed: u64,
    /// Runs of each condition; `None` takes the file's number.
    pub runs: Option<u32>,
    /// The robot: the seed of a surrogate and its surroundings, or where it is on a wire.
    pub robot: Address,
    /// How much reality differs from its simulator; `None` takes the file's value.
    pub severity: Option<f32>,
    /// Whether to add controls and other simulators.
    pub full: bool,
    /// Hashes of the files with the simulator's tables; empty if the tables are sampled from the surrogate.
    pub tables: Vec<String>,
}

/// The study's file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    experiment: Option<String>,
    runs: u32,
    #[serde(default)]
    set: Table,
    #[serde(default)]
    conditions: Conditions,
    samples: Samples,
    selection: Selection,
    champion: Champion,
    reality: RealitySettings,
    calibration: Calibration,
    #[serde(default)]
    variants: Vec<Variants>,
    #[serde(default)]
    sources: BTreeMap<String, String>,
    #[serde(default)]
    editions: BTreeMap<String, Earlier>,
    /// Read before the rest.
    #[serde(default, rename = "arms")]
    _arms: IgnoredAny,
}

/// Values of the conditions' experiments.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Conditions {
    none: Table,
    sensor: Table,
    conservative: Table,
}

impl Conditions {
    fn of(&self, condition: Condition) -> &Table {
        match condition {
            Condition::None => &self.none,
            Condition::Sensor => &self.sensor,
            Condition::Conservative => &self.conservative,
        }
    }
}

/// How the robot is sampled.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Samples {
    /// Turns in front of an object that are averaged into a row of its table.
    pub turns: u32,
    /// Whether simulators interpolate between samples.
    pub(crate) interpolated: bool,
}

/// Criteria of selection in simulation, besides fitness.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Selection {
    /// Value of each newly visited 50 mm cell. It counts only in selection and not in fitness, since a real robot
    /// doesn't know where it is.
    pub new_cell: f32,
}

/// Choice of champions.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Champion {
    /// Number of simulated episodes whose mean decides which individual of the transferred generation is champion. 1:
    /// the episode that compares simulation and reality.
    pub lives: u32,
}

/// The reality that controllers are transferred to.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RealitySettings {
    /// Generations selected by real fitness.
    pub generations: u32,
    /// How much reality differs from its simulator.
    severity: f32,
    /// How much it differs in motion and latency, if otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    motion_severity: Option<f32>,
    #[serde(skip_serializing)]
    severity_factor: f32,
    #[serde(skip_serializing)]
    robot_offset: u64,
    /// Age of readings in ms, at severity 1.
    latency_ms: f32,
    /// The only active difference; `without` names the only inactive one.
    #[serde(skip_serializing_if = "Option::is_none")]
    only: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    without: Option<String>,
    /// Starts of real episodes.
    pub starts: RealStarts,
    /// Values of a connected robot: those of an experiment's `[reality]` except its address and its generations.
    #[serde(default, skip_serializing)]
    wire: Table,
}

/// How the robot gets to the start of an episode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RealStarts {
    /// Placed at a fresh free pose.
    Fresh,
    /// Stays where the last episode of the same run stopped.
    Continuing,
    /// Drives about for a while from there; the episode starts where it ends up.
    Walk,
}

/// Values for calibrating the severity.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    pub runs: u32,
    pub robots: Vec<u64>,
    pub severities: Vec<f32>,
}

/// Other simulators of one family.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Variants {
    family: Family,
    simulators: Vec<OtherSimulator>,
}

#[derive(Deserialize)]
struct OtherSimulator {
    name: String,
    #[serde(default)]
    value: f32,
    #[serde(default = "without_noise")]
    condition: Condition,
    #[serde(default)]
    samples: Tables,
    #[serde(flatten)]
    set: Table,
}

fn without_noise() -> Condition {
    Condition::None
}

/// Source of another simulator's tables.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Tables {
    /// The robot's own samples.
    #[default]
    Own,
    /// Samples of another robot in the same surroundings.
    Another,
    /// The means of both.
    Average,
    /// Built-in tables instead of samples.
    BuiltIn,
}

/// Another simulator.
#[derive(Clone, Debug)]
pub struct Simulator {
    pub family: Family,
    /// The difference from the study's simulator.
    pub name: String,
    /// Value of that difference if it is a number.
    pub value: f64,
    pub tables: Tables,
    /// World of the simulator, apart from its tables.
    pub world: WorldSpec,
}

/// The robot of a study.
#[derive(Debug)]
enum Real {
    /// A surrogate, by its seed.
    Surrogate(u64),
    /// A connected robot, by the experiment whose last generations run on it.
    Connected(Box<Experiment>),
}

/// A whole study. Studies with equal settings have equal reports, except for what a connected robot does.
#[derive(Debug)]
pub struct Settings {
    /// Values from the command line.
    asked: Asked,
    pub(crate) edition: Edition,
    arm: Arm,
    /// Hash of a user's study file.
    file: Option<String>,
    pub runs: u32,
    /// How much reality differs from its simulator, before the arm's factor.
    severity: f32,
    pub samples: Samples,
    pub selection: Selection,
    pub champion: Champion,
    pub reality: RealitySettings,
    pub calibration: Calibration,
    /// Other simulators, if requested.
    pub variants: Vec<Simulator>,
    /// Experiments of the conditions.
    experiments: [Experiment; 3],
    robot: Real,
    differences: Differences,
    sources: BTreeMap<String, String>,
}

/// Whether the study uses a key of its conditions' experiments. Its robot is a Khepera, sampled anew; its individuals have one
/// episode in each generation; its champions are chosen by `champion.lives`.
fn is_used(key: &str) -> bool {
    const ALONE: [&str; 5] = [
        "cycles",
        "robot.states",
        "robot.collision",
        "evolution.kind",
        "evolution.common_random_numbers",
    ];
    const TABLES: [&str; 5] = ["arena.", "noise.", "task.", "start.", "evolution."];
    const BUT: [&str; 4] = [
        "evolution.finalists",
        "evolution.finalist_lives",
        "evolution.init",
        "task.part",
    ];
    ALONE.contains(&key) || TABLES.iter().any(|table| key.starts_with(table)) && !BUT.contains(&key)
}

/// Whether a value is in force that the study does not let change: those of a Khepera, and what is one.
fn is_fixed(key: &str) -> bool {
    key == "trials" || key == "controller.kind" || key.starts_with("robot.")
}

/// Checks that evolutions are by the genetic algorithm with different random numbers for each episode: the study breeds
/// its generations itself.
fn only_the_papers(experiment: &settings::Settings, source: &Source<'_>) -> Result {
    let evolution = &experiment.evolution;
    if evolution.kind != evolve::settings::Kind::Genetic {
        let problem = format!("has evolution.kind = {:?}; allowed: genetic", evolution.kind.word());
        return Err(source.invalid("experiment", problem));
    }
    if evolution.has_common_numbers() {
        let problem = "has evolution.common_random_numbers = true; allowed: false";
        return Err(source.invalid("experiment", problem));
    }
    Ok(())
}

impl Settings {
    /// Reads the study's settings under an arm.
    ///
    /// # Errors
    /// Exit 2 for an unknown arm. Exit 3: the file, line and column (or the arm), the key, the value found and the
    /// values allowed; an arm that changes a surrogate, for a connected robot.
    pub fn new(file: &StudyFile, arm: &str, asked: Asked) -> Result<Self> {
        let arm = file.arm(arm)?;
        if let Address::Wire(wire) = &asked.robot {
            concerns(&arm, wire)?;
        }
        file.under(&arm, |mut values: File, source| {
            check(&values, source)?;
            let reality = &mut values.reality;
            let severity = asked.severity.unwrap_or(reality.severity);
            let motion = reality.motion_severity.filter(|_| asked.severity.is_none());
            let motion = reality.severity_factor * motion.unwrap_or(severity);
            reality.severity = reality.severity_factor * severity;
            reality.motion_severity = (motion != reality.severity).then_some(motion);
            let differences = differences(&values.reality, source)?;
            let (path, text) = file.experiment(values.experiment.as_deref())?;
            let base = Parsed::new(path.display().to_string(), &text)?;
            let files = Files::default();
            let experiment = |condition: Condition, more: Vec<Setting>, is_used: &dyn Fn(&str) -> bool| {
                let mut set = file::settings("set", &values.set, source);
                let key = format!("conditions.{}", condition.name());
                let of_condition = file::settings(&key, values.conditions.of(condition), source).into_iter();
                set.extend(of_condition.map(|setting| setting.ranked(2)));
                set.extend(more.into_iter().map(|setting| setting.ranked(3)));
                Experiment::partly(&path, &base, &set, &files, ("the study", is_used))
            };
            let mut variants = Vec::new();
            for (place, family) in values.variants.iter().enumerate().filter(|_| asked.full) {
                for (index, simulator) in family.simulators.iter().enumerate() {
                    let under = format!("variants[{place}].simulators[{index}]");
                    of_simulator(&under, &simulator.set, source)?;
                    let experiment = experiment(
                        simulator.condition,
                        file::settings(&under, &simulator.set, source),
                        &is_used,
                    )?;
                    variants.push(Simulator {
                        family: family.family,
                        name: simulator.name.clone(),
                        value: f64::from(simulator.value),
                        tables: simulator.samples,
                        world: experiment.world().spec().clone(),
                    });
                }
            }
            let [none, sensor, conservative] =
                Condition::ALL.map(|condition| experiment(condition, Vec::new(), &is_used));
            let none = none?;
            only_the_papers(none.settings(), source)?;
            let robot = match &asked.robot {
                Address::Surrogate(seed) => Real::Surrogate(seed.wrapping_add(values.reality.robot_offset)),
                Address::Wire(wire) => {
                    let simulated = none.settings().evolution.generations;
                    let more = of_connected(wire, simulated, &values.reality, source)?;
                    let is_used = |key: &str| is_used(key) || key.starts_with("reality.");
                    Real::Connected(Box::new(experiment(Condition::None, more, &is_used)?))
                }
            };
            if let Some(earlier) = values.editions.remove(file.edition().word()) {
                values.sources.extend(earlier.sources);
            }
            let settings = Self {
                file: file.own_hash(),
                edition: file.edition(),
                runs: asked.runs.unwrap_or(values.runs),
                severity,
                asked,
                arm: arm.clone(),
                samples: values.samples,
                selection: values.selection,
                champion: values.champion,
                reality: values.reality,
                calibration: values.calibration,
                variants,
                experiments: [none, sensor?, conservative?],
                robot,
                differences,
                sources: values.sources,
            };
            settings.check_worlds(source)?;
            Ok(settings)
        })
    }

    /// Checks the worlds made only after the robot has been sampled.
    fn check_worlds(&self, source: &Source<'_>) -> Result {
        let place = |Invalid { field, problem }: Invalid| {
            let key = match &*field {
                "surrogate.severity" => "reality.severity".to_owned(),
                "surrogate.latency_ms" => "reality.latency_ms".to_owned(),
                "task.new_cell" => "selection.new_cell".to_owned(),
                "start" => "the start of the champions".to_owned(),
                _ => format!("set.{field}"),
            };
            source.invalid(&key, problem)
        };
        let [x, y, heading] = SHARED_START;
        let simulated = WorldSpec {
            start: Start::At { x, y, heading },
            ..self.world()
        };
        let selecting = WorldSpec {
            task: simulated.task.with_new_cell(self.selection.new_cell),
            ..simulated.clone()
        };
        let real = WorldSpec {
            surrogate: self.surrogate().map(|(_, surrogate)| Arc::new(surrogate)),
            robot: Robot::khepera(),
            ..simulated
        };
        for spec in [selecting, real] {
            World::new(spec).map_err(place)?;
        }
        Ok(())
    }

    /// Record of the settings for the study's directory.
    pub fn record(&self) -> String {
        #[derive(Serialize)]
        struct Record {
            seed: u64,
            runs: u32,
            robot: serde_json::Value,
            #[serde(skip_serializing_if = "Option::is_none")]
            severity: Option<f32>,
            arm: String,
            #[serde(skip_serializing_if = "Option::is_none")]
            edition: Option<&'static str>,
            full: bool,
            tables: Vec<String>,
            #[serde(skip_serializing_if = "Option::is_none")]
            study: Option<String>,
        }
        let (robot, severity) = match &self.asked.robot {
            Address::Surrogate(seed) => ((*seed).into(), Some(self.severity)),
            Address::Wire(wire) => (wire.to_string().into(), None),
        };
        let record = Record {
            seed: self.asked.seed,
            runs: self.runs,
            robot,
            severity,
            arm: self.arm.name.clone(),
            // Studies from before there was a choice keep their identity.
            edition: (self.edition != Edition::First).then(|| self.edition.word()),
            full: self.asked.full,
            tables: self.asked.tables.clone(),
            study: self.file.clone(),
        };
        serde_json::to_string_pretty(&record).expect("numbers and words are JSON")
    }

    pub fn seed(&self) -> u64 {
        self.asked.seed
    }

    /// Whether it is a study of one of the second edition's surrogates, with nothing changed.
    pub(crate) fn is_calibrated_main(&self) -> bool {
        let asked = &self.asked;
        let has_own_values = self.file.is_some() || asked.severity.is_some() || !asked.tables.is_empty();
        self.edition == Edition::Second && self.arm.is_main() && !has_own_values && !self.is_wired()
    }

    /// Whether to add controls and other simulators.
    pub fn is_full(&self) -> bool {
        self.asked.full
    }

    fn experiment(&self, condition: Condition) -> &Experiment {
        &self.experiments[condition as usize]
    }

    /// Noise of a condition's simulator.
    pub fn noise(&self, condition: Condition) -> Noise {
        self.experiment(condition).world().spec().noise
    }

    /// Generations selected by simulated fitness.
    pub(crate) fn simulated_generations(&self) -> u32 {
        self.experiment(Condition::None).settings().evolution.generations
    }

    /// Settings of the genetic algorithm, over all generations.
    pub fn evolution(&self) -> evolve::settings::Settings {
        evolve::settings::Settings {
            generations: self.simulated_generations() + self.reality.generations,
            ..self.experiment(Condition::None).settings().evolution.clone()
        }
    }

    /// Arena, task and the effect of collisions; the rest of the robot, and noise, are set elsewhere.
    pub fn world(&self) -> WorldSpec {
        let spec = self.experiment(Condition::None).world().spec();
        WorldSpec {
            robot: Robot {
                collision: spec.robot.collision,
                ..Robot::khepera()
            },
            noise: Noise::NONE,
            ..spec.clone()
        }
    }

    /// States of the motors.
    pub fn states(&self) -> MotorStates {
        self.experiment(Condition::None).settings().robot.states
    }

    /// Tables that a simulator looks up instead of a robot's samples.
    pub(crate) fn looked_up(&self, sensors: &Arc<SensorTables>) -> Arc<SensorTables> {
        if self.samples.interpolated {
            Arc::new(interpolate(sensors))
        } else {
            Arc::clone(sensors)
        }
    }

    /// Whether the robot is on a wire.
    pub fn is_wired(&self) -> bool {
        matches!(self.robot, Real::Connected(_))
    }

    /// The sampled surrogate that stands in for reality, and its seed; none if the robot is connected.
    pub fn surrogate(&self) -> Option<(u64, Surrogate)> {
        match self.robot {
            Real::Surrogate(seed) => Some((seed, Surrogate::drawn(seed, self.differences))),
            Real::Connected(_) => None,
        }
    }

    /// The site of reality.
    pub fn site(&self) -> Site {
        match &self.robot {
            Real::Surrogate(seed) => Site::surrogate(*seed, Surrogate::drawn(*seed, self.differences)),
            Real::Connected(experiment) => experiment.site().expect("it was made with a robot"),
        }
    }

    /// The site with another robot of the same kind in the same surroundings, if reality is a simulation.
    pub(crate) fn other_site(&self) -> Option<Site> {
        let (seed, surrogate) = self.surrogate()?;
        let surrogate = Surrogate {
            individual: Individual::drawn(seed.wrapping_add(1)),
            ..surrogate
        };
        Some(Site::surrogate(seed, surrogate))
    }

    /// How real episodes of a run follow one another. A connected robot drives to its starts, or a person takes it
    /// there.
    pub fn starts(&self) -> RealStarts {
        match self.robot {
            Real::Surrogate(_) => self.reality.starts,
            Real::Connected(_) => RealStarts::Fresh,
        }
    }

    /// The longest time that `runs` runs of each condition can take on a connected robot, in words. The transferred
    /// generation runs twice, the others once, and each run's champion once more.
    pub fn time(&self, runs: u32) -> Option<String> {
        let runs = u64::from(runs) * Condition::ALL.len() as u64;
        let generations = u64::from(self.reality.generations) + 1;
        let episodes = runs * (generations * u64::from(self.evolution().population) + 1);
        let time = self.site().time(episodes, self.world().cycles).filter(|_| runs > 0)?;
        Some(format!(
            "{time}; for {runs} of them, those of the champions, somebody has to put the robot at the start"
        ))
    }

    /// Hash of a sampled surrogate's parameters, its surroundings and its reality's differences.
    fn parameters_hash(surrogate: &Surrogate) -> String {
        let text = format!("{surrogate:?}");
        blake3::hash(text.as_bytes()).to_hex()[..16].to_owned()
    }

    /// Description of the robot and of its simulator's tables.
    pub fn describe(&self) -> String {
        let tables = self.asked.tables.join(", ");
        let Some((seed, surrogate)) = self.surrogate() else {
            let robot = &self.asked.robot;
            return format!("{robot}, connected; its simulator is made from its samples ({tables})");
        };
        let motion = self.reality.motion_severity;
        let motion = motion.map_or_else(String::new, |motion| format!(" (of motion {motion})"));
        let reality = format!(
            "surrogate:{seed}, severity {}{motion}, parameters {}",
            self.reality.severity,
            Self::parameters_hash(&surrogate)
        );
        if tables.is_empty() {
            format!("{reality}; its simulator is made from its samples")
        } else {
            format!(
                "{reality}; the simulator is made from recordings of another robot ({tables}), to which the surrogate \
                 is not fitted"
            )
        }
    }

    /// Seed of a run.
    pub(crate) fn run_seed(&self, condition: Condition, number: u32) -> u64 {
        let index = self.seed().wrapping_mul(1 << 20).wrapping_add(u64::from(number));
        // The second edition compares conditions within a run number, whose seed they share.
        let condition = match self.edition {
            Edition::First => condition as u64,
            Edition::Second => 0,
        };
        index.wrapping_mul(4).wrapping_add(condition)
    }

    /// The two assumptions that decide most: the collision rule, and the simulator's form of equation 1.
    fn choices(&self) -> Vec<(String, String)> {
        fn chosen<C: Choice + PartialEq>(choice: &C) -> String {
            let known = C::CHOICES.iter().find(|(_, other, _)| other == choice);
            known.map_or_else(String::new, |(word, _, about)| format!("{word}: {about}"))
        }
        let spec = self.experiment(Condition::None).world().spec();
        let mut rows = vec![("robot.collision", chosen(&spec.robot.collision))];
        rows.push((
            "collision.fitness",
            "0: a cycle that ends in a collision earns nothing".to_owned(),
        ));
        if let Task::Avoidance { speed, difference, .. } = &spec.task {
            rows.extend([("task.difference", chosen(difference)), ("task.speed", chosen(speed))]);
        }
        rows.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
    }

    /// All values in force, for the report.
    pub(crate) fn assumptions(&self) -> Vec<Assumption> {
        let resolved = |condition| {
            let mut listed = file::listed(&self.experiment(condition).resolved_toml(0));
            listed.retain(|key, _| is_used(key) || is_fixed(key));
            listed
        };
        let of_all = resolved(Condition::None);
        let made_from = if self.asked.tables.is_empty() {
            "the robot's samples".to_owned()
        } else {
            format!("recordings {}", self.asked.tables.join(", "))
        };
        // The first edition's list is unchanged.
        let mut rows = match self.edition {
            Edition::First => Vec::new(),
            Edition::Second => self.choices(),
        };
        let is_first: Vec<String> = rows.iter().map(|(key, _)| key.clone()).collect();
        rows.push(("runs".to_owned(), format!("{} of each condition", self.runs)));
        rows.extend(
            of_all
                .iter()
                .filter(|(key, _)| !is_first.contains(key))
                .map(|(key, value)| {
                    let is_sampled = ["robot.tables", "robot.motors"].contains(&key.as_str());
                    (key.clone(), if is_sampled { &made_from } else { value }.clone())
                }),
        );
        for condition in [Condition::Sensor, Condition::Conservative] {
            let of_condition = resolved(condition).into_iter();
            let of_condition = of_condition.filter(|(key, value)| of_all.get(key) != Some(value));
            rows.extend(of_condition.map(|(key, value)| (format!("conditions.{}.{key}", condition.name()), value)));
        }
        let table = |values: Value| values.as_table().map(file::leaves).unwrap_or_default();
        let parts = [
            ("samples", Value::try_from(&self.samples)),
            ("selection", Value::try_from(&self.selection)),
            ("champion", Value::try_from(&self.champion)),
            ("reality", self.real_values()),
        ];
        for (name, values) in parts {
            let values = table(values.expect("values of a study are numbers and words"));
            rows.extend(
                values
                    .into_iter()
                    .map(|(key, value)| (format!("{name}.{key}"), file::words(&value))),
            );
        }
        rows.extend(self.surrogate().map(|(seed, surrogate)| {
            let parameters = Self::parameters_hash(&surrogate);
            let robot = format!("surrogate robot {seed}, parameters {parameters}");
            ("reality.robot".to_owned(), robot)
        }));
        let of_row = |key: &str| {
            let described = settings::Settings::rows();
            described.iter().find(|row| row.key == key).map(|row| row.source)
        };
        let source = |key: &str| match key {
            "reality.robot" if self.is_wired() => Some("--robot"),
            key => self.sources.get(key).map(String::as_str).or_else(|| of_row(key)),
        };
        self.arm.assumptions(rows, source)
    }

    /// Values of reality: the study's, or those of a connected robot's experiment.
    fn real_values(&self) -> std::result::Result<Value, toml::ser::Error> {
        match &self.robot {
            Real::Surrogate(_) => Value::try_from(&self.reality),
            Real::Connected(experiment) => Ok(experiment.values().remove("reality").unwrap_or(Table::new().into())),
        }
    }
}

/// Refuses an arm that changes what a connected robot does not have.
fn concerns(arm: &Arm, wire: &Wire) -> Result {
    let is_of_surrogate = |key: &String| {
        let of_wire = key == "reality.generations" || key.starts_with("reality.wire.");
        key == "samples.turns" || key.starts_with("reality.") && !of_wire
    };
    match arm.changed_keys().into_iter().find(is_of_surrogate) {
        Some(key) => Err(Failure::input(format_args!(
            "--arm {}: changes {key}, which is given with --robot {wire}; allowed: with a surrogate",
            arm.name
        ))),
        None => Ok(()),
    }
}

/// Settings of an experiment whose last generations run on a connected robot, after the simulated ones.
fn of_connected(wire: &Wire, simulated: u32, reality: &RealitySettings, source: &Source<'_>) -> Result<Vec<Setting>> {
    for (key, allowed) in [("robot", "--robot"), ("generations", "reality.generations")] {
        if reality.wire.contains_key(key) {
            let problem = format!("is given; allowed: {allowed} instead");
            return Err(source.invalid_key(&format!("reality.wire.{key}"), problem));
        }
    }
    let of_wire = file::leaves(&reality.wire).into_iter().map(|(key, value)| {
        let place = source.place_of(&format!("reality.wire.{key}"));
        Setting::at(place, &format!("reality.{key}"), &value)
    });
    let generations = source.place_of("reality.generations");
    let all = u64::from(simulated) + u64::from(reality.generations);
    let of_study = [
        ("--robot".to_owned(), "reality.robot", Value::from(wire.to_string())),
        (generations.clone(), "evolution.generations", (all as i64).into()),
        (
            generations,
            "reality.generations",
            i64::from(reality.generations).into(),
        ),
    ];
    let of_study = of_study.map(|(place, key, value)| Setting::at(place, key, &value));
    Ok(of_wire.chain(of_study).collect())
}

/// Checks that a variant changes only its simulator: its runs have the evolution of the condition without noise.
fn of_simulator(under: &str, set: &Table, source: &Source<'_>) -> Result {
    const TABLES: [&str; 4] = ["noise.", "arena.", "task.", "start."];
    for (key, _) in file::leaves(set) {
        if key != "cycles" && !TABLES.iter().any(|table| key.starts_with(table)) {
            let problem = "does not belong to a simulator; allowed: noise.*, arena.*, task.*, start.*, cycles. Other keys go \
                 under [set]";
            return Err(source.invalid_key(&format!("{under}.{key}"), problem));
        }
    }
    Ok(())
}

fn check(values: &File, source: &Source<'_>) -> Result {
    let severity = |key: &str, severity: f32| match experiment::allows("reality.severity", &severity) {
        (true, _) => Ok(()),
        (false, allowed) => Err(source.invalid(key, format_args!("is {severity}; allowed: {allowed}"))),
    };
    severity("reality.severity", values.reality.severity)?;
    if let Some(motion) = values.reality.motion_severity {
        severity("reality.motion_severity", motion)?;
    }
    let Calibration {
        runs,
        robots,
        severities,
    } = &values.calibration;
    source.within("calibration.runs", *runs, &(1..=1000))?;
    for (key, is_empty) in [
        ("calibration.robots", robots.is_empty()),
        ("calibration.severities", severities.is_empty()),
    ] {
        if is_empty {
            return Err(source.invalid(key, "is empty; allowed: at least one number"));
        }
    }
    for (index, pair) in severities.iter().enumerate() {
        severity(&format!("calibration.severities[{index}]"), *pair)?;
    }
    // The study has its arena, its task and its evolution from what all conditions share.
    for condition in Condition::ALL {
        for (key, _) in file::leaves(values.conditions.of(condition)) {
            if !key.starts_with("noise.") {
                let key = format!("conditions.{}.{key}", condition.name());
                return Err(source.invalid_key(
                    &key,
                    "does not belong to the noise; allowed: noise.*. Other keys go under [set]",
                ));
            }
        }
    }
    source.within("samples.turns", values.samples.turns, &(1..=100))?;
    source.within("champion.lives", values.champion.lives, &(1..=10_000))?;
    source.within("reality.generations", values.reality.generations, &(1..=10_000))
}

/// Differences between reality and its simulator.
fn differences(reality: &RealitySettings, source: &Source<'_>) -> Result<Differences> {
    let named = |key: &str, name: &str| {
        let names = Difference::ALL.map(Difference::name);
        let known = Difference::ALL.into_iter().find(|difference| difference.name() == name);
        known.ok_or_else(|| source.invalid(key, format_args!("is \"{name}\"; allowed: {}", names.join(", "))))
    };
    let motion = reality.motion_severity.unwrap_or(reality.severity);
    let differences = match (&reality.only, &reality.without) {
        (None, None) => Differences::all(reality.severity).with_motion(motion),
        (Some(only), None) => {
            let only = named("reality.only", only)?;
            let severity = if only.is_of_motion() { motion } else { reality.severity };
            Differences::only(severity, only)
        }
        (None, Some(without)) => {
            let without = named("reality.without", without)?;
            Differences::without(reality.severity, without).with_motion(motion)
        }
        (Some(_), Some(_)) => {
            return Err(source.invalid(
                "reality.without",
                "is set together with reality.only; allowed: one of them",
            ));
        }
    };
    Ok(differences.with_latency(reality.latency_ms))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::MIGLINO1995;
    use crate::scratch::Scratch;
    use oneiro_lab::experiment::tried::{names_a_key, others};
    use oneiro_lab::experiment::values;
    use oneiro_lab::reality::site::SEVERITY;

    /// The first edition, which has the arms.
    fn shipped() -> StudyFile {
        StudyFile::open(&MIGLINO1995, None)
            .unwrap()
            .in_edition(Edition::First)
            .unwrap()
    }

    fn under(arm: &str) -> Settings {
        let asked = Asked {
            seed: 1,
            runs: None,
            robot: Address::Surrogate(3),
            severity: None,
            full: true,
            tables: Vec::new(),
        };
        Settings::new(&shipped(), arm, asked).unwrap()
    }

    fn assumption(settings: &Settings, name: &str) -> Assumption {
        let all = settings.assumptions();
        all.into_iter()
            .find(|assumption| assumption.name == name)
            .unwrap_or_else(|| panic!("{name}"))
    }

    /// The default is the second edition, at the severities of its calibration; the first is unchanged.
    #[test]
    fn editions_have_their_values() {
        let asked = Asked {
            severity: None,
            ..under("main").asked
        };
        let second = |severity| {
            let file = StudyFile::open(&MIGLINO1995, None).unwrap();
            Settings::new(
                &file,
                Arm::MAIN,
                Asked {
                    severity,
                    ..asked.clone()
                },
            )
            .unwrap()
        };
        let main = second(None);
        assert_eq!(main.differences, Differences::all(1.0).with_motion(0.5));
        assert_eq!(main.world().robot.collision.word(), "slide");
        assert!(
            main.describe().contains("severity 1 (of motion 0.5), "),
            "{}",
            main.describe()
        );
        assert!(main.record().contains("\"edition\": \"second\""));
        assert_eq!(assumption(&main, "reality.motion_severity").value, "0.5");
        let seeds = |settings: &Settings| Condition::ALL.map(|condition| settings.run_seed(condition, 2));
        assert_eq!(seeds(&main), [seeds(&under("main"))[0]; 3]);
        assert!(main.is_calibrated_main() && !second(Some(1.0)).is_calibrated_main());
        // One number is for all differences.
        assert_eq!(second(Some(1.5)).differences, Differences::all(1.5));
        let first = under("main");
        assert!(!first.is_calibrated_main() && first.world().robot.collision.word() == "undo");
        assert!(
            !first.record().contains("edition"),
            "studies from before keep their identity"
        );
        assert!(
            first
                .assumptions()
                .iter()
                .all(|row| row.name != "reality.motion_severity" && row.name != "robot.collision")
        );
    }

    #[test]
    fn the_first_edition_is_the_papers() {
        let main = under("main");
        assert_eq!(
            (main.runs, main.simulated_generations(), main.reality.generations),
            (5, 200, 20)
        );
        assert_eq!(main.reality.severity.to_bits(), SEVERITY.to_bits());
        assert_eq!(
            Condition::ALL.map(|condition| main.noise(condition)),
            [Noise::NONE, Noise::SENSOR, Noise::CONSERVATIVE]
        );
        assert_eq!(main.differences, Differences::all(SEVERITY));
        assert_eq!(main.variants.len(), 18);
    }

    #[test]
    fn values_changed_by_an_arm_are_reported() {
        let [main, square] = ["main", "square"].map(|arm| assumption(&under(arm), "task.difference"));
        assert_eq!(main.value, "root");
        assert_eq!(square.value, "square");
        assert_eq!(square.source, "arm square: The square of DV, as the paper prints it");
        let half = assumption(&under("half-severity"), "reality.severity");
        assert_eq!(half.value, "0.875");
        let step = assumption(&under("walk-step-small"), "conditions.conservative.noise.walk_step_mm");
        assert_eq!(step.value, "0.3");
        assert!(
            under("wide-genes")
                .assumptions()
                .iter()
                .any(|assumption| assumption.name == "evolution.limits")
        );
    }

    /// A connected robot has the values of an experiment whose last generations run on it, and none of a surrogate's.
    #[test]
    fn a_connected_robot_is_an_experiments() {
        let asked = Asked {
            robot: "serial:/dev/ttyS0@9600".parse().unwrap(),
            tables: vec!["own".into()],
            full: false,
            ..under("main").asked
        };
        let settings = Settings::new(&shipped(), "square", asked).unwrap();
        let Real::Connected(experiment) = &settings.robot else {
            panic!("is simulated")
        };
        assert_eq!(experiment.first_real(), Some(200));
        // 2,000 episodes of 60 s.
        assert_eq!(experiment.robot_time().unwrap().robot_minutes, 2000.0);
        assert_eq!(settings.evolution(), experiment.settings().evolution);
        assert!(settings.site().is_wired() && settings.surrogate().is_none() && settings.other_site().is_none());
        let assumptions = settings.assumptions();
        let of_reality: Vec<_> = assumptions
            .iter()
            .filter(|assumption| assumption.name.starts_with("reality."))
            .collect();
        let values: Vec<_> = of_reality
            .iter()
            .map(|assumption| (&*assumption.name, &*assumption.value, &*assumption.source))
            .collect();
        let generations = settings.sources["reality.generations"].as_str();
        let expected = [
            ("reality.robot", "serial:/dev/ttyS0@9600", "--robot"),
            ("reality.generations", "20", generations),
            ("reality.starts", "walk", "ours"),
            ("reality.walk_s", "10", "ours"),
        ];
        assert_eq!(values, expected);
        let record = settings.record();
        assert!(record.contains("\"robot\": \"serial:/dev/ttyS0@9600\"") && !record.contains("severity"));
        // Three runs of 2,100 episodes and a champion.
        let time = settings.time(1).unwrap();
        assert!(
            time.starts_with("6303 episodes of 50 s, each after 10 s of driving about: 105.0 robot-hours"),
            "{time}"
        );
        assert_eq!(settings.time(0), None);
    }

    /// The source of a value that doesn't exist would never be read.
    #[test]
    fn every_source_is_that_of_a_value() {
        let asked = Asked {
            severity: None,
            ..under("main").asked
        };
        let main = Settings::new(&StudyFile::open(&MIGLINO1995, None).unwrap(), Arm::MAIN, asked).unwrap();
        for key in main.sources.keys() {
            assert!(!assumption(&main, key).source.is_empty(), "{key}");
        }
    }

    #[test]
    fn a_difference_is_alone_or_the_only_one_that_is_missing() {
        for difference in Difference::ALL {
            let name = difference.name().replace('_', "-");
            let [only, without] = ["only", "without"].map(|which| under(&format!("{which}-{name}")).differences);
            for other in Difference::ALL {
                let expected = if other == difference { [1.75, 0.0] } else { [0.0, 1.75] };
                assert_eq!(
                    [only, without].map(|differences| differences.strength(other)),
                    expected,
                    "{name}"
                );
            }
        }
    }

    /// Another robot's tables and noise reach the simulators that `--full` adds.
    #[test]
    fn displacements_are_of_one_size_and_differ_in_how_they_change() {
        let all = under("main").variants;
        let displaced: Vec<_> = all
            .iter()
            .filter(|simulator| simulator.family == Family::Displacement)
            .collect();
        let noises: Vec<_> = displaced.iter().map(|simulator| simulator.world.noise).collect();
        assert_eq!(
            noises.iter().map(|noise| noise.walk_step).collect::<Vec<_>>(),
            [0.0, 1.5, 60.0]
        );
        for noise in &noises {
            assert_eq!((noise.walk_range, noise.sensor, noise.motor), (30.0, (0.0, 0.0), 0.0));
        }
        let made_from: Vec<Tables> = all.iter().skip(13).map(|simulator| simulator.tables).collect();
        assert_eq!(
            made_from,
            [
                Tables::Own,
                Tables::Another,
                Tables::Average,
                Tables::BuiltIn,
                Tables::Own
            ]
        );
        // The range is the variant's; the step is the arm's.
        let small = under("walk-step-small").variants;
        let walk = small
            .iter()
            .find(|simulator| simulator.family == Family::WalkRange)
            .unwrap()
            .world
            .noise;
        assert_eq!((walk.walk_range, walk.walk_step), (7.5, 0.3));
    }

    /// A changed value of a key changes what the study takes from its experiment, or the key is refused by name. With `ONEIRO_LONG` all
    /// values in all tables.
    #[test]
    fn each_key_of_an_experiment_is_used_or_refused() {
        let is_long = std::env::var_os("ONEIRO_LONG").is_some();
        let values_of_a_key = if is_long { usize::MAX } else { 2 };
        let shipped = MIGLINO1995
            .text
            .replace("experiment = \"../khepera-avoidance.toml\"", "");
        let scratch = Scratch::new("keys-of-1995");
        let read = |table: &str, line: &str| {
            assert!(shipped.contains(table), "{table}");
            let path = scratch.write("own.toml", shipped.replacen(table, &format!("{table}\n{line}"), 1));
            let file = StudyFile::open(&MIGLINO1995, Some(&path))?;
            let asked = Asked {
                full: false,
                ..under("main").asked
            };
            Settings::new(&file, Arm::MAIN, asked)
        };
        let taken = |settings: &Settings| {
            let noise = Condition::ALL.map(|condition| settings.noise(condition));
            format!(
                "{:?}",
                (settings.world(), noise, settings.evolution(), settings.states())
            )
        };
        let before = read("[set]", "").unwrap();
        let values = before.experiment(Condition::None).values();
        let before = taken(&before);
        let (mut used, mut refused) = (0, 0);
        let rows = settings::Settings::rows().iter().filter(|row| !row.key.contains("[]"));
        for (number, row) in rows.enumerate() {
            let key = row.key;
            let last = key.rsplit('.').next().unwrap_or(key);
            let mut has_effect = false;
            for value in others(row, values::at(&values, key)).into_iter().take(values_of_a_key) {
                let line = format!("{key} = {value}");
                match read("[set]", &line) {
                    Ok(changed_settings) => {
                        let after = taken(&changed_settings);
                        let is_default = changed_settings.experiment(Condition::None).values() == values;
                        assert!(is_used(key) || is_default, "{line} is accepted");
                        assert!(after != before || is_default, "{line} is accepted and has no effect");
                        has_effect |= after != before;
                    }
                    Err(failure) => {
                        let message = failure.to_string();
                        let is_named = message.contains(last) || names_a_key::<settings::Settings>(&message);
                        assert!(failure.code() == 3 && is_named, "{line}: {message}");
                    }
                }
                if has_effect {
                    break;
                }
            }
            if has_effect {
                used += 1;
            } else {
                refused += 1;
            }
            if is_used(key) || ["name", "seed"].contains(&key) {
                continue;
            }
            // The same of an arm, of a condition, and of another simulator.
            let tables = ["[conditions.none]", "[conditions.sensor]"];
            for table in if is_long {
                &tables[..]
            } else {
                &tables[number % 2..][..1]
            } {
                let message = read(table, &format!("{key} = 1")).unwrap_err().to_string();
                assert!(message.contains(key), "{key} under {table}: {message}");
            }
        }
        println!("{used} keys are used, {refused} refused");
        assert!(used > 20 && refused > 100, "{used} {refused}");
    }

    #[test]
    fn invalid_studies_name_the_place() {
        let directory = std::env::temp_dir().join(format!("oneiro-study-{}", std::process::id()));
        std::fs::create_dir_all(&directory).unwrap();
        let path = directory.join("own.toml");
        let shipped = MIGLINO1995
            .text
            .replace("experiment = \"../khepera-avoidance.toml\"", "");
        let refusal = |from: &str, to: &str, robot: &str| {
            assert!(shipped.contains(from), "{from}");
            std::fs::write(&path, shipped.replacen(from, to, 1)).unwrap();
            let file = StudyFile::open(&MIGLINO1995, Some(&path)).unwrap();
            let asked = Asked {
                robot: robot.parse().unwrap(),
                ..under("main").asked
            };
            Settings::new(&file, "main", asked).unwrap_err().to_string()
        };
        for (from, to, expected) in [
            ("turns = 1", "turns = 0", "samples.turns: is 0; allowed: 1 to 100"),
            ("starts = \"fresh\"", "starts = \"here\"", "reality.starts: "),
            (
                "starts = \"fresh\"",
                "starts = \"fresh\"\nonly = \"magic\"",
                "allowed: geometry, ",
            ),
            ("noise.sensor = [0.0, 0.4]", "noise.sensors = [0.0, 0.4]", "own.toml:"),
            ("[selection]", "[selections]", "selections"),
            (
                "[conditions.none]",
                "[conditions.none]\ncycles = 3",
                "conditions.none.cycles: does not belong to the noise",
            ),
            (
                "{ name = \"own samples\" }",
                "{ name = \"own samples\", evolution.population = 50 }",
                "variants[3].simulators[0].evolution.population: does not belong to a simulator; allowed: noise.*, ",
            ),
            (
                "{ name = \"own samples\" }",
                "{ name = \"own samples\", robot.states = \"asymmetric\" }",
                "variants[3].simulators[0].robot.states: does not belong to a simulator; allowed: noise.*, ",
            ),
        ] {
            let refusal = refusal(from, to, "surrogate:3");
            assert!(refusal.contains("own.toml:") && refusal.contains(expected), "{refusal}");
        }
        for (values, expected) in [
            (
                "walk = 5",
                "reality.walk: unknown key `walk`; did you mean reality.walk_s? (allowed: robot, ",
            ),
            ("walk_s = 1000", "reality.walk_s: is 1000; allowed: 0 to 600"),
            (
                "severity = 1.0",
                "reality.severity: is given; allowed: only with a surrogate",
            ),
            ("guard.speed_mm_s = 5000", "reality.robot: "),
            (
                "generations = 3",
                "reality.wire.generations: is given; allowed: reality.generations instead",
            ),
            (
                "robot = \"tcp:a:1\"",
                "reality.wire.robot: is given; allowed: --robot instead",
            ),
        ] {
            let refusal = refusal("walk_s = 10.0", values, "tcp:localhost:1000");
            assert!(refusal.contains(expected), "{refusal}");
        }
        std::fs::remove_dir_all(&directory).unwrap();
    }
}
