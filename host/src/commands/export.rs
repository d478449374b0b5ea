//! `oneiro export`: a controller as a file for another program or a robot.

use std::path::{Path, PathBuf};

use oneiro::cpu::Cpu;
use oneiro::export::{Controller, Form, Recorded, TARGETS, Target};
use oneiro_base::answer::Answer;
use oneiro_base::console::{Console, counted};
use oneiro_base::exit::{Failure, Result};
use oneiro_base::{files, plain};
use oneiro_evolve::Population;
use oneiro_lab::experiment::Experiment;
use oneiro_lab::genomes;
use oneiro_lab::lives::Keys;
use oneiro_lab::record::SingleRun;
use serde_json::json;

use super::list;
use super::places::{RUNS, named_or_newest, settings_typed};
use crate::cli::Export;

/// A name's most characters.
const LONGEST: usize = 40;

/// A controller's experiment and genome, and where both are from.
struct Subject {
    experiment: Experiment,
    genome: Vec<f32>,
    from: String,
    seed: u64,
}

/// Writes the controller, after it has acted in an episode with the simulator's bits.
pub(crate) fn run(arguments: &Export, console: Console) -> Result {
    let target = target(arguments.to.as_deref())?;
    let Subject {
        experiment,
        genome,
        from,
        seed,
    } = subject(arguments, console)?;
    let name = match &arguments.name {
        Some(name) => checked(name)?,
        None => identifier(experiment.name()),
    };
    let out = out(arguments.out.as_deref(), &name, target)?;
    let seed = arguments.seed.unwrap_or(seed);
    let key = Keys::of_seed(seed).of(0, arguments.trial as usize);
    let refused = |problem: &dyn std::fmt::Display| Failure::input(format_args!("{from}: {problem}"));
    let world = experiment.world();
    let controller = Controller::new(world, &genome, arguments.number).map_err(|invalid| refused(&invalid))?;
    let mut cpu = Cpu::new(Some(1)).map_err(|error| refused(&error))?;
    let cycles = controller.record(&mut cpu, key).map_err(|error| refused(&error))?;
    if cycles.is_empty() {
        return Err(refused(
            &"its episode ends before its first cycle; allowed: another --seed or --trial",
        ));
    }
    let identity = experiment.identities().of(seed).to_hex();
    let bytes: Vec<u8> = genome.iter().flat_map(|gene| gene.to_le_bytes()).collect();
    let set = settings_typed(&arguments.set);
    let origin = [
        format!(
            "Experiment: {} (with seed {seed}: {})",
            experiment.name(),
            &identity[..16]
        ),
        format!(
            "Genome: {from} (its {} genes: {})",
            genome.len(),
            &blake3::hash(&bytes).to_hex()[..16]
        ),
        format!(
            "Cycles to check it by: oneiro evaluate{set} --seed {seed} --traces DIR, trial {}{}",
            arguments.trial,
            if world.robots() > 1 {
                format!(", robot {}", arguments.number)
            } else {
                String::new()
            }
        ),
    ];
    let chosen = spread(&cycles, arguments.checks as usize);
    let texts = match target.form {
        Form::File(_, print) => vec![(out.clone(), print(&controller, &name, &origin, &chosen))],
        Form::Folder(print) => {
            let files = print(&controller, &name, &origin, &chosen).into_iter();
            files.map(|(file, text)| (out.join(file), text)).collect()
        }
    };
    write(&texts)?;
    let path = out.display().to_string();
    let value = json!({
        "file": path,
        "to": target.name,
        "name": name,
        "inputs": controller.inputs.iter().map(|input| &input.name).collect::<Vec<_>>(),
        "memory": controller.memory.len(),
        "genes": controller.genes.len(),
        "draws": controller.draws(),
        "cycles": cycles.len(),
        "checked": chosen.len(),
    });
    let answer = Answer {
        messages: vec![format!(
            "wrote {path}: {}; it has the simulator's bits in {}, and {} of these with it",
            counted(controller.inputs.len() as u64, "input", "inputs"),
            counted(cycles.len() as u64, "cycle", "cycles"),
            chosen.len()
        )],
        ..Answer::new(String::new(), value)
    };
    console.print_answer(&answer)?;
    if target.name == "c" {
        console.next(format!("gcc -std=c99 -Wall -fsyntax-only {}", files::for_shell(&path)));
    }
    Ok(())
}

/// The named target.
fn target(to: Option<&str>) -> Result<&'static Target> {
    TARGETS.iter().find(|target| Some(target.name) == to).ok_or_else(|| {
        let allowed: Vec<_> = TARGETS
            .iter()
            .map(|target| format!("{} ({})", target.name, target.about))
            .collect();
        let problem = match to {
            Some(to) => format!("{to}: is no target"),
            None => "names what to write, and is missing".to_owned(),
        };
        Failure::usage(format_args!("--to {problem}; allowed: {}", allowed.join("; ")))
    })
}

