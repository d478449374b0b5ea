//! An experiment, and the evolution of its controllers.

use std::fmt::Display;
use std::fs;
use std::io::{self, Write};
use std::path::Path;
use std::process;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use oneiro::arena::Patch;
use oneiro::batch::{GREATEST_GENE, Worlds};
use oneiro::world::World;
use oneiro_base::columns;
use oneiro_base::disk;
use oneiro_base::exit::{self, Failure};
use oneiro_base::npy::npy;
use oneiro_base::plain;
use oneiro_base::sealed;
use oneiro_evolve as evolve;
use oneiro_evolve::SavedEvolution;
use oneiro_experiments::EXAMPLES;
use oneiro_lab::experiment::check_seed;
use oneiro_lab::experiment::source::{Parsed, Setting};
use oneiro_lab::experiment::{self, Files};
use oneiro_lab::lives::measures::descriptors;
use oneiro_lab::runs;
use oneiro_lab::runs::single::job::{means, score};
use oneiro_lab::runs::single::trace::TraceTable;

use super::evaluate::TraceColumn;
use super::{Error, Result};
use crate::commands::adopt;
use crate::examples;

/// What the states of evolutions are sealed as.
const STATE: &str = "oneiro evolution";
const VERSION: u32 = 1;

/// A checked experiment. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Experiment(Arc<Known>);

#[derive(Debug)]
struct Known {
    any: Arc<dyn runs::Experiment>,
    /// The world of single robots, packed when it is first used.
    worlds: OnceLock<Worlds>,
}

/// An arena as rows of numbers: mm, and headings in turns.
#[derive(Clone, Debug)]
pub struct Arena {
    /// Left and lower corner, width and height.
    pub field: [f32; 4],
    /// Both ends.
    pub walls: Vec<[f32; 4]>,
    /// Middle and radius.
    pub circles: Vec<[f32; 3]>,
    /// Middle, length, width and heading.
    pub blocks: Vec<[f32; 5]>,
    /// Middle; radius, or 0 and length, width and heading; grey.
    pub patches: Vec<[f32; 7]>,
    /// Place, and height, 0 if it has none.
    pub lights: Vec<[f32; 3]>,
}

/// Writes files into a folder.
fn write_all<'a>(folder: &Path, files: impl Iterator<Item = (&'a str, &'a [u8])>) -> exit::Result {
    for (name, bytes) in files {
        let name = Path::new(name);
        disk::make_folder(folder, name.parent().unwrap_or(Path::new("")))?;
        let written = plain::create(&folder.join(name)).and_then(|mut file| file.write_all(bytes));
        written.map_err(|error| Failure::storage(&folder.join(name), &error))?;
    }
    Ok(())
}

/// Does something while files are in a new folder in the system's for temporary files.
fn with_files<'a, T>(
    files: impl ExactSizeIterator<Item = (&'a str, &'a [u8])>,
    work: impl FnOnce(&Path) -> exit::Result<T>,
) -> exit::Result<T> {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let place = || {
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        std::env::temp_dir().join(format!("oneiro-{}-{number}", process::id()))
    };
    let mut folder = place();
    if files.len() == 0 {
        return work(&folder);
    }
    // A new one: others can write to the system's folder.
    while let Err(error) = plain::make_new_directory(&folder) {
        if error.kind() != io::ErrorKind::AlreadyExists {
            return Err(Failure::storage(&folder, &error));
        }
        folder = place();
    }
    let done = write_all(&folder, files).and_then(|()| work(&folder));
    // What can't be removed is in the way of nobody.
    let _ = fs::remove_dir_all(&folder);
    done
}

/// All that an experiment is made of, so that another process can make it again.
#[derive(Clone, Debug, PartialEq)]
pub struct Portable {
    /// Its file, with every value written out.
    pub toml: String,
    /// The files that it names, each with its content.
    pub files: Vec<(String, Vec<u8>)>,
}

