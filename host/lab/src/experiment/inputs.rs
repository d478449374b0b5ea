//! Files that an experiment names: found, read, and hashed, so that a run can keep copies.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::{iter, thread};

use oneiro::arena::Arena;
use oneiro::backend::{self, Options};
use oneiro::compose::{Kind, OwnPart, Part};
use oneiro::parameter::Invalid;
use oneiro::picture::{self, Picture};
use oneiro::tables::{self, MotorStates, MotorTable, SensorTables};
use oneiro::tasks::Ready;
use oneiro::world::{GeneLayout, WorldSpec};
use oneiro_base::console::counted;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_evolve as evolve;
use oneiro_evolve::{Population, settings as evolution};

use super::champions;
use super::kinds::{CHAMPION_GENES, is_run};
use super::settings::{BUILT_IN, FROM_REALITY, PartFile, SensorFiles, Settings, surrogate};
use super::source::Source;
use crate::engine::handle::Engine;
use crate::genomes;
use crate::pixels;
use crate::reality::Object;
use crate::reality::sampling::{self, Samples};
use crate::reality::site::{SEVERITY, Site};

/// Directory of a run's copies.
pub const DIRECTORY: &str = "inputs";

/// A file that an experiment names.
#[derive(Clone, Debug)]
pub struct Input {
    /// Name in the experiment.
    pub named: String,
    /// Name in a run's directory.
    pub name: String,
    pub content: Arc<Content>,
}

/// Content of a file.
#[derive(Debug)]
pub struct Content {
    pub bytes: Vec<u8>,
    /// BLAKE3 hash of the content, in hex.
    pub hash: String,
}

impl Content {
    fn new(bytes: Vec<u8>) -> Arc<Self> {
        let hash = blake3::hash(&bytes).to_hex().to_string();
        Arc::new(Self { bytes, hash })
    }
}

/// Files that experiments name, each read only once.
#[derive(Debug, Default)]
pub struct Files {
    contents: Mutex<BTreeMap<PathBuf, Arc<Content>>>,
    sensors: Mutex<BTreeMap<Vec<PathBuf>, Tables<SensorTables>>>,
    motors: Mutex<BTreeMap<(PathBuf, MotorStates), Tables<MotorTable>>>,
    parts: Mutex<BTreeMap<(Kind, PathBuf), Arc<Part>>>,
    pictures: Mutex<BTreeMap<Lying, Picture>>,
    /// Samples of surrogates, by surrogate and by classes of objects.
    samples: Mutex<BTreeMap<Sampling, Arc<OnceLock<Taken>>>>,
    /// Their tables as files, by the names in [`made`].
    made: Mutex<BTreeMap<String, Arc<Content>>>,
    /// The same files, by whether a setting or the experiment names them, and by their names there.
    named: Mutex<BTreeMap<(bool, String), Arc<Content>>>,
}

impl Files {
    /// Files whose contents are known, by their paths: they are not read.
    pub fn given(files: Vec<(PathBuf, Vec<u8>)>) -> Self {
        let contents = files.into_iter().map(|(path, bytes)| (path, Content::new(bytes)));
        Self {
            contents: Mutex::new(contents.collect()),
            ..Self::default()
        }
    }

    /// Files that settings named so far, or those that experiments did.
    pub fn named(&self, by_settings: bool) -> Vec<(String, Arc<Content>)> {
        let named = self.named.lock().unwrap_or_else(PoisonError::into_inner);
        let chosen = named.iter().filter(|((by, _), _)| *by == by_settings);
        chosen
            .map(|((_, name), content)| (name.clone(), Arc::clone(content)))
            .collect()
    }
}

/// Tables, and warnings about their files.
#[derive(Debug)]
struct Tables<T> {
    tables: Arc<T>,
    warnings: Vec<String>,
}

impl<T> Clone for Tables<T> {
    fn clone(&self) -> Self {
        Self {
            tables: Arc::clone(&self.tables),
            warnings: self.warnings.clone(),
        }
    }
}

/// Returns the known value of a key, or finds it out and remembers it.
fn known<K: Ord, V: Clone, E>(
    known: &Mutex<BTreeMap<K, V>>,
    key: K,
    find: impl FnOnce(&K) -> std::result::Result<V, E>,
) -> std::result::Result<V, E> {
    let mut known = known.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(value) = known.get(&key) {
        return Ok(value.clone());
    }
    let value = find(&key)?;
    known.insert(key, value.clone());
    Ok(value)
}

