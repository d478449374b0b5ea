//! `oneiro export`: a controller as a file for another program or a robot.

use std::path::{Path, PathBuf};

use oneiro::export::Target;
use oneiro::foraging::Light;
use oneiro::world::World;
use oneiro_base::answer::Answer;
use oneiro_base::console::{Console, counted};
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_evolve::Population;
use oneiro_lab::experiment::swarm::SwarmExperiment;
use oneiro_lab::experiment::{Experiment, Identities};
use oneiro_lab::exported::{self, Order};
use oneiro_lab::genomes;
use oneiro_lab::record::{SavedRun, SingleRun};
use oneiro_lab::runs;
use oneiro_lab::runs::swarm::acting::{self, Acting};
use serde_json::json;

use super::list;
use super::places::{RUNS, named_or_newest, settings_typed};
use crate::cli::Export;

/// A controller's experiment and genome, and where both are from.
struct Subject {
    experiment: String,
    identities: Identities,
    world: World,
    /// Whether `oneiro evaluate` takes the experiment.
    is_evaluated: bool,
    genome: Vec<f32>,
    from: String,
    /// The robot among those of the world.
    number: u32,
    /// The hash of the results of the run whose champion it is.
    result: Option<String>,
    seed: u64,
}

impl Subject {
    /// A genome of an experiment of single robots, or of a swarm's.
    fn of(experiment: &Experiment, genome: Vec<f32>, from: String, number: u32) -> Self {
        Self {
            experiment: experiment.name().to_owned(),
            identities: experiment.identities(),
            world: experiment.world().clone(),
            is_evaluated: true,
            genome,
            from,
            number,
            result: None,
            seed: experiment.settings().seed.unwrap_or(1),
        }
    }

    /// Behaviours of the foraging study, which are chosen in a simulator with the light there.
    fn of_study(study: &SwarmExperiment, light: Light) -> Result<Self> {
        Ok(Self {
            experiment: study.name().to_owned(),
            identities: study.identities(),
            world: acting::simulator(study, light)?,
            is_evaluated: false,
            genome: Vec::new(),
            from: String::new(),
            number: 0,
            result: None,
            seed: study.seed().unwrap_or(1),
        })
    }
}

/// Writes the controller, after it has acted in an episode with the simulator's bits.
pub(crate) fn run(arguments: &Export, console: Console) -> Result {
    let target = target(arguments.to.as_deref())?;
    let subject = subject(arguments, console)?;
    let name = match &arguments.name {
        Some(name) => checked(name, target)?,
        None => exported::identifier(&subject.experiment, target),
    };
    let out = exported::place("--out", arguments.out.as_deref(), &name, target)?;
    let set = settings_typed(&arguments.set);
    let exported = exported::export(&Order {
        experiment: &subject.experiment,
        identities: subject.identities,
        world: &subject.world,
        genome: &subject.genome,
        from: &subject.from,
        result: subject.result.as_deref(),
        command: Some(&files::command()),
        set: subject.is_evaluated.then_some(&set),
        number: subject.number,
        target,
        also: exported::also("--with", &arguments.with, target)?,
        name: name.clone(),
        out: out.clone(),
        seed: arguments.seed.unwrap_or(subject.seed),
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
    if let Some(path) = arguments.champion.as_ref().filter(is_experiment) {
        let Some(genome) = &arguments.genome else {
            return Err(Failure::usage(format_args!(
                "{}: is an experiment, which has no champion; allowed: with --genome FILE, or a run",
                path.display()
            )));
        };
        no_interval(arguments, "an experiment")?;
        return of_file(arguments, path, genome, console);
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
    let saved = SavedRun::open(&list::one(&directory)?)?;
    if let Some(file) = arguments.genome.as_ref().or(champion) {
        no_interval(arguments, "a genome's file")?;
        let subject = of_file(arguments, &saved.config(), file, console)?;
        let result = champion.filter(|_| arguments.genome.is_none()).map(|_| saved.done());
        return Ok(Subject {
            result: result.transpose()?.flatten().map(|done| done.result),
            ..subject
        });
    }
    let from = saved.directory().display();
    let result = saved.done()?.map(|done| done.result);
    let experiment = runs::read(&saved.config(), &arguments.set)?;
    if let Some(study) = experiment.swarm() {
        saved.finished()?;
        let acted = Acting::read(saved.directory(), arguments.number, arguments.interval)?;
        return Ok(Subject {
            genome: acted.genome().into(),
            from: format!(
                "{from}, robot {} in interval {}, fitness {}",
                acted.robot, acted.interval, acted.real
            ),
            result,
            ..Subject::of_study(study, acted.light())?
        });
    }
    no_interval(arguments, "a run that has a champion")?;
    let run = SingleRun::open(saved.directory())?;
    let experiment = Experiment::read(&run.config(), &arguments.set)?;
    let champion = run.champion()?.alone();
    let own = run.experiment()?.world().gene_layout();
    let champion = genomes::by_name(run.directory(), own, champion, experiment.world().gene_layout())?;
    let genome = only(run.directory(), &champion)?;
    Ok(Subject {
        result,
        ..Subject::of(&experiment, genome, from.to_string(), arguments.number)
    })
}

/// A file's only genome, for the experiment in another file.
fn of_file(arguments: &Export, path: &Path, genome: &Path, console: Console) -> Result<Subject> {
    let experiment = runs::read(path, &arguments.set)?;
    let read = |world: &World| -> Result<Vec<f32>> {
        only(
            genome,
            &genomes::read(genome, world.gene_layout(), |word| console.say(word))?,
        )
    };
    let from = genome.display().to_string();
    if let Some(study) = experiment.swarm() {
        if arguments.number != 0 {
            let problem = "--number: names the robot of a run; allowed here: 0, as there is one genome";
            return Err(Failure::input(problem));
        }
        let subject = Subject::of_study(study, Light::OverNest)?;
        let genome = read(&subject.world)?;
        return Ok(Subject {
            genome,
            from,
            ..subject
        });
    }
    let experiment = Experiment::read(path, &arguments.set)?;
    let genome = read(experiment.world())?;
    Ok(Subject::of(&experiment, genome, from, arguments.number))
}

/// Refuses an interval where there are none.
fn no_interval(arguments: &Export, of: &str) -> Result {
    if arguments.interval.is_none() {
        return Ok(());
    }
    let problem = format_args!("--interval: is given for {of}; allowed: with runs of the foraging study");
    Err(Failure::usage(problem))
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
