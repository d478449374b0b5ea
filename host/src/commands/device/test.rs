//! `oneiro device test`: checks that this machine computes the same bits as every other.

use std::sync::Arc;
use std::thread;

use oneiro::backend::Specialise;
use oneiro::batch::{Batch, Outcome, PartResult, Trace, TraceRequest, Worlds};
use oneiro::evaluator::{Control, Evaluator};
use oneiro::foraging::Foraging;
use oneiro::parameter::Invalid;
use oneiro::probe::{self, Case, Subject};
use oneiro::random::{KNOWN_ANSWERS, pcg4d};
use oneiro::swarm::Swarm;
use oneiro::tables::SensorTables;
use oneiro::world::{Robot, World, WorldSpec};
use oneiro_base::answer::Answer;
use oneiro_base::console::{Console, columns};
use oneiro_base::exit::{Failure, Result};
use oneiro_lab::device::{self, Candidate};
use oneiro_lab::workload;
use serde::Serialize;
use serde_json::{Value, json};

use super::bench::{self, Plan, Timed};
use super::machine_code::MachineCode;
use crate::cli::DeviceTest;

/// Rollouts whose traces are compared, for each controller.
const TRACED: u32 = 256;
/// Arguments of each function of the kernels' library.
const ARGUMENTS: usize = 10_000;
/// Seed of all genomes and keys.
const SEED: u32 = 1995;

/// One comparison.
#[derive(Debug, Serialize)]
struct Check {
    what: String,
    device: String,
    /// Number of values whose bits were compared.
    compared: u64,
    /// Number of values that differ.
    different: u64,
    verdict: Verdict,
    /// The differences, if they are known in detail.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    details: Vec<String>,
}

/// Result of a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum Verdict {
    /// No bit differs.
    Same,
    /// Some bits differ, but none may.
    Differs,
    /// Some bits differ, on a device that doesn't guarantee them.
    NotExact,
    /// A control that must differ does.
    Caught,
    /// A control that must differ doesn't, so the comparison is worthless.
    Missed,
}

impl Verdict {
    fn is_good(self) -> bool {
        !matches!(self, Self::Differs | Self::Missed)
    }

    fn words(self) -> &'static str {
        match self {
            Self::Same => "same bits",
            Self::Differs => "DIFFERS",
            Self::NotExact => "differs; not exact",
            Self::Caught => "caught",
            Self::Missed => "MISSED",
        }
    }
}

impl Check {
    /// Checks bits that must be equal if the device guarantees it.
    fn same(what: impl Into<String>, device: &str, exact: bool, counts: (u64, u64)) -> Self {
        let verdict = match counts.1 {
            0 => Verdict::Same,
            _ if exact => Verdict::Differs,
            _ => Verdict::NotExact,
        };
        Self::new(what, device, counts, verdict)
    }

    /// Checks bits of altered inputs, some of which must differ.
    fn control(what: impl Into<String>, device: &str, counts: (u64, u64)) -> Self {
        let verdict = if counts.1 > 0 { Verdict::Caught } else { Verdict::Missed };
        Self::new(what, device, counts, verdict)
    }

    fn new(what: impl Into<String>, device: &str, (compared, different): (u64, u64), verdict: Verdict) -> Self {
        Self {
            what: what.into(),
            device: device.to_owned(),
            compared,
            different,
            verdict,
            details: Vec::new(),
        }
    }
}

/// Compares everything, prints a table, and fails if any check fails.
pub(crate) fn run(arguments: &DeviceTest, console: Console) -> Result {
    let found = examined(arguments, console)?;
    console.print_answer(&Answer::new(found.text(), found.value()))?;
    let (bad, all) = (found.failed(), found.checks.len());
    if bad > 0 {
        return Err(Failure::failed(format_args!(
            "{bad} of {all} checks failed on this machine"
        )));
    }
    console.say(format!("all {all} checks passed"));
    Ok(())
}

/// What [`run`] prints as JSON.
///
/// # Errors
/// Exit 4: there is no such device. Checks that fail are no error.
pub(crate) fn report(backend: &str, rollouts: u32, console: Console) -> Result<Value> {
    let arguments = DeviceTest {
        backend: backend.to_owned(),
        rollouts,
        tables: Vec::new(),
    };
    Ok(examined(&arguments, console)?.value())
}

/// What was found of this machine.
struct Found {
    checks: Vec<Check>,
    cells: Vec<bench::Cell>,
    /// By the adapters' names.
    machine_code: Vec<(String, MachineCode)>,
}

