//! An experiment: a run's complete configuration except its seed, from one TOML file.

mod budget;
mod champions;
mod check;
pub(crate) mod degrees;
mod inputs;
pub mod kinds;
mod needs;
pub mod reference;
pub mod robots;
pub mod settings;
pub mod source;
pub mod start;
pub mod swarm;
mod tested;
#[cfg(any(test, feature = "testing"))]
pub mod tried;
pub mod values;
mod world;

use std::path::Path;

use oneiro::parameter::{Field, Invalid};
use oneiro::world::World;
use toml::{Table, Value};

use crate::reality::site::Site;
use crate::reality::wired::Time;

pub use inputs::DIRECTORY as INPUTS;
use inputs::Inputs;
pub use inputs::{Content, Files, Input};
use kinds::FileKind;
use oneiro_base::exit::{Failure, Result};
use oneiro_evolve as evolve;
use oneiro_evolve::settings::{Course, Episodes, Kind, MOST_GENERATIONS};
use oneiro_evolve::{Evolution, Population};
pub use settings::GREATEST_SEED;
use settings::{Settings, Transfer};
use source::{LeftOut, Parsed, Setting, Source};
use tested::{NotTested, TEST};

/// A checked experiment, its world, and the files that it names.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// All values, including defaults; files have the names that a run's directory gives them.
    settings: Settings,
    /// The same values as TOML, with the seed 0.
    values: Table,
    world: World,
    init: Option<Population>,
    inputs: Vec<Input>,
    warnings: Vec<String>,
    left_out: LeftOut,
    /// The same with the values of tests, if it has any.
    test: Option<std::result::Result<Box<Experiment>, NotTested>>,
}

/// What an experiment's values make.
enum Made {
    Whole(Box<Experiment>),
    /// Nothing: values at these paths must be left out first.
    Without(Vec<String>),
}

impl Experiment {
    /// Reads an experiment's file, with `key=value` settings that override it. Files that it names are relative to its
    /// directory.
    ///
    /// # Errors
    /// Exit 3: the file and the line and column in it (or the setting), the key, the value found, and the values
    /// allowed.
    pub fn read(path: &Path, set: &[String]) -> Result<Self> {
        let text = FileKind::Experiment.text(path)?;
        let file = FileKind::Experiment.parsed(path, &text)?;
        if file.has("swarm") {
            let path = path.display();
            return Err(Failure::input(format_args!(
                "{path}: is the foraging study; allowed: experiments with one robot, or with robot.count"
            )));
        }
        Self::of(path, &file, &Setting::all_typed(set)?, &Files::default())
    }

    /// Reads the values of an experiment's file. Files that other experiments have already named come from `files`.
    ///
    /// # Errors
    /// As [`Experiment::read`].
    pub fn of(path: &Path, file: &Parsed<'_>, set: &[Setting], files: &Files) -> Result<Self> {
        let (mut own, source) = Self::untested(path, file, set, files)?;
        if !own.settings.test.0.is_empty() {
            let test = own.tested(path, file, set, files, &source).map(Box::new);
            own.test = Some(test.map_err(|failure| {
                let of_file = Self::untested(path, file, &[], files);
                let is_wrong = of_file.is_ok_and(|(own, source)| own.tested(path, file, &[], files, &source).is_err());
                NotTested {
                    problem: failure.to_string(),
                    is_of_file: set.is_empty() || is_wrong,
                }
            }));
            let is_same = |test: &Self| own.difference(test, true).is_none();
            if set.is_empty() && matches!(&own.test, Some(Ok(test)) if is_same(test)) {
                let place = source.place_of(TEST);
                own.warnings.push(format!("{place}: {TEST}: changes nothing"));
            }
        }
        Ok(own)
    }

