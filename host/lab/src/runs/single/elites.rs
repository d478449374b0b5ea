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
use oneiro_evolve::settings::Descriptor;
use oneiro_report::figures::{self, escaped, packed, turns};
use oneiro_report::numbers::significant;
use oneiro_report::page::{Section, document};
use serde_json::{Value, json};

use super::archive::{self, RecordedElite};
use super::job::{keys, score};
use super::{ARCHIVE_PAGE, Recorded, Replay, Single, pictures};
use crate::engine::handle::Engine;
use crate::experiment::settings::Settings;

const SCRIPT: &str = include_str!("elites.js");
/// Poses on the page, about 6 MB, and of one episode.
const POSES: usize = 1_000_000;
const POSES_OF_LIFE: usize = 500;
/// Elites in one batch.
const CHUNK: usize = 1024;

/// The episode of an elite that the page plays.
struct Lived {
    fitness: f32,
    /// The robot's poses: x and y in mm, and the heading in turns.
    poses: Vec<[f32; 3]>,
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
    /// Cells of the archive.
    cells: usize,
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

/// The range of the elites' fitness, with a margin if all are equal.
fn span(elites: &[RecordedElite]) -> [f64; 2] {
    let fitness = || elites.iter().map(|elite| elite.fitness).filter(|own| own.is_finite());
    let (low, high) = (
        fitness().fold(f64::INFINITY, f64::min),
        fitness().fold(f64::NEG_INFINITY, f64::max),
    );
    match low < high {
        true => [low, high],
        false if low.is_finite() => [low - 0.5, low + 0.5],
        false => [0.0, 1.0],
    }
}

impl Page<'_> {
    fn html(&self) -> String {
        let Self {
            name,
            arena,
            descriptors,
            elites,
            lives,
            ..
        } = *self;
        let title = format!("{name}, seed {}: elites", self.seed);
        let axis = |index: usize| {
            let own = &descriptors[index];
            (&*own.measure, [own.least, own.greatest].map(f64::from))
        };
        // With several measures, the first two are shown; with one, that and the fitness.
        let up = if descriptors.len() > 1 {
            axis(1)
        } else {
            ("fitness", span(elites))
        };
        let dot = |elite: &RecordedElite| {
            let above = elite.behaviour.get(1).copied().unwrap_or(elite.fitness);
            [elite.behaviour[0], above, elite.fitness]
        };
        let dots: Vec<_> = elites.iter().map(dot).collect();
        let picture = pictures::archive::drawn(&title, [axis(0), up], &dots);
        let (stage, place) = figures::stage(arena, &format!("{name}: an elite's episode"));

        let bounds = arena.bounds();
        let share = |value: f32, from: f32, size: f32| (65535.0 * ((value - from) / size).clamp(0.0, 1.0)) as u16;
        let poses = lives.iter().flat_map(|own| &own.poses).flat_map(|&[x, y, heading]| {
            let x = share(x, bounds.x, bounds.width);
            let y = share(bounds.y + bounds.height - y, 0.0, bounds.height);
            [x, y, turns(heading)]
        });
        let row = |(elite, own): (&RecordedElite, &Lived)| -> Value {
            let measured = elite.behaviour.iter().map(|value| significant(*value, 6));
            let mut row = vec![
                elite.cell.to_string(),
                significant(elite.fitness, 6),
                elite.evaluations.to_string(),
                elite.lived.generation.to_string(),
                elite.lived.individual.to_string(),
                own.fitness.to_string(),
            ];
            row.extend(measured);
            json!(row)
        };
        let mut columns = vec![
            "cell",
            "fitness",
            "evaluations",
            "generation",
            "individual",
            "this episode",
        ];
        columns.extend(descriptors.iter().map(|own| &*own.measure));
        let data = json!({
            "columns": columns,
            "elites": elites.iter().zip(lives).map(row).collect::<Vec<_>>(),
            "lengths": lives.iter().map(|own| own.poses.len()).collect::<Vec<_>>(),
            "every": self.every,
            "place": place,
            "radius": place[2] / f64::from(bounds.width) * f64::from(self.body_radius),
            "poses": packed(poses),
        });
        // Its text must not end the element.
        let data = data.to_string().replace('<', "\\u003c");
        let body = format!(
            "<p>Click a square, or a row of the table below, to play the elite's episode. <button type=\"button\" \
         id=\"play\">Play</button> <output id=\"clock\"></output></p>\n\
         <div id=\"pictures\">\n<figure>{picture}</figure>\n<figure>{stage}</figure>\n</div>\n\
         <p id=\"said\" role=\"status\"></p>\n<p>As a picture and a table: <code>oneiro replay {} --elite \
         <span id=\"which\">CELL</span></code></p>\n<div class=\"scroll\" id=\"rows\"><table id=\"table\"></table></div>\n\
         <noscript><p>This page plays episodes with JavaScript, which is switched off.</p></noscript>\n\
         <style>#pictures {{ display: grid; grid-template-columns: 1fr 1fr; gap: 12px; align-items: start; }}\n\
         #pictures [data-elite] {{ cursor: pointer; }} #pictures [data-elite].chosen {{ stroke: #26282e; stroke-width: 2; }}\n\
         #rows {{ max-height: 30em; overflow-y: auto; }} #rows tr.chosen td {{ background: var(--ground); }}\n\
         @media (max-width: 700px) {{ #pictures {{ grid-template-columns: 1fr; }} }}</style>\n\
         <script type=\"application/json\" id=\"elites\">{data}</script>\n<script>\n{SCRIPT}</script>\n",
            escaped(self.directory)
        );
        let lead = format!(
            "<p class=\"lead\">{} of {}</p>\n",
            counted(elites.len(), "elite", "elites"),
            counted(self.cells, "cell", "cells")
        );
        let section = Section::new("archive", "The archive", body);
        document(&title, &lead, &[section])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use oneiro_evolve::Champion;
    use oneiro_report::figures::browser;

    /// The page of two elites opens with one of them, and plays the other once its square is clicked.
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
            elites: &[elite(7, 1.0), elite(12, 9.0)],
            lives: &[lived(100.0), lived(300.0)],
            every: 10,
        };
        let html = page.html();
        assert!(!html.contains("<b>") && html.contains("2 elites of 25 cells"));
        let ask = "
            const text = (id) => document.getElementById(id).textContent;
            const played = () => new Promise((then) => setTimeout(then, 4500));
            const rows = document.querySelectorAll('#table tbody tr').length;
            const squares = document.querySelectorAll('[data-elite]');
            squares[1].dispatchEvent(new MouseEvent('click', { bubbles: true }));
            await played();
            const points = document.querySelector('#robots polyline').getAttribute('points').split(' ').length;
            const right = document.querySelector('#robots polyline').getAttribute('points').split(',')[0];
            const first = [text('which'), text('clock'), text('said')];
            document.querySelectorAll('#table tbody tr')[0].click();
            await played();
            const left = document.querySelector('#robots polyline').getAttribute('points').split(',')[0];
            return { rows, squares: squares.length, points, first, apart: right - left, second: text('which') };";
        let Some(told) = browser::told("elites", &html, ask) else {
            return;
        };
        assert_eq!(
            (&told["rows"], &told["squares"], &told["points"]),
            (&2.into(), &2.into(), &3.into()),
            "{told}"
        );
        assert_eq!(
            (&told["first"][0], &told["first"][1]),
            (&"12".into(), &"2.0 s".into()),
            "{told}"
        );
        let said = told["first"][2].as_str().unwrap();
        assert!(
            said.contains("cell 12, fitness 12") && said.contains("this episode 1.5") && said.contains("<b> 5"),
            "{said}"
        );
        assert!(
            told["apart"].as_f64().unwrap() > 50.0 && told["second"] == "7",
            "{told}"
        );
    }
}
