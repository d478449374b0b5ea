//! `oneiro replay --generations`: the bests of several generations on one page, each from the same start: single robots in one arena, one swarm
//! after another.

use oneiro::batch::{Batch, Rollout, TraceRequest};
use oneiro::parameter::Choice;
use oneiro_base::answer::Answer;
use oneiro_base::console::decimal;
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::plain;
use oneiro_evolve::Champion;
use oneiro_report::figures;
use serde_json::json;

use super::job::keys;
use super::together::{self, Watched};
use super::{Recorded, Replay, Single, taken};
use crate::engine::handle::Engine;
use crate::lives::Keys;

/// The page.
pub(super) const LEARNING: &str = "learning.html";

/// Simulates an episode of each generation's best, all with the same start and random numbers, and writes the page that plays them. It
/// is the champion's recorded episode unless a seed is given.
pub(super) fn page(single: &Single, run: &Recorded<'_>, replay: &Replay<'_>, engine: &Engine) -> Result<Answer> {
    let experiment = &single.experiment;
    let settings = experiment.settings();
    let all = super::replay::individuals(run, experiment, "--generations")?;
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
    let title = format!("{}, seed {}: how it learned", experiment.name(), run.seed);
    let is_swarm = experiment.world().robots() > 1;
    let every = replay.every.min(experiment.world().cycles());
    let trace = (!is_swarm).then_some(TraceRequest { every });
    let episodes = engine.evaluate(&Batch::new(&worlds, &rollouts, trace)?)?;
    let refused = |best: &Champion, why: &str| {
        Failure::input(format_args!(
            "--generations: there is no page of generation {}'s best: {why}; allowed: other generations, or --seed N",
            best.generation
        ))
    };
    let watched: Vec<Watched>;
    let shown = if is_swarm {
        if replay.picture.is_some() || replay.film.is_some() {
            return Err(Failure::input(
                "--generations: the swarms of several generations are on one page, and not in one picture or film; allowed: --generation N",
            ));
        }
        let watch = |((best, life), fitness): ((&Champion, &Rollout<'_>), &f32)| {
            let world = &worlds[life.world];
            let watched = together::watch(world, life, every, *fitness, bests.len(), engine)?;
            watched.map_err(|why| refused(best, &why))
        };
        let all = bests.iter().zip(&rollouts).zip(&episodes.fitness).map(watch);
        watched = all.collect::<Result<_>>()?;
        together::of_swarms(&bests, &watched, &title)
    } else {
        if let Some((best, _)) = bests.iter().zip(&episodes.traces).find(|(_, trace)| trace.is_empty()) {
            return Err(refused(best, together::NO_CYCLE));
        }
        together::of_bests(&worlds[0], &bests, &episodes.traces, every, &title)
    };
    plain::make_directory(replay.out).map_err(|error| Failure::unreadable(replay.out, &error))?;
    let path = replay.out.join(LEARNING);
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
