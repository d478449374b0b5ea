//! `oneiro replay --generations`: the bests of several generations on one page, each from the same start: single robots in one arena, one swarm
//! after another.

use oneiro::parameter::Choice;
use oneiro_base::answer::Answer;
use oneiro_base::console::decimal;
use oneiro_base::exit::{Failure, Result};
use oneiro_report::figures::Compared;
use serde_json::json;

use super::job::keys;
use super::{Recorded, Replay, Single, together};
use crate::engine::handle::Engine;
use crate::lives::Keys;
use crate::runs::taken;

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
    let path = replay.out.join(LEARNING);
    let refused = |episode: usize, why: &str| {
        Failure::input(format_args!(
            "--generations: there is no page of generation {}'s best: {why}; allowed: other generations, or --seed N",
            replay.generations[episode]
        ))
    };
    let (taken, fitness) = together::compare(&episodes, key, how, engine, refused, |shown| {
        taken::write_with_page(replay, shown, &path)
    })?;
    let [picture, film] = &taken;
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
        let of = match settings.trials {
            1 => String::new(),
            trials => format!(", {} of {trials} episodes", settings.trial_score.word()),
        };
        format!("generation {generation}, individual {individual}: fitness {fitness} here, {own} in its generation{of}")
    });
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