impl Found {
    fn failed(&self) -> usize {
        self.checks.iter().filter(|check| !check.verdict.is_good()).count()
    }

    fn value(&self) -> Value {
        let machine_code: Value = self
            .machine_code
            .iter()
            .map(|(name, own)| (name.clone(), own.value()))
            .collect();
        json!({
            "passed": self.failed() == 0,
            "checks": self.checks,
            "throughput": self.cells,
            "machine_code": machine_code,
        })
    }

    fn text(&self) -> String {
        let (checks, speeds) = (table(&self.checks), bench::table(&self.cells));
        let drivers: Vec<String> = self
            .machine_code
            .iter()
            .map(|(name, own)| format!("\nThe driver of {name}\n{}", own.text()))
            .collect();
        format!(
            "{checks}\nMillion robot-steps per second\n\n{speeds}{}",
            drivers.concat()
        )
    }
}

/// Compares everything, and measures speeds.
fn examined(arguments: &DeviceTest, console: Console) -> Result<Found> {
    let candidates = compared(&arguments.backend)?;
    let robot = robot(arguments, console)?;
    let mut checks = vec![known_answers()];
    console.say("operations and functions");
    let arithmetic = Arithmetic::new()?;
    for candidate in &candidates {
        arithmetic.check(candidate, &mut checks)?;
    }
    let mut subjects = Vec::new();
    for (name, controller) in workload::CONTROLLERS {
        let lives = workload::worlds(&controller, &robot)?;
        subjects.push((name.to_owned(), Lives::of_worlds(&lives)?, arguments.rollouts));
        // A surrogate's cycle takes some twenty times as long.
        let surrogates = workload::surrogates(&controller, &robot)?;
        let name = format!("surrogate, {name}");
        subjects.push((name, Lives::of_worlds(&surrogates)?, arguments.rollouts / 20));
    }
    subjects.push(("forager".into(), Lives::of_foragers()?, arguments.rollouts));
    // Each has some dozen robots.
    subjects.push(("swarm".into(), Lives::of_swarms()?, arguments.rollouts / 20));
    for (name, lives, rollouts) in subjects {
        console.say(format!("episodes: {name}"));
        let reference = Reference::new(&name, &lives, rollouts)?;
        for candidate in &candidates {
            reference.check(candidate, &mut checks)?;
        }
    }
    let khepera = Timed::khepera()?;
    let (cells, _) = bench::measure(
        &khepera,
        &khepera.candidates(&arguments.backend)?,
        &Plan::quick(),
        console,
    )?;
    Ok(Found {
        checks,
        cells,
        machine_code: machine_code(&candidates),
    })
}

/// What the drivers of the adapters tell of the machine code, by the adapters' names.
fn machine_code(candidates: &[Candidate]) -> Vec<(String, MachineCode)> {
    #[cfg(feature = "gpu")]
    return candidates
        .iter()
        .filter_map(|own| Some((own.name.clone(), MachineCode::of(own.adapter()?))))
        .collect();
    #[cfg(not(feature = "gpu"))]
    {
        let _ = candidates;
        Vec::new()
    }
}

/// Formats one line per check, followed by the differences.
fn table(checks: &[Check]) -> String {
    let row = |check: &Check| {
        let Check {
            what,
            device,
            compared,
            different,
            verdict,
            ..
        } = check;
        let counts = [compared.to_string(), different.to_string()];
        [
            vec![what.clone(), device.clone()],
            counts.to_vec(),
            vec![verdict.words().to_owned()],
        ]
        .concat()
    };
    let rows: Vec<Vec<String>> = checks.iter().map(row).collect();
    let mut text = columns(&["check", "device", "compared", "different", "verdict"], &rows);
    for check in checks {
        for detail in &check.details {
            text += &["differs on ", &check.device, ": ", detail, "\n"].concat();
        }
    }
    text
}

/// Each lane code with all threads, and the adapters.
fn compared(which: &str) -> Result<Vec<Candidate>> {
    let all = thread::available_parallelism().map_or(1, usize::from);
    let mut candidates = device::candidates(which)?;
    candidates.retain(|candidate| candidate.threads.is_none_or(|threads| threads == all));
    Ok(candidates)
}

/// The built-in Khepera, or one with the given tables.
fn robot(arguments: &DeviceTest, console: Console) -> Result<Robot> {
    let built_in = WorldSpec::miglino1995().robot;
    if arguments.tables.is_empty() {
        return Ok(built_in);
    }
    let import = SensorTables::read(&arguments.tables).map_err(Failure::input)?;
    console.warn(import.warnings);
    Ok(Robot {
        sensors: Arc::new(import.table),
        ..built_in
    })
}

