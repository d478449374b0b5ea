//! Swarms whose on-board simulators evolve: [`crate::swarm`] has the algorithm.

pub mod acting;
mod replay;
mod report;

use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

use oneiro::batch::{WorldKind, Worlds};
use oneiro::foraging::Light;
use oneiro::parameter::Choice;
use oneiro_base::answer::Answer;
use oneiro_base::console::Bars;
use oneiro_base::console::counted;
use oneiro_base::contents::{Column, Entry, head};
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use serde_json::json;

use super::{Audit, Experiment, Recorded, Recording, Replay, Shown, Summary, Table, Work};
use crate::engine::handle::Engine;
use crate::engine::job::Job;
use crate::engine::watcher::Watcher;
use crate::exchange::links::Links;
use crate::experiment::source::LeftOut;
use crate::experiment::swarm::SwarmExperiment;
use crate::experiment::{self, Identities, Input};
use crate::swarm::job::SwarmJob;
use crate::swarm::record::{Case, Kind, Run};
use crate::swarm::tables::{
    CONTROLLERS, CONTROLLERS_COLUMNS, DEPOSITS, DEPOSITS_COLUMNS, FOOD, FOOD_COLUMNS, INTERVALS, INTERVALS_COLUMNS,
    PAIRS, PAIRS_COLUMNS, outcomes,
};
use crate::swarm::{controllers, steps};

const REPLAY: &str = "replay.html";

/// The files of the directory of any run.
#[cfg(any(test, feature = "testing"))]
pub fn all_contents() -> Vec<Entry> {
    contents()
}

/// The columns of a run's table of steps.
#[cfg(any(test, feature = "testing"))]
pub fn all_steps() -> &'static [Column] {
    &INTERVALS_COLUMNS
}

/// The columns of runs' values in a sweep's table of results.
#[cfg(any(test, feature = "testing"))]
pub fn all_outcomes() -> Vec<Column> {
    outcomes()
}

fn contents() -> Vec<Entry> {
    let intervals = "one row per robot and interval; none in the case `random`, in which nothing evolves";
    vec![
        Entry::table(INTERVALS, intervals, &INTERVALS_COLUMNS),
        Entry::table(FOOD, "one row per second", &FOOD_COLUMNS),
        Entry::table(
            DEPOSITS,
            "one row per item of food that a robot brought",
            &DEPOSITS_COLUMNS,
        ),
        Entry::table(
            CONTROLLERS,
            "one row per controller, robot and interval; none in the case `random` and without simulators (`swarm.control`)",
            &CONTROLLERS_COLUMNS,
        ),
        Entry::table(
            PAIRS,
            "one row per pair that a robot had at the end of an interval; none in the case `random`",
            &PAIRS_COLUMNS,
        ),
        super::report::entry(),
        Entry::file(REPLAY, "written by `oneiro replay`: a page that plays the run"),
    ]
}

/// The tables of a run with a directory from which it can be recomputed.
static DETAILS: [(&str, &[Column]); 3] = [
    (DEPOSITS, &DEPOSITS_COLUMNS),
    (CONTROLLERS, &CONTROLLERS_COLUMNS),
    (PAIRS, &PAIRS_COLUMNS),
];

/// Lets a run with a directory write its tables of details and its page.
fn with_page(job: SwarmJob, experiment: Arc<SwarmExperiment>, seed: u64, recording: Recording<'_>) -> SwarmJob {
    match recording {
        Recording::Directory { .. } => {
            let page = move |run: &Run| report::html(&experiment, seed, run);
            job.with_details().with_page((super::report::FILE, Box::new(page)))
        }
        Recording::Tables => job,
    }
}

/// Food in each second, from a run's table.
fn food(directory: &Path) -> Result<Vec<u32>> {
    let path = directory.join(FOOD);
    let text = disk::read_text(&path)?;
    let of_line = |line: &str| line.split_once(',')?.1.parse().ok();
    let lines = text.strip_prefix(&head(&FOOD_COLUMNS));
    let seconds: Option<Vec<u32>> = lines.and_then(|lines| lines.lines().map(of_line).collect());
    seconds.ok_or_else(|| Failure::corrupt(format_args!("{}: is not a table of food", path.display())))
}

