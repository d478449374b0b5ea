//! `oneiro verify --recompute`: evaluates recorded individuals again on this machine and compares them bit for bit.

use oneiro::batch::{Batch, Rollout};
use oneiro::random::pcg4d;
use oneiro_base::answer::Answer;
use oneiro_base::console::Bars;
use oneiro_base::console::counted;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::progress;
use serde_json::{Value, json};

use super::individuals::Individuals;
use super::job::{keys, score};
use super::{Audit, Recorded, Single};
use crate::engine::handle::Engine;
use crate::experiment::Experiment;

/// Individuals per batch.
const AT_ONCE: usize = 1 << 16;
/// Differences that are listed individually.
const LISTED: usize = 10;

/// Re-evaluates a fraction of a run's individuals.
pub(super) fn run(single: &Single, run: &Recorded<'_>, share: f64, engine: &Engine, bars: Bars) -> Result<Audit> {
    let report = Report::of(single, run, share, engine, bars)?;
    let different = report.differences.len();
    let others = (different > 0).then(|| {
        let individuals = counted(different, "individual has", "individuals have");
        format!("{individuals} other bits on {}", engine.name())
    });
    let begins = report
        .begins_otherwise
        .then(|| "the first generation is not what evolution.init and the seed make".to_owned());
    let problems: Vec<String> = others.into_iter().chain(begins).collect();
    Ok(Audit {
        answer: Answer::new(report.text(), report.value()),
        problem: (!problems.is_empty()).then(|| problems.join("; ")),
    })
}

/// Result of the audit of one run.
struct Report {
    directory: String,
    recorded: usize,
    audited: usize,
    differences: Vec<Difference>,
    /// Whether the recorded first generation is not that of the given genomes.
    begins_otherwise: bool,
}

/// An individual whose score differs on this machine.
struct Difference {
    generation: u32,
    individual: u32,
    recorded: f32,
    here: f32,
}

impl Report {
    fn of(single: &Single, run: &Recorded<'_>, share: f64, engine: &Engine, bars: Bars) -> Result<Self> {
        let experiment = &single.experiment;
        let directory = run.directory;
        let individuals = Individuals::read(directory, experiment)?;
        let chosen = chosen(&individuals, run.seed, share);
        let begins_otherwise = experiment.init().is_some() && !begins_as_given(&individuals, experiment, run.seed);
        let settings = experiment.settings();
        let trials = settings.trials as usize;
        let is_real = |index: &usize| {
            let (generation, _) = individuals.place(*index);
            experiment.first_real().is_some_and(|first| generation >= first)
        };
        let (mut real, simulated): (Vec<usize>, Vec<usize>) = chosen.into_iter().partition(is_real);
        if single.ends_outside() {
            // Episodes of a robot can't be repeated.
            real.clear();
        }
        let audited = simulated.len() + real.len();
        let steps =
            (audited * trials) as u64 * u64::from(experiment.world().cycles()) * u64::from(experiment.world().robots());
        let differences = progress::watched(
            steps,
            "auditing",
            bars,
            &engine.control,
            || -> Result<Vec<Difference>> {
                let mut differences = Vec::new();
                let chunks = [&simulated, &real].map(|own| own.chunks(AT_ONCE.div_ceil(trials)));
                for some in chunks.into_iter().flatten() {
                    let (generation, _) = individuals.place(some[0]);
                    let world = single.world_of(generation)?;
                    let rollouts: Vec<Rollout<'_>> = some
                        .iter()
                        .filter_map(|&index| Some((individuals.get(index)?.0, individuals.place(index))))
                        .flat_map(|(genes, (generation, individual))| {
                            keys(settings, run.seed, generation, individual).map(move |key| Rollout {
                                world: 0,
                                genes,
                                key,
                            })
                        })
                        .collect();
                    // A run can't have written genes that a batch doesn't accept.
                    let batch = Batch::new(std::slice::from_ref(&world), &rollouts, None)
                        .map_err(|invalid| Failure::corrupt(format_args!("{}: {invalid}", directory.display())))?;
                    let outcome = engine.evaluate(&batch)?;
                    for (&index, lives) in some.iter().zip(outcome.fitness.chunks_exact(trials)) {
                        let Some((_, recorded)) = individuals.get(index) else {
                            continue;
                        };
                        let here = score(settings.trial_score, lives);
                        if here.to_bits() != recorded.to_bits() {
                            let (generation, individual) = individuals.place(index);
                            differences.push(Difference {
                                generation,
                                individual,
                                recorded,
                                here,
                            });
                        }
                    }
                }
                Ok(differences)
            },
        )?;
        Ok(Self {
            directory: directory.display().to_string(),
            recorded: individuals.len(),
            audited,
            differences,
            begins_otherwise,
        })
    }

    fn text(&self) -> String {
        let Self {
            directory,
            recorded,
            audited,
            differences,
            ..
        } = self;
        let listed = differences.iter().take(LISTED).map(|difference| {
            let Difference { generation, individual, recorded, here } = difference;
            format!(
                "  generation {generation}, individual {individual}: recorded {recorded} ({:08x}), here {here} ({:08x})\n",
                recorded.to_bits(),
                here.to_bits()
            )
        });
        let listed: String = listed.collect();
        let different = differences.len();
        format!(
            "{directory}: {audited} of {} audited, {different} with other bits\n{listed}",
            counted(*recorded, "individual", "individuals")
        )
    }

    fn value(&self) -> Value {
        let differences: Vec<Value> = self
            .differences
            .iter()
            .map(|difference| {
                json!({
                    "generation": difference.generation,
                    "individual": difference.individual,
                    "recorded": format!("{:08x}", difference.recorded.to_bits()),
                    "here": format!("{:08x}", difference.here.to_bits()),
                })
            })
            .collect();
        json!({
            "directory": self.directory,
            "recorded": self.recorded,
            "audited": self.audited,
            "different": self.differences.len(),
            "differences": differences,
        })
    }
}

/// Whether the first generation has the genomes that the given ones and the seed make.
fn begins_as_given(individuals: &Individuals, experiment: &Experiment, seed: u64) -> bool {
    let evolution = experiment.evolution(seed);
    let is_recorded = |(index, genome): (usize, &[f32])| match individuals.get(index) {
        Some((genes, _)) => genes
            .iter()
            .map(|gene| gene.to_bits())
            .eq(genome.iter().map(|gene| gene.to_bits())),
        // It was killed before its first generation.
        None => true,
    };
    evolution.ask().genomes().enumerate().all(is_recorded)
}

/// Individuals to audit: a reproducible random choice, or the first one if none is drawn.
fn chosen(individuals: &Individuals, seed: u64, share: f64) -> Vec<usize> {
    let drawn = |&index: &usize| {
        let (generation, individual) = individuals.place(index);
        let [lot, ..] = pcg4d([seed as u32, (seed >> 32) as u32, generation, individual]);
        f64::from(lot) < share * 4_294_967_296.0
    };
    let mut chosen: Vec<usize> = (0..individuals.len()).filter(drawn).collect();
    if chosen.is_empty() && individuals.len() > 0 {
        chosen.push(0);
    }
    chosen
}
