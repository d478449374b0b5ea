//! An experiment of the foraging study: a file with a table `swarm`.

use std::path::Path;
use std::sync::LazyLock;

use oneiro::foraging::{AsForaging, Foraging, GREATEST_ITEMS};
use oneiro::parameter::{Allowed, Choice, Choices, Parameter, row};
use oneiro::swarm::Swarm;
use oneiro_base::exit::Result;
use toml::{Table, Value};

use super::check::{Checked, invalid, name};
use super::degrees;
use super::needs::{self, Need};
use super::settings::head;
use super::source::{LeftOut, Parsed, Setting};
use super::values::{self, Described};
use super::{Difference, Identities, SEED, differences, text};
use crate::exchange::links::Topology;
use crate::swarm::Plan;
use crate::swarm::record::{Case, Kind};
use crate::swarm::settings::{self, Clock, Settings};

/// The key of the control.
const CONTROL: &str = "swarm.control";

/// A checked experiment of the foraging study.
#[derive(Clone, Debug)]
pub struct SwarmExperiment {
    file: File,
    left_out: LeftOut,
}

/// Contents of its file.
#[derive(Clone, Debug, Default)]
pub struct File {
    /// Name of the experiment's runs; the file's name by default.
    name: String,
    /// Seed of the run; the command line's takes precedence.
    seed: Option<u64>,
    swarm: Settings,
    /// The evolution, or a control.
    control: Kind,
}

/// One robot alone is no control of an experiment, but an experiment with one robot.
impl Choice for Kind {
    const CHOICES: Choices<Self> = &[
        ("evolved", Self::Evolved, "no control, the paper's evolution"),
        (
            "fitness-shuffled",
            Self::FitnessShuffled,
            "real fitness is shuffled among robots before it is compared (the null)",
        ),
        (
            "simulator-shuffled",
            Self::SimulatorShuffled,
            "simulators are shuffled among robots after each exchange",
        ),
        (
            "simulator-right",
            Self::SimulatorRight,
            "all simulators have the light where it is",
        ),
        (
            "simulator-wrong",
            Self::SimulatorWrong,
            "all simulators have the light where it is not",
        ),
        (
            "simulator-random",
            Self::SimulatorRandom,
            "each simulator is drawn anew each interval",
        ),
        (
            "embodied",
            Self::Embodied,
            "no simulators: a robot takes over the controller of the highest real fitness, its own or a received one, mutated",
        ),
        (
            "embodied-random",
            Self::EmbodiedRandom,
            "no simulators: it takes over one of the received controllers at random, mutated, and keeps its own if there is none",
        ),
        (
            "disparity",
            Self::Disparity,
            "simulators are compared by the difference between the fitness that they predicted and the real one",
        ),
        (
            "heard-by-all",
            Self::HeardByAll,
            "every robot hears all others, wherever they are",
        ),
        (
            "central",
            Self::Central,
            "all robots have one simulator, which a computer that knows all of them chooses: of the three places of the light the one that best predicted their real fitness in the last interval",
        ),
    ];
}

impl AsMut<Settings> for File {
    fn as_mut(&mut self) -> &mut Settings {
        &mut self.swarm
    }
}

impl AsMut<Swarm> for File {
    fn as_mut(&mut self) -> &mut Swarm {
        &mut self.swarm.world
    }
}

impl AsForaging for File {
    fn as_foraging(&mut self) -> Option<&mut Foraging> {
        Some(&mut self.swarm.world.forager)
    }
}

impl Described for File {
    fn rows() -> &'static [Parameter<Self>] {
        static ROWS: LazyLock<Vec<Parameter<File>>> = LazyLock::new(|| {
            let mut rows = head(|own: &mut File, _| Some(&mut own.name), |own, _| Some(&mut own.seed));
            rows.extend(settings::parameters().into_iter().map(|row| below_swarm(&row)));
            rows.push(row(
                CONTROL,
                "",
                Allowed::Any,
                "ours; the null and the interventions of studies/preregistration-2014.md, and the rivals of studies/preregistration-2014-rivals.md",
                "What the experimenter does to the evolution of simulators, or which other method is used. Simulated swarms only.",
                |own: &mut File, _| Some(&mut own.control),
            ));
            rows
        });
        &ROWS
    }
}

/// Moves a row's keys below the table `swarm`. Rows are made once and exist as long as the program.
fn below_swarm(row: &Parameter<File>) -> Parameter<File> {
    let below = |key: &str| -> &'static str { format!("swarm.{key}").leak() };
    Parameter {
        key: below(row.key),
        allowed: match row.allowed {
            Allowed::WholeUpTo(least, key) => Allowed::WholeUpTo(least, below(key)),
            Allowed::NumberUpTo(least, factor, key) => Allowed::NumberUpTo(least, factor, below(key)),
            other => other,
        },
        ..*row
    }
}

