//! `oneiro evaluate --tournament`: plays the best of each generation of one population against the best of each generation of the
//! other (Floreano and Nolfi 1997), writes all results and pictures of them, and says whether later generations are better.

use std::fmt::Write;
use std::path::Path;

use oneiro::evaluator::{Control, Evaluator};
use oneiro_base::console::{Console, counted};
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::progress;
use oneiro_evolve::Population;
use oneiro_lab::device;
use oneiro_lab::experiment::Experiment;
use oneiro_lab::genomes;
use oneiro_lab::lives::{Keys, Lives};
use oneiro_lab::record::SingleRun;
use oneiro_lab::runs::single::{HALL, TOURNAMENT, TOURNAMENT_PICTURE, TOURNAMENT_PROGRESS};
use oneiro_report::figures::{self, Series};
use oneiro_report::numbers::fixed;
use oneiro_report::numbers::{significant, to_six_places};
use oneiro_statistics::{kendall, mean};
use serde_json::{Value, json};

use crate::cli::Evaluate;
use crate::commands::list;
use crate::commands::places::{RUNS, found, typed};

/// Contests of each pair without `--trials`, and the most.
const CONTESTS: u32 = 10;
const MOST_CONTESTS: u32 = 10_000;
/// Pairs whose contests are evaluated at a time.
const AT_ONCE: usize = 1 << 14;
/// Generations at either end of a run whose best are compared.
const ENDS: usize = 10;

/// Plays the tournament of each run that is named, and of each run of a directory.
pub(crate) fn run(arguments: &Evaluate, console: Console) -> Result {
    let contests = arguments.trials.unwrap_or(CONTESTS);
    if contests > MOST_CONTESTS {
        return Err(Failure::input(format_args!(
            "--trials {contests}: is too many episodes of each pair; allowed with --tournament: 1 to {MOST_CONTESTS}"
        )));
    }
    let mut runs = Vec::new();
    let directories = arguments
        .genomes
        .iter()
        .map(|path| list::runs(&found(path, &[RUNS], console)?));
    for directory in directories.collect::<Result<Vec<_>>>()?.concat() {
        let run = SingleRun::open(&directory)?;
        if !run.experiment()?.settings().evolution.is_coevolution() {
            return Err(Failure::input(format_args!(
                "{}: is the run of one population; allowed: runs with evolution.kind = \"coevolution\"",
                directory.display()
            )));
        }
        if !run.is_done()? {
            let directory = directory.display();
            return Err(Failure::failed(format_args!(
                "{directory}: is not finished; `oneiro resume {directory}` continues it"
            )));
        }
        runs.push(run);
    }
    let mut evaluator = arguments.backend.open()?;
    let mut values = Vec::new();
    for run in &runs {
        let played = Played::of(run, contests, arguments, evaluator.as_mut(), console)?;
        played.write(run.directory(), run.experiment()?)?;
        console.print_text(played.text(run.directory()))?;
        values.push(played.value(run.directory()));
    }
    device::tell_warnings(evaluator.as_ref(), console);
    console.print_json(&json!({ "device": device::name(evaluator.as_ref()), "runs": values }))?;
    if let Some(first) = runs.first() {
        console.next(format_args!("oneiro replay {}", typed(first.directory())));
    }
    Ok(())
}

/// The mean scores of all pairs.
struct Played {
    /// Generations that take part.
    generations: Vec<u32>,
    contests: u32,
    /// The first population's, by its generation and then by that of the second.
    scores: Vec<f64>,
    total: f64,
}

/// How well the best of a population's generations do against those of all of the other's.
struct Progress {
    means: Vec<f64>,
    /// Mean of the means, and those of the generations at both ends.
    mean: f64,
    first: f64,
    last: f64,
    /// Place of the best.
    best: usize,
    /// Kendall's tau of generations and means: 1 if each is better than all before; none if all are equal.
    tau: Option<f64>,
}

