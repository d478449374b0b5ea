//! `oneiro replay`: replays a champion's episode, or simulates another one.

use std::path::{Path, PathBuf};

use oneiro::batch::{Batch, Rollout, TraceRequest};
use oneiro::differential::{Build, Differential};
use oneiro::parameter::Choice;
use oneiro::random::Key;
use oneiro::world::{Start, World, WorldSpec};
use oneiro_base::answer::Answer;
use oneiro_base::console::decimal;
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::plain;
use oneiro_report::figures::{self, EpisodeReplay, Frames};
use oneiro_report::numbers::significant;
use serde_json::json;

use super::individuals::Individuals;
use super::job::{keys, score};
use super::trace::TraceTable;
use super::{Experiment, REPLAY, Recorded, Replay, Single, together};
use crate::engine::handle::Engine;
use crate::genomes;
use crate::lives::Keys;
use crate::reality::site::LIVES;
use crate::runs::taken;

/// A warning, before the reason.
const NO_PAGE: &str = "there is no page that plays the episode";

/// Simulates the champion's episodes again, compares its score with the recorded one, and writes one episode's path and trace. An
/// episode from another start, with other random numbers or of another genome is also written, but not compared.
pub(super) fn run(single: &Single, run: &Recorded<'_>, replay: &Replay<'_>, engine: &Engine) -> Result<Answer> {
    let experiment = &single.experiment;
    if single.ends_outside() {
        let directory = run.directory.display();
        return Err(Failure::input(format_args!(
            "{directory}: its champion was evaluated on a connected robot, and such an episode can't be repeated; allowed: runs in a \
             simulator. Its episodes are in {directory}/{LIVES}; `oneiro evaluate --genomes {directory}` simulates it"
        )));
    }
    taken::check(replay)?;
    if replay.elites {
        return super::elites::page(single, run, replay, engine);
    }
    if !replay.generations.is_empty() {
        return super::learning::page(single, run, replay, engine);
    }
    let champion = match (replay.elite, replay.generation) {
        (Some(cell), _) => super::archive::elite(run, experiment, cell)?,
        (None, Some(generation)) => {
            individuals(run, experiment, "--generation")?.of_generation(generation, replay.individual)?
        }
        (None, None) => super::champion(run, experiment)?,
    };
    let mut messages = Vec::new();
    let other = replay
        .genome
        .map(|file| genome(file, experiment, |word| messages.push(word)))
        .transpose()?;
    let test = replay.test.then(|| experiment.tested_in()).transpose()?;
    let settings = test.unwrap_or(experiment).settings();
    replay.check_trial(settings.trials)?;
    if let (Some(_), Build::Differential(Differential { count: Some(_), .. })) =
        (replay.start, &experiment.world().spec().robot.build)
    {
        return Err(Failure::input(
            "--start: is given for a swarm, which starts as its experiment says; allowed: with single robots, or --seed and --trial for other starts",
        ));
    }
    let is_new = replay.start.is_some() || replay.seed.is_some() || other.is_some() || replay.test;
    let lived_in = match test {
        Some(test) => test.world().clone(),
        None if replay.surrogate.is_some() => experiment.world().clone(),
        None => single.world_of(champion.generation)?,
    };
    let world = match replay.start {
        None => lived_in,
        Some([x, y, heading]) => World::new(WorldSpec {
            start: Start::At { x, y, heading },
            ..lived_in.spec().clone()
        })
        .map_err(|invalid| Failure::input(format_args!("--start {x},{y},{heading}: {invalid}")))?,
    };
    let keys: Vec<Key> = match replay.seed.or(other.as_ref().map(|_| 1)) {
        None => keys(settings, run.seed, champion.generation, champion.individual).collect(),
        Some(seed) => {
            let keys = Keys::of_seed(seed);
            (0..settings.trials as usize).map(|trial| keys.of(0, trial)).collect()
        }
    };
    let stem = match settings.trials {
        1 => format!("{REPLAY}{}", differences(replay)),
        _ => format!("{REPLAY}-{}{}", replay.trial, differences(replay)),
    };
    let title = |more: &str| match replay.genome {
        Some(file) => format!("{}: {}{more}", experiment.name(), file.display()),
        None => format!(
            "{}, seed {}: generation {}{more}",
            experiment.name(),
            run.seed,
            champion.generation
        ),
    };
    if let Some((seed, _)) = replay.surrogate {
        let genes = other.as_ref().unwrap_or(&champion.genome);
        let key = keys[replay.trial as usize];
        let page = replay.out.join(format!("{stem}.html"));
        return super::realities::page(
            single,
            world,
            genes,
            key,
            replay,
            (page, &title(&format!(", surrogate {seed}"))),
            engine,
        );
    }
    let worlds = std::slice::from_ref(&world);
    let rollouts: Vec<Rollout<'_>> = keys
        .into_iter()
        .map(|key| Rollout {
            world: 0,
            genes: other.as_ref().unwrap_or(&champion.genome),
            key,
        })
        .collect();
    let lives = engine.evaluate(&Batch::new(worlds, &rollouts, None)?)?;
    let own = score(settings.trial_score, &lives.fitness);
    let (bits, recorded) = (own.to_bits(), champion.fitness.to_bits());
    if !is_new && bits != recorded {
        return Err(Failure::failed(format_args!(
            "{}: the recorded fitness is {} (bits {recorded:08x}), but {own} (bits {bits:08x}) on {}",
            run.directory.display(),
            champion.fitness,
            engine.name()
        )));
    }

    let shown = rollouts[replay.trial as usize];
    let every = replay.every.min(world.cycles());
    let traced = Batch::new(worlds, &[shown], Some(TraceRequest { every }))?;
    let trace = engine.evaluate(&traced)?.traces.into_iter().next().unwrap_or_default();
    taken::check_moment(replay, every, trace.len())?;
    let life = lives.fitness[replay.trial as usize];
    // Where worlds or starts vary, the one of this episode.
    let number = (world.variants().len() > 1).then(|| world.variant(shown.key));
    let place = number.map_or_else(String::new, |number| format!(", world {number}"));
    let title = title(&format!(", fitness {}{place}", significant(life.into(), 6)));
    let shown_in = world.of(shown.key);
    let spec = shown_in.spec();
    let picture = figures::life(&spec.arena, spec.robot.body_radius, &title, &trace, every);

    let directory = replay.out;
    plain::make_directory(directory).map_err(|error| Failure::unreadable(directory, &error))?;
    let [path, table] = ["svg", "csv"].map(|extension| directory.join(format!("{stem}.{extension}")));
    disk::write(&path, picture.as_bytes())?;
    disk::write(&table, TraceTable::new(&world).csv(&trace, every).as_bytes())?;
    let mut files = vec![path, table];
    let page = |episode: &EpisodeReplay<'_>| {
        let page = directory.join(format!("{stem}.html"));
        disk::write(&page, figures::episode_page(episode).as_bytes()).map(|()| page)
    };
    let (mut taken, mut warnings) = ([None, None], Vec::new());
    if trace.is_empty() {
        warnings.push(format!("{NO_PAGE}: {}", together::NO_CYCLE));
    } else if world.robots() == 1 {
        let episode = together::of_one(shown_in, shown.genes, &trace, every, &title);
        files.push(page(&episode)?);
        taken = taken::write(replay, |side| Frames::new(&episode, side))?;
    } else {
        match together::watch(&world, &shown, replay.every, life, 1, engine)? {
            Ok(watched) => {
                let episode = watched.episode(&title);
                files.push(page(&episode)?);
                let table = directory.join(format!("{stem}-robots.csv"));
                disk::write(&table, watched.table().as_bytes())?;
                files.push(table);
                taken = taken::write(replay, |side| Frames::new(&episode, side))?;
            }
            Err(why) => warnings.push(format!("{NO_PAGE}: {why}")),
        }
    }
    let text = |file: &PathBuf| file.display().to_string();
    let files: Vec<String> = files.iter().map(text).collect();
    let [picture, film] = taken.each_ref().map(|file| file.as_ref().map(text));
    let collisions = trace.iter().filter(|record| record.collided > 0.0).count();
    let value = json!({
        "genome": replay.genome,
        "generation": other.is_none().then_some(champion.generation),
        "individual": other.is_none().then_some(champion.individual),
        "fitness": decimal(own),
        "bits": format!("{bits:08x}"),
        "compared": !is_new,
        "trial": replay.trial,
        "world": number,
        "trial_fitness": decimal(life),
        "trial_bits": format!("{:08x}", life.to_bits()),
        "collisions": collisions,
        "path": files[0],
        "trace": files[1],
        "page": files.get(2),
        "robots": files.get(3),
        "picture": picture,
        "film": film,
        "device": engine.name(),
    });
    let compared = if is_new {
        "a new episode, not compared with the record"
    } else {
        "as recorded"
    };
    let who = match replay.genome {
        Some(file) => file.display().to_string(),
        None => format!("generation {}, individual {}", champion.generation, champion.individual),
    };
    let (all, one) = match settings.trials {
        1 => (String::new(), place),
        trials => {
            let (score, trial) = (settings.trial_score.word(), replay.trial);
            let one = format!("\nepisode {trial}: fitness {life} (bits {:08x}){place}", life.to_bits());
            (format!(" of {trials} episodes ({score})"), one)
        }
    };
    let text = format!(
        "{who}: fitness {own}{all} (bits {bits:08x}), {compared}{one}\n{}",
        files
            .into_iter()
            .chain(picture)
            .chain(film)
            .collect::<Vec<_>>()
            .join("\n")
    );
    Ok(Answer {
        text,
        value,
        warnings,
        messages,
    })
}

