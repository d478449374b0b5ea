//! `oneiro replay`: a champion's life again.

use std::fs;

use oneiro::batch::{Batch, Rollout, TraceRequest};
use oneiro::evaluator::Control;
use serde_json::json;

use super::swarm;
use crate::cli::Replay;
use crate::console::{Console, decimal};
use crate::device;
use crate::exit::{Failure, Result};
use crate::record::{SavedRun, is_swarm_run, trace_csv, write_whole};
use crate::report::figures;
use crate::run::{keys, score};

/// Lives the champion's lives again, compares its score with the recorded one, and writes one life's path and trace.
pub(crate) fn run(arguments: &Replay, console: Console) -> Result {
    if is_swarm_run(&arguments.run_dir) {
        return swarm::replay(arguments, console);
    }
    let run = SavedRun::open(&arguments.run_dir)?;
    let champion = run.champion()?;
    let experiment = run.experiment();
    let settings = experiment.settings();
    if arguments.trial >= settings.trials {
        return Err(Failure::input(format_args!(
            "--trial {}: no such life; allowed: 0 to {}",
            arguments.trial,
            settings.trials - 1
        )));
    }
    let mut evaluator = device::open(&arguments.backend)?;
    let control = Control::new();
    let worlds = std::slice::from_ref(experiment.world());
    let rollouts: Vec<Rollout<'_>> = keys(run.seed(), champion.generation, champion.individual, settings.trials)
        .map(|key| Rollout {
            world: 0,
            genes: &champion.genome,
            key,
        })
        .collect();
    let lives = evaluator.evaluate(&Batch::new(worlds, &rollouts, None)?, &control)?;
    let own = score(settings.trial_score, &lives.fitness);
    let (bits, recorded) = (own.to_bits(), champion.fitness.to_bits());
    if bits != recorded {
        return Err(Failure::failed(format_args!(
            "{}: the champion's recorded fitness is {} (bits {recorded:08x}), but {own} (bits {bits:08x}) on {}",
            run.directory().display(),
            champion.fitness,
            device::name(evaluator.as_ref())
        )));
    }

    let shown = rollouts[arguments.trial as usize];
    let every = arguments.every.min(experiment.world().cycles());
    let traced = Batch::new(worlds, &[shown], Some(TraceRequest { every }))?;
    let trace = evaluator
        .evaluate(&traced, &control)?
        .traces
        .into_iter()
        .next()
        .unwrap_or_default();
    device::tell_warnings(evaluator.as_ref(), console);
    let life = lives.fitness[arguments.trial as usize];
    let title = format!(
        "{}, seed {}: generation {}, fitness {life:.1}",
        experiment.name(),
        run.seed(),
        champion.generation
    );
    let spec = experiment.world().spec();
    let picture = figures::life(&spec.arena, spec.robot.body_radius, &title, &trace, every);

    let directory = arguments.out.as_deref().unwrap_or(run.directory());
    fs::create_dir_all(directory).map_err(|error| Failure::unreadable(directory, &error))?;
    let (path, table) = (directory.join("replay.svg"), directory.join("replay.csv"));
    write_whole(&path, picture.as_bytes())?;
    write_whole(&table, trace_csv(&trace, every).as_bytes())?;
    let collisions = trace.iter().filter(|record| record.collided > 0.0).count();
    if console.json() {
        return console.json_data(&json!({
            "generation": champion.generation,
            "individual": champion.individual,
            "fitness": decimal(champion.fitness),
            "bits": format!("{bits:08x}"),
            "collisions": collisions,
            "path": path.display().to_string(),
            "trace": table.display().to_string(),
            "device": device::name(evaluator.as_ref()),
        }));
    }
    console.data(format!(
        "generation {}, individual {}: fitness {} (bits {bits:08x}), as recorded\n{}\n{}",
        champion.generation,
        champion.individual,
        champion.fitness,
        path.display(),
        table.display()
    ))
}
