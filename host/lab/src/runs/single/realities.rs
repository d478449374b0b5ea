//! `oneiro replay --robot surrogate:SEED`: a controller in the simulator and on a surrogate, from the same start on one page.

use std::path::PathBuf;

use oneiro::random::Key;
use oneiro::world::World;
use oneiro_base::answer::Answer;
use oneiro_base::console::decimal;
use oneiro_base::exit::{Failure, Result};
use oneiro_report::figures::Compared;
use serde_json::json;

use super::{Replay, Single, together};
use crate::engine::handle::Engine;
use crate::reality::site::{SEVERITY, Site};
use crate::runs::taken;

const NAMES: [&str; 2] = ["simulator", "surrogate"];

/// Simulates an episode in a simulator's world and on the surrogate, and writes the page that plays both.
pub(super) fn page(
    single: &Single,
    simulator: World,
    genes: &[f32],
    key: Key,
    replay: &Replay<'_>,
    (path, title): (PathBuf, &str),
    engine: &Engine,
) -> Result<Answer> {
    let (seed, severity) = replay.surrogate.expect("it is asked for");
    let surrogate = site(single, seed, severity).world(simulator.spec())?;
    let episodes = [simulator, surrogate].map(|world| (world, genes));
    let how = (Compared::Realities(&NAMES), replay.every, title);
    let refused = |episode: usize, why: &str| {
        Failure::input(format_args!(
            "--robot: there is no page of the {}: {why}; allowed: other starts, such as --seed N",
            NAMES[episode]
        ))
    };
    let (taken, fitness) = together::compare(&episodes, key, how, engine, refused, |shown| {
        taken::write_with_page(replay, shown, &path)
    })?;
    let [picture, film] = &taken;
    let realities = NAMES.iter().zip(&fitness);
    let rows: Vec<_> = realities
        .clone()
        .map(|(name, fitness)| json!({ "name": name, "fitness": decimal(*fitness) }))
        .collect();
    let lines = realities.map(|(name, fitness)| format!("{name}: fitness {fitness}"));
    let files = [path.display().to_string()]
        .into_iter()
        .chain(taken.iter().flatten().cloned());
    let text = lines.chain(files).collect::<Vec<_>>().join("\n");
    let value = json!({ "realities": rows, "trial": replay.trial, "page": path, "picture": picture, "film": film, "device": engine.name() });
    Ok(Answer::new(text, value))
}

/// The surrogate with this seed: the run's, unless its severity is given.
fn site(single: &Single, seed: u64, severity: Option<f32>) -> Site {
    match (severity, &single.robot) {
        (None, Some(Site::Surrogate { seed: of_run, .. })) if *of_run == seed => single.robot.clone(),
        _ => None,
    }
    .unwrap_or_else(|| Site::drawn(seed, severity.unwrap_or(SEVERITY)))
}