/// Names of the experiments that ship with a single robot each.
///
/// # Errors
/// Exit 1 for a file that is no TOML.
pub fn examples_of_single_robots() -> Result<Vec<&'static str>> {
    let mut names = Vec::new();
    for example in EXAMPLES.iter().filter(|example| !example.is_sweep()) {
        let text = String::from_utf8_lossy(example.files[0].1);
        let values: toml::Table = text.parse().map_err(Failure::failed)?;
        let robot = values.get("robot").and_then(toml::Value::as_table);
        if !values.contains_key("swarm") && robot.is_none_or(|robot| !robot.contains_key("count")) {
            names.push(example.name);
        }
    }
    Ok(names)
}

impl Experiment {
    /// Reads an experiment's file, with `KEY=VALUE` settings that override it, as `--set` does.
    ///
    /// # Errors
    /// Exit 3: the file and the line and column in it (or the setting), the key, the value found, and the values allowed.
    pub fn load(path: &Path, set: &[String]) -> Result<Self> {
        Ok(Self::of(runs::read(path, set)?))
    }

    pub(super) fn of(any: Arc<dyn runs::Experiment>) -> Self {
        let worlds = OnceLock::new();
        Self(Arc::new(Known { any, worlds }))
    }

    /// All that it is made of.
    pub fn portable(&self) -> Portable {
        let inputs = self.0.any.inputs().iter();
        Portable {
            toml: self.to_toml(),
            files: inputs
                .map(|input| (input.name.clone(), input.content.bytes.clone()))
                .collect(),
        }
    }

    /// Writes it to a file, with every value written out, and the files that it names beside it. Files that are there and have the same
    /// content stay, so that experiments that share files share a folder.
    ///
    /// # Errors
    /// Exit 3 if a file with another content is there: then nothing is written. Exit 6 if something can't be read or written.
    pub fn save(&self, path: &Path) -> Result {
        let Portable { toml, files } = self.portable();
        let folder = path.parent().unwrap_or(Path::new(""));
        let name = path.file_name().map(|name| name.to_string_lossy());
        let Some(name) = name else {
            let problem = format!(
                "{}: names no file; allowed: a path that ends with a name",
                path.display()
            );
            return Err(Error::input(problem));
        };
        let files = files.iter().map(|(name, bytes)| (name.as_str(), &bytes[..]));
        let mut missing = Vec::new();
        for (name, bytes) in files.chain([(&*name, toml.as_bytes())]) {
            let path = folder.join(name);
            match plain::read(&path, u64::MAX) {
                Ok(there) if there == bytes => (),
                Ok(_) => {
                    let problem = "has another content; allowed: a new file, or another folder";
                    return Err(Error::input(format_args!("{}: {problem}", path.display())));
                }
                Err(error) if error.kind() == io::ErrorKind::NotFound => missing.push((name, bytes)),
                Err(error) => return Err(Failure::storage(&path, &error).into()),
            }
        }
        Ok(write_all(folder, missing.into_iter())?)
    }

    /// Its arena; the first one if it varies.
    ///
    /// # Errors
    /// Exit 3 for the foraging study.
    pub fn arena(&self) -> Result<Arena> {
        let arena = &self.world()?.variants()[0].spec().arena;
        let field = &arena.field;
        let patch = |patch: &Patch| {
            let [length, width] = patch.sides.unwrap_or_default();
            let radius = patch.radius.unwrap_or(0.0);
            [patch.x, patch.y, radius, length, width, patch.heading, patch.grey]
        };
        Ok(Arena {
            field: [field.x, field.y, field.width, field.height],
            walls: arena
                .walls
                .iter()
                .map(|wall| [wall.from[0], wall.from[1], wall.to[0], wall.to[1]])
                .collect(),
            circles: arena
                .obstacles
                .iter()
                .map(|circle| [circle.x, circle.y, circle.radius])
                .collect(),
            blocks: arena
                .blocks
                .iter()
                .map(|block| [block.x, block.y, block.length, block.width, block.heading])
                .collect(),
            patches: arena.patches.iter().map(patch).collect(),
            lights: arena
                .lights
                .iter()
                .map(|light| [light.x, light.y, light.height.unwrap_or(0.0)])
                .collect(),
        })
    }

    /// Makes it again, with `KEY=VALUE` settings that override its values.
    ///
    /// # Errors
    /// As [`Experiment::load`]; exit 6 if its files can't be written to the system's folder for temporary files, where they are for
    /// as long as this takes.
    pub fn from_portable(portable: &Portable, set: &[String]) -> Result<Self> {
        Self::made(portable, |_| Setting::all_typed(set))
    }