/// Key of a picture on a floor: its file, the numbers of cells, and the bits of its place and its sides.
type Lying = (PathBuf, [u32; 2], [u32; 4]);
/// Key of samples: the hash of a surrogate, and whether blocks are also sampled.
type Sampling = ([u8; 32], bool);
/// Samples, or the reason why there are none.
type Taken = std::result::Result<Arc<Samples>, String>;

/// Reader of the files that an experiment names.
pub(super) struct Inputs<'a> {
    /// Directory of the experiment.
    directory: &'a Path,
    source: &'a Source<'a>,
    /// Hashes given in the experiment.
    hashes: &'a BTreeMap<String, String>,
    files: &'a Files,
    /// The robot of `[reality]`, if there is one, and whether the arena has blocks.
    reality: Option<Site>,
    has_blocks: bool,
    found: Vec<Input>,
    warnings: Vec<String>,
}

impl<'a> Inputs<'a> {
    pub(super) fn new(
        directory: &'a Path,
        source: &'a Source<'a>,
        settings: &Settings,
        hashes: &'a BTreeMap<String, String>,
        files: &'a Files,
    ) -> Self {
        let preset = settings.arena.preset.as_deref().and_then(Arena::named);
        Self {
            directory,
            source,
            hashes,
            files,
            reality: settings.reality.site().ok().flatten(),
            has_blocks: !preset.as_ref().unwrap_or(&settings.world.arena).blocks.is_empty(),
            found: Vec::new(),
            warnings: Vec::new(),
        }
    }

    /// Reads the sensor tables.
    pub(super) fn sensors(&mut self, files: &SensorFiles) -> Result<Arc<SensorTables>> {
        let files = match files {
            SensorFiles::BuiltIn => return Ok(SensorTables::khepera()),
            SensorFiles::FromReality => return Ok(Arc::clone(&self.of_reality("robot.tables")?.sensors)),
            SensorFiles::Surrogate(seed) => {
                let samples = self.samples("robot.tables", &Site::drawn(*seed, SEVERITY))?;
                for table in &samples.sensors.classes {
                    self.make("robot.tables", &made(*seed, &table.class), || table.text())?;
                }
                return Ok(Arc::clone(&samples.sensors));
            }
            SensorFiles::Files(files) => files,
        };
        if files.is_empty() {
            return Err(self
                .source
                .invalid("robot.tables", "is empty; allowed: a file for each class of object"));
        }
        let paths = files
            .iter()
            .enumerate()
            .map(|(index, file)| Ok(self.take(&format!("robot.tables[{index}]"), file)?.0))
            .collect::<Result<Vec<_>>>()?;
        let read = |paths: &Vec<PathBuf>| {
            SensorTables::read(paths).map(|import| Tables {
                tables: Arc::new(import.table),
                warnings: import.warnings,
            })
        };
        let found = known(&self.files.sensors, paths, read).map_err(|error| self.refused("robot.tables", error))?;
        self.warnings.extend(found.warnings);
        Ok(found.tables)
    }

    /// Reads the motor table.
    pub(super) fn motors(&mut self, file: &str, states: MotorStates) -> Result<Arc<MotorTable>> {
        if file == BUILT_IN {
            return Ok(MotorTable::khepera(states));
        }
        if file == FROM_REALITY {
            let samples = self.of_reality("robot.motors")?;
            return Ok(motor_table(&samples, states));
        }
        if let Some(seed) = surrogate(file) {
            let samples = self.samples("robot.motors", &Site::drawn(seed, SEVERITY))?;
            self.make("robot.motors", &made(seed, MOTORS), || samples.motors.text())?;
            return Ok(motor_table(&samples, states));
        }
        let (path, _) = self.take("robot.motors", file)?;
        let read = |(path, _): &(PathBuf, _)| {
            MotorTable::read(path, states).map(|table| Tables {
                tables: Arc::new(table),
                warnings: Vec::new(),
            })
        };
        let found =
            known(&self.files.motors, (path, states), read).map_err(|error| self.refused("robot.motors", error))?;
        Ok(found.tables)
    }

    /// Samples of the surrogate of `[reality]`.
    fn of_reality(&self, key: &str) -> Result<Arc<Samples>> {
        let Some(site) = self.reality.as_ref().filter(|site| !site.is_wired()) else {
            let problem = "is \"reality\"; allowed: only with a surrogate as reality.robot; `oneiro robot sample` samples a connected robot";
            return Err(self.source.invalid(key, problem));
        };
        self.samples(key, site)
    }