/// Where to write.
fn out(out: Option<&Path>, name: &str, target: &Target) -> Result<PathBuf> {
    let Form::File(extensions, _) = target.form else {
        let out = out.unwrap_or(Path::new(name));
        files::must_not_be_file(out)?;
        return Ok(out.to_owned());
    };
    let out = out.map_or_else(|| PathBuf::from(name).with_extension(extensions[0]), Path::to_owned);
    let is_of_target = |ending: &&str| out.extension().is_some_and(|extension| extension == *ending);
    if !extensions.iter().any(is_of_target) {
        files::must_end_in("--out", &out, extensions[0], target.about)?;
    }
    Ok(out)
}

/// Writes files, none of which is there with other bytes.
fn write(texts: &[(PathBuf, String)]) -> Result {
    let is_new = |(path, text): &&(PathBuf, String)| !files::is_already(path, text.as_bytes());
    for (path, _) in texts.iter().filter(is_new) {
        files::must_not_exist(path)?;
    }
    for (path, text) in texts {
        if let [_, _, ..] = texts {
            let folder = path.parent().unwrap_or(path);
            plain::make_directory(folder).map_err(|error| files::uncreated(folder, &error))?;
        }
        files::write_new(path, text.as_bytes())?;
    }
    Ok(())
}

/// The named controller.
fn subject(arguments: &Export, console: Console) -> Result<Subject> {
    let is_experiment = |path: &&PathBuf| path.extension().is_some_and(|extension| extension == "toml");
    let read = |path: &Path, experiment: &Experiment| -> Result<Vec<f32>> {
        let all = genomes::read(path, experiment.world().gene_layout(), |word| console.say(word))?;
        only(path, &all)
    };
    if let Some(path) = arguments.champion.as_ref().filter(is_experiment) {
        let Some(genome) = &arguments.genome else {
            return Err(Failure::usage(format_args!(
                "{}: is an experiment, which has no champion; allowed: with --genome FILE, or a run",
                path.display()
            )));
        };
        let experiment = Experiment::read(path, &arguments.set)?;
        return Ok(Subject {
            genome: read(genome, &experiment)?,
            from: genome.display().to_string(),
            experiment,
            seed: 1,
        });
    }
    // A run's champion.json is a file in its directory.
    let champion = arguments.champion.as_ref().filter(|path| path.is_file());
    let directory = match champion {
        Some(file) => file
            .parent()
            .filter(|parent| !parent.as_os_str().is_empty())
            .unwrap_or(Path::new("."))
            .to_owned(),
        None => named_or_newest(arguments.champion.as_deref(), &[RUNS], console)?,
    };
    let run = SingleRun::open(&list::one(&directory)?)?;
    let experiment = Experiment::read(&run.config(), &arguments.set)?;
    let (genome, from) = if let Some(file) = arguments.genome.as_ref().or(champion) {
        (read(file, &experiment)?, file.display().to_string())
    } else {
        let champion = run.champion()?.alone();
        let path = run.directory();
        let own = run.experiment()?.world().gene_layout();
        let champion = genomes::by_name(path, own, champion, experiment.world().gene_layout())?;
        (only(path, &champion)?, path.display().to_string())
    };
    Ok(Subject {
        seed: run.seed(),
        experiment,
        genome,
        from,
    })
}

/// The only genome of a file.
fn only(path: &Path, all: &Population) -> Result<Vec<f32>> {
    if all.len() == 1 {
        return Ok(all.values().to_vec());
    }
    Err(Failure::input(format_args!(
        "{}: has {} genomes; allowed: a file with one",
        path.display(),
        all.len()
    )))
}

/// A name in C.
fn checked(name: &str) -> Result<String> {
    let is_name = name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && name.len() <= LONGEST;
    if is_name {
        return Ok(name.to_owned());
    }
    Err(Failure::usage(format_args!(
        "--name {name}: is no name in C; allowed: up to {LONGEST} letters, digits and _, a letter first"
    )))
}

/// A name in C that is like an experiment's.
fn identifier(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let name: String = name.chars().map(plain).take(LONGEST - 1).collect();
    if name.starts_with(|c: char| c.is_ascii_alphabetic()) {
        name
    } else {
        format!("c{name}")
    }
}

/// As many cycles, evenly over the episode, the first and the last among them.
fn spread(cycles: &[Recorded], count: usize) -> Vec<Recorded> {
    let count = count.min(cycles.len());
    let last = cycles.len().saturating_sub(1);
    let at = |index: usize| index * last / count.saturating_sub(1).max(1);
    (0..count).map(|index| cycles[at(index)].clone()).collect()
}