/// Repeats a recorded run.
fn again(experiment: &SwarmExperiment, seed: u64, engine: &Engine, bars: Bars) -> Result<SwarmJob> {
    let plan = experiment.plan(seed);
    let mut watcher = Watcher::new(steps(&plan).iter().sum(), "foraging", None, bars);
    let jobs = engine.finished(vec![SwarmJob::new(plan).keeping_lines().with_details()], &mut watcher)?;
    let job = jobs.into_iter().next();
    job.ok_or_else(|| Failure::failed("a swarm has no result"))
}

/// Name of the first table that differs from the recorded one, if any.
fn difference(job: &SwarmJob, directory: &Path) -> Result<Option<String>> {
    let run = job.run();
    let mut tables = vec![
        (INTERVALS, head(&INTERVALS_COLUMNS) + &run.interval_rows()),
        (FOOD, run.food_table()),
    ];
    for ((name, columns), (_, rows)) in DETAILS.iter().zip(job.details()) {
        // Runs of versions before have none.
        if directory.join(name).exists() {
            tables.push((name, head(*columns) + rows));
        }
    }
    for (name, text) in tables {
        if disk::read_text(&directory.join(name))? != text {
            return Ok(Some(format!("{name} is not what this device computes")));
        }
    }
    Ok(None)
}

impl Experiment for SwarmExperiment {
    fn name(&self) -> &str {
        self.name()
    }

    fn single(&self) -> Option<&experiment::Experiment> {
        None
    }

    fn swarm(&self) -> Option<&SwarmExperiment> {
        Some(self)
    }

    fn seed(&self) -> Option<u64> {
        self.seed()
    }

    fn warnings(&self) -> &[String] {
        &[]
    }

    fn left_out(&self) -> &LeftOut {
        SwarmExperiment::left_out(self)
    }

    fn inputs(&self) -> &[Input] {
        &[]
    }

    fn resolved_toml(&self, seed: u64) -> String {
        self.resolved_toml(seed)
    }

    fn identities(&self) -> Identities {
        self.identities()
    }

    fn length(&self) -> u32 {
        self.settings().minutes
    }

    fn steps(&self) -> u64 {
        steps(&self.plan(0)).iter().sum()
    }