    /// The same experiment with its values of tests.
    ///
    /// # Errors
    /// Exit 3 if it has none.
    pub fn tested_in(&self) -> Result<Self> {
        let problem = "is the foraging study; allowed: experiments with a table [test]";
        let single = self.0.any.single().ok_or_else(|| Error::input(problem))?;
        let toml = single.tested_in()?.values().to_string();
        Self::from_portable(
            &Portable {
                toml,
                ..self.portable()
            },
            &[],
        )
    }

    /// Makes it again, with settings that are given the folder where its files are.
    fn made(portable: &Portable, set: impl FnOnce(&Path) -> exit::Result<Vec<Setting>>) -> Result<Self> {
        let files = portable.files.iter().map(|(name, bytes)| (name.as_str(), &bytes[..]));
        Ok(Self::of(with_files(files, |folder| {
            let values = Parsed::new("the experiment".into(), &portable.toml)?.recorded();
            let path = folder.join("experiment.toml");
            runs::of(&path, &values, &set(folder)?, &Files::default(), None)
        })?))
    }

    /// An experiment that ships with Oneiro, by its name, such as `khepera-avoidance`, with `KEY=VALUE` settings that override its
    /// values.
    ///
    /// # Errors
    /// As [`Experiment::from_portable`]; exit 3 if there is none with this name.
    pub fn example(name: &str, set: &[String]) -> Result<Self> {
        let found = examples::named("example", name, |example| !example.is_sweep())?;
        let made = with_files(found.files.iter().copied(), |folder| {
            runs::read(&folder.join(found.files[0].0), set)
        });
        Ok(Self::of(made?))
    }

    /// The experiment of a run whose only generation is these genomes, one after the other, as `oneiro adopt` makes it: each is a
    /// finalist with so many episodes.
    ///
    /// # Errors
    /// Exit 3 for swarms of the foraging study, for other numbers of genes, genomes or episodes, and for genes that aren't allowed.
    pub fn adopting(&self, genomes: &[f32], episodes: u32) -> Result<Self> {
        let genes = self.world()?.genes();
        let count = genomes.len() / genes;
        if count * genes != genomes.len() || !(1..=adopt::MOST).contains(&count) {
            return Err(Error::input(format_args!(
                "genomes: are {} genes; allowed: 1 to {} genomes of {genes} each",
                genomes.len(),
                adopt::MOST
            )));
        }
        if !(2..=10_000).contains(&episodes) {
            return Err(Error::input(format_args!("trials: is {episodes}; allowed: 2 to 10000")));
        }
        let mut portable = self.portable();
        let mut name = "genomes.npy".to_owned();
        while portable.files.iter().any(|(other, _)| *other == name) {
            name.insert(0, '_');
        }
        portable.files.push((name.clone(), npy(&[count, genes], genomes)));
        Self::made(&portable, |folder| {
            let evolution = adopt::evolution(Path::new(&name), count, episodes);
            Ok(vec![Setting::typed(&evolution)?.in_folder(folder)])
        })
    }

    /// Its name.
    pub fn name(&self) -> &str {
        self.0.any.name()
    }

    /// The seed in its file, if any.
    pub fn seed(&self) -> Option<u64> {
        self.0.any.seed()
    }

    /// Warnings about its files and values.
    pub fn warnings(&self) -> &[String] {
        self.0.any.warnings()
    }

    pub(crate) fn any(&self) -> &Arc<dyn runs::Experiment> {
        &self.0.any
    }

    /// Its values, if it has single robots.
    pub(super) fn single(&self) -> exit::Result<&experiment::Experiment> {
        self.0.any.single().ok_or_else(|| {
            Failure::input(format_args!(
                "{}: is of the foraging study; allowed: experiments without a table `swarm`",
                self.name()
            ))
        })
    }

    pub(super) fn world(&self) -> exit::Result<&World> {
        Ok(self.single()?.world())
    }

