//! Controllers as files for other programs and robots.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use oneiro::compose::Kind;
use oneiro::cpu::Cpu;
use oneiro::export::{Also, Controller, Form, Recorded, TARGETS, Target};
use oneiro::parameter::Invalid;
use oneiro::world::World;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::{files, plain};

use crate::OF_WORLD;
use crate::experiment::Identities;
use crate::lives::Keys;

/// Most characters of a name.
pub const LONGEST: usize = 40;

/// What is exported, and how.
pub struct Order<'a> {
    /// The name of its experiment, and the hashes of everything that decides the experiment's results.
    pub experiment: &'a str,
    pub identities: Identities,
    pub world: &'a World,
    /// One genome of the world, and where it is from.
    pub genome: &'a [f32],
    pub from: &'a str,
    /// The hash of the results of the run whose champion it is.
    pub result: Option<&'a str>,
    /// The command that exports it.
    pub command: Option<&'a str>,
    /// Options of `oneiro evaluate` that make the same experiment, if it takes the experiment.
    pub set: Option<&'a str>,
    /// The robot of a swarm.
    pub number: u32,
    pub target: &'static Target,
    /// The part of its world that is printed with it, and by which option or argument.
    pub also: Option<(Also, &'static str)>,
    /// What the names in the file begin with.
    pub name: String,
    pub out: PathBuf,
    /// The seed and the trial of the episode that its checks are from, and their number.
    pub seed: u64,
    pub trial: u32,
    pub checks: usize,
}

/// What was exported.
pub struct Exported {
    pub controller: Controller,
    /// Cycles of the episode in which it had the simulator's bits, and how many of these its file checks.
    pub cycles: usize,
    pub checked: usize,
    /// How near the file is to the simulator, if it hasn't its bits.
    pub note: Option<String>,
}

/// The target of this name.
pub fn target(name: &str) -> Option<&'static Target> {
    TARGETS.iter().find(|target| target.name == name)
}

/// All targets, for messages.
pub fn targets() -> String {
    let all: Vec<_> = TARGETS
        .iter()
        .map(|target| format!("{} ({})", target.name, target.about))
        .collect();
    all.join("; ")
}

/// The part of its world that is printed with a controller, by words that were given as `label`.
pub fn also(label: &'static str, words: &[String], target: &Target) -> Result<Option<(Also, &'static str)>> {
    if let Some(other) = words.iter().find(|word| !OF_WORLD.contains(&word.as_str())) {
        let problem = format_args!("{label}: has {other:?}; allowed: {}", OF_WORLD.join(", "));
        return Err(Failure::input(problem));
    }
    if words.is_empty() {
        return Ok(None);
    }
    if !target.has_world() {
        let can: Vec<_> = TARGETS
            .iter()
            .filter(|target| target.has_world())
            .map(|target| target.name)
            .collect();
        let problem = format_args!("{label}: is not for {}; allowed for: {}", target.name, can.join(", "));
        return Err(Failure::input(problem));
    }
    let has = |word: &str| words.iter().any(|own| own == word);
    let also = Also {
        sensors: has("sensors"),
        task: has("task"),
    };
    Ok(Some((also, label)))
}

/// Whether names in a target's file can begin with a name.
pub fn is_name(name: &str, target: &Target) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && name.len() <= LONGEST
        && !target.is_reserved(name)
}

/// The names that are allowed, for messages.
pub fn names(target: &Target) -> String {
    let letters = target.letters();
    format!("up to {LONGEST} {letters}, a letter first, and no word of the language or its library")
}

/// A name for a target's file that is like an experiment's.
pub fn identifier(name: &str, target: &Target) -> String {
    let name = plain_name(name);
    if is_name(&name, target) {
        return name;
    }
    let parts: Vec<_> = name.split('_').filter(|part| !part.is_empty()).collect();
    let shorter: String = parts.join("_").to_lowercase().chars().take(LONGEST - 11).collect();
    shorter.trim_end_matches('_').to_owned() + "_controller"
}

fn plain_name(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let name: String = name.chars().map(plain).take(LONGEST - 1).collect();
    if name.starts_with(|c: char| c.is_ascii_alphabetic()) {
        name
    } else {
        format!("c{name}")
    }
}

/// Where to write a target: what was given as `label`, or a file or folder by its name.
pub fn place(label: &str, out: Option<&Path>, name: &str, target: &Target) -> Result<PathBuf> {
    let extensions = match target.form {
        Form::File(extensions, _) | Form::Fitting(extensions, _) => extensions,
        Form::Folder(end, _) => {
            let out = out.map_or_else(|| PathBuf::from(format!("{name}{end}")), Path::to_owned);
            files::must_not_be_file(&out)?;
            return Ok(out);
        }
    };
    let out = out.map_or_else(|| PathBuf::from(name).with_extension(extensions[0]), Path::to_owned);
    let is_of_target = |ending: &&str| out.extension().is_some_and(|extension| extension == *ending);
    if !extensions.iter().any(is_of_target) {
        files::must_end_in(label, &out, extensions[0], target.about)?;
    }
    Ok(out)
}