    /// Samples of a surrogate, always taken on the CPU, since no device has been chosen yet. Every exact device would give the same.
    fn samples(&self, key: &str, site: &Site) -> Result<Arc<Samples>> {
        let sampling = (*site.hash().as_bytes(), self.has_blocks);
        let none = |_: &Sampling| Ok::<_, Failure>(Arc::default());
        // Not under the lock, so that several cells of a sweep can be sampled at once.
        let own: Arc<OnceLock<Taken>> = known(&self.files.samples, sampling, none)?;
        // On a separate thread: one of a pool's would do other cells' work while it waits, and might come to wait for itself. A browser has
        // neither.
        let has_blocks = self.has_blocks;
        let sample = || take(site, has_blocks);
        let sampled = || {
            if cfg!(target_family = "wasm") {
                Ok(sample())
            } else {
                thread::scope(|scope| scope.spawn(sample).join())
            }
        };
        let taken = own.get_or_init(|| match sampled() {
            Ok(samples) => samples.map(Arc::new).map_err(|failure| failure.to_string()),
            Err(panic) => std::panic::resume_unwind(panic),
        });
        taken.clone().map_err(|problem| self.source.invalid(key, problem))
    }

    /// Reads a custom part, or makes a task that is ready.
    pub(super) fn part(&mut self, kind: Kind, file: &PartFile, ready: Option<&Ready>) -> Result<Arc<OwnPart>> {
        let word = kind.word();
        let part = match (ready, &file.part) {
            (Some(ready), _) => Arc::new(ready.part()?),
            (None, None) => {
                let problem = format!("lacks `part`; allowed: the file of the {word}, .wgsl");
                return Err(self.source.invalid(word, problem));
            }
            (None, Some(name)) => {
                let (path, content) = self.take(&format!("{word}.part"), name)?;
                let read = |(kind, path): &(Kind, PathBuf)| {
                    let text = files::as_written(path, content.bytes.clone())?;
                    let part = Part::new(*kind, &path.display().to_string(), &text);
                    part.map(Arc::new).map_err(Failure::input)
                };
                known(&self.files.parts, (kind, path), read)?
            }
        };
        let values: Vec<_> = file
            .values
            .iter()
            .map(|(name, value)| (name.as_str(), *value))
            .collect();
        let own = OwnPart::new(part, &values);
        own.map(Arc::new)
            .map_err(|invalid| self.source.invalid(&invalid.field, &invalid.problem))
    }

    /// Reads the picture on the floor as cells, given its lower left corner and its sides, mm.
    pub(super) fn picture(&mut self, file: &str, [low, sides]: [[f32; 2]; 2], cells: [u32; 2]) -> Result<Picture> {
        const KEY: &str = "arena.picture.file";
        let (path, content) = self.take(KEY, file)?;
        let name = path.display().to_string();
        let read = |_: &_| {
            let pixels = pixels::read(&content.bytes).map_err(|problem| Invalid {
                field: KEY.to_owned(),
                problem: format!("{name} {problem}"),
            })?;
            let greys = picture::averaged(&pixels.greys, [pixels.width, pixels.height], cells);
            Picture::new(low, sides, cells, greys)
        };
        let key = (path, cells, [low[0], low[1], sides[0], sides[1]].map(f32::to_bits));
        let found = known(&self.files.pictures, key, read);
        found.map_err(|invalid| self.source.invalid(&invalid.field, &invalid.problem))
    }

    /// Reads the genomes that an evolution begins with.
    pub(super) fn init(&mut self, evolution: &evolution::Settings, layout: &GeneLayout) -> Result<Option<Population>> {
        const KEY: &str = "evolution.init";
        let Some(file) = &evolution.init else {
            return Ok(None);
        };
        let (path, content) = self.take_genomes(KEY, file, layout)?;
        let say = |word| self.warnings.push(format!("{KEY}: {word}"));
        let genomes = genomes::parse(&path, &content.bytes, layout, say);
        let genomes = genomes.map_err(|failure| self.source.invalid(KEY, failure))?;
        let most = evolve::most_given(evolution, layout.all());
        if let Some(most) = most.filter(|most| genomes.len() > *most) {
            let by = match evolution.kind {
                evolution::Kind::Race => "the candidates of the first race",
                _ => "evolution.population",
            };
            let problem = format!(
                "{} holds {}; allowed: 1 to {most}, {by}",
                path.display(),
                counted(genomes.len(), "genome", "genomes")
            );
            return Err(self.source.invalid(KEY, problem));
        }
        let limits = match evolution.kind {
            // It samples within the initial range.
            evolution::Kind::Race => Some((evolution.initial, ", evolution.initial")),
            _ => evolution.limits.map(|limits| (limits, ", evolution.limits")),
        };
        let limits = limits.filter(|_| !self.source.is_recorded());
        for (index, genome) in genomes.genomes().enumerate() {
            for (gene, &value) in layout.all().iter().zip(genome) {
                let (range, by) = match (gene.range, limits) {
                    (Some(range), _) => (range.map(f64::from), ""),
                    (None, Some(limits)) => limits,
                    (None, None) => continue,
                };
                // Limits are compared as genes are kept within them.
                let [least, greatest] = range.map(|limit| limit as f32);
                if !(least..=greatest).contains(&value) {
                    let (path, name) = (path.display(), &gene.name);
                    let problem =
                        format!("{path}: {name} of genome {index} is {value}; allowed: {least} to {greatest}{by}");
                    return Err(self.source.invalid(KEY, problem));
                }
            }
        }
        Ok(Some(genomes))
    }