    /// The same without its values of tests, and the source of its values.
    fn untested<'a>(path: &Path, file: &'a Parsed<'a>, set: &[Setting], files: &Files) -> Result<(Self, Source<'a>)> {
        let (given, source) = degrees::read::<Settings>(file, set)?;
        let mut given = robots::described(given, &source)?;
        loop {
            match Self::made(path, &given, &source, files)? {
                Made::Whole(experiment) => return Ok((*experiment, source)),
                Made::Without(needless) => needless.iter().for_each(|path| values::remove(&mut given, path)),
            }
        }
    }

    /// Like [`Experiment::of`], for an experiment that is a part of something else, which uses only some of its keys. Its file may also
    /// have a name, a seed and what to record.
    ///
    /// # Errors
    /// As [`Experiment::read`], and for a value of another key.
    pub fn partly(
        path: &Path,
        file: &Parsed<'_>,
        set: &[Setting],
        files: &Files,
        (by, is_used): (&str, &dyn Fn(&str) -> bool),
    ) -> Result<Self> {
        let own = Self::of(path, file, set, files)?;
        let (_, source) = degrees::read::<Settings>(file, set)?;
        let is_of_runs = |key: &str| ["name", SEED, "files"].contains(&key) || key.starts_with("record.");
        let is_used = |key: &str| is_used(key) || is_of_runs(key) && !source.is_set(key);
        needs::check_used(&mut own.settings.clone(), &source, &is_used, by)?;
        Ok(own)
    }

    /// Makes an experiment from all its values.
    ///
    /// # Errors
    /// As [`Experiment::read`].
    fn made(path: &Path, given: &Table, source: &Source<'_>, files: &Files) -> Result<Made> {
        let mut settings = Settings::default();
        let is_given = |key: &str| values::at(given, key).is_some();
        for other in FOLLOWING {
            if is_given(BUDGET) && is_given(other) {
                return Ok(Made::Without(vec![source.outranked([BUDGET, other])?.to_owned()]));
            }
        }
        if is_given(BUDGET) {
            // Their number follows.
            settings.evolution.generations = MOST_GENERATIONS;
        }
        let population = values::at(given, "evolution.population").and_then(Value::as_integer);
        if let Some(population) = population.and_then(|own| u32::try_from(own).ok())
            && !is_given("evolution.parents")
        {
            settings.evolution.parents = evolve::settings::Settings::parents_of(population);
        }
        values::read(given, &mut settings, source)?;
        if settings.name.is_empty() {
            settings.name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        }
        let has_own = check::is_own_arena(&settings) || check::is_forager(&settings);
        if values::at(given, "arena.preset").is_none() && has_own {
            settings.arena.preset = None;
        }
        if values::at(given, "record.individuals").is_none() {
            settings.record.individuals &= settings.evolution.records_individuals();
        }
        settings.reality.complete(settings.evolution.generations);
        let needless = needs::check(needs::of_settings(&settings), given, &mut settings, source)?;
        if !needless.is_empty() {
            return Ok(Made::Without(needless));
        }
        let refused = |invalid: Invalid| source.invalid(&invalid.field, &invalid.problem);
        let has_sides = settings.arena.open != Some(true) && settings.arena.corners.is_none();
        if has_sides
            && values::at(given, "arena.walls")
                .and_then(Value::as_array)
                .is_some_and(Vec::is_empty)
        {
            let allowed = "allowed: walls; no such key, for the four sides; or arena.open = true, for none";
            return Err(source.invalid("arena.walls", format_args!("is empty; {allowed}")));
        }
        check::check(&settings).map_err(refused)?;
        check::drawn(&settings, source)?;
        let directory = path.parent().unwrap_or(Path::new(""));
        let hashes = settings.files.clone();
        let mut inputs = Inputs::new(directory, source, &settings, &hashes, files);
        let world = world::world(&settings, source, &mut inputs)?;
        if let Ok(Some(site)) = settings.reality.site() {
            let allowed = site.allows(world.spec());
            allowed
                .map_err(|problem| source.invalid("reality.robot", format!("can't run this experiment: {problem}")))?;
        }
        let has_population = values::at(given, "evolution.population").is_some();
        settings
            .evolution
            .complete(world.genes(), settings.trials, has_population);
        let course = course(&settings, world.genes());
        settings.evolution.spend(course, &is_given).map_err(refused)?;
        if let Some(real) = &mut settings.reality.generations
            && is_given(BUDGET)
        {
            let generations = settings.evolution.generations;
            if is_given("reality.generations") {
                source.within("reality.generations", *real, &(1..=generations))?;
            }
            *real = (*real).min(generations);
        }
        let needless = needs::check(needs::of_world(&world), given, &mut settings, source)?;
        if !needless.is_empty() {
            return Ok(Made::Without(needless));
        }
        check::evolution(&settings, world.gene_layout().all()).map_err(refused)?;
        if !source.is_recorded() {
            check::beginnings(&settings, world.gene_layout().all()).map_err(refused)?;
        }
        check::measures(&settings, &world).map_err(refused)?;
        check::memory(&settings, world.genes()).map_err(refused)?;
        let init = inputs.init(&settings.evolution, world.gene_layout())?;
        let (inputs, mut warnings) = inputs.finish()?;
        let doubts = check::doubts(&settings, &world).into_iter();
        warnings.extend(doubts.map(|(key, problem)| format!("{}: {key}: {problem}", source.place_of(&key))));
        inputs::rename(&mut settings, &inputs);
        for own in world.spec().own.iter() {
            settings.part_mut(own.part().kind()).values = own.named_values();
        }
        let mut with_seed = Settings {
            seed: Some(0),
            ..settings.clone()
        };
        let mut values = values::table(&mut with_seed, given);
        if settings.evolution.budget.is_some() {
            for key in FOLLOWING {
                values::remove(&mut values, key);
            }
        }
        Ok(Made::Whole(Box::new(Self {
            settings,
            values,
            world,
            init,
            inputs,
            warnings,
            left_out: source.left_out(),
            test: None,
        })))
    }

    pub fn name(&self) -> &str {
        &self.settings.name
    }

    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// World of its robots.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The evolution of a run before its first generation.
    pub fn evolution(&self, seed: u64) -> Evolution {
        let settings = &self.settings.evolution;
        let genes = self.world.gene_layout().all();
        let optimizer = evolve::optimizer(settings, seed, genes, self.init.clone());
        Evolution::new(optimizer, settings.generations, None)
    }

    /// Random genomes, as in the first generation of a genetic algorithm with this seed and size.
    pub fn random_genomes(&self, count: u32, seed: u64) -> Population {
        let settings = evolve::settings::Settings {
            kind: Kind::Random,
            population: count,
            ..self.settings.evolution.clone()
        };
        let genes = self.world.gene_layout().all();
        evolve::optimizer(&settings, seed, genes, None).ask().clone()
    }

    /// The files that it names, for a run's directory.
    pub fn inputs(&self) -> &[Input] {
        &self.inputs
    }

    /// The genomes that its evolution begins with, and their file, if they are given.
    pub fn init(&self) -> Option<(&Population, &Input)> {
        let name = self.settings.evolution.init.as_ref()?;
        let input = self.inputs.iter().find(|input| input.name == *name)?;
        Some((self.init.as_ref()?, input))
    }

    /// Warnings about its files and its values.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// The settings that others of a higher rank left without effect.
    pub fn left_out(&self) -> &LeftOut {
        &self.left_out
    }

    /// The experiment of a run as TOML with every default written out; reading it gives this run's experiment again.
    pub fn resolved_toml(&self, seed: u64) -> String {
        let mut values = self.values.clone();
        values.insert("seed".into(), (seed as i64).into());
        text(&values)
    }

    /// All its values as TOML, with the seed of its file.
    pub fn values(&self) -> Table {
        let mut values = self.values.clone();
        match self.settings.seed {
            Some(seed) => values.insert("seed".into(), (seed as i64).into()),
            None => values.remove("seed"),
        };
        values
    }

    /// Number of individuals that are re-evaluated after the last generation: the luckiest of the run and the best others.
    pub fn finalists(&self) -> u32 {
        let Course { genes, finalists, .. } = self.course();
        self.settings.evolution.finalists(finalists, genes)
    }

    /// What its episodes depend on besides the optimiser.
    fn course(&self) -> Course {
        course(&self.settings, self.world.genes())
    }

    /// Episodes of a run that decide its results, at most.
    pub fn episodes(&self) -> Episodes {
        self.settings.evolution.episodes(self.course())
    }

    /// What the optimiser makes of `evolution.episodes`, in words; none if they are not given.
    pub fn budget(&self) -> Option<String> {
        let evolution = &self.settings.evolution;
        let budget = evolution.budget?;
        Some(budget::words(budget, self.episodes(), evolution, self.course()))
    }

    /// The first generation that is evaluated on the robot of [`settings::Transfer`], if there is one.
    pub fn first_real(&self) -> Option<u32> {
        let Settings { reality, evolution, .. } = &self.settings;
        let generations = reality.generations.filter(|_| !reality.robot.0.is_empty())?;
        Some(evolution.generations - generations)
    }

    /// Time of all episodes on that robot, if it is connected, or on those robots.
    pub fn robot_time(&self) -> Option<Time> {
        let Settings {
            reality,
            evolution,
            trials,
            ..
        } = &self.settings;
        let lives = u64::from(evolution.population) * u64::from(*trials);
        self.site()?
            .generations(reality.generations?, lives, self.world.cycles())
    }

    /// The robot of [`settings::Transfer`], if there is one.
    pub fn site(&self) -> Option<Site> {
        self.settings.reality.site().ok().flatten()
    }

    /// Robot-steps of a run, excluding its trace. (If a whole population are finalists, the luckiest may be one of
    /// them; then there is one less.)
    pub fn steps(&self) -> u64 {
        let steps = u64::from(self.world.cycles()) * u64::from(self.world.robots());
        let episodes = self.episodes().total().saturating_add(self.test_episodes().into());
        episodes.saturating_mul(steps)
    }

    /// Episodes of the champion after it was chosen among finalists. They decide nothing, so that no budget counts them.
    pub fn test_episodes(&self) -> u32 {
        match self.finalists() {
            0 | 1 => 0,
            _ => self.settings.finalists.lives,
        }
    }

    /// Approximate memory of a run in progress, in bytes.
    pub fn bytes(&self) -> u64 {
        check::bytes(&self.settings, self.world.genes())
    }

    /// Hash of everything that affects episodes of its robots. Experiments that differ only in their evolution have the same hash.
    pub(crate) fn world_identity(&self) -> blake3::Hash {
        blake3::hash(text(&self.world_values()).as_bytes())
    }

    /// The values that affect episodes of its robots.
    fn world_values(&self) -> Table {
        let mut world = self.values.clone();
        // Genomes to begin with, by their file's name, are no part of the world.
        let init = values::at(&self.values, "evolution.init").and_then(Value::as_str);
        if let (Some(init), Some(files)) = (init, world.get_mut("files").and_then(Value::as_table_mut)) {
            files.remove(init);
            if files.is_empty() {
                world.remove("files");
            }
        }
        for key in [&SCORE[..], &["name", "evolution", "record", TEST]].concat() {
            world.remove(key);
        }
        // Where the simulator is made from samples of that robot, the robot affects episodes in the simulator.
        let reality = world
            .remove("reality")
            .filter(|_| Transfer::is_sampled(&self.settings.robot));
        if let Some(Value::Table(mut reality)) = reality {
            reality.remove("generations");
            world.insert("reality".into(), reality.into());
        }
        world
    }

    /// The first key that makes the episodes of two experiments differ, with both values; `None` if there is none. With `scores`, it
    /// also compares the ways to combine several episodes.
    pub fn difference(&self, other: &Self, scores: bool) -> Option<Difference> {
        let values = |own: &Self| {
            let mut values = own.world_values();
            for key in SCORE.iter().filter(|_| scores) {
                values.extend(own.values.get(*key).map(|value| ((*key).to_owned(), value.clone())));
            }
            Value::Table(values)
        };
        differences(&values(self), &values(other)).into_iter().next()
    }

    /// All keys that make the episodes of two experiments differ, with both values.
    pub fn differences(&self, other: &Self) -> Vec<Difference> {
        let values = |own: &Self| Value::Table(own.world_values());
        differences(&values(self), &values(other))
    }

    /// The keys by which two experiments have different tasks, with both values. Those of [`SCORE_NAME`] say what is scored; the others
    /// where, by how many robots and for how long.
    pub fn task_differences(&self, other: &Self) -> Vec<Difference> {
        let values = |own: &Self| Value::Table(own.task_values());
        differences(&values(self), &values(other))
    }

    /// The keys by which two experiments combine the fitness of several episodes in different ways, with both values.
    pub fn score_differences(&self, other: &Self) -> Vec<Difference> {
        let values = |own: &Self| {
            let keys = SCORE.iter().filter_map(|key| own.values.get_key_value(*key));
            Value::Table(keys.map(|(key, value)| (key.clone(), value.clone())).collect())
        };
        differences(&values(self), &values(other))
    }

    fn task_values(&self) -> Table {
        let own = |key: &str| self.values.get(key).map(|value| (key.to_owned(), value.clone()));
        let mut values: Table = ["cycles", "arena", "start", "task"]
            .into_iter()
            .filter_map(own)
            .collect();
        if let Some(count) = values::at(&self.values, "robot.count") {
            let count = Table::from_iter([("count".to_owned(), count.clone())]);
            values.insert("robot".into(), count.into());
        }
        // Two files may have one name.
        let files = self.values.get("files").and_then(Value::as_table);
        for path in [&["task", "part"][..], &["arena", "picture", "file"]] {
            let (first, rest) = (values.get_mut(path[0]), &path[1..]);
            let found = rest
                .iter()
                .try_fold(first, |table, key| Some(table?.get_mut(*key)))
                .flatten();
            if let Some(Value::String(file)) = found
                && let Some(hash) = files.and_then(|files| files.get(file.as_str())?.as_str())
            {
                *file = format!("{file}, hash {hash:.12}");
            }
        }
        values
    }

    /// The keys whose values differ from the defaults of the chosen kinds, with the default and the value. Names and hashes of files,
    /// and what is recorded, are left out.
    pub fn changed(&self) -> Vec<Difference> {
        let mut usual = values::with_kinds_of(&mut self.settings.clone());
        // What follows from other settings was not set.
        let mut following = evolve::settings::Settings {
            population: usual.evolution.population,
            ..self.settings.evolution.clone()
        };
        following.complete(self.world.genes(), self.settings.trials, false);
        usual.evolution.complete(self.world.genes(), usual.trials, false);
        usual.evolution.population = following.population;
        let mut values = self.values.clone();
        for key in ["name", SEED, "files", "record", TEST] {
            values.remove(key);
        }
        let mut usual = values::table(&mut usual, &Table::new());
        usual.remove("name");
        usual.remove("record");
        differences(&usual.into(), &values.into())
    }

    /// Hashes of everything that decides the results of its runs, which excludes what is recorded and when.
    pub fn identities(&self) -> Identities {
        let mut values = self.values.clone();
        let defaults = values::table(&mut Settings::default(), &Table::new());
        values.insert("record".into(), defaults["record"].clone());
        values.remove(TEST);
        if self.settings.finalists.count == 0
            && let Some(evolution) = values.get_mut("evolution").and_then(Value::as_table_mut)
        {
            // Runs had this identity before there were finalists.
            evolution.remove("finalists");
            evolution.remove("finalist_lives");
        }
        Identities::new(&text(&values))
    }
}