/// The differences of a replayed episode from the champion's recorded one, for the names of its files: they never replace the
/// recorded episode's files.
fn differences(replay: &Replay<'_>) -> String {
    let plain = |name: &Path| -> String {
        let stem = name.file_stem().unwrap_or_default().to_string_lossy();
        stem.replace(|c: char| !c.is_alphanumeric() && !"-_.".contains(c), "_")
    };
    let elite = replay.elite.map(|cell| format!("-elite-{cell}"));
    let generation = replay.generation.map(|generation| format!("-generation-{generation}"));
    let individual = replay.individual.map(|individual| format!("-individual-{individual}"));
    let genome = replay.genome.map(|file| format!("-genome-{}", plain(file)));
    let start = replay.start.map(|[x, y, heading]| format!("-start-{x}_{y}_{heading}"));
    let seed = replay.seed.map(|seed| format!("-seed-{seed}"));
    let test = replay.test.then(|| "-test".to_owned());
    let surrogate = replay.surrogate.map(|(seed, _)| format!("-surrogate-{seed}"));
    let all = [elite, generation, individual, genome, start, seed, test, surrogate];
    all.into_iter().flatten().collect()
}

/// All recorded individuals, which an option asks for.
pub(super) fn individuals(run: &Recorded<'_>, experiment: &Experiment, option: &str) -> Result<Individuals> {
    if experiment.settings().evolution.is_coevolution() {
        return Err(Failure::input(format_args!(
            "{option}: is given, and this run's individuals were scored against opponents; allowed: runs of one population"
        )));
    }
    Individuals::read(run.directory, experiment)
}

/// The one genome of a file.
fn genome(file: &Path, experiment: &Experiment, say: impl FnMut(String)) -> Result<Vec<f32>> {
    let all = genomes::read(file, experiment.world().gene_layout(), say)?;
    if all.len() > 1 {
        let (file, count) = (file.display(), all.len());
        return Err(Failure::input(format_args!(
            "--genome {file}: has {count} genomes; allowed: one"
        )));
    }
    Ok(all.genome(0).to_vec())
}
