//! `oneiro export`: a controller as a file for another program or a robot.

use std::path::{Path, PathBuf};

use oneiro::export::Target;
use oneiro_base::answer::Answer;
use oneiro_base::console::{Console, counted};
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_evolve::Population;
use oneiro_lab::experiment::Experiment;
use oneiro_lab::exported::{self, Order};
use oneiro_lab::genomes;
use oneiro_lab::record::SingleRun;
use serde_json::json;

use super::list;
use super::places::{RUNS, named_or_newest, settings_typed};
use crate::cli::Export;

/// A controller's experiment and genome, and where both are from.
struct Subject {
    experiment: Experiment,
    genome: Vec<f32>,
    from: String,
    /// The hash of the results of the run whose champion it is.
    result: Option<String>,
    seed: u64,
}

/// Writes the controller, after it has acted in an episode with the simulator's bits.
pub(crate) fn run(arguments: &Export, console: Console) -> Result {
    let target = target(arguments.to.as_deref())?;
    let Subject {
        experiment,
        genome,
        from,
        result,
        seed,
    } = subject(arguments, console)?;
    let name = match &arguments.name {
        Some(name) => checked(name, target)?,
        None => exported::identifier(experiment.name(), target),
    };
    let out = exported::place("--out", arguments.out.as_deref(), &name, target)?;
    let exported = exported::export(&Order {
        experiment: &experiment,
        genome: &genome,
        from: &from,
        result: result.as_deref(),
        command: Some(&files::command()),
        set: &settings_typed(&arguments.set),
        number: arguments.number,
        target,
        also: exported::also("--with", &arguments.with, target)?,
        name: name.clone(),
        out: out.clone(),
        seed: arguments.seed.unwrap_or(seed),
        trial: arguments.trial,
        checks: arguments.checks as usize,
    })?;
    let controller = &exported.controller;
    let path = out.display().to_string();
    let value = json!({
        "file": path,
        "to": target.name,
        "name": name,
        "inputs": controller.inputs.iter().map(|input| &input.name).collect::<Vec<_>>(),
        "memory": controller.memory.len(),
        "genes": controller.genes.len(),
        "draws": controller.draws(),
        "with": arguments.with,
        "cycles": exported.cycles,
        "checked": exported.checked,
        "note": exported.note,
    });
    let bits = exported.note.clone().unwrap_or_else(|| {
        let cycles = counted(exported.cycles as u64, "cycle", "cycles");
        format!(
            "it has the simulator's bits in {cycles}, and {} of these with it",
            exported.checked
        )
    });
    let inputs = counted(controller.inputs.len() as u64, "input", "inputs");
    let answer = Answer {
        messages: vec![format!("wrote {path}: {inputs}; {bits}")],
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
    to.and_then(exported::target).ok_or_else(|| {
        let problem = match to {
            Some(to) => format!("{to}: is no target"),
            None => "names what to write, and is missing".to_owned(),
        };
        Failure::usage(format_args!("--to {problem}; allowed: {}", exported::targets()))
    })
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
            result: None,
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
    let result = if arguments.genome.is_none() {
        run.result()?
    } else {
        None
    };
    Ok(Subject {
        seed: run.seed(),
        experiment,
        genome,
        from,
        result,
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

/// A name for a target's file.
fn checked(name: &str, target: &Target) -> Result<String> {
    if exported::is_name(name, target) {
        return Ok(name.to_owned());
    }
    Err(Failure::usage(format_args!(
        "--name {name}: can't begin names in a file for {}; allowed: {}",
        target.name,
        exported::names(target)
    )))
}