/// The budget, and keys whose values follow from it.
const BUDGET: &str = "evolution.episodes";
const FOLLOWING: [&str; 2] = ["evolution.generations", "evolution.race.lives"];

/// What the episodes of a run depend on besides the optimiser.
fn course(settings: &Settings, genes: usize) -> Course {
    let site = settings.reality.site().ok().flatten();
    // On a connected robot finalists would take days.
    let is_wired = site.is_some_and(|site| site.is_wired());
    Course {
        genes,
        trials: settings.trials,
        finalists: if is_wired { 0 } else { settings.finalists.count },
        finalist_episodes: settings.finalists.lives,
    }
}

/// Keys that decide how the fitness of an individual's several episodes is combined.
const SCORE: [&str; 2] = ["trials", "trial_score"];

/// Keys that say what a score counts.
pub const SCORE_NAME: [&str; 2] = ["task.kind", "task.part"];

/// A key in which two experiments differ.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    pub key: String,
    /// Both values as TOML, or a note that there is none.
    pub values: [String; 2],
}

impl Difference {
    /// The keys that make the results of two runs differ, given the text of their `config.toml`.
    pub fn of_runs(one: &str, other: &str) -> Vec<Self> {
        let values = |text: &str| {
            let mut values: Table = text.parse().ok()?;
            // What is recorded changes no result.
            values.remove("record");
            Some(Value::Table(values))
        };
        match (values(one), values(other)) {
            (Some(one), Some(other)) => differences(&one, &other),
            _ => Vec::new(),
        }
    }
}

