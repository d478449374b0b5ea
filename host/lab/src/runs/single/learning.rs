//! `oneiro replay --generations`: the bests of several generations on one page, each alone from the same start.

use oneiro::batch::{Batch, Rollout, TraceRequest};
use oneiro::parameter::Choice;
use oneiro_base::answer::Answer;
use oneiro_base::console::decimal;
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::plain;
use oneiro_report::figures;
use serde_json::json;

use super::individuals::Individuals;
use super::job::keys;
use super::{Recorded, Replay, Single, taken, together};
use crate::engine::handle::Engine;
use crate::lives::Keys;

/// The page.
pub(super) const LEARNING: &str = "learning.html";

/// Simulates an episode of each generation's best, all with the same start and random numbers, and writes the page that plays them. It
/// is the champion's recorded episode unless a seed is given.
pub(super) fn page(single: &Single, run: &Recorded<'_>, replay: &Replay<'_>, engine: &Engine) -> Result<Answer> {
    let experiment = &single.experiment;
    let settings = experiment.settings();
    if experiment.world().robots() > 1 {
        return Err(Failure::input(
            "--generations: is given, and the robots of a swarm share their world; allowed: runs of single robots",
        ));
    }
    let all = Individuals::read(run.directory, experiment)?;
    let bests = replay
        .generations
        .iter()
        .map(|generation| all.of_generation(*generation, None));
    let bests = bests.collect::<Result<Vec<_>>>()?;
    let worlds = bests.iter().map(|best| single.world_of(best.generation));
    let worlds = worlds.collect::<Result<Vec<_>>>()?;
    replay.check_trial(settings.trials)?;
    let trial = replay.trial as usize;
    let key = if let Some(seed) = replay.seed {
        Keys::of_seed(seed).of(0, trial)
    } else {
        let champion = super::champion(run, experiment)?;
        let mut recorded = keys(settings, run.seed, champion.generation, champion.individual);
        recorded.nth(trial).expect("it is one of its trials")
    };
    let rollouts: Vec<Rollout<'_>> = (0..)
        .zip(&bests)
        .map(|(world, best)| Rollout {
            world,
            genes: &best.genome,
            key,
        })
        .collect();
    let every = replay.every.min(experiment.world().cycles());
    let episodes = engine.evaluate(&Batch::new(&worlds, &rollouts, Some(TraceRequest { every }))?)?;

    if let Some((best, _)) = bests.iter().zip(&episodes.traces).find(|(_, trace)| trace.is_empty()) {
        return Err(Failure::input(format_args!(
            "--generations: the episode of generation {}'s best ends before its first cycle; allowed: other generations, or --seed N",
            best.generation
        )));
    }
    plain::make_directory(replay.out).map_err(|error| Failure::unreadable(replay.out, &error))?;
    let path = replay.out.join(LEARNING);
    let title = format!("{}, seed {}: how it learned", experiment.name(), run.seed);
    let shown = together::of_generations(&worlds[0], &bests, &episodes.traces, every, &title);
    disk::write(&path, figures::episode_page(&shown).as_bytes())?;
    let taken = taken::write(replay, &shown)?.map(|file| file.map(|file| file.display().to_string()));
    let rows = bests.iter().zip(&episodes.fitness).map(|(best, fitness)| {
        json!({
            "generation": best.generation,
            "individual": best.individual,
            "fitness": decimal(*fitness),
            "recorded": decimal(best.fitness),
        })
    });
    let rows: Vec<_> = rows.collect();
    let lines = bests.iter().zip(&episodes.fitness).map(|(best, fitness)| {
        let (generation, individual) = (best.generation, best.individual);
        let own = best.fitness;
        format!("generation {generation}, individual {individual}: fitness {fitness} here, {own} in its generation")
    });
    let [picture, film] = &taken;
    let files = [path.display().to_string()]
        .into_iter()
        .chain(taken.iter().flatten().cloned());
    let text = lines.chain(files).collect::<Vec<_>>().join("\n");
    let score = settings.trial_score.word();
    let value = json!({
        "generations": rows, "seed": replay.seed, "trial": replay.trial, "score": score, "page": path, "picture": picture, "film": film,
        "device": engine.name(),
    });
    Ok(Answer::new(text, value))
}
