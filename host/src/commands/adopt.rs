//! `oneiro adopt`: genomes that others evolved become a run of one generation.

use std::path::Path;

use oneiro_base::console::Console;
use oneiro_base::exit::{Failure, Result};
use oneiro_lab::experiment::Experiment;
use oneiro_lab::genomes;
use oneiro_lab::record::SingleRun;
use serde_json::json;

use super::run as evolve;
use crate::cli;

/// The genome of a run's directory.
const CHAMPION: &str = "champion.json";
/// Most genomes of a run: each is a finalist.
pub(crate) const MOST: usize = 10_000;

/// The setting that makes an experiment's only generation of a file's genomes, each of which is a finalist. It is the whole table,
/// since what another optimiser needs is not for this one.
pub(crate) fn evolution(genomes: &Path, count: usize, episodes: u32) -> String {
    format!(
        "evolution={{kind=\"genetic\",init={},population={count},parents={count},generations=1,finalists={count},finalist_lives={episodes}}}",
        json!(genomes)
    )
}

/// Runs the experiment with the given genomes as its only generation, each of which is a finalist.
pub(crate) fn run(arguments: cli::Adopt, console: Console) -> Result {
    let of_evolution = |set: &&String| set.trim_start().starts_with("evolution");
    if let Some(set) = arguments.set.iter().find(of_evolution) {
        return Err(Failure::input(format_args!(
            "--set {set}: has no effect, as the given genomes are the only generation; allowed: keys of episodes, and --trials"
        )));
    }
    let count = count(&arguments)?;
    let episodes = arguments.trials.unwrap_or(cli::Adopt::EPISODES);
    let evolution = evolution(&arguments.genomes, count, episodes);
    evolve::run(
        &cli::Run {
            experiment: arguments.experiment,
            seed: arguments.seed,
            seeds: None,
            backend: arguments.backend,
            set: arguments.set.into_iter().chain([evolution]).collect(),
            out: arguments.out,
            beside: cli::Beside::default(),
        },
        console,
    )
}

/// The number of given genomes.
fn count(arguments: &cli::Adopt) -> Result<usize> {
    let mut path = arguments.genomes.clone();
    if path.is_dir() {
        // A run that has a champion.
        SingleRun::open(&path)?;
        path.push(CHAMPION);
    }
    let experiment = Experiment::read(&arguments.experiment, &arguments.set)?;
    // The run tells what is to be said of the file.
    let count = genomes::read(&path, experiment.world().gene_layout(), drop)?.len();
    if count > MOST {
        return Err(Failure::input(format_args!(
            "{}: has {count} genomes; allowed: 1 to {MOST}",
            path.display()
        )));
    }
    Ok(count)
}