/// All differences between two tables of values, in the order of their keys.
fn differences(one: &Value, other: &Value) -> Vec<Difference> {
    let mut found = Vec::new();
    add_differences("", Some(one), Some(other), &mut found);
    found
}

/// Adds the differences between two values of a key.
fn add_differences(key: &str, one: Option<&Value>, other: Option<&Value>, found: &mut Vec<Difference>) {
    if one == other {
        return;
    }
    if let (Some(Value::Table(one)), Some(Value::Table(other))) = (one, other) {
        let mut keys: Vec<&String> = one.keys().chain(other.keys()).collect();
        keys.sort();
        keys.dedup();
        for inner in keys {
            let path = if key.is_empty() {
                inner.clone()
            } else {
                format!("{key}.{inner}")
            };
            add_differences(&path, one.get(inner), other.get(inner), found);
        }
        return;
    }
    let shown = |value: Option<&Value>| value.map_or_else(|| "not set".to_owned(), ToString::to_string);
    found.push(Difference {
        key: key.to_owned(),
        values: [shown(one), shown(other)],
    });
}

/// Identities of an experiment's runs: hashes of all values that affect results, and a run's seed.
#[derive(Clone, Debug)]
pub struct Identities {
    /// The experiment as TOML, before and after the place of its seed.
    before: String,
    after: String,
}