/// Checks the host's random numbers against known answers.
fn known_answers() -> Check {
    let wrong = KNOWN_ANSWERS
        .iter()
        .filter(|(words, hash)| pcg4d(*words) != *hash)
        .count();
    Check::same(
        "random numbers: known answers",
        "host",
        true,
        (KNOWN_ANSWERS.len() as u64, wrong as u64),
    )
}

/// Results of the scalar code for single operations and functions.
struct Arithmetic {
    cases: Vec<Case>,
    results: Vec<Vec<u32>>,
}

impl Arithmetic {
    fn new() -> Result<Self> {
        let cases = [probe::operations(), probe::functions(ARGUMENTS)].concat();
        let results = Candidate::scalar(1).probe()?.compute(&cases)?;
        Ok(Self { cases, results })
    }

    /// Compares a device's operations and functions with these results, and as a control one operation with another.
    fn check(&self, candidate: &Candidate, checks: &mut Vec<Check>) -> Result {
        let Candidate { name, exact, .. } = candidate;
        let results = candidate.probe()?.compute(&self.cases)?;
        for (kind, is_function) in [("operations", false), ("functions", true)] {
            let (mut compared, mut different, mut details) = (0, 0, Vec::new());
            for ((case, here), there) in self.cases.iter().zip(&self.results).zip(&results) {
                if matches!(case.subject, Subject::Function(_)) == is_function {
                    let differ = differing(here, there);
                    compared += here.len() as u64;
                    different += differ;
                    if differ > 0 {
                        details.push(format!("{}: {differ} of {}", case.subject, here.len()));
                    }
                }
            }
            checks.push(Check {
                details,
                ..Check::same(kind, name, *exact, (compared, different))
            });
        }
        if let ([here, ..], [_, there, ..]) = (&self.results[..], &results[..]) {
            let counts = (here.len() as u64, differing(here, there));
            checks.push(Check::control("another operation must show", name, counts));
        }
        Ok(())
    }
}

/// Number of positions where two lists differ, including those that only one has.
fn differing<T: PartialEq>(here: &[T], there: &[T]) -> u64 {
    (here.iter().zip(there).filter(|(a, b)| a != b).count() + here.len().abs_diff(there.len())) as u64
}

/// Worlds, and the same worlds with one constant larger by one unit in the last place.
struct Lives {
    worlds: Worlds,
    altered: Worlds,
    /// Makes batches in these worlds.
    batch: fn(&Worlds, u32, u32, Option<TraceRequest>) -> std::result::Result<Batch, Invalid>,
}

impl Lives {
    fn of_worlds(worlds: &[World]) -> Result<Self> {
        Ok(Self {
            worlds: Worlds::new(worlds)?,
            altered: Worlds::new(&altered(worlds)?)?,
            batch: workload::batch,
        })
    }

    fn of_foragers() -> Result<Self> {
        let foragers = workload::foragers();
        let altered = |forager: &Foraging| Foraging {
            cruise: forager.cruise.next_up(),
            ..*forager
        };
        Ok(Self {
            worlds: Worlds::new(&foragers)?,
            altered: Worlds::new(&foragers.iter().map(altered).collect::<Vec<_>>())?,
            batch: workload::batch,
        })
    }

    fn of_swarms() -> Result<Self> {
        let swarms = workload::swarms();
        let altered = |swarm: &Swarm| Swarm {
            forager: Foraging {
                cruise: swarm.forager.cruise.next_up(),
                ..swarm.forager
            },
            ..*swarm
        };
        Ok(Self {
            worlds: Worlds::new(&swarms)?,
            altered: Worlds::new(&swarms.iter().map(altered).collect::<Vec<_>>())?,
            batch: workload::swarm_batch,
        })
    }
}

/// Results of the scalar code for lives.
struct Reference {
    name: String,
    batch: Batch,
    outcome: Outcome,
    traced: Batch,
    traces: Outcome,
    /// The same lives with one constant altered.
    altered: Batch,
}