impl Played {
    fn of(
        run: &SingleRun,
        contests: u32,
        arguments: &Evaluate,
        evaluator: &mut dyn Evaluator,
        console: Console,
    ) -> Result<Self> {
        let experiment = run.experiment()?;
        let layout = experiment.world().gene_layout();
        let opponents = &experiment.settings().evolution.tables.opponents;
        let hall = genomes::recorded(&run.directory().join(HALL), layout)?;
        let split = opponents
            .split(layout.all())
            .ok_or_else(|| Failure::corrupt("the second population has no genes"))?;
        let generations: Vec<u32> = (0..hall.len() as u32)
            .step_by(arguments.played.every as usize)
            .collect();
        let genome = |generation: &u32| hall.genome(*generation as usize);
        let steps = (generations.len() * generations.len()) as u64
            * u64::from(contests)
            * u64::from(experiment.world().cycles())
            * u64::from(experiment.world().robots());
        let control = Control::new();
        let scores = progress::watched(steps, "playing", console.bars(), &control, || -> Result<Vec<f64>> {
            let mut scores = Vec::with_capacity(generations.len() * generations.len());
            for rows in generations.chunks((AT_ONCE / generations.len()).max(1)) {
                let pairs = rows.iter().flat_map(|first| {
                    let second = generations.iter().flat_map(|second| &genome(second)[split..]);
                    let own = &genome(first)[..split];
                    pairs_of(own, &second.copied().collect::<Vec<_>>(), hall.genes() - split)
                });
                let lives = Lives {
                    worlds: std::slice::from_ref(experiment.world()),
                    genomes: &Population::new(hall.genes(), pairs.collect()),
                    count: contests as usize,
                    keys: Keys {
                        common: true,
                        ..Keys::of_seed(arguments.seed.unwrap_or(1))
                    },
                };
                let fitness = lives.fitness(evaluator, &control)?;
                let pairs = fitness.chunks_exact(contests as usize);
                scores.extend(pairs.map(|own| mean(own.iter().copied().map(f64::from))));
            }
            Ok(scores)
        })?;
        Ok(Self {
            generations,
            contests,
            scores,
            total: opponents.total,
        })
    }

    /// The progress of both populations.
    fn progress(&self) -> [Progress; 2] {
        let count = self.generations.len();
        let first = (0..count).map(|row| mean(&self.scores[row * count..][..count]));
        let column = |column: usize| mean(self.scores.iter().skip(column).step_by(count));
        let second = (0..count).map(|own| self.total - column(own));
        [first.collect(), second.collect()].map(|means: Vec<f64>| Progress::of(&self.generations, means))
    }

    fn write(&self, directory: &Path, experiment: &Experiment) -> Result {
        let title = format!("{}: master tournament", experiment.name());
        let [first, second] = self.progress();
        let series = |label, own: &Progress| Series {
            label,
            values: own.means.clone(),
        };
        let both = [series("first", &first), series("second", &second)];
        let every = self.generations.get(1).copied().unwrap_or(1);
        for (file, text) in [
            (TOURNAMENT, self.csv()),
            (
                TOURNAMENT_PICTURE,
                figures::tournament(&title, every, self.generations.len(), &self.scores),
            ),
            (
                TOURNAMENT_PROGRESS,
                figures::learning_curve(&title, "mean score against all generations of the other", &both, None),
            ),
        ] {
            disk::write(&directory.join(file), text.as_bytes())?;
        }
        Ok(())
    }

    /// A row for each generation of the first population, with its scores against each of the second.
    fn csv(&self) -> String {
        let mut text = "generation".to_owned();
        // Writing to a string can't fail.
        for generation in &self.generations {
            let _ = write!(text, ",second_{generation}");
        }
        text.push('\n');
        for (generation, scores) in self
            .generations
            .iter()
            .zip(self.scores.chunks_exact(self.generations.len()))
        {
            let _ = write!(text, "{generation}");
            for score in scores {
                let _ = write!(text, ",{}", significant(*score, 6));
            }
            text.push('\n');
        }
        text
    }

