//! `oneiro replay --elites`: replays all elites of an archive, and writes a page that shows the archive and plays their episodes.

use std::collections::BTreeMap;

use oneiro::arena::Arena;
use oneiro::batch::{Batch, Record, Rollout, TraceRequest};
use oneiro::world::World;
use oneiro_base::answer::Answer;
use oneiro_base::console::counted;
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::plain;
use oneiro_evolve::map_elites::centroids_of;
use oneiro_evolve::settings::Descriptor;
use oneiro_report::figures::{Axis, ElitesReplay, ShownElite, elites_page};
use oneiro_report::numbers::significant;
use serde_json::json;

use super::archive::{self, RecordedElite};
use super::job::{keys, score};
use super::{ARCHIVE_PAGE, Recorded, Replay, Single};
use crate::engine::handle::Engine;
use crate::experiment::settings::Settings;

/// Poses on the page, about 8 MB, and of one episode.
const POSES: usize = 600_000;
const POSES_OF_LIFE: usize = 500;
/// Elites in one batch.
const CHUNK: usize = 1024;

/// The episode of an elite that the page plays.
struct Lived {
    fitness: f32,
    /// The robot's poses: x and y in mm, and the heading in turns.
    poses: Vec<[f32; 3]>,
    /// The fitness up to each of them.
    earned: Vec<f32>,
}

/// The contents of the page.
struct Page<'a> {
    name: &'a str,
    seed: u64,
    /// Name of the run's directory.
    directory: &'a str,
    arena: &'a Arena,
    body_radius: f32,
    descriptors: &'a [Descriptor],
    /// Cells of the archive, and their centroids unless they are a grid.
    cells: usize,
    centroids: Option<Vec<f64>>,
    elites: &'a [RecordedElite],
    /// An episode of each.
    lives: &'a [Lived],
    /// Cycles between poses.
    every: u32,
}

/// Replays all elites, compares their scores with the record, and writes the page.
pub(super) fn page(single: &Single, run: &Recorded<'_>, replay: &Replay<'_>, engine: &Engine) -> Result<Answer> {
    let experiment = &single.experiment;
    let settings = experiment.settings();
    let elites = archive::elites(run, experiment, "--elites")?;
    replay.check_trial(settings.trials)?;
    let cycles = settings.world.cycles as usize;
    let least = (cycles.div_ceil(POSES_OF_LIFE)).max((elites.len() * cycles).div_ceil(POSES)) as u32;
    let every = replay.every.max(least).min(settings.world.cycles);
    // The simulator's, and that of the robot which replaces it in the last generations.
    let real = experiment.first_real();
    let mut lives = BTreeMap::new();
    for (index, generation) in std::iter::once(0).chain(real).enumerate() {
        let world = single.world_of(generation)?;
        let is_own = |elite: &RecordedElite| real.is_some_and(|first| elite.lived.generation >= first) == (index == 1);
        let own: Vec<_> = elites.iter().enumerate().filter(|(_, elite)| is_own(elite)).collect();
        for chunk in own.chunks(CHUNK) {
            let (places, chunk): (Vec<usize>, Vec<_>) = chunk.iter().copied().unzip();
            lives.extend(
                places
                    .into_iter()
                    .zip(lived(&world, settings, run, replay.trial, every, &chunk, engine)?),
            );
        }
    }
    let lives: Vec<Lived> = lives.into_values().collect();

    plain::make_directory(replay.out).map_err(|error| Failure::unreadable(replay.out, &error))?;
    let path = replay.out.join(ARCHIVE_PAGE);
    let spec = experiment.world().spec();
    let page = Page {
        name: experiment.name(),
        seed: run.seed,
        directory: &run.directory.file_name().unwrap_or_default().to_string_lossy(),
        arena: &spec.arena,
        body_radius: spec.robot.body_radius,
        descriptors: &settings.evolution.descriptors,
        cells: settings.evolution.cells(),
        centroids: centroids_of(&settings.evolution),
        elites: &elites,
        lives: &lives,
        every,
    };
    disk::write(&path, page.html().as_bytes())?;
    let value = json!({
        "elites": elites.len(),
        "compared": true,
        "page": path.display().to_string(),
        "device": engine.name(),
    });
    let elites = counted(elites.len(), "elite", "elites");
    Ok(Answer::new(format!("{elites}, as recorded\n{}", path.display()), value))
}