impl Identities {
    /// Takes an experiment as TOML with the seed 0.
    fn new(toml: &str) -> Self {
        const SEED: &str = "\nseed = ";
        let (before, after) = toml
            .split_once("\nseed = 0\n")
            .expect("a name comes first, then the seed");
        Self {
            before: format!("{before}{SEED}"),
            after: format!("\n{after}"),
        }
    }

    /// Hash of the run with a seed.
    pub fn of(&self, seed: u64) -> blake3::Hash {
        // In one piece, of which several kilobytes are hashed at a time.
        blake3::hash([&*self.before, &*seed.to_string(), &*self.after].concat().as_bytes())
    }
}

/// The key of a run's seed.
pub const SEED: &str = "seed";

/// Whether a key allows a value from elsewhere, and a description of the allowed values.
pub fn allows(key: &str, value: &dyn Field) -> (bool, String) {
    let single = values::alone::<Settings>(key, value);
    let found = single.or_else(|| values::alone::<swarm::File>(key, value));
    found.expect("the key has a row")
}

/// Checks a seed that another program gives.
///
/// # Errors
/// Exit 3: the seed, and the allowed ones.
pub fn check_seed(seed: u64) -> Result {
    match allows(SEED, &seed) {
        (true, _) => Ok(()),
        (false, allowed) => Err(Failure::input(format_args!("{SEED}: is {seed}; allowed: {allowed}"))),
    }
}

/// Checks a name of an experiment or a sweep, which becomes part of directory names; the error says what is wrong.
pub(crate) fn check_name(name: &str) -> std::result::Result<(), String> {
    check::name(name).map_err(|invalid| invalid.problem)
}

/// Formats a table as the text of a file.
fn text(values: &Table) -> String {
    toml::to_string(values).expect("values are tables of numbers, words and lists")
}

#[cfg(test)]
mod effects;
#[cfg(test)]
mod mutants;
#[cfg(test)]
pub mod tests;