    /// Its world, packed.
    pub(super) fn worlds(&self) -> exit::Result<&Worlds> {
        let world = self.world()?;
        if let Some(worlds) = self.0.worlds.get() {
            return Ok(worlds);
        }
        let worlds = Worlds::new(std::slice::from_ref(world))?;
        Ok(self.0.worlds.get_or_init(|| worlds))
    }

    /// Name of each gene.
    ///
    /// # Errors
    /// Exit 3 for swarms.
    pub fn gene_names(&self) -> Result<Vec<String>> {
        Ok(self.world()?.gene_layout().names())
    }

    /// The place of each gene among the names of a table's columns, which are in any order and in upper or lower case, and what there is
    /// to say of other columns.
    ///
    /// # Errors
    /// Exit 3 for swarms, and for names that lack a gene.
    pub fn gene_columns(&self, names: &[&str]) -> Result<(Vec<usize>, Option<String>)> {
        let layout = columns::Layout::named(names, &self.gene_names()?);
        let layout = layout.map_err(|problem| Error::input(format_args!("genomes: {problem}")))?;
        Ok((layout.columns, layout.word.map(|word| format!("genomes: {word}"))))
    }

    /// Minimum and maximum of each gene: its own range, or else `evolution.limits`, or else that of all genes.
    ///
    /// # Errors
    /// Exit 3 for swarms.
    pub fn bounds(&self) -> Result<Vec<[f32; 2]>> {
        let single = self.single()?;
        let limits = single
            .settings()
            .evolution
            .limits
            .map(|limits| limits.map(|limit| limit as f32));
        let all = limits.unwrap_or([-GREATEST_GENE, GREATEST_GENE]);
        let ranges = single.world().gene_layout().ranges();
        Ok(ranges.into_iter().map(|range| range.unwrap_or(all)).collect())
    }

    /// Hash of everything that decides its results, except the seed.
    pub fn hash(&self) -> String {
        self.0.any.identities().of(0).to_hex().to_string()
    }

    /// It as TOML with every default written out. Files have the names that a run's directory gives them.
    pub fn to_toml(&self) -> String {
        match self.seed() {
            Some(seed) => self.0.any.resolved_toml(seed),
            None => self.0.any.resolved_toml(0).replacen("\nseed = 0\n", "\n", 1),
        }
    }

    /// Its values as JSON by the keys that settings have, such as `{"evolution.population": 100}`.
    ///
    /// # Errors
    /// Exit 1 if JSON can't express them.
    pub fn settings(&self) -> Result<String> {
        fn flatten(prefix: &str, table: toml::Table, flat: &mut toml::Table) {
            for (key, value) in table {
                match value {
                    toml::Value::Table(inner) => flatten(&format!("{prefix}{key}."), inner, flat),
                    value => drop(flat.insert(format!("{prefix}{key}"), value)),
                }
            }
        }
        let mut flat = toml::Table::new();
        flatten("", self.to_toml().parse().map_err(Failure::failed)?, &mut flat);
        Ok(serde_json::to_string(&flat).map_err(Failure::failed)?)
    }

    /// Maximum number of cycles of an episode.
    ///
    /// # Errors
    /// Exit 3 for swarms.
    pub fn cycles(&self) -> Result<u32> {
        Ok(self.world()?.cycles())
    }

    /// Episodes of each individual in its evolution.
    ///
    /// # Errors
    /// Exit 3 for swarms.
    pub fn trials(&self) -> Result<u32> {
        Ok(self.single()?.settings().trials)
    }

    /// Names of the measures of its episodes, as `oneiro evaluate --measures` has them.
    ///
    /// # Errors
    /// Exit 3 for swarms.
    pub fn descriptor_names(&self) -> Result<Vec<String>> {
        let all = descriptors(self.world()?).into_iter();
        Ok(all.map(|own| own.column.name.into_owned()).collect())
    }

    /// Columns of its episodes' traces, without that of the cycle.
    ///
    /// # Errors
    /// Exit 3 for swarms.
    pub fn trace_columns(&self) -> Result<Vec<TraceColumn>> {
        Ok(TraceTable::new(self.world()?).scalars())
    }
}

