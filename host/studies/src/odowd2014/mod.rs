//! The study of O'Dowd, Studley and Winfield (2014): swarms whose on-board simulators evolve with their controllers, in
//! six cases, with nulls and interventions. Every claim of the paper is tested against the results.

mod judge;
mod measures;
mod report;
mod results;
mod second;
mod study;

use std::time::Instant;

use oneiro::batch::{Rollout, Worlds};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::foraging::{Foraging, Light};
use oneiro::parameter::Choice;
use oneiro::random::Key;

pub use self::second::judge_sweeps;
pub use self::study::Asked;
use crate::Findings;
use crate::assumptions::Assumption;
use crate::claims::Claim;
use crate::directory::{self, Directory, Reproduction, Request};
use crate::file::{ODOWD2014, StudyFile};
use crate::verdicts::Sensitivity;
use oneiro_base::answer::Answer;
use oneiro_base::console::Console;
use oneiro_base::contents::Entry;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::progress;
use oneiro_lab::device;
use oneiro_lab::engine::handle::Engine;
pub(super) use report::contents;
use results::Results;
#[cfg(any(test, feature = "testing"))]
pub(super) use second::contents as contents_of_second;
use study::{Study, combine};

/// Most runs of each case and kind: their figures take two gigabytes of memory.
const GREATEST_RUNS: u32 = 400;
/// Runs of each case and kind that advance, and are saved, together.
const COHORT: u32 = 10;
/// Seconds that the paper's robots needed for the simulations of an interval.
const PAPERS_SECONDS: f64 = 34.0;

/// Runs or resumes the whole study.
pub fn run(asked: &Asked, request: &Request<'_>, console: Console) -> Result<Answer<Findings>> {
    if let Some(runs) = asked.runs {
        directory::check_runs(runs, &(2..=GREATEST_RUNS))?;
    }
    if let Some(scale) = asked.scales.iter().find(|scale| !(**scale > 0.0 && **scale <= 10.0)) {
        return Err(Failure::input(format_args!(
            "--scale {scale}: allowed: above 0, up to 10"
        )));
    }
    let twice = |words: &str| Failure::input(format_args!("{words} is given twice; allowed: each once"));
    if let Some(scale) = again(&asked.scales) {
        return Err(twice(&format!("--scale {scale}")));
    }
    if let Some(credit) = again(&asked.credits) {
        return Err(twice(&format!("--credit {}", credit.word())));
    }
    let file = StudyFile::open(&ODOWD2014, request.file)?;
    let evaluations = device::engine(request.backend)?;
    let under = |arm: &str| -> Result<Whole<'_>> {
        let asked = Asked {
            // Open questions aren't repeated under other arms.
            questions: asked.questions && arm == request.arm,
            ..asked.clone()
        };
        let study = Study::new(&file, arm, &asked)?;
        directory::check_runs(study.runs(), &(2..=GREATEST_RUNS))?;
        let evaluations = &evaluations;
        Ok(Whole { study, evaluations })
    };
    let found = directory::reproduce(request, &file, under, console)?;
    device::close(evaluations, console);
    Ok(found)
}

/// The first element that occurs twice.
fn again<T: PartialEq>(list: &[T]) -> Option<&T> {
    let mut places = list.iter().enumerate();
    places
        .find(|(place, one)| list[..*place].contains(one))
        .map(|(_, one)| one)
}

/// A study under one arm.
struct Whole<'a> {
    study: Study,
    evaluations: &'a Engine,
}

impl Reproduction for Whole<'_> {
    const NAME: &'static str = "odowd2014";

    type Found = Results;

    fn seed(&self) -> u64 {
        self.study.seed()
    }

    fn record(&self) -> String {
        self.study.record()
    }

    fn assumptions(&self) -> Vec<Assumption> {
        self.study.assumptions()
    }

    fn run(&self, directory: &Directory, console: Console) -> Result<Results> {
        let Self { study, evaluations } = self;
        let steps = study.steps() + evaluations.control.steps();
        let mut runs = Vec::new();
        let mut questions = Vec::new();
        progress::watched(steps, "foraging", console.bars(), &evaluations.control, || -> Result {
            for cohort in study.cohorts(COHORT) {
                let name = format!("cohorts/{}", cohort.name());
                runs.push((cohort, directory.kept(&name, || study.run(&cohort, evaluations))?));
            }
            for question in study.questions() {
                let name = format!("cohorts/{}", question.0.name());
                questions.push(directory.kept(&name, || study.answer(question, evaluations))?);
            }
            Ok(())
        })?;
        let settings = study.settings();
        Ok(Results {
            robots: settings.world.robots,
            minutes: settings.minutes,
            light_moves_minute: settings.light_moves_minute,
            runs: study.runs(),
            generation_within_34_s: generation_seconds(&settings.simulator(Light::OverNest))? < PAPERS_SECONDS,
            combinations: combine(runs),
            questions,
        })
    }

    fn judge(&self, results: &Results) -> Vec<Claim> {
        judge::judge(results)
    }

    fn json(&self, results: &Results) -> Result<Vec<u8>> {
        serde_json::to_vec(&report::summary(results)).map_err(Failure::failed)
    }

    fn contents(&self) -> Vec<Entry> {
        contents(self.study.has_questions())
    }

    fn csv(&self, results: &Results) -> Vec<(&'static str, String)> {
        report::csv_files(results)
    }

    fn html(&self, results: &Results, claims: &[Claim], arms: Option<&Sensitivity>) -> String {
        report::html(&report::Report {
            results,
            claims,
            foragers: &self.study.settings().swarm(),
            assumptions: &self.study.assumptions(),
            seed: self.seed(),
            arms,
        })
    }
}

/// Seconds that one core needs for ten simulated episodes with the scalar code.
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
    let start = Instant::now();
    cpu.evaluate(&batch, &Control::new())?;
    Ok(start.elapsed().as_secs_f64())
}
