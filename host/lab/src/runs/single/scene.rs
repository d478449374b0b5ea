//! What `oneiro watch` shows of a run, also while it evolves: the best of a generation on a page, and the paths of its generation.

use std::sync::Arc;

use oneiro::batch::{Batch, Rollout, Trace, TraceRequest};
use oneiro_base::exit::Result;
use oneiro_evolve::Champion;
use oneiro_evolve::map_elites::Archive;
use oneiro_report::figures::{self, Path};
use oneiro_report::numbers::significant;

use super::archive::{self, RecordedElite};
use super::individuals::Individuals;
use super::job::{Evolving, keys};
use super::{Recorded, Recording, Single, pictures, together};
use crate::engine::handle::Engine;
use crate::runs::Scene;

/// Individuals whose paths are drawn.
const PATHS: usize = 64;
/// Poses of a path.
const PLACES: u32 = 200;

/// The scene of a generation, or of the newest; `None` if there is nothing that could be simulated.
pub(super) fn of(
    single: &Arc<Single>,
    run: &Recorded<'_>,
    generation: Option<u32>,
    checkpoint: &dyn Fn() -> Option<Vec<u8>>,
    engine: &Engine,
) -> Result<Option<Scene>> {
    let experiment = &single.experiment;
    let evolution = &experiment.settings().evolution;
    let is_outside =
        |generation| experiment.first_real().is_some_and(|first| generation >= first) && single.ends_outside();
    // Individuals of two populations were scored against opponents: only a finished run has a pair.
    let own = if evolution.is_coevolution() {
        None
    } else {
        Individuals::of_one(run.directory, experiment, generation)?
    };
    let (elites, archive) = match generation {
        None if evolution.has_archive() => elites(single, run, checkpoint)?,
        _ => (Vec::new(), None),
    };
    let best = match (&own, newest(elites)) {
        (Some((number, own)), _) => Champion {
            generation: *number,
            ..own.of_generation(0, None)?
        },
        (None, Some(elite)) => elite.lived,
        (None, None) if run.is_done && generation.is_none() => super::champion(run, experiment)?,
        (None, None) => return Ok(None),
    };
    if is_outside(best.generation) {
        return Ok(None);
    }
    let scene = scene(single, run, &best, own.as_ref().map(|(_, own)| own), engine)?;
    Ok(scene.map(|scene| Scene { archive, ..scene }))
}

/// The fittest of the elites of the last generation that has added some.
fn newest(elites: Vec<RecordedElite>) -> Option<RecordedElite> {
    let order = |own: &RecordedElite| own.lived.generation;
    elites
        .into_iter()
        .max_by(|a, b| order(a).cmp(&order(b)).then(a.fitness.total_cmp(&b.fitness)))
}

/// The elites of a run, and their picture if two measures describe behaviour: those of the newest checkpoint while it evolves.
fn elites(
    single: &Arc<Single>,
    run: &Recorded<'_>,
    checkpoint: &dyn Fn() -> Option<Vec<u8>>,
) -> Result<(Vec<RecordedElite>, Option<String>)> {
    let experiment = &single.experiment;
    let elites = if run.is_done {
        archive::elites(run, experiment, "")?
    } else {
        let Some(job) = checkpoint() else {
            return Ok((Vec::new(), None));
        };
        let job = Evolving::new(Arc::clone(single), run.seed, Recording::Tables)?.restored(&job)?;
        let elites = job.archive().into_iter().flat_map(Archive::elites);
        elites.map(|(cell, elite)| RecordedElite::of(cell, elite)).collect()
    };
    let picture = match &experiment.settings().evolution.descriptors[..] {
        [x, y] => {
            let dots = elites
                .iter()
                .map(|elite| [elite.behaviour[0], elite.behaviour[1], elite.fitness]);
            let axes = [x, y].map(|axis| (&*axis.measure, [axis.least, axis.greatest].map(f64::from)));
            let title = format!("{} elites", elites.len());
            Some(pictures::archive::drawn(&title, axes, &dots.collect::<Vec<_>>()))
        }
        _ => None,
    };
    Ok((elites, picture))
}

/// The first episode of an individual, and the paths of others in theirs.
fn scene(
    single: &Single,
    run: &Recorded<'_>,
    best: &Champion,
    others: Option<&Individuals>,
    engine: &Engine,
) -> Result<Option<Scene>> {
    let experiment = &single.experiment;
    let settings = experiment.settings();
    let Champion {
        generation,
        individual,
        fitness,
        ref genome,
    } = *best;
    let world = single.world_of(generation)?;
    let first_key = |individual| {
        keys(settings, run.seed, generation, individual)
            .next()
            .expect("there is a trial")
    };
    let worlds = std::slice::from_ref(&world);
    let life = |genes, individual| Rollout {
        world: 0,
        genes,
        key: first_key(individual),
    };
    let (name, seed) = (experiment.name(), run.seed);
    let title = format!(
        "{name}, seed {seed}: generation {generation}, fitness {}",
        significant(fitness.into(), 6)
    );
    let own = life(genome, individual);
    let page = if world.robots() == 1 {
        let batch = Batch::new(worlds, &[own], Some(TraceRequest { every: 1 }))?;
        let trace = engine.evaluate(&batch)?.traces.into_iter().next().unwrap_or_default();
        (!trace.is_empty())
            .then(|| figures::episode_page(&together::of_one(world.of(own.key), genome, &trace, 1, &title)))
    } else {
        together::page_of_swarm(&world, &own, engine, &title)?
    };
    let Some(page) = page else {
        return Ok(None);
    };
    let paths = match others {
        Some(others) if world.robots() == 1 => {
            let all = (0..PATHS).map_while(|index| Some((index as u32, others.get(index)?)));
            let all: Vec<_> = all.collect();
            let rollouts: Vec<_> = all.iter().map(|(index, (genes, _))| life(genes, *index)).collect();
            let every = world.cycles().div_ceil(PLACES);
            let traces = engine
                .evaluate(&Batch::new(worlds, &rollouts, Some(TraceRequest { every }))?)?
                .traces;
            let path = |((_, (_, fitness)), trace): (&(u32, (&[f32], f32)), &Trace)| Path {
                places: trace.iter().map(|record| [record.x, record.y]).collect(),
                fitness: *fitness,
            };
            let paths: Vec<Path> = all.iter().zip(&traces).map(path).collect();
            let title = format!("Paths of {} individuals of generation {generation}", paths.len());
            Some(figures::paths(&world.of(own.key).spec().arena, &title, &paths))
        }
        _ => None,
    };
    Ok(Some(Scene {
        generation,
        individual,
        fitness,
        page,
        paths,
        archive: None,
    }))
}