impl SwarmExperiment {
    /// Like [`SwarmExperiment::of`], for a fleet, where no program controls the evolution of all robots.
    ///
    /// # Errors
    /// As there, and for a control.
    pub fn of_robots(path: &Path, text: &Parsed<'_>) -> Result<Self> {
        const WHY: &str = "needs the evolution of all robots in one program";
        let own = Self::without_control(path, text, &[], &format!("is a control, which {WHY}"))?;
        let (_, source) = degrees::read::<File>(text, &[])?;
        let links = own.settings().links;
        if links.topology != Topology::Encounters {
            let problem = format_args!("is `{}`, which {WHY}; allowed: encounters", links.topology.word());
            return Err(source.invalid("swarm.messages.topology", problem));
        }
        if links.migration < 1.0 {
            let problem = format_args!("is {}, which {WHY}; allowed: 1", links.migration);
            return Err(source.invalid("swarm.messages.migration", problem));
        }
        Ok(own)
    }

    /// Like [`SwarmExperiment::of`], without a control, for the reason `why`.
    ///
    /// # Errors
    /// As there, and for a control.
    pub fn without_control(path: &Path, text: &Parsed<'_>, set: &[Setting], why: &str) -> Result<Self> {
        let own = Self::of(path, text, set)?;
        if own.file.control == Kind::Evolved {
            return Ok(own);
        }
        let (_, source) = degrees::read::<File>(text, set)?;
        Err(source.invalid(CONTROL, format_args!("{why}; allowed: evolved")))
    }

    /// Reads the values of an experiment's file.
    ///
    /// # Errors
    /// Exit 3: the file and the line and column in it (or the setting), the key, the value found, and the values
    /// allowed.
    pub fn of(path: &Path, text: &Parsed<'_>, set: &[Setting]) -> Result<Self> {
        let (mut given, source) = degrees::read::<File>(text, set)?;
        let mut file = loop {
            let mut file = File::default();
            values::read(&given, &mut file, &source)?;
            let needless = needs::check(needs(&file), &given, &mut file, &source)?;
            if needless.is_empty() {
                break file;
            }
            for path in &needless {
                values::remove(&mut given, path);
            }
        };
        if file.name.is_empty() {
            file.name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        }
        check(&file).map_err(|invalid| source.invalid(&invalid.field, &invalid.problem))?;
        if !source.is_recorded() {
            light(&file.swarm).map_err(|invalid| source.invalid(&invalid.field, &invalid.problem))?;
        }
        let left_out = source.left_out();
        Ok(Self { file, left_out })
    }

    pub fn name(&self) -> &str {
        &self.file.name
    }

    /// The settings that others of a higher rank left without effect.
    pub fn left_out(&self) -> &LeftOut {
        &self.left_out
    }

    /// The seed in its file, if any.
    pub fn seed(&self) -> Option<u64> {
        self.file.seed
    }

    /// All its values as TOML, with the seed of its file.
    pub fn values(&self) -> Table {
        values::table(&mut self.file.clone(), &Table::new())
    }

    /// The keys whose values differ from their defaults, with the default and the value, except its name.
    pub fn changed(&self) -> Vec<Difference> {
        let all = |own: &mut File| {
            let mut values = values::table(own, &Table::new());
            for key in ["name", SEED] {
                values.remove(key);
            }
            Value::from(values)
        };
        differences(
            &all(&mut values::with_kinds_of(&mut self.file.clone())),
            &all(&mut self.file.clone()),
        )
    }

    pub fn settings(&self) -> &Settings {
        &self.file.swarm
    }

    /// The plan of its run with a seed.
    pub fn plan(&self, seed: u64) -> Plan {
        Plan {
            settings: self.file.swarm.clone(),
            kind: self.file.control,
            number: 0,
            seed,
        }
    }

    /// The experiment of a run as TOML, with every default written out.
    pub fn resolved_toml(&self, seed: u64) -> String {
        let mut file = File {
            seed: Some(seed),
            ..self.file.clone()
        };
        text(&values::table(&mut file, &Table::new()))
    }

    /// Hashes of everything that decides the results of its runs.
    pub fn identities(&self) -> Identities {
        Identities::new(&self.resolved_toml(0))
    }
}

/// Whether the light moves.
fn is_moving(case: Case) -> bool {
    matches!(case, Case::OverThenOpposite | Case::OppositeThenOver)
}