/// Simulates all episodes of some elites again, and traces one of each.
fn lived(
    world: &World,
    settings: &Settings,
    run: &Recorded<'_>,
    trial: u32,
    every: u32,
    elites: &[&RecordedElite],
    engine: &Engine,
) -> Result<Vec<Lived>> {
    let worlds = std::slice::from_ref(world);
    let rollouts: Vec<Rollout<'_>> = elites
        .iter()
        .flat_map(|RecordedElite { lived, .. }| {
            keys(settings, run.seed, lived.generation, lived.individual).map(|key| Rollout {
                world: 0,
                genes: &lived.genome,
                key,
            })
        })
        .collect();
    let all = engine.evaluate(&Batch::new(worlds, &rollouts, None)?)?.fitness;
    let trials = settings.trials as usize;
    for (elite, own) in elites.iter().zip(all.chunks_exact(trials)) {
        compare(settings, run, elite, own, engine)?;
    }
    let shown: Vec<_> = rollouts.into_iter().skip(trial as usize).step_by(trials).collect();
    let traced = engine.evaluate(&Batch::new(worlds, &shown, Some(TraceRequest { every }))?)?;
    let lived = traced.fitness.into_iter().zip(&traced.traces);
    let pose = |record: &Record| [record.x, record.y, record.heading];
    Ok(lived
        .map(|(fitness, trace)| Lived {
            fitness,
            poses: trace.iter().map(pose).collect(),
            earned: trace.iter().map(|record| record.fitness).collect(),
        })
        .collect())
}

/// Compares an elite's score with the recorded one.
fn compare(settings: &Settings, run: &Recorded<'_>, elite: &RecordedElite, lives: &[f32], engine: &Engine) -> Result {
    let (own, recorded) = (score(settings.trial_score, lives), elite.lived.fitness);
    let (bits, then) = (own.to_bits(), recorded.to_bits());
    if bits == then {
        return Ok(());
    }
    Err(Failure::failed(format_args!(
        "{}: the recorded score of the elite of cell {} is {recorded} (bits {then:08x}), but {own} (bits {bits:08x}) on {}",
        run.directory.display(),
        elite.cell,
        engine.name()
    )))
}

impl Page<'_> {
    fn html(&self) -> String {
        let mut columns = vec![
            "cell",
            "fitness",
            "evaluations",
            "generation",
            "individual",
            "this episode",
        ];
        columns.extend(self.descriptors.iter().map(|own| &*own.measure));
        elites_page(&ElitesReplay {
            title: &format!("{}, seed {}: elites", self.name, self.seed),
            lead: &format!(
                "{} of {}",
                counted(self.elites.len(), "elite", "elites"),
                counted(self.cells, "cell", "cells")
            ),
            directory: self.directory,
            arena: self.arena,
            body_radius: self.body_radius,
            axes: self.descriptors.iter().map(axis).collect(),
            centroids: self.centroids.clone(),
            columns,
            elites: self.elites.iter().zip(self.lives).map(shown).collect(),
            every: self.every,
        })
    }
}

fn axis(own: &Descriptor) -> Axis<'_> {
    Axis {
        name: &own.measure,
        least: f64::from(own.least),
        greatest: f64::from(own.greatest),
        cells: own.cells,
    }
}