    fn kernel(&self) -> &'static str {
        // If nothing evolves, only the arena is simulated.
        if self.settings().case == Case::Random {
            oneiro_shaders::SWARM.name
        } else {
            self.settings().simulator(Light::OverNest).kernel().name
        }
    }

    fn bytes(&self) -> u64 {
        let settings = self.settings();
        u64::from(settings.world.robots) * u64::from(settings.seconds()) * 64
    }

    fn sample(&self) -> Result<Worlds> {
        Ok(Worlds::new(&[self.settings().simulator(Light::OverNest)])?)
    }

    fn work(&self) -> Result<Vec<Work>> {
        let settings = self.settings();
        let [real, simulated] = steps(&self.plan(0));
        let arena = Work {
            worlds: Worlds::new(&[&settings.swarm()])?,
            at_a_time: 1,
            steps: real,
        };
        let on_board = Work {
            worlds: self.sample()?,
            at_a_time: controllers(settings),
            steps: simulated,
        };
        Ok([arena, on_board].into_iter().filter(|work| work.steps > 0).collect())
    }

    fn job(self: Arc<Self>, seed: u64, recording: Recording<'_>) -> Result<Box<dyn Job>> {
        let job = SwarmJob::new(self.plan(seed));
        Ok(Box::new(with_page(job, self, seed, recording)))
    }

    fn restored(self: Arc<Self>, seed: u64, recording: Recording<'_>, saved: &[u8]) -> Result<Box<dyn Job>> {
        let job = SwarmJob::restore(self.plan(seed), saved)?;
        Ok(Box::new(with_page(job, self, seed, recording)))
    }

    fn extended(&self, _: &dyn Experiment, _: u64, _: &[u8]) -> Result<Vec<u8>> {
        Err(Failure::failed("runs of the foraging study have no generations"))
    }

    fn tables(&self, recording: Recording<'_>) -> Vec<Table> {
        let details = match recording {
            Recording::Directory { .. } => &DETAILS[..],
            Recording::Tables => &[],
        };
        [(INTERVALS, &INTERVALS_COLUMNS[..])]
            .iter()
            .chain(details)
            .map(|(file, columns)| Table {
                file,
                head: head(*columns).into_bytes(),
            })
            .collect()
    }

    fn results(&self) -> Vec<&'static str> {
        vec![INTERVALS, FOOD]
    }

    fn contents(&self) -> Vec<Entry> {
        contents()
    }

    fn outcomes(&self) -> Vec<Column> {
        outcomes()
    }

    fn columns(&self) -> &'static [Column] {
        &INTERVALS_COLUMNS
    }

    fn shown(&self) -> Shown {
        Shown {
            by: ("rate", "food per robot-minute"),
            time: ("interval", "interval"),
            value: ("real", "real fitness of a robot's interval"),
        }
    }

    fn summary(&self, run: &Recorded<'_>) -> Result<Summary> {
        let brought: u32 = food(run.directory)?.iter().sum();
        Ok(Summary {
            line: ("food", brought.to_string()),
            values: vec![("brought", json!(brought))],
            cells: vec![("food", brought.to_string())],
            warnings: Vec::new(),
        })
    }

    fn progress(&self, run: &Recorded<'_>) -> Result<(u32, Option<f32>)> {
        if !run.is_done {
            let minutes = checkpointed(run.directory).unwrap_or(0);
            return Ok((minutes, None));
        }
        let food = food(run.directory)?;
        Ok((food.len() as u32 / 60, Some(food.iter().sum::<u32>() as f32)))
    }

    fn check(&self, picture: Option<&Path>) -> Result<Answer> {
        let settings = self.settings();
        if picture.is_some() {
            return Err(Failure::usage(
                "--out: `oneiro replay` draws the foraging study's arena",
            ));
        }
        let value = json!({
            "name": self.name(),
            "robot_steps": Experiment::steps(self),
            "settings": self.values()["swarm"],
        });
        let kind = self.plan(0).kind;
        let mut evolves = String::new();
        if settings.case != Case::Random {
            // Writing to a string can't fail.
            let _ = writeln!(evolves, "  method      {}", kind.title());
            if kind.exchanges() && kind != Kind::HeardByAll {
                let Links { topology, migration } = settings.links;
                let _ = writeln!(evolves, "  messages    {}, migration {migration}", topology.word());
            }
        }
        let text = format!(
            "{} is valid\n  case        {}\n{evolves}  robots      {}, for {}\n  arena       radius {} mm\n  work        \
             {:.1} million robot-steps a run",
            self.name(),
            settings.case.title(),
            settings.world.robots,
            counted(settings.minutes, "minute", "minutes"),
            settings.world.forager.arena_radius,
            Experiment::steps(self) as f64 / 1e6
        );
        Ok(Answer::new(text, value))
    }

    fn check_lives(&self, _: u32) -> Result<String> {
        Err(Failure::usage(
            "--episodes: is given for the foraging study, which has no custom arithmetic to check; allowed: other experiments",
        ))
    }

    fn replay(&self, run: &Recorded<'_>, replay: &Replay<'_>, engine: &Engine, bars: Bars) -> Result<Answer> {
        replay::run(self, run, replay, engine, bars)
    }

    /// Audits the whole run, whatever the fraction.
    fn audit(&self, run: &Recorded<'_>, _: f64, engine: &Engine, bars: Bars) -> Result<Audit> {
        let directory = run.directory.display();
        if !run.is_done {
            return Err(Failure::failed(format_args!(
                "{directory}: is not finished; `oneiro resume` continues it"
            )));
        }
        let again = again(self, run.seed, engine, bars)?;
        let problem = difference(&again, run.directory)?;
        let text = match &problem {
            None => format!("{directory}: as recorded, all of it, on {}", engine.name()),
            Some(problem) => format!("{directory}: {problem}"),
        };
        let value = json!({ "directory": directory.to_string(), "problem": problem });
        Ok(Audit {
            answer: Answer::new(text, value),
            problem,
        })
    }
}

/// Finished minutes at a run's newest checkpoint.
fn checkpointed(directory: &Path) -> Option<u32> {
    let (newest, _) = crate::engine::checkpoint::list(directory).ok()?.into_iter().next()?;
    u32::try_from(newest).ok()
}
