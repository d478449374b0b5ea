//! The study of O'Dowd, Studley and Winfield (2014): swarms whose on-board simulators evolve with their controllers, in
//! six cases, with nulls and interventions, each claim of the paper held against what came out.

pub(crate) mod arms;
mod judge;
mod measures;
mod report;
pub(crate) mod results;
mod study;

use std::fs;
use std::path::Path;
use std::time::Instant;

use oneiro::batch::{Rollout, Worlds};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::foraging::{Foraging, Light};
use oneiro::random::Key;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::cli::Odowd2014;
use crate::console::Console;
use crate::engine::handle::Engine;
use crate::exit::{Failure, Result};
use crate::record::write_whole;
use crate::studies::claims::Claim;
use crate::studies::directory;
use crate::{device, progress, swarm};
use results::{Case, Kind, Results};
use study::{Cohort, Study, combined};

/// Runs of each case and kind that a study may have: their figures take two gigabytes of memory.
const GREATEST_RUNS: u32 = 400;
/// Runs of each case and kind that advance together and are kept together.
const COHORT: u32 = 10;
/// What the paper's robots took for the simulations of an interval, in seconds.
const PAPERS_SECONDS: f64 = 34.0;

/// Does the whole study, or goes on with it.
pub(crate) fn run(arguments: &Odowd2014, console: Console) -> Result {
    directory::check_runs(arguments.runs, GREATEST_RUNS)?;
    if let Some(scale) = arguments.scale.iter().find(|scale| !(**scale > 0.0 && **scale <= 10.0)) {
        return Err(Failure::input(format_args!(
            "--scale {scale}: allowed: above 0, up to 10"
        )));
    }
    let twice = |words: &str| Failure::input(format_args!("{words} is there twice; allowed: each once"));
    if let Some(scale) = again(&arguments.scale) {
        return Err(twice(&format!("--scale {scale}")));
    }
    if let Some(credit) = again(&arguments.credit) {
        return Err(twice(&format!("--credit {}", credit.title())));
    }
    let study = |arm: &str, questions| Study {
        seed: arguments.seed,
        runs: arguments.runs,
        scales: arguments.scale.clone(),
        credits: arguments.credit.clone(),
        only_cases: arguments.only_cases,
        arm: arm.into(),
        questions,
    };
    let evaluations = device::engine(&arguments.backend)?;
    let main = study(&arguments.arm, arguments.questions);
    let out = arguments
        .out
        .clone()
        .unwrap_or_else(|| directory::usual("odowd2014", main.seed, &main));
    let (results, claims) = studied(&main, &evaluations, &out, console)?;
    write(&out, &main, &results, &claims, &[])?;
    if arguments.sensitivity {
        let mut all = vec![(main.arm.clone(), claims.clone())];
        for arm in arms::ARMS.iter().skip(1) {
            console.say(format!("arm {}", arm.name));
            let own = study(arm.name, false);
            let place = out.join("arms").join(arm.name);
            let (results, claims) = studied(&own, &evaluations, &place, console)?;
            write(&place, &own, &results, &claims, &[])?;
            all.push((arm.name.into(), claims));
        }
        directory::write_sensitivity(&out, &all)?;
        write(&out, &main, &results, &claims, &all)?;
    }
    device::close(evaluations, console);
    directory::tell(&claims, &out, console)
}

/// The first of a list that stands in it twice.
fn again<T: PartialEq>(list: &[T]) -> Option<&T> {
    let mut places = list.iter().enumerate();
    places
        .find(|(place, one)| list[..*place].contains(one))
        .map(|(_, one)| one)
}