/// The elites of an evolution, in the order of their cells' numbers.
#[derive(Clone, Debug, Default)]
pub struct Elites {
    /// Numbers of their cells.
    pub cells: Vec<u32>,
    /// The fitness by which each is compared.
    pub fitness: Vec<f64>,
    /// The behaviour of each, as many numbers as [`Evolution::descriptor_names`] has.
    pub behaviour: Vec<f64>,
    /// Genomes, one after the other.
    pub genomes: Vec<f32>,
    /// The fraction of cells that have one.
    pub coverage: f64,
    /// The sum of what their fitness is above `evolution.archive.offset`.
    pub quality: f64,
}

/// An evolution that is asked for genomes and told their fitness.
#[derive(Debug)]
pub struct Evolution {
    experiment: Experiment,
    own: evolve::Evolution,
}

impl Evolution {
    /// Begins the evolution of a run with a seed, by the experiment's optimiser.
    ///
    /// # Errors
    /// Exit 3 for swarms, and for a seed above 2^63 - 1.
    pub fn new(experiment: &Experiment, seed: u64) -> Result<Self> {
        check_seed(seed)?;
        Ok(Self {
            own: experiment.single()?.evolution(seed),
            experiment: experiment.clone(),
        })
    }

    /// Name of its optimiser.
    pub fn kind(&self) -> &'static str {
        self.own.optimizer().name()
    }

    /// Number of the generation that is to be evaluated next, from 0.
    pub fn generation(&self) -> u32 {
        self.own.generation()
    }

    /// Whether all of the experiment's generations have been evaluated.
    pub fn is_finished(&self) -> bool {
        self.own.is_finished()
    }

    /// Genes of a genome, and the genomes to evaluate next, one after the other.
    pub fn ask(&self) -> (usize, &[f32]) {
        let population = self.own.ask();
        (population.genes(), population.values())
    }

    /// The generation and the number of each genome, from which a run makes its random numbers.
    ///
    /// # Errors
    /// None: experiments of swarms have no evolution.
    pub fn keys(&self) -> Result<Vec<[u64; 2]>> {
        let evolution = &self.experiment.single()?.settings().evolution;
        let generation = evolution.draw(self.own.generation());
        let numbers = 0..self.own.ask().len() as u32;
        let key = |number| [generation, evolution.lot(number)].map(u64::from);
        Ok(numbers.map(key).collect())
    }

    /// Names of the measures by which the optimiser describes behaviour; empty if it does not.
    ///
    /// # Errors
    /// None: experiments of swarms have no evolution.
    pub fn descriptor_names(&self) -> Result<Vec<String>> {
        let evolution = &self.experiment.single()?.settings().evolution;
        let names = evolution.descriptors.iter().map(|own| own.measure.clone());
        Ok(names.take(self.own.optimizer().descriptors()).collect())
    }

    /// Takes the fitness of the genomes: of each genome as many episodes as are given, combined as `trial_score` says; and what
    /// describes the behaviour of each genome: for each of as many episodes as are given, as many numbers as
    /// [`Evolution::descriptor_names`] has. Their means over the episodes count.
    ///
    /// # Errors
    /// Exit 3 for another number of either; then nothing has changed. Exit 1 if all generations have been evaluated.
    pub fn tell(&mut self, fitness: &[f32], behaviour: &[f64]) -> Result {
        if self.own.is_finished() {
            return Err(Failure::failed(format_args!(
                "all {} generations have been evaluated; allowed: a higher evolution.generations",
                self.own.generation()
            )))?;
        }
        let genomes = self.own.ask().len();
        let lives = fitness.len() / genomes;
        if lives == 0 || lives * genomes != fitness.len() {
            return Err(refused(
                "fitness",
                format_args!("has {} values for {genomes} genomes", fitness.len()),
            ))?;
        }
        let described = self.own.optimizer().descriptors();
        let all = described * genomes;
        let fits = if all == 0 {
            behaviour.is_empty()
        } else {
            !behaviour.is_empty() && behaviour.len().is_multiple_of(all)
        };
        if !fits {
            let problem = format_args!("descriptors: have {} values for {genomes} genomes", behaviour.len());
            return Err(Failure::input(format_args!(
                "{problem}; allowed: {described} for each episode of each genome"
            )))?;
        }
        let of_individuals = behaviour.chunks_exact((behaviour.len() / genomes).max(1));
        let behaviour: Vec<f64> = of_individuals.flat_map(|lives| means(lives, described)).collect();
        let kind = self.experiment.single()?.settings().trial_score;
        let scores = fitness.chunks_exact(lives).map(|lives| score(kind, lives));
        self.own.tell(scores.collect(), &behaviour)?;
        Ok(())
    }

    /// The luckiest so far: generation, individual, score and genes.
    pub fn luckiest(&self) -> Option<(u32, u32, f32, &[f32])> {
        let best = self.own.champion()?;
        Some((best.generation, best.individual, best.fitness, &best.genome))
    }

    /// Its elites, if its optimiser keeps some.
    ///
    /// # Errors
    /// None: experiments of swarms have no evolution.
    pub fn elites(&self) -> Result<Option<Elites>> {
        let offset = self.experiment.single()?.settings().evolution.tables.archive.offset;
        Ok(self.own.optimizer().archive().map(|archive| {
            let mut elites = Elites {
                coverage: archive.coverage(),
                quality: archive.quality(offset),
                ..Elites::default()
            };
            for (cell, elite) in archive.elites() {
                elites.cells.push(cell);
                elites.fitness.push(elite.fitness);
                elites.behaviour.extend(&elite.behaviour);
                elites.genomes.extend(&elite.genome);
            }
            elites
        }))
    }

    /// The genome around which a strategy samples, and its step size in halves of the genes' initial ranges.
    pub fn distribution(&self) -> Option<(Vec<f32>, f64)> {
        self.own.optimizer().distribution()
    }

    /// All that it needs to continue, sealed.
    pub fn state(&self) -> Vec<u8> {
        sealed::seal(STATE, VERSION, &self.owner(), &self.own.save())
    }

    fn owner(&self) -> blake3::Hash {
        self.experiment.any().identities().of(0)
    }

    /// Continues from a state.
    ///
    /// # Errors
    /// Exit 5 for one that is damaged, or of another optimiser, version or settings; then nothing has changed.
    pub fn restore(&mut self, state: &[u8]) -> Result {
        let saved: SavedEvolution = sealed::open(STATE, VERSION, &self.owner(), state)
            .map_err(|problem| Failure::corrupt(format_args!("the state of an evolution {problem}")))?;
        Ok(self.own.restore(saved)?)
    }

    /// Its experiment.
    pub fn experiment(&self) -> &Experiment {
        &self.experiment
    }
}