/// Writes the controller, after it has acted in an episode with the simulator's bits.
pub fn export(order: &Order<'_>) -> Result<Exported> {
    let Order {
        genome,
        from,
        result,
        set,
        number,
        target,
        also,
        seed,
        trial,
        ..
    } = *order;
    let refused = |problem: &dyn std::fmt::Display| Failure::input(format_args!("{from}: {problem}"));
    let key = Keys::of_seed(seed).of(0, trial as usize);
    // Starts and values may vary from trial to trial.
    let world = &order.world.variants()[order.world.variant(key)];
    if number >= world.robots() {
        let allowed = match world.robots() {
            1 => "0, as there is one robot".to_owned(),
            robots => format!("0 to {}", robots - 1),
        };
        let problem = format_args!("--number: is {number}; allowed: {allowed}");
        return Err(Failure::input(problem));
    }
    let mut controller = Controller::new(world, genome, number).map_err(|invalid| refused(&invalid))?;
    let mut cpu = Cpu::new(Some(1)).map_err(|error| refused(&error))?;
    if let Some((also, label)) = also {
        let own = world.spec().own.get(Kind::Controller);
        if let Some(end) = own.and_then(|own| own.part().end_function()) {
            let problem = format_args!(
                "{label}: is given, and the controller of {from} has `{end}`, while a written world ends by itself; allowed: the controller alone"
            );
            return Err(Failure::input(problem));
        }
        let refused =
            |invalid: Invalid| Failure::input(format_args!("{label}: the world of {from} {}", invalid.problem));
        controller = controller.with_world(also, key).map_err(refused)?;
    }
    let cycles = controller.record(&mut cpu, key).map_err(|error| refused(&error))?;
    if cycles.is_empty() {
        return Err(refused(
            &"its episode ends before its first cycle; allowed: another seed or trial",
        ));
    }
    let identity = order.identities.of(seed).to_hex();
    let bytes: Vec<u8> = genome.iter().flat_map(|gene| gene.to_le_bytes()).collect();
    let robot = match number {
        0 if world.robots() == 1 => String::new(),
        0 => ", robot 0".to_owned(),
        other => format!(", of robot {other} (the traces have robot 0)"),
    };
    let of_run = result.map_or_else(String::new, |result| {
        let whose = if set.is_some() { "the champion of" } else { "of" };
        format!(", {whose} the run with the result {}", &result[..16])
    });
    let mut origin = vec![
        format!(
            "Experiment: {} (with seed {seed}: {})",
            order.experiment,
            &identity[..16]
        ),
        format!(
            "Genome: {from} (its {} genes: {}){of_run}",
            genome.len(),
            &blake3::hash(&bytes).to_hex()[..16]
        ),
    ];
    origin.push(match set {
        Some(set) => {
            format!("Cycles to check it by: oneiro evaluate{set} --seed {seed} --traces DIR, trial {trial}{robot}")
        }
        None => format!("Cycles to check it by: a simulated episode of one robot, seed {seed}, trial {trial}"),
    });
    let worlds = order.world.variants().len();
    if worlds > 1 {
        let number = order.world.variant(key);
        origin.push(format!(
            "World: number {number} of {worlds} (from 0), as all numbers and starts here are those of that trial"
        ));
    }
    origin.extend(order.command.map(|command| format!("Made by: {command}")));
    // A target with other bits doesn't check them, but may say how near it comes in the whole episode.
    let checked = if target.is_exact {
        chosen(&controller, &cycles, order.checks)
    } else {
        cycles.clone()
    };
    let (name, out) = (order.name.as_str(), &order.out);
    let mut note = None;
    let texts = match target.form {
        Form::File(_, print) => vec![(out.clone(), print(&controller, name, &origin, &checked).into_bytes())],
        Form::Fitting(_, print) => {
            let printed = print(&controller, name, &origin, &checked).map_err(|invalid| refused(&invalid))?;
            note = printed.note;
            vec![(out.clone(), printed.bytes)]
        }
        Form::Folder(_, print) => {
            let files = print(&controller, name, &origin, &checked).into_iter();
            files.map(|(file, text)| (out.join(file), text.into_bytes())).collect()
        }
    };
    write(&texts)?;
    Ok(Exported {
        controller,
        cycles: cycles.len(),
        checked: if target.is_exact { checked.len() } else { 0 },
        note,
    })
}

/// Writes files, none of which is there with other bytes.
fn write(texts: &[(PathBuf, Vec<u8>)]) -> Result {
    let is_new = |(path, text): &&(PathBuf, Vec<u8>)| !files::is_already(path, text);
    for (path, _) in texts.iter().filter(is_new) {
        files::must_not_exist(path)?;
    }
    for (path, text) in texts {
        if let [_, _, ..] = texts {
            let folder = path.parent().unwrap_or(path);
            plain::make_directory(folder).map_err(|error| files::uncreated(folder, &error))?;
        }
        files::write_new(path, text)?;
    }
    Ok(())
}

/// As many cycles in their order: half of them evenly over the episode, the first and the last among them, and the others evenly over those
/// that fused products would change, as far as there are any.
fn chosen(controller: &Controller, cycles: &[Recorded], count: usize) -> Vec<Recorded> {
    let count = count.min(cycles.len());
    let showing: Vec<usize> = (0..cycles.len())
        .filter(|at| controller.shows_fusing(&cycles[*at]))
        .collect();
    let mut places: BTreeSet<usize> = spread(cycles.len(), count.div_ceil(2)).collect();
    places.extend(spread(showing.len(), count / 2).map(|at| showing[at]));
    // Where both have chosen the same.
    let mut more = spread(cycles.len(), count).chain(0..cycles.len());
    while places.len() < count {
        places.extend(more.next());
    }
    places.into_iter().map(|at| cycles[at].clone()).collect()
}

/// As many of so many places, evenly, the first and the last among them.
fn spread(all: usize, count: usize) -> impl Iterator<Item = usize> {
    let (count, last) = (count.min(all), all.saturating_sub(1));
    (0..count).map(move |index| index * last / count.saturating_sub(1).max(1))
}