/// One study in its directory, all but its report: what is kept there already is not done again.
fn studied(study: &Study, evaluations: &Engine, place: &Path, console: Console) -> Result<(Results, Vec<Claim>)> {
    directory::open(place, study)?;
    let kept_in = place.join("cohorts");
    fs::create_dir_all(&kept_in).map_err(|error| Failure::storage(&kept_in, &error))?;
    let cohorts = study.cohorts(COHORT);
    let asked = if study.questions { Study::asked() } else { Vec::new() };
    let steps = cohorts.iter().map(|cohort| study.steps(cohort)).sum::<u64>()
        + asked
            .iter()
            .flat_map(|own| study.asked_plans(own))
            .map(|plan| swarm::steps(&plan))
            .sum::<u64>();
    let done = evaluations.control.steps();
    let mut runs = Vec::new();
    let mut questions = Vec::new();
    progress::watched(steps + done, "foraging", console, &evaluations.control, || -> Result {
        for cohort in cohorts {
            let Cohort {
                scale, credit, first, ..
            } = cohort;
            let path = kept_in.join(format!("{scale}-{}-{first:04}", credit.title()));
            runs.push((cohort, kept(&path, || study.run(&cohort, evaluations))?));
        }
        for own in &asked {
            let path = kept_in.join(own.name());
            questions.push(kept(&path, || study.answer(own, evaluations))?);
        }
        Ok(())
    })?;
    let settings = study.settings(Case::Over, Kind::Evolved, study.scales[0], study.credits[0]);
    let results = Results {
        robots: settings.world.robots,
        minutes: settings.minutes,
        light_moves_minute: settings.light_moves_minute,
        runs: study.runs,
        generation_within_34_s: generation_seconds(&settings.simulator(Light::OverNest))? < PAPERS_SECONDS,
        combinations: combined(runs),
        questions,
    };
    let claims = judge::judge(&results);
    directory::write_claims(place, &claims)?;
    Ok((results, claims))
}

/// Writes what came out, with what came out under other assumptions where that is known.
fn write(place: &Path, study: &Study, results: &Results, claims: &[Claim], arms: &[(String, Vec<Claim>)]) -> Result {
    let settings = study.settings(Case::Over, Kind::Evolved, study.scales[0], study.credits[0]);
    let html = report::html(&report::Study {
        results,
        claims,
        swarm: &settings.swarm(),
        assumptions: &study.assumptions(),
        seed: study.seed,
        arms,
    });
    write_whole(&place.join("report.html"), html.as_bytes())?;
    let text = serde_json::to_vec(&report::summary(results)).map_err(Failure::failed)?;
    write_whole(&place.join("results.json"), &text)?;
    for (name, csv) in report::csv_files(results) {
        write_whole(&place.join(name), csv.as_bytes())?;
    }
    Ok(())
}

/// What a file holds, or what is made now and then kept there.
fn kept<T: Serialize + DeserializeOwned>(path: &Path, make: impl FnOnce() -> Result<T>) -> Result<T> {
    const HASH: usize = 32;
    if let Ok(bytes) = fs::read(path) {
        let corrupt = || Failure::corrupt(format_args!("{}: is not what was written there", path.display()));
        let (data, hash) = bytes.split_last_chunk::<HASH>().ok_or_else(corrupt)?;
        if blake3::hash(data).as_bytes() != hash {
            return Err(corrupt());
        }
        return postcard::from_bytes(data).map_err(|_| corrupt());
    }
    let made = make()?;
    let mut bytes = postcard::to_allocvec(&made).map_err(Failure::failed)?;
    let hash = blake3::hash(&bytes);
    bytes.extend(hash.as_bytes());
    write_whole(path, &bytes)?;
    Ok(made)
}

/// How long ten simulated lives take one core by the scalar code.
fn generation_seconds(simulator: &Foraging) -> Result<f64> {
    const LIVES: u64 = 10;
    let worlds = Worlds::new(&[*simulator])?;
    let life = |individual| Rollout {
        world: 0,
        genes: &[0.99, 0.0],
        key: Key::rollout(0, 0, individual, 0),
    };
    let batch = worlds.batch(&(0..LIVES).map(life).collect::<Vec<_>>(), None)?;
    let mut cpu = Cpu::new(Some(1))?.with_variant("scalarx1")?;
    let begun = Instant::now();
    cpu.evaluate(&batch, &Control::new())?;
    Ok(begun.elapsed().as_secs_f64())
}
