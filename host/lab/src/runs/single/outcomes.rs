//! A run's values in a sweep's table of results: each column once, with the function that gives its value.

use oneiro_base::contents::{Column, OutcomeColumn};
use oneiro_evolve::Champion;
use oneiro_evolve::appraisal::Appraisal;
use oneiro_evolve::map_elites::Archive;
use oneiro_report::numbers::fixed;
use oneiro_statistics::mean;

use super::rows::Row;
use super::transferred::{self, Compared};
use super::{CHAMPION_MEAN, Single};
use crate::engine::job::Named;

/// A finished run.
pub(super) struct Ended<'a> {
    pub(super) luckiest: &'a Champion,
    pub(super) champion: &'a Champion,
    /// The champion's, if there are finalists.
    pub(super) appraisal: Option<Appraisal>,
    /// The last generation, and that of the second of two populations.
    pub(super) last: &'a Row,
    pub(super) second: Option<&'a Row>,
    /// Number of NaN scores in all generations.
    pub(super) nan: u64,
    /// Number of individuals that have a measure that is NaN, in all generations.
    pub(super) unmeasured: u64,
    /// Fitness of the last offspring in the simulator, and of each of their episodes in reality.
    pub(super) simulated: &'a [f32],
    pub(super) real: &'a [f32],
    /// The first generation on the robot, if it is compared.
    pub(super) compared: Option<Compared>,
    /// The archive, if there is one, and what its quality is counted from.
    pub(super) archive: Option<(&'a Archive, f64)>,
}