fn refused(what: &str, problem: impl Display) -> Failure {
    Failure::input(format_args!(
        "{what}: {problem}; allowed: the same number for each genome"
    ))
}

#[cfg(all(test, feature = "compose"))]
mod tests {
    use oneiro::parameter::Choice;

    use super::*;
    use crate::api::{Task, evaluate, recorded};
    use oneiro_base::npy;
    use oneiro_evolve::settings::Kind;

    const SEED: u64 = 3;
    const GENERATIONS: usize = 4;

    /// An experiment that ships, shortened, which evolves by this kind, and what else it takes.
    fn experiment(name: &str, kind: Kind, common: bool) -> Experiment {
        const CELLS: &str = "evolution.descriptors=[{measure=\"end_x_mm\",least=0,greatest=600,cells=60},\
                             {measure=\"mean_speed_mm_s\",least=0,greatest=80,cells=90}]";
        const RANGES: &str = "evolution.descriptors=[{measure=\"end_x_mm\",least=0,greatest=600},\
                              {measure=\"mean_speed_mm_s\",least=0,greatest=80}]";
        let avoidance = "khepera-avoidance.toml";
        let (file, own): (_, &[&str]) = match kind {
            Kind::Genetic => (avoidance, &["evolution.parents=4"]),
            Kind::MapElites => (avoidance, &[CELLS]),
            Kind::Novelty => (avoidance, &[RANGES, "evolution.parents=4"]),
            Kind::Grid => ("aggregation.toml", &["evolution.grid.levels=2"]),
            Kind::Race => ("automode-cues.toml", &["evolution.race.lives=400"]),
            Kind::Coevolution => (
                "predator-prey.toml",
                &[
                    "evolution.parents=4",
                    "evolution.opponents.contests=3",
                    "record.individuals=true",
                ],
            ),
            _ => (avoidance, &[]),
        };
        let mut set: Vec<String> = own.iter().map(|&own| own.to_owned()).collect();
        set.extend([
            format!("evolution.kind={name}"),
            "cycles=40".into(),
            "evolution.finalists=0".into(),
        ]);
        if kind != Kind::Race {
            let population = if kind == Kind::Grid { 4 } else { 12 };
            set.extend([
                format!("evolution.common_random_numbers={common}"),
                format!("evolution.population={population}"),
                "trials=3".into(),
            ]);
        }
        if !matches!(kind, Kind::Race | Kind::Grid) {
            set.push(format!("evolution.generations={GENERATIONS}"));
        }
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments").join(file);
        Experiment::load(&path, &set).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Genomes and scores of each generation of an evolution that is told what `evaluate` measures of it.
    fn told(experiment: &Experiment, as_in_run: bool) -> Vec<(Vec<f32>, Vec<f32>)> {
        let single = experiment.single().unwrap();
        let lives = single.settings().trials as usize;
        let mut evolution = Evolution::new(experiment, SEED).unwrap();
        let names = evolution.descriptor_names().unwrap();
        let mut generations = Vec::new();
        while !evolution.is_finished() {
            let genomes = evolution.ask().1.to_vec();
            let request = evaluate::Request {
                genomes: &genomes,
                seed: SEED,
                numbers: Some(&evolution.keys().unwrap()),
                lives,
                common_starts: false,
                backend: "cpu",
                descriptors: &names,
                as_in_run,
                traces: false,
            };
            let outcome = evaluate::evaluate(experiment, &request, &Task::default()).unwrap();
            evolution.tell(&outcome.fitness, &outcome.descriptors).unwrap();
            let kind = single.settings().trial_score;
            let scores = outcome.fitness.chunks_exact(lives).map(|lives| score(kind, lives));
            generations.push((genomes, scores.collect()));
        }
        generations
    }

    fn bits<'a>(numbers: impl IntoIterator<Item = &'a f32>) -> Vec<u32> {
        numbers.into_iter().map(|number| number.to_bits()).collect()
    }