/// Values that have an effect only in some cases.
fn needs(File { swarm, control, .. }: &File) -> Vec<Need> {
    const CASE: &[&str] = &["swarm.case"];
    let evolves = "with another swarm.case than \"random\", in which nothing evolves";
    vec![
        Need::new(
            &[
                "swarm.controllers",
                "swarm.simulators",
                "swarm.clock.installed_s",
                "swarm.control",
            ],
            swarm.case != Case::Random,
            evolves,
            CASE,
        ),
        Need::new(
            &[
                "swarm.messages",
                "swarm.robot.phototaxis_gain",
                "swarm.robot.phototaxis_turn_rad_s",
                "swarm.robot.phototaxis_threshold",
                "swarm.arena.lamp_behind_wall_mm",
                "swarm.arena.light_decay",
                "swarm.arena.ambient",
                "swarm.arena.light_noise",
            ],
            swarm.case != Case::Random,
            "with another swarm.case than \"random\", in which robots neither see a light nor send anything",
            CASE,
        ),
        Need::new(
            &[
                "swarm.differences.light",
                "swarm.differences.beam",
                "swarm.differences.reflection",
                "swarm.differences.shadows",
            ],
            !matches!(swarm.case, Case::Random | Case::NoLight),
            "with a swarm.case that has a light",
            CASE,
        ),
        Need::new(
            &["swarm.simulators.mutation_scale", "swarm.simulators.boundary"],
            control.has_simulators() && !control.sets_simulators() && *control != Kind::Central,
            "with simulators that evolve (swarm.control)",
            &[CONTROL],
        ),
        Need::new(
            &[
                "swarm.controllers.population",
                "swarm.controllers.parents",
                "swarm.controllers.guests",
            ],
            control.has_simulators(),
            "with simulators, in which controllers are chosen (swarm.control)",
            &[CONTROL],
        ),
        Need::new(
            &["swarm.simulators.pairs", "swarm.simulators.leaves"],
            *control != Kind::EmbodiedRandom,
            "with another swarm.control: there nothing that a robot has heard may be lost by its fitness",
            &[CONTROL],
        ),
        Need::new(
            &[
                "swarm.messages",
                "swarm.controllers.guests",
                "swarm.simulators.pairs",
                "swarm.simulators.key",
                "swarm.simulators.leaves",
                "swarm.simulators.says",
                "swarm.simulators.credit",
            ],
            control.exchanges(),
            "with another swarm.control: there robots exchange nothing",
            &[CONTROL],
        ),
        Need::new(
            &["swarm.messages"],
            *control != Kind::HeardByAll,
            "with another swarm.control: there every robot hears all others",
            &[CONTROL],
        ),
        Need::new(
            &[
                "swarm.messages.range_mm",
                "swarm.messages.heard",
                "swarm.messages.line_of_sight",
            ],
            swarm.meet(),
            "with swarm.messages.topology = \"encounters\", where robots hear those that they meet",
            &["swarm.messages.topology"],
        ),
        Need::new(
            &["swarm.simulators.credit", "swarm.simulators.says"],
            control.has_simulators() && *control != Kind::Disparity,
            "with another swarm.control: there a message has the real fitness of the controller that acts, or what was predicted of a whole interval",
            &[CONTROL],
        ),
    ]
}

/// Checks that a moving light moves before the end.
fn light(swarm: &Settings) -> Checked {
    let (minute, minutes) = (swarm.light_moves_minute, swarm.minutes);
    if is_moving(swarm.case) && minute >= minutes {
        let problem = format!(
            "is {minute}; allowed: 0 to {}, less than swarm.minutes, or another swarm.case",
            minutes - 1
        );
        return invalid("swarm.light_moves_minute", problem);
    }
    Ok(())
}

/// Checks what the rows don't.
fn check(file: &File) -> Checked {
    name(&file.name)?;
    let items = file.swarm.food_items();
    if items > GREATEST_ITEMS {
        let problem = format!(
            "makes {items} items of food; allowed: at most {GREATEST_ITEMS}, with fewer swarm.arena.food_items, fewer robots or a smaller arena"
        );
        return invalid("swarm.arena.food_scales", problem);
    }
    let Clock {
        interval_s,
        offset_s,
        installed_s,
    } = file.swarm.clock;
    if file.control == Kind::Central && offset_s > 0 {
        let problem =
            format!("is {offset_s}; allowed: 0 with this swarm.control, which compares an interval of all robots");
        return invalid("swarm.clock.offset_s", problem);
    }
    if !file.control.has_simulators() && offset_s > 0 {
        let problem = format!(
            "is {offset_s}; allowed: 0 with this swarm.control, where a controller that was received takes over at once"
        );
        return invalid("swarm.clock.offset_s", problem);
    }
    if !file.control.has_simulators() && installed_s != interval_s {
        let problem = format!(
            "is {installed_s}; allowed: {interval_s}, swarm.clock.interval_s, with this swarm.control, where nothing is simulated"
        );
        return invalid("swarm.clock.installed_s", problem);
    }
    if file.control == Kind::Central && installed_s != interval_s {
        let problem = format!(
            "is {installed_s}; allowed: {interval_s}, swarm.clock.interval_s, with this swarm.control, which predicts what one controller reaches in a whole interval"
        );
        return invalid("swarm.clock.installed_s", problem);
    }
    if installed_s < offset_s {
        let problem = format!(
            "is {installed_s}; allowed: {offset_s} to {interval_s}, no less than the time in which robots are switched on"
        );
        return invalid("swarm.clock.installed_s", problem);
    }
    Ok(())
}