    fn text(&self, directory: &Path) -> String {
        let mut text = format!(
            "{}: {} of each population, {} a pair\n  {:<12}{:>10}{:>14}{:>14}{:>10}{:>18}\n",
            directory.display(),
            counted(self.generations.len(), "best one", "best ones"),
            counted(self.contests, "episode", "episodes"),
            "population",
            "mean",
            format!("first {ENDS}"),
            format!("last {ENDS}"),
            "tau",
            "best generation"
        );
        for (name, own) in ["first", "second"].iter().zip(self.progress()) {
            let tau = own.tau.map_or_else(|| "-".to_owned(), |tau| fixed(tau, 3));
            let _ = writeln!(
                text,
                "  {name:<12}{:>10}{:>14}{:>14}{tau:>10}{:>10} ({})",
                fixed(own.mean, 3),
                fixed(own.first, 3),
                fixed(own.last, 3),
                self.generations[own.best],
                fixed(own.means[own.best], 3)
            );
        }
        text
    }

    fn value(&self, directory: &Path) -> Value {
        let populations: Vec<Value> = self
            .progress()
            .iter()
            .map(|own| {
                let rounded = |number: f64| json!(to_six_places(number));
                json!({
                    "mean": rounded(own.mean),
                    "first": rounded(own.first),
                    "last": rounded(own.last),
                    "tau": own.tau.map(to_six_places),
                    "best_generation": self.generations[own.best],
                    "best": rounded(own.means[own.best]),
                })
            })
            .collect();
        json!({
            "directory": directory.display().to_string(),
            "generations": self.generations.len(),
            "contests": self.contests,
            "first": populations[0],
            "second": populations[1],
        })
    }
}

/// One genome's genes before those of each of some others.
fn pairs_of(own: &[f32], others: &[f32], genes: usize) -> Vec<f32> {
    others
        .chunks_exact(genes)
        .flat_map(|other| [own, other].concat())
        .collect()
}

impl Progress {
    fn of(generations: &[u32], means: Vec<f64>) -> Self {
        let ends = ENDS.min(means.len());
        let better = |best: usize, place: usize| if means[place] > means[best] { place } else { best };
        let times: Vec<f64> = generations.iter().copied().map(f64::from).collect();
        Self {
            mean: mean(&means),
            first: mean(&means[..ends]),
            last: mean(&means[means.len() - ends..]),
            best: (0..means.len()).fold(0, better),
            tau: kendall(&times, &means).ok(),
            means,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three generations each: the first population's second generation beats all, and its last one nobody.
    fn played() -> Played {
        Played {
            generations: vec![0, 5, 10],
            contests: 2,
            scores: vec![0.5, 0.25, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0],
            total: 1.0,
        }
    }

    #[test]
    fn progress_is_the_mean_against_all_of_the_other() {
        let [first, second] = played().progress();
        assert_eq!(first.means, [0.25, 1.0, 0.0]);
        assert_eq!((first.best, first.mean), (1, 1.25 / 3.0));
        assert_eq!(first.tau, Some(-1.0 / 3.0));
        for (own, expected) in second.means.iter().zip([0.5, 1.0 - 1.25 / 3.0, 1.0 - 1.0 / 3.0]) {
            assert!((own - expected).abs() < 1e-12, "{own}");
        }
        assert_eq!((second.best, second.tau), (2, Some(1.0)));
        // What one wins the other loses.
        assert!((first.mean + second.mean - 1.0).abs() < 1e-12);
    }

    #[test]
    fn each_pair_is_in_the_table() {
        let expected = "generation,second_0,second_5,second_10\n0,0.5,0.25,0\n5,1,1,1\n10,0,0,0\n";
        assert_eq!(played().csv(), expected);
    }

    #[test]
    fn pairs_have_the_genes_of_both() {
        assert_eq!(pairs_of(&[1.0, 2.0], &[3.0, 4.0], 1), [1.0, 2.0, 3.0, 1.0, 2.0, 4.0]);
    }
}