/// An elite as the page shows it.
fn shown<'a>((elite, lived): (&'a RecordedElite, &'a Lived)) -> ShownElite<'a> {
    let mut row = vec![
        elite.cell.to_string(),
        significant(elite.fitness, 6),
        elite.evaluations.to_string(),
        elite.lived.generation.to_string(),
        elite.lived.individual.to_string(),
        lived.fitness.to_string(),
    ];
    row.extend(elite.behaviour.iter().map(|value| significant(*value, 6)));
    ShownElite {
        cell: elite.cell,
        fitness: elite.fitness,
        behaviour: &elite.behaviour,
        row,
        poses: &lived.poses,
        earned: &lived.earned,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use oneiro_evolve::Champion;
    use oneiro_report::figures::browser;

    /// The page of two elites plays the best one, and plays the other once its tile, a key or its row is chosen.
    #[test]
    fn the_page_plays_the_elite_that_is_clicked() {
        let elite = |cell: u32, behaviour: f64| RecordedElite {
            cell,
            fitness: f64::from(cell),
            evaluations: 1,
            behaviour: vec![behaviour, 5.0],
            lived: Champion {
                generation: 3,
                individual: cell,
                fitness: 2.0,
                genome: Vec::new(),
            },
        };
        let lived = |x: f32| Lived {
            fitness: 1.5,
            poses: vec![[x, 100.0, 0.0], [x, 200.0, 0.25], [x, 250.0, 0.25]],
            earned: vec![0.0, 0.5, 1.5],
        };
        let descriptors = ["end_x_mm", "<b>"].map(|measure| Descriptor {
            measure: measure.into(),
            least: 0.0,
            greatest: 10.0,
            cells: 5,
        });
        let page = Page {
            name: "maze",
            seed: 4,
            directory: "run-4",
            arena: &Arena::named("miglino1995").unwrap(),
            body_radius: 27.5,
            descriptors: &descriptors,
            cells: 25,
            centroids: None,
            elites: &[elite(7, 1.0), elite(12, 9.0)],
            lives: &[lived(100.0), lived(300.0)],
            every: 10,
        };
        let html = page.html();
        assert!(!html.contains("<b>") && html.contains("2 elites of 25 cells"));
        let ask = "
            const at = (id) => document.getElementById(id);
            const soon = () => new Promise((then) => setTimeout(then, 100));
            const told = () => {
                const { lines, robots: [{ x, y }], time } = window.oneiro.drawn(9);
                return { which: at('which').textContent, cell: at('cell').textContent, said: at('said').textContent,
                    clock: at('clock').textContent, chosen: document.querySelector('[aria-selected=true]').dataset.elite,
                    lines, x, y, time };
            };
            await soon();
            const counts = ['#table tbody tr', '[data-elite]', '[data-cell]'].map((own) => document.querySelectorAll(own).length);
            const playing = at('play').textContent;
            const opened = told();
            document.querySelectorAll('[data-elite]')[0].dispatchEvent(new MouseEvent('click', { bubbles: true }));
            await soon(); const clicked = told();
            document.querySelectorAll('[data-cell]')[0].dispatchEvent(new PointerEvent('pointerover', { bubbles: true }));
            const empty = at('cell').textContent;
            at('map').dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowRight', bubbles: true, cancelable: true }));
            await soon(); const keyed = told();
            document.querySelectorAll('#table tbody tr')[0].click();
            await soon(); const rowed = told();
            return { counts, playing, opened, clicked, empty, keyed, rowed };";
        let Some(told) = browser::told("elites", &html, ask) else {
            return;
        };
        assert_eq!(told["counts"], json!([2, 2, 25]), "{told}");
        assert_eq!(
            (&told["playing"], &told["empty"]),
            (&"Pause".into(), &"cell 0: end_x_mm 0 to 2, <b> 0 to 2: no elite".into())
        );
        for (act, cell, x) in [
            ("opened", "12", 300.0),
            ("clicked", "7", 100.0),
            ("keyed", "12", 300.0),
            ("rowed", "7", 100.0),
        ] {
            let told = &told[act];
            assert_eq!(
                (&told["which"], &told["clock"], &told["lines"]),
                (&cell.into(), &"0:02 of 0:02".into(), &3.into()),
                "{act}: {told}"
            );
            assert!(
                (told["x"].as_f64().unwrap() - x).abs() < 0.06 && told["time"] == 2.0,
                "{act}: {told}"
            );
            assert!((told["y"].as_f64().unwrap() - 250.0).abs() < 0.06, "{act}: {told}");
            assert_eq!(told["chosen"], if cell == "7" { "0" } else { "1" }, "{act}");
        }
        for said in [&told["clicked"]["cell"], &told["clicked"]["said"]] {
            let said = said.as_str().unwrap();
            assert!(
                said.contains("cell 7, fitness 7") && said.contains("this episode 1.5") && said.contains("<b> 5"),
                "{said}"
            );
        }
    }
}