    /// Every kind of evolution that is told what `evaluate` says has the run's genomes and scores in all generations.
    #[test]
    fn told_evolutions_are_runs() {
        let folder = std::env::temp_dir().join(format!("oneiro-told-{}", process::id()));
        let mut compared = 0;
        for (name, kind, _) in Kind::CHOICES {
            for common in [false, true] {
                let experiment = experiment(name, *kind, common);
                let told = told(&experiment, true);
                assert!(told.len() >= 3, "{name}: {} generations", told.len());
                let out = folder.join(format!("{name}-{common}"));
                recorded::run(&experiment, SEED, &out, "cpu", &Task::default()).unwrap();
                let recorded = |file: &str| {
                    let bytes = fs::read(out.join(file)).ok()?;
                    let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
                    Some(npy::floats(&bytes[header..]))
                };
                let (genomes, scores) = told.last().unwrap();
                let place = format!("{name}, common numbers: {common}");
                assert!(bits(genomes) == bits(&recorded("population.npy").unwrap()), "{place}");
                assert!(bits(scores) == bits(&recorded("fitness.npy").unwrap()), "{place}");
                if let Some(recorded) = recorded("individuals.npy") {
                    let genes = genomes.len() / scores.len();
                    let row = |(genome, score): (&[f32], &f32)| [genome, &[*score]].concat();
                    let rows = told
                        .iter()
                        .flat_map(|(genomes, scores)| genomes.chunks_exact(genes).zip(scores).map(row));
                    assert!(bits(&rows.flatten().collect::<Vec<_>>()) == bits(&recorded), "{place}");
                    compared += 1;
                }
                if *kind == Kind::MapElites {
                    // Control: measured as `oneiro evaluate --measures` does, it is another evolution.
                    assert!(told != self::told(&experiment, false), "{place}");
                }
            }
        }
        assert!(compared >= 2 * (Kind::CHOICES.len() - 1), "{compared}");
        fs::remove_dir_all(&folder).unwrap();
    }
}