    /// Adds a file of genomes, or the champion of a run's directory as one. Returns the path that messages show, and its content.
    fn take_genomes(&mut self, key: &str, file: &str, layout: &GeneLayout) -> Result<(PathBuf, Arc<Content>)> {
        let path = self.path_of(key, file);
        // A run's configuration names only its copies, which are files.
        if self.source.is_recorded() || !path.is_dir() {
            self.check_order(key, &path, layout)?;
            return self.take(key, file);
        }
        let read = |path: &PathBuf| champions::read(path).map(Content::new);
        let content =
            known(&self.files.contents, path.clone(), read).map_err(|failure| self.source.invalid(key, failure))?;
        let copy = Path::new(file).join(champions::COPY);
        self.note_named(key, &copy.to_string_lossy(), &content);
        let name = path.canonicalize().unwrap_or_else(|_| path.clone());
        let name = name.file_name().unwrap_or_default().to_string_lossy().into_owned() + ".json";
        self.add(key, file, Path::new(&name), &content)?;
        Ok((path.join(CHAMPION_GENES).with_extension("json"), content))
    }

    /// Refuses a run's `.npy` file, which names no genes, if the genes of that run are others or in another order.
    fn check_order(&self, key: &str, path: &Path, layout: &GeneLayout) -> Result {
        let folder = path.parent().filter(|folder| is_run(folder));
        let is_npy = path.extension().is_some_and(|own| own.eq_ignore_ascii_case("npy"));
        let Some(folder) = folder.filter(|_| is_npy && !self.source.is_recorded()) else {
            return Ok(());
        };
        // Another program's config.toml says nothing about the file.
        let Ok(of_run) = champions::layout(folder) else {
            return Ok(());
        };
        let order = genomes::check_names(path, &of_run, layout).map_err(|failure| self.source.invalid(key, failure))?;
        if order.iter().copied().eq(0..layout.genes()) {
            return Ok(());
        }
        let problem = format!(
            "{} names no genes, and its run has them in another order; allowed: the run's directory {} for its champion, or a .csv file \
             with the names of the genes",
            path.display(),
            folder.display()
        );
        Err(self.source.invalid(key, problem))
    }

    /// Returns the files read, and warnings about them.
    pub(super) fn finish(self) -> Result<(Vec<Input>, Vec<String>)> {
        // A setting may name another file, or a kind without one.
        let is_needed =
            |file: &&String| !self.source.is_overridden() && !self.found.iter().any(|input| input.named == **file);
        if let Some(file) = self.hashes.keys().find(is_needed) {
            let problem = "is a file that no other key names; allowed: hashes of the files that are named";
            return Err(self.source.invalid(&format!("files.{file}"), problem));
        }
        Ok((self.found, self.warnings))
    }

    /// Adds a file, checks its hash if one is given, and returns its path and content.
    fn take(&mut self, key: &str, file: &str) -> Result<(PathBuf, Arc<Content>)> {
        let path = self.path_of(key, file);
        let read = |path: &PathBuf| files::bytes(path).map(Content::new);
        let content =
            known(&self.files.contents, path.clone(), read).map_err(|failure| self.source.invalid(key, failure))?;
        self.note_named(key, file, &content);
        self.add(key, file, &path, &content)?;
        Ok((path, content))
    }

    /// The path of a file that a key names.
    fn path_of(&self, key: &str, file: &str) -> PathBuf {
        self.source.folder_of(key).unwrap_or(self.directory).join(file)
    }