type Outcome = OutcomeColumn<fn(&Ended<'_>) -> Option<String>>;

/// Values of all runs.
static OF_ALL: [Outcome; 11] = [
    OutcomeColumn::new(
        Column::number("best", "", "the highest score of any individual in its generation"),
        |run| Some(run.luckiest.fitness.to_string()),
    ),
    OutcomeColumn::new(
        Column::whole("best_generation", "", "the generation of that individual, the luckiest"),
        |run| Some(run.luckiest.generation.to_string()),
    ),
    OutcomeColumn::new(
        Column::whole("best_individual", "", "its index in the generation"),
        |run| Some(run.luckiest.individual.to_string()),
    ),
    OutcomeColumn::new(
        Column::number("peak", "", "the mean fitness of the last generation's would-be parents"),
        |run| Some(fixed(run.last.peak, 6)),
    ),
    OutcomeColumn::new(
        Column::number("mean", "", "the mean fitness of the last generation"),
        |run| Some(fixed(run.last.mean, 6)),
    ),
    OutcomeColumn::new(
        Column::whole(
            "nan",
            "",
            "the number of NaN fitness values in the whole run; they ranked last",
        )
        .less_is_better(),
        |run| Some(run.nan.to_string()),
    ),
    OutcomeColumn::new(
        Column::number(
            CHAMPION_MEAN,
            "",
            "the mean of the champion's new episodes (`evolution.finalist_lives`), which did not choose it; empty without finalists, when the \
         champion is the luckiest",
        ),
        |run| run.appraisal.map(|own| fixed(own.mean, 6)),
    ),
    OutcomeColumn::new(
        Column::number(
            "champion_low",
            "",
            "the lower bound of that mean's 95 % confidence interval, by Student's t",
        ),
        |run| run.appraisal.map(|own| fixed(own.interval()[0], 6)),
    ),
    OutcomeColumn::new(
        Column::number("champion_high", "", "the upper bound of that interval"),
        |run| run.appraisal.map(|own| fixed(own.interval()[1], 6)),
    ),
    OutcomeColumn::new(
        Column::whole("champion_generation", "", "the champion's generation"),
        |run| run.appraisal.map(|_| run.champion.generation.to_string()),
    ),
    OutcomeColumn::new(
        Column::whole("champion_individual", "", "its index in the generation"),
        |run| run.appraisal.map(|_| run.champion.individual.to_string()),
    ),
];

/// Values of the last offspring, which nobody selected.
static OF_REALITY: [Outcome; 3] = [
    OutcomeColumn::new(
        Column::number(
            "simulated",
            "",
            "with the sweep's `[reality]`: the mean simulated fitness of the last generation's offspring, before any selection",
        ),
        |run| Some(fixed(mean_of(run.simulated), 6)),
    ),
    OutcomeColumn::new(
        Column::number(
            "real",
            "",
            "with the sweep's `[reality]`: the mean real fitness of the same offspring",
        ),
        |run| Some(fixed(mean_of(run.real), 6)),
    ),
    OutcomeColumn::new(
        Column::number(
            "real_best",
            "",
            "with the sweep's `[reality]`: the highest real fitness of the same offspring",
        ),
        |run| Some(run.real.iter().copied().fold(f32::NAN, f32::max).to_string()),
    ),
];

/// Values of the archive after the last generation.
static OF_ARCHIVE: [Outcome; 2] = [
    OutcomeColumn::new(
        Column::number(
            "coverage",
            "",
            "with `evolution.kind = \"map-elites\"`: the fraction of all cells that have an elite; empty with other optimisers",
        ),
        |run| run.archive.map(|(archive, _)| archive.coverage().to_string()),
    ),
    OutcomeColumn::new(
        Column::number(
            "qd_score",
            "",
            "with it: the sum over all elites of what their fitness is above `evolution.archive.offset`",
        ),
        |run| run.archive.map(|(archive, offset)| archive.quality(offset).to_string()),
    ),
];

/// Values of the second population's last generation.
static OF_COEVOLUTION: [Outcome; 2] = [
    OutcomeColumn::new(
        Column::number(
            "second_peak",
            "",
            "with `evolution.kind = \"coevolution\"`: `peak` of the second population; the columns before it are of the first, and of the \
         last pair",
        ),
        |run| run.second.map(|own| fixed(own.peak, 6)),
    ),
    OutcomeColumn::new(
        Column::number("second_mean", "", "with it: `mean` of the second population"),
        |run| run.second.map(|own| fixed(own.mean, 6)),
    ),
];

/// Values of optimisers that use behaviour.
static OF_BEHAVIOUR: [Outcome; 1] = [OutcomeColumn::new(
    Column::whole(
        "nan_measures",
        "",
        "with `evolution.kind = \"map-elites\"` or `\"novelty\"`: the number of individuals in the whole run that have a measure that is \
         not a number (NaN): they had no behaviour",
    ),
    |run| Some(run.unmeasured.to_string()),
)];

impl Single {
    /// The values of its runs, apart from the comparison with reality.
    fn own_outcomes(&self) -> [&'static [Outcome]; 5] {
        let evolution = &self.experiment.settings().evolution;
        [
            &OF_ALL,
            if self.has_reality() { &OF_REALITY } else { &[] },
            if evolution.has_archive() { &OF_ARCHIVE } else { &[] },
            if evolution.is_coevolution() {
                &OF_COEVOLUTION
            } else {
                &[]
            },
            if evolution.uses_behaviour() { &OF_BEHAVIOUR } else { &[] },
        ]
    }

    /// The columns of its runs' values.
    pub(super) fn outcome_columns(&self) -> Vec<Column> {
        columns(self.own_outcomes(), self.is_compared)
    }

    /// The values of a finished run.
    pub(super) fn outcomes_of(&self, run: &Ended<'_>) -> Named {
        let own = self.own_outcomes().into_iter().flatten();
        let own = own.filter_map(|outcome| Some((outcome.column.name.clone(), (outcome.value)(run)?)));
        let compared = run.compared.iter().flat_map(|compared| {
            let all = transferred::OUTCOMES.iter();
            all.map(move |outcome| (outcome.column.name.clone(), (outcome.value)(compared)))
        });
        own.chain(compared).collect()
    }
}

fn columns([all, reality, archive, coevolution, behaviour]: [&[Outcome]; 5], is_compared: bool) -> Vec<Column> {
    let columns = |outcomes: &[Outcome]| outcomes.iter().map(|outcome| outcome.column.clone()).collect();
    let compared = transferred::OUTCOMES.iter().filter(|_| is_compared);
    let compared: Vec<Column> = compared.map(|outcome| outcome.column.clone()).collect();
    [
        columns(all),
        columns(reality),
        compared,
        columns(archive),
        columns(coevolution),
        columns(behaviour),
    ]
    .concat()
}

/// The columns that runs of any experiment have.
#[cfg(any(test, feature = "testing"))]
pub(super) fn all() -> Vec<Column> {
    columns(
        [&OF_ALL, &OF_REALITY, &OF_ARCHIVE, &OF_COEVOLUTION, &OF_BEHAVIOUR],
        true,
    )
}

fn mean_of(fitness: &[f32]) -> f64 {
    mean(fitness.iter().copied().map(f64::from))
}
