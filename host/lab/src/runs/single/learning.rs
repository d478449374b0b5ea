//! `oneiro replay --generations`: the bests of several generations on one page, each from the same start: single robots in one arena, one swarm
//! after another.

use oneiro::parameter::Choice;
use oneiro_base::answer::Answer;
use oneiro_base::console::decimal;
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::plain;
use oneiro_report::figures::Compared;
use serde_json::json;

use super::job::keys;
use super::{Recorded, Replay, Single, together};
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
    let episodes = bests
        .iter()
        .map(|best| Ok((single.world_of(best.generation)?, &*best.genome)));
    let episodes = episodes.collect::<Result<Vec<_>>>()?;
    replay.check_trial(settings.trials)?;
    let trial = replay.trial as usize;
    let key = if let Some(seed) = replay.seed {
        Keys::of_seed(seed).of(0, trial)
    } else {
        let champion = super::champion(run, experiment)?;
        let mut recorded = keys(settings, run.seed, champion.generation, champion.individual);
        recorded.nth(trial).expect("it is one of its trials")
    };
    let title = format!("{}, seed {}: how it learned", experiment.name(), run.seed);
    let how = (Compared::Generations(replay.generations), replay.every, &*title);
    let (html, fitness) = together::compare(&episodes, key, how, engine, |episode, why| {
        Failure::input(format_args!(
            "--generations: there is no page of generation {}'s best: {why}; allowed: other generations, or --seed N",
            replay.generations[episode]
        ))
    })?;
    plain::make_directory(replay.out).map_err(|error| Failure::unreadable(replay.out, &error))?;
    let path = replay.out.join(LEARNING);
    disk::write(&path, html.as_bytes())?;
    let rows = bests.iter().zip(&fitness).map(|(best, fitness)| {
        json!({
            "generation": best.generation,
            "individual": best.individual,
            "fitness": decimal(*fitness),
            "recorded": decimal(best.fitness),
        })
    });
    let rows: Vec<_> = rows.collect();
    let lines = bests.iter().zip(&fitness).map(|(best, fitness)| {
        let (generation, individual) = (best.generation, best.individual);
        let own = best.fitness;
        format!("generation {generation}, individual {individual}: fitness {fitness} here, {own} in its generation")
    });
    let text = lines.chain([path.display().to_string()]).collect::<Vec<_>>().join("\n");
    let score = settings.trial_score.word();
    let value = json!({
        "generations": rows, "seed": replay.seed, "trial": replay.trial, "score": score, "page": path, "device": engine.name(),
    });
    Ok(Answer::new(text, value))
}