    /// Notes a file for the copies of a sweep.
    fn note_named(&self, key: &str, file: &str, content: &Arc<Content>) {
        let by_settings = self.source.folder_of(key).is_some();
        let mut named = self.files.named.lock().unwrap_or_else(PoisonError::into_inner);
        named.insert((by_settings, file.into()), Arc::clone(content));
    }

    /// Adds a table that was sampled for this experiment, as if it were a file that `oneiro robot sample` wrote: runs keep it, and their
    /// hashes depend on its text.
    fn make(&mut self, key: &str, name: &str, text: impl FnOnce() -> String) -> Result {
        let content = known(&self.files.made, name.to_owned(), |_| {
            Ok::<_, Failure>(Content::new(text().into_bytes()))
        })?;
        self.add(key, name, Path::new(name), &content)
    }

    /// Adds a file, and checks its hash if one is given.
    fn add(&mut self, key: &str, file: &str, path: &Path, content: &Arc<Content>) -> Result {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let input = Input {
            named: file.into(),
            name: format!("{DIRECTORY}/{name}"),
            content: Arc::clone(content),
        };
        if let Some(expected) = self.hashes.get(file)
            && *expected != input.content.hash
        {
            let problem = format!(
                "{} has changed: its BLAKE3 hash is {}, not {expected}",
                path.display(),
                input.content.hash
            );
            return Err(self.source.invalid(key, problem));
        }
        if let Some(other) = self.found.iter().find(|other| other.name == input.name) {
            let problem = format!(
                "{file} and {} have one name; allowed: files of different names",
                other.named
            );
            return Err(self.source.invalid(key, problem));
        }
        self.found.push(input);
        Ok(())
    }

    fn refused(&self, key: &str, error: tables::Error) -> Failure {
        self.source.invalid(key, error)
    }
}

/// Name of a surrogate's motor table.
const MOTORS: &str = "motor";

/// Name of a table sampled from a surrogate.
fn made(seed: u64, table: &str) -> String {
    format!("surrogate:{seed}/{table}.sam")
}

fn motor_table(samples: &Samples, states: MotorStates) -> Arc<MotorTable> {
    Arc::new(MotorTable::new(&samples.motors, states).expect("all speeds were sampled"))
}

/// Samples a surrogate before all objects, on one thread.
fn take(site: &Site, has_blocks: bool) -> Result<Samples> {
    let cpu = backend::open(
        "cpu",
        Options {
            threads: Some(1),
            ..Options::default()
        },
    )?;
    let engine = Engine::new(cpu, Arc::new(AtomicBool::new(false)));
    let mut robot = site.sampled(&engine, &WorldSpec::miglino1995())?;
    let mut objects = Object::of_the_paper();
    objects.extend(Object::named("block").filter(|_| has_blocks));
    sampling::sample_unkept(&mut *robot, &objects)
}

/// Gives files the names that they have in a run's directory, and adds their hashes.
pub(super) fn rename(settings: &mut Settings, inputs: &[Input]) {
    let rename = |file: &mut String| {
        let made = surrogate(file).map(|seed| made(seed, MOTORS));
        if let Some(input) = inputs
            .iter()
            .find(|input| input.named == *made.as_ref().unwrap_or(file))
        {
            file.clone_from(&input.name);
        }
    };
    let robot = &mut settings.robot;
    for tables in iter::once(&mut robot.tables).chain(&mut robot.described.tables) {
        match tables {
            SensorFiles::BuiltIn | SensorFiles::FromReality => (),
            SensorFiles::Surrogate(seed) => {
                let (folder, motors) = (format!("surrogate:{seed}/"), made(*seed, MOTORS));
                let is_table = |input: &&Input| input.named.starts_with(&folder) && input.named != motors;
                let made = inputs.iter().filter(is_table).map(|input| input.name.clone());
                *tables = SensorFiles::Files(made.collect());
            }
            SensorFiles::Files(files) => files.iter_mut().for_each(rename),
        }
    }
    rename(&mut robot.motors);
    robot.described.motors.iter_mut().for_each(rename);
    for kind in [Kind::Sensor, Kind::Controller, Kind::Task] {
        settings.part_mut(kind).part.iter_mut().for_each(rename);
    }
    settings.arena.picture.file.iter_mut().for_each(rename);
    settings.evolution.init.iter_mut().for_each(rename);
    settings.files = inputs
        .iter()
        .map(|input| (input.name.clone(), input.content.hash.clone()))
        .collect();
}