impl Reference {
    fn new(name: &str, lives: &Lives, rollouts: u32) -> Result<Self> {
        let batch = (lives.batch)(&lives.worlds, rollouts, SEED, None)?;
        let traced = (lives.batch)(&lives.worlds, TRACED, SEED, Some(TraceRequest { every: 3 }))?;
        // One ulp shows at once in a trace, but late or never in a fitness that counts few events.
        let altered = (lives.batch)(&lives.altered, TRACED, SEED, Some(TraceRequest { every: 3 }))?;
        let mut scalar =
            Candidate::scalar(thread::available_parallelism().map_or(1, usize::from)).open(None, Specialise::Never)?;
        let outcome = scalar.evaluate(&batch, &Control::new())?;
        let traces = scalar.evaluate(&traced, &Control::new())?;
        Ok(Self {
            name: name.to_owned(),
            batch,
            outcome,
            traced,
            traces,
            altered,
        })
    }

    /// Compares a device's lives with these: whole, cut into pieces, cycle by cycle, and altered.
    fn check(&self, candidate: &Candidate, checks: &mut Vec<Check>) -> Result {
        let Candidate { name, exact, .. } = candidate;
        let lives_of = &self.name;
        let control = Control::new();
        let same = |what, counts| Check::same(format!("{lives_of}: {what}"), name, *exact, counts);
        let mut evaluator = candidate.open(None, Specialise::Never)?;
        if candidate.threads.is_none() {
            let mut specialised = candidate.open(None, Specialise::Always)?;
            let lives = specialised.evaluate(&self.batch, &control)?;
            checks.push(same("fitness, specialised", self.fitness(&lives)));
            let lives = specialised.evaluate(&self.traced, &control)?;
            checks.push(same("traces, specialised", self.trace(&lives)));
        }
        if !candidate.is_scalar() {
            let lives = evaluator.evaluate(&self.batch, &control)?;
            checks.push(same("fitness", self.fitness(&lives)));
            let lives = evaluator.evaluate(&self.traced, &control)?;
            checks.push(same("traces", self.trace(&lives)));
        }
        let mut cut = candidate.open(Some(CHUNK), Specialise::Never)?;
        let lives = in_parts(cut.as_mut(), &self.batch)?;
        checks.push(same("fitness, episodes and batch cut", self.fitness(&lives)));
        let lives = evaluator.evaluate(&self.altered, &control)?;
        let what = format!("{lives_of}: one constant 1 ulp up must show");
        checks.push(Check::control(what, name, self.trace(&lives)));
        Ok(())
    }

    /// Number of rollouts compared, and of those whose fitness has other bits.
    fn fitness(&self, other: &Outcome) -> (u64, u64) {
        let pairs = self.outcome.fitness.iter().zip(&other.fitness);
        (
            self.outcome.fitness.len() as u64,
            pairs.filter(|(a, b)| a.to_bits() != b.to_bits()).count() as u64,
        )
    }

    /// Number of records compared (words for worlds of several robots), and of those in which any number differs. (Zero
    /// has one sign there, and a NaN differs from everything.)
    fn trace(&self, other: &Outcome) -> (u64, u64) {
        let lines = |outcome: &Outcome| {
            outcome
                .traces
                .iter()
                .flat_map(Trace::lines)
                .map(|(record, details)| (*record, details.to_vec()))
                .collect::<Vec<_>>()
        };
        let (here, there) = (lines(&self.traces), lines(other));
        let (logs, others) = (self.traces.logs.concat(), other.logs.concat());
        (
            (here.len() + logs.len()) as u64,
            differing(&here, &there) + differing(&logs, &others),
        )
    }
}

/// Cycles per dispatch, few enough to cut lives into many pieces.
const CHUNK: u32 = 37;

/// Evaluates a batch in three parts of different sizes.
fn in_parts(evaluator: &mut dyn Evaluator, batch: &Batch) -> Result<Outcome> {
    let groups = batch.groups();
    let cuts = [0, 1, 1 + groups / 3, groups];
    let mut whole = PartResult::default();
    for pair in cuts.windows(2) {
        if pair[0] < pair[1] {
            let part = evaluator.evaluate_part(&batch.part(pair[0]..pair[1]), &Control::new())?;
            whole.fitness.extend(part.fitness);
        }
    }
    Ok(batch.outcome(whole))
}

/// The same worlds, with the activation per unit of a reading increased to the next float.
fn altered(worlds: &[World]) -> Result<Vec<World>> {
    let mut altered = Vec::new();
    for world in worlds {
        let mut spec = world.spec().clone();
        let mut sensors = (*spec.robot.sensors).clone();
        sensors.reading_scale = sensors.reading_scale.next_up();
        spec.robot.sensors = Arc::new(sensors);
        altered.push(World::new(spec)?);
    }
    Ok(altered)
}
